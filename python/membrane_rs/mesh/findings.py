"""What an audit found, of a mesh or of a scene."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from membrane_rs._arrays import Ints
from membrane_rs._renamed import Renamed
from membrane_rs._validation import check_kind, show
from membrane_rs.errors import InputTypeError

Severity: TypeAlias = Literal["error", "warning", "info"]

_ORDER: tuple[Severity, ...] = ("error", "warning", "info")
_SHOWN = 10


@dataclass(frozen=True)
class Finding:
    """One thing that the audit found.

    Attributes
    ----------
    severity : str
        "error": it cannot run, or runs wrong. "warning": it may. "info": a fact.
    kind : str
        Of a mesh: "degenerate", "obtuse", "unused_nodes", "duplicate_nodes", "hanging_nodes", "pinched_nodes",
        "long_bridges", "duplicate_triangles", "shared_edges", "winding", "upside_down", "overlaps", "crossings",
        "pieces", "thick_film", "singular_springs", "negative_springs", "growing_mode" or "strain".
        Of a scene: "fold_angles", "film_law", "two_moduli", "rectangles", "bending", "supports", "spool", "chord_sag",
        "start_inside", "crossings", "touching_layers", "method", "free_hub", "fast_body", "implausible_value",
        "idle_law", "net_of_springs", "stowed_energy", "softening", "step", "setting_without_effect", "step_accuracy" or
        "left_out".
        Of a run: "body_without_contact" or "friction_step".
    count : int
        How many there are.
    message, remedy : str
        What it is, in numbers; what to do.
    where : tuple of int
        The first ten: nodes, triangles, or rows of `mesh.edges`, as the message says.

    Examples
    --------
    >>> from membrane_rs.mesh import Finding
    >>> found = Finding("warning", "strain", 2, "2 edges are strained by 1 %", "move their nodes")
    >>> print(found)
    warning: 2 edges are strained by 1 %
        move their nodes
    >>> found.as_dict()["count"]
    2
    """

    severity: Severity
    kind: str
    count: int
    message: str
    remedy: str
    where: tuple[int, ...] = ()

    cure = Renamed("remedy")

    def __str__(self) -> str:
        remedy = f"\n    {self.remedy}" if self.remedy else ""
        return f"{self.severity}: {self.message}{remedy}"

    def as_dict(self) -> dict[str, Any]:
        """Severity, kind, count, message and remedy, as summary.json holds them.

        Returns
        -------
        dict of str to object
            By these names.
        """
        return {name: getattr(self, name) for name in ("severity", "kind", "count", "message", "remedy")}


@dataclass(frozen=True)
class Audit:
    """All that the audit found, errors first.

    Parameters
    ----------
    findings : tuple of Finding
        Errors first, then warnings, then facts.

    Examples
    --------
    >>> from membrane_rs import Mesh
    >>> sliver = Mesh([[0, 0, 0], [1, 0, 0], [0.5, 1e-9, 0], [0.5, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> audit = sliver.audit()
    >>> audit.ok, audit.find("degenerate").count
    (False, 1)
    >>> audit.without_facts().findings[0].severity
    'error'
    """

    findings: tuple[Finding, ...]

    @classmethod
    def of(cls, findings: Iterable[Finding]) -> Audit:
        """Findings in any order.

        Parameters
        ----------
        findings : iterable of Finding
            In any order.

        Returns
        -------
        Audit
            Of these, in order.

        Raises
        ------
        InputTypeError
            What is no finding.

        Examples
        --------
        >>> from membrane_rs.mesh import Audit, Finding
        >>> audit = Audit.of([Finding("info", "pieces", 1, "one piece", "")])
        >>> audit.ok
        True
        """
        try:
            found = tuple(findings)
        except TypeError:
            raise InputTypeError(f"findings = {show(findings)}: must be a list of findings") from None
        for finding in found:
            check_kind(finding, Finding, "findings", "a list of findings")
        return cls(tuple(sorted(found, key=lambda finding: _ORDER.index(finding.severity))))

    @property
    def ok(self) -> bool:
        """No errors; there may be warnings."""
        return not self.errors

    @property
    def errors(self) -> tuple[Finding, ...]:
        """Findings of severity "error"."""
        return self._of_severity("error")

    @property
    def warnings(self) -> tuple[Finding, ...]:
        """Findings of severity "warning"."""
        return self._of_severity("warning")

    def find(self, kind: str) -> Finding | None:
        """The finding of a kind, or None.

        Parameters
        ----------
        kind : str
            See `Finding`.

        Returns
        -------
        Finding or None
            The first one.

        Raises
        ------
        InputTypeError
            No text.
        """
        check_kind(kind, str, "kind", "the kind of a finding, such as 'strain'")
        return next((finding for finding in self.findings if finding.kind == kind), None)

    def without_facts(self) -> Audit:
        """Errors and warnings alone.

        Returns
        -------
        Audit
            Without findings of severity "info".
        """
        return Audit(self.errors + self.warnings)

    def __str__(self) -> str:
        number = {"error": len(self.errors), "warning": len(self.warnings)}
        head = ", ".join(f"{count or 'no'} {name}{'' if count == 1 else 's'}" for name, count in number.items())
        return "\n".join([head, *map(str, self.findings)])

    def _of_severity(self, severity: Severity) -> tuple[Finding, ...]:
        return tuple(finding for finding in self.findings if finding.severity == severity)


def first_few(found: Ints) -> tuple[int, ...]:
    """The first ten of some indices, for `Finding.where`."""
    return tuple(found[:_SHOWN].tolist())
