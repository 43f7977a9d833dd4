"""Curves of several runs and experiments, each against one of them: a table of differences and a figure.

Two curves are compared over the time that both cover, at the samples of the one that has fewer there (of the reference
where they have as many); the other is interpolated linearly between its own samples. Measured values, where they are
few, are thus compared as they are. At each of these instants the difference is d = curve - reference.

rms       sqrt(mean(d^2))
share     rms over the range of the reference, largest less smallest value, in that time
mean      mean(d)
largest   the d of the largest magnitude, and its time
peak      the value of the largest magnitude of each, among its own samples in that time, and its time
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from membrane_rs._validation import nearest, show
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.plotting.comparison import plot_comparison
from membrane_rs.plotting.deployment import PANELS, turns
from membrane_rs.plotting.style import Style
from membrane_rs.results.experiment import DEVIATION
from membrane_rs.study.compared_curves import Compared, Curves, read_curves

ALL = "all"
"""In place of names of columns: each that the reference shares with another one."""
DEFAULTS = tuple(column for column, _, _ in PANELS)
BOOKKEEPING = ("stage",)
"""Columns that are no measured or computed quantity."""


@dataclass(frozen=True)
class Difference:
    """One column of one curve against the reference.

    Attributes
    ----------
    label, column, unit : str
        Of the curve; the unit is that of rms, mean, largest and peaks, empty for a plain number.
    instants : int
        How many instants are compared.
    start, end : float
        The time that both cover [s].
    rms, mean, largest, largest_time : float
        Of the difference; the time in seconds.
    share : float
        The rms over the range of the reference; NaN where that does not change.
    peak, peak_time, reference_peak, reference_peak_time : float
        Peaks and their times [s].
    """

    label: str
    column: str
    unit: str
    instants: int
    start: float
    end: float
    rms: float
    share: float
    mean: float
    largest: float
    largest_time: float
    peak: float
    peak_time: float
    reference_peak: float
    reference_peak_time: float


@dataclass(frozen=True, eq=False)
class Comparison:
    """Curves of runs and experiments, and their differences from a reference.

    Attributes
    ----------
    reference : str
        Label of the one with which the others are compared.
    columns : tuple of str
        Names of what is compared.
    differences : tuple of Difference
        By column, then in the order of the curves; nothing for a curve that lacks a column, or shares no time.
    curves : tuple of Curves
        All that was compared, the reference among them.
    """

    reference: str
    columns: tuple[str, ...]
    differences: tuple[Difference, ...]
    curves: tuple[Curves, ...]

    def difference(self, label: str, column: str) -> Difference:
        """That of one curve. Raises InputError where there is none."""
        for found in self.differences:
            if (found.label, found.column) == (label, column):
                return found
        known = ", ".join(f"{found.label!r} in {found.column!r}" for found in self.differences)
        raise InputError(f"no difference of {show(label)} in {show(column)}; there are those of {known}")

    def table(self) -> str:
        """The differences as Markdown."""
        head = [
            "column",
            "curve",
            "instants",
            "RMS",
            "of the range [%]",
            "mean",
            "largest",
            "peak",
            "peak of reference",
        ]
        rows = []
        for d in self.differences:
            largest = _at(d.largest, d.largest_time)
            peaks = _at(d.peak, d.peak_time), _at(d.reference_peak, d.reference_peak_time)
            numbers = map(_number, (d.rms, 100.0 * d.share, d.mean))
            column = f"{d.column} [{d.unit}]" if d.unit else d.column
            rows.append([column, d.label, str(d.instants), *numbers, largest, *peaks])
        return table(head, rows, words=(0, 1))

    def summary(self) -> str:
        """The result as text."""
        return f"Differences from {self.reference}\n\n{self.table()}"

    def as_dict(self) -> dict[str, Any]:
        """Reference, columns and differences as plain numbers and texts."""
        found = {"reference": self.reference, "columns": list(self.columns)}
        return {**found, "differences": [asdict(difference) for difference in self.differences]}

    def figure(
        self,
        path: Path | str | None = None,
        *,
        title: str = "",
        dpi: float | None = None,
        style: Style | str | Path | Mapping[str, Any] | None = None,
    ) -> Any:
        """All curves laid over each other, a panel for each column: runs as lines, experiments as marks.

        Parameters
        ----------
        path : path, optional
            A PNG, PDF or SVG file, by its ending. Default: none is written.
        title : str
            Where the style has one.
        dpi : float, optional
            Resolution of a PNG file [1/inch]. Default: the style's.
        style : Style, str, path or mapping, optional
            As for `membrane_rs.plotting.plot_comparison`.

        Returns
        -------
        matplotlib.figure.Figure
            Without pyplot: nothing has to be closed.
        """
        runs = {curves.label: curves.table for curves in self.curves if not curves.is_measured}
        return plot_comparison(
            runs or (),
            None if self.columns == DEFAULTS else list(self.columns),
            experiments={curves.label: curves.table for curves in self.curves if curves.is_measured},
            path=path,
            title=title,
            dpi=dpi,
            style=style,
        )

    def __repr__(self) -> str:
        """Labels and columns."""
        others = ", ".join(curves.label for curves in self.curves if curves.label != self.reference)
        return f"Comparison({others} with {self.reference}: {', '.join(self.columns)})"


def compare(
    curves: Sequence[Compared] | Mapping[str, Compared],
    columns: Sequence[str] | str | None = None,
    *,
    reference: str | None = None,
    labels: Sequence[str] | None = None,
) -> Comparison:
    """Compare curves of runs and experiments with those of one of them.

    Parameters
    ----------
    curves : sequence or mapping
        Two or more: runs, folders of runs, and measured curves: CSV files as `membrane_rs.results.read_experiment`
        reads them, `Experiment`, arrays by name, tables of pandas. A mapping gives each its label. Measured values are
        converted to the units of the runs.
    columns : sequence of str, or "all", optional
        Names of columns. Default: those of the experiments; without any, the deployment rate and, where a hub turns,
        the phase difference. "all": each that the reference shares with another.
    reference : str, optional
        Label of the one with which the others are compared. Default: the first.
    labels : sequence of str, optional
        One for each. Default: names of folders and files.

    Returns
    -------
    Comparison
        Differences, as a table and as numbers, and the figure.

    Raises
    ------
    InputError
        Fewer than two; a column, label or unit that does not fit; curves that share no time.
    MissingFileError, OutputError
        A folder or file that is not there, or cannot be read.

    Examples
    --------
    >>> import membrane_rs
    >>> from membrane_rs.study import compare
    >>> runs = {f"{dt:g} s": membrane_rs.run("spinning-tether", 0.01, dt=dt) for dt in (1e-5, 2e-5)}
    >>> found = compare(runs, ["kinetic_energy"])
    >>> found.reference, found.difference("2e-05 s", "kinetic_energy").share < 1e-6
    ('1e-05 s', True)
    """
    given = read_curves(curves, labels)
    first = _reference(given, reference)
    chosen = _columns(given, first, columns)
    differences = []
    for column in chosen:
        for other in given:
            if other is not first and column in other.table:
                difference = _difference(other, first, column)
                differences += [difference] if difference is not None else []
    if not differences:
        raise InputError(
            f"{first.label}: shares no time with another curve in {', '.join(chosen)}; compare curves of the same time"
        )
    return Comparison(first.label, tuple(chosen), tuple(differences), tuple(given))


def _reference(given: Sequence[Curves], wanted: str | None) -> Curves:
    """The curves of a label. Raises InputError."""
    if wanted is None:
        return given[0]
    for curves in given:
        if curves.label == wanted:
            return curves
    raise InputError(f"reference = {show(wanted)}: is no label; {nearest(str(wanted), [c.label for c in given])}")


def _columns(given: Sequence[Curves], reference: Curves, wanted: Sequence[str] | str | None) -> list[str]:
    """The columns that are compared, in their order. Raises InputError."""
    shared = [c for c in reference.columns if any(c in other.table for other in given if other is not reference)]
    if wanted is not None and wanted != ALL:
        if isinstance(wanted, str) or not all(isinstance(name, str) for name in wanted):
            raise InputTypeError(f"columns = {show(wanted)}: must be a list of names of columns, or {ALL!r}")
        for name in wanted:
            if name not in shared:
                what = "is in no other curve" if name in reference.table else f"is not in {reference.label}"
                raise InputError(f"columns: {show(name)} {what}; {nearest(name, shared) if shared else 'none is'}")
        if not wanted:
            raise InputError("columns = []: must name one or more, or be left out")
        return list(dict.fromkeys(wanted))
    measured = [name for curves in given if curves.is_measured for name in curves.columns]
    usual = dict.fromkeys(name for name in measured if not _is_uncertainty(name, measured)) or DEFAULTS
    found = [
        name
        for name in shared
        if (wanted == ALL or name in usual)
        and name not in BOOKKEEPING
        and not _is_uncertainty(name, measured)
        and _is_known(given, reference, name)
    ]
    if not found:
        names = ", ".join(shared) or "none at all"
        raise InputError(f"{reference.label}: shares no values of {', '.join(usual)} with another; it shares {names}")
    return found


def _is_uncertainty(name: str, columns: Sequence[str]) -> bool:
    """Whether a column holds the standard deviations of another one."""
    return name.endswith(DEVIATION) and name.removesuffix(DEVIATION) in columns


def _is_known(given: Sequence[Curves], reference: Curves, name: str) -> bool:
    """Whether the reference and another one have values of a column, which for the phase are more than rounding."""
    if name == DEFAULTS[1] and not any(turns(each.table) for each in given if name in each.table):
        return False
    others = [other for other in given if other is not reference and name in other.table]
    return len(reference.curve(name)[0]) > 0 and any(len(other.curve(name)[0]) for other in others)


def _difference(curves: Curves, reference: Curves, column: str) -> Difference | None:
    """The difference in a column; None where both share no time."""
    one, other = curves.curve(column), reference.curve(column)
    if not len(one[0]) or not len(other[0]):
        return None
    start, end = max(one[0][0], other[0][0]), min(one[0][-1], other[0][-1])
    near, far = _within(one, start, end), _within(other, start, end)
    instants = near[0] if 0 < len(near[0]) < len(far[0]) or not len(far[0]) else far[0]
    if not len(instants):
        return None
    values = np.interp(instants, *other)
    d = np.interp(instants, *one) - values
    worst = int(np.argmax(np.abs(d)))
    largest = float(d[worst])
    rms = abs(largest) * float(np.sqrt(np.mean((d / largest) ** 2))) if largest else 0.0
    extent = float(np.ptp(far[1])) if len(far[1]) else 0.0
    peaks = [_peak(*some) for some in (near, far)]
    return Difference(
        label=curves.label,
        column=column,
        unit=reference.table.units[column],
        instants=len(instants),
        start=float(start),
        end=float(end),
        rms=rms,
        share=rms / extent if extent > 0.0 else float("nan"),
        mean=float(np.mean(d)),
        largest=largest,
        largest_time=float(instants[worst]),
        peak=peaks[0][1],
        peak_time=peaks[0][0],
        reference_peak=peaks[1][1],
        reference_peak_time=peaks[1][0],
    )


def _within(curve: tuple[Floats, Floats], start: float, end: float) -> tuple[Floats, Floats]:
    """The samples from `start` to `end` [s]."""
    inside = (curve[0] >= start) & (curve[0] <= end)
    return curve[0][inside], curve[1][inside]


def _peak(time: Floats, values: Floats) -> tuple[float, float]:
    """Time [s] and value of the largest magnitude; NaN without samples."""
    if not len(time):
        return float("nan"), float("nan")
    k = int(np.argmax(np.abs(values)))
    return float(time[k]), float(values[k])


def _at(value: float, time: float) -> str:
    """A value and its time [s]."""
    return f"{_number(value)} at {_number(time)} s" if np.isfinite(value) else "-"


def _number(value: float) -> str:
    return f"{value:.4g}" if np.isfinite(value) else "-"
