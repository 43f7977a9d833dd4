"""The audit of a scene: the one list of checks, and what they find."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from typing import TypeAlias
from weakref import WeakKeyDictionary

from membrane_rs.check.contact import chord_sag, start_inside
from membrane_rs.check.film_law import film_law
from membrane_rs.check.material_values import material_values
from membrane_rs.check.mesh_faults import fold_angles, growing_modes, mesh_faults
from membrane_rs.check.net_of_springs import net_of_springs
from membrane_rs.check.redundancy import laws_without_effect
from membrane_rs.check.scene_values import law_and_part_values
from membrane_rs.check.spool import spool
from membrane_rs.check.supports import supports
from membrane_rs.errors import AuditWarning
from membrane_rs.mesh.findings import Audit, Finding
from membrane_rs.scene import Scene

Check: TypeAlias = Callable[[Scene], Iterator[Finding]]
"""Yields what it finds in a scene, run settings included; nothing where all is well. It never raises."""

CHECKS: list[Check] = [
    mesh_faults,
    fold_angles,
    film_law,
    supports,
    spool,
    chord_sag,
    start_inside,
    material_values,
    law_and_part_values,
    laws_without_effect,
]
"""Checks that cost little beside the first step of a run: made by `Simulation`, `run` and `check` alike."""

COSTLY_CHECKS: list[Check] = [
    growing_modes,
    net_of_springs,
]
"""Checks that take longer: made by `check` alone."""


_FOUND: WeakKeyDictionary[Scene, dict[bool, Audit]] = WeakKeyDictionary()
"""What was found in scenes that are still there, which never change."""


def audit(scene: Scene, *, costly: bool = True) -> Audit:
    """Faults, risks and facts of a scene before it runs, errors first.

    Parameters
    ----------
    scene : Scene
        The scene, with the run settings by which it is to run.
    costly : bool
        Whether checks that may take seconds are made as well, as `membrane-rs check` does.

    Returns
    -------
    Audit
        The findings of all `CHECKS`, and of `COSTLY_CHECKS` or a note that those were left out.
    """
    found = _FOUND.setdefault(scene, {})
    if costly not in found:
        checks = [*CHECKS, *(COSTLY_CHECKS if costly else [_left_out])]
        found[costly] = Audit.of(finding for check in checks for finding in check(scene))
    return found[costly]


def unaccepted_errors(scene: Scene) -> tuple[Finding, ...]:
    """Errors for which a run is not to begin: those that no setting of the scene accepts. Costly checks are left out.

    `Springs.negative` "clip" or "keep" accepts negative springs; a strain limit above the strain at the start accepts
    that.
    """
    accepted = set()
    if scene.negative_springs in ("clip", "keep"):
        accepted.add("negative_springs")
    limits = [law.edge_strain_limit for law in scene.laws if law.is_film]
    if scene.mesh is not None and all(limit is None or scene.mesh.strain().max() < limit for limit in limits):
        accepted.add("strain")
    return tuple(error for error in audit(scene, costly=False).errors if error.kind not in accepted)


def warn_of(found: Audit, stacklevel: int = 2) -> None:
    """Warn of each error and each warning of an audit, by the category `AuditWarning`."""
    for finding in found.without_facts().findings:
        text = f"{finding.severity}: {finding.message}; {finding.remedy}"
        warnings.warn(text, AuditWarning, stacklevel=stacklevel + 1)


def _left_out(scene: Scene) -> Iterator[Finding]:
    names = [check.__name__.replace("_", " ") for check in COSTLY_CHECKS]
    yield Finding(
        "info",
        "left_out",
        len(names),
        f"checks that may take seconds were left out: {', '.join(names)}",
        "`membrane-rs check` makes them, and membrane_rs.check.audit",
    )
