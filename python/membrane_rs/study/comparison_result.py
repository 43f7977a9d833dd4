"""The result of a comparison: differences from a reference as a table and as numbers, and a figure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from membrane_rs._markdown import table
from membrane_rs._renamed import Renamed
from membrane_rs._validation import show
from membrane_rs.errors import InputError
from membrane_rs.plotting.comparison import plot_comparison
from membrane_rs.plotting.deployment import PANELS
from membrane_rs.plotting.style import Style
from membrane_rs.study.compared_curves import Curves

DEFAULTS = tuple(column for column, _, _ in PANELS)


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
    rms, mean, largest : float
        Of the difference, in the unit of the column.
    largest_time : float
        Of the largest difference [s].
    share : float
        The rms over the range of the reference [-]; NaN where that does not change.
    peak, reference_peak : float
        Peaks of both, in the unit of the column.
    peak_time, reference_peak_time : float
        Their times [s].

    Examples
    --------
    >>> import numpy as np
    >>> from membrane_rs.results import Experiment
    >>> from membrane_rs.study import compare
    >>> force = {"hub_force": np.array([1.0, 2.0, 3.0])}, {"hub_force": np.array([1.0, 2.0, 3.3])}
    >>> both = [Experiment(name, np.arange(3.0), each, {"hub_force": "N"}) for name, each in zip("ab", force)]
    >>> found = compare(both).difference("b", "hub_force")
    >>> round(found.largest, 3), found.largest_time, found.unit, found.instants
    (0.3, 2.0, 'N', 3)
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

    Examples
    --------
    >>> import membrane_rs
    >>> from membrane_rs.study import compare
    >>> steps = {"a": 1e-5, "b": 2e-5}
    >>> made = {name: membrane_rs.run("spinning-tether", 0.01, dt=dt, samples=11) for name, dt in steps.items()}
    >>> found = compare(made, ["kinetic_energy"])
    >>> found.difference("b", "kinetic_energy").rms < 1e-9
    True
    >>> found.table().splitlines()[0][:28], found.summary().splitlines()[0]
    ('| column | curve | instants ', 'Differences from a')
    >>> found.as_dict()["columns"], len(found.plot().axes)
    (['kinetic_energy'], 1)
    """

    reference: str
    columns: tuple[str, ...]
    differences: tuple[Difference, ...]
    curves: tuple[Curves, ...]

    def difference(self, label: str, column: str) -> Difference:
        """That of one curve in one column.

        Parameters
        ----------
        label : str
            Of the curve.
        column : str
            Name of the column.

        Returns
        -------
        Difference
            From the reference.

        Raises
        ------
        InputError
            There is none.
        """
        for found in self.differences:
            if (found.label, found.column) == (label, column):
                return found
        known = ", ".join(f"{found.label!r} in {found.column!r}" for found in self.differences)
        raise InputError(f"no difference of {show(label)} in {show(column)}; there are those of {known}")

    def table(self) -> str:
        """The differences as a table.

        Returns
        -------
        str
            In Markdown.
        """
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
        """The result as text.

        Returns
        -------
        str
            Several lines.
        """
        return f"Differences from {self.reference}\n\n{self.table()}"

    def as_dict(self) -> dict[str, Any]:
        """Reference, columns and differences as plain numbers and texts.

        Returns
        -------
        dict of str to object
            By these names.
        """
        found = {"reference": self.reference, "columns": list(self.columns)}
        return {**found, "differences": [asdict(difference) for difference in self.differences]}

    def plot(
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

        Raises
        ------
        InputError
            A style, a resolution or an ending of `path` that does not exist.
        OutputError
            `path` cannot be written.
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

    figure = Renamed("plot")

    def __repr__(self) -> str:
        """Labels and columns."""
        others = ", ".join(curves.label for curves in self.curves if curves.label != self.reference)
        return f"Comparison({others} with {self.reference}: {', '.join(self.columns)})"


def _at(value: float, time: float) -> str:
    """A value and its time [s]."""
    return f"{_number(value)} at {_number(time)} s" if np.isfinite(value) else "-"


def _number(value: float) -> str:
    return f"{value:.4g}" if np.isfinite(value) else "-"
