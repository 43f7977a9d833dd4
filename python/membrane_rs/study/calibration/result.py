"""The result of a calibration: values, how far they are known, tables, a figure, files."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._files import made_folder, write_text
from membrane_rs.errors import MissingExtraError
from membrane_rs.scene import Scene
from membrane_rs.study.calibration.analysis import NORMAL_95, UNDETERMINED, Analysis, FittedParameter
from membrane_rs.study.calibration.model import Curves, DataColumn, FitModel
from membrane_rs.study.calibration.report import (
    plot_calibration,
    table_of_columns,
    table_of_correlation,
    table_of_parameters,
)

CALIBRATED = "calibrated"
OUTPUTS = ("calibration.md", "calibration.json", "calibration.png")
NEAR = 1e-3
"""A value this near to an end of its range, as a share of it, is at that end."""


@dataclass(frozen=True)
class Calibration:
    """Parameters of a scene that were fitted to measured curves.

    Attributes
    ----------
    parameters : sequence of FittedParameter
        In the order of `vary`.
    columns : sequence of DataColumn
        What was measured, as far as it was used.
    misfit, first_misfit : float
        Root mean square of the residuals [-], in standard deviations of the data or, where none were given, in standard
        deviations of each column; at the end and at the start.
    residuals : mapping of str to float
        By column, root mean square in its unit.
    analysis : Analysis or None
        How far the parameters are known; None where the runs did not suffice.
    method, outcome : str
        What was used, and how it ended.
    trials : sequence
        Values and misfit of all sets that ran, in their order; the misfit of those that failed is None.
    runs : int
        Number of runs, all starts counted.
    failures : sequence of str
        Sets whose runs failed, and why.
    unused : int
        Measured values outside of the time of the runs.
    path : Path or None
        Folder of the runs.

    Examples
    --------
    >>> import numpy as np
    >>> from membrane_rs.results import Experiment
    >>> from membrane_rs.study import calibrate
    >>> time = np.linspace(0.0, 0.05, 6)
    >>> force = {"hub_force": 0.009 * np.ones(6)}
    >>> data = Experiment("measured", time, force, {"hub_force": "N"})
    >>> found = calibrate("spinning-tether", data, {"laws.spin.frequency": "1:4"}, samples=6, most_runs=20)
    >>> list(found.values), found.runs <= 20, found.table().splitlines()[0][:15]
    (['laws.spin.frequency'], True, '| parameter | s')
    >>> figure = found.plot()
    >>> [path.name for path in found.save("calibrated")]
    ['calibrated', 'calibration.md', 'calibration.json', 'calibration.png']
    >>> found.as_dict()["method"]
    'least-squares'
    """

    parameters: Sequence[FittedParameter]
    columns: Sequence[DataColumn]
    misfit: float
    first_misfit: float
    residuals: Mapping[str, float]
    analysis: Analysis | None
    method: str
    outcome: str
    trials: Sequence[tuple[Mapping[str, float], float | None]]
    runs: int
    failures: Sequence[str]
    unused: int
    _scene: Scene
    _first: Curves
    _best: Curves
    path: Path | None = None

    def __repr__(self) -> str:
        """Outcome, values and misfit, in a line."""
        values = ", ".join(f"{key} = {value:.6g}" for key, value in self.values.items())
        return f"Calibration({self.outcome}: {values}; misfit {self.misfit:.4g})"

    @property
    def values(self) -> dict[str, float]:
        """The fitted values by key, each in its unit."""
        return {one.key: one.value for one in self.parameters}

    @cached_property
    def spreads(self) -> dict[str, float]:
        """By column, standard deviation of one start at the fitted values, RMS in its unit; NaN with one start."""
        single = self._best.noise * math.sqrt(len(self._best.runs))
        return _rms_by_column(self.columns, single)

    @cached_property
    def scene(self) -> Scene:
        """The scene with the fitted values."""
        return self._scene.with_values(self.values)

    @property
    def undetermined(self) -> list[str]:
        """What the data do not determine: parameters, or combinations of several."""
        ends = [f"{one.key}, at the {one.end} end of its range" for one in self.parameters if one.end]
        near = [
            f"{one.key}, whose 95 % interval holds the {one.reaches} end of its range"
            for one in self.parameters
            if one.reaches and not one.end and one.error <= UNDETERMINED  # others are in a combination below
        ]
        return [*ends, *near, *(self.analysis.undetermined if self.analysis else ())]

    @property
    def warnings(self) -> list[str]:
        """What speaks against the result."""
        found = [f"not determined by these data: {what}" for what in self.undetermined]
        if self.unused:
            found.append(f"{self.unused} measured values are not used: they lie outside of the time of the runs")
        count = sum(len(column.time) for column in self.columns)
        if count <= len(self.parameters) and not all(column.has_deviation for column in self.columns):
            found.append(
                f"no standard deviations: measured values are {count}, parameters {len(self.parameters)}; give more "
                "values, or the standard deviations of these (uncertainty)"
            )
        if self.analysis is None:
            found.append("no standard deviations: the number of runs did not suffice; allow more (most_runs)")
        elif self.analysis.is_hidden:
            found.append(
                "the spread of the starts hides what changes with the undetermined parameters; take more starts, a "
                "larger step, or the method 'nelder-mead'"
            )
        return found + [f"failed: {failure}" for failure in self.failures]

    def table(self) -> str:
        """Parameters, columns, sensitivities and correlations.

        Returns
        -------
        str
            Tables in Markdown.
        """
        parts = [
            table_of_parameters(self.parameters),
            table_of_columns(self.columns, self.residuals, self.spreads, self.parameters, self.analysis),
        ]
        if self.analysis is not None and len(self.parameters) > 1:
            parts.append(table_of_correlation([one.key for one in self.parameters], self.analysis.correlation))
        return "\n".join([*parts, "".join(f"- {line}\n" for line in self.warnings)]).rstrip() + "\n"

    def plot(self, path: str | Path | None = None, **options: Any) -> Any:
        """The data, and the curves before and after, with the spread of their starts.

        Parameters
        ----------
        path : path, optional
            A PNG, PDF or SVG file.
        **options
            As in `membrane_rs.plotting.plot_comparison`: title, dpi, style.

        Returns
        -------
        matplotlib.figure.Figure
            Without pyplot: nothing has to be closed.
        """
        return plot_calibration(self.columns, self._first.runs, self._best.runs, path=path, **options)

    def save(self, folder: str | Path, **options: Any) -> list[Path]:
        """Write the scene with the fitted values, the tables, the numbers and the figure into a folder.

        Parameters
        ----------
        folder : path
            Made where it is missing.
        **options
            As in `plot`.

        Returns
        -------
        list of Path
            The folder calibrated/ with scene.toml, calibration.md, calibration.json, and calibration.png where
            matplotlib is installed.

        Raises
        ------
        OutputError
            One cannot be written.
        InputError, InputTypeError
            No path.
        """
        place = made_folder(folder)
        tables, numbers, figure = (place / name for name in OUTPUTS)
        scene = place / CALIBRATED
        self.scene.save(scene)
        write_text(tables, self.table())
        write_text(numbers, json.dumps(self.as_dict(), indent=2) + "\n")
        try:
            self.plot(figure, **options)
        except MissingExtraError:
            return [scene, tables, numbers]
        return [scene, tables, numbers, figure]

    def as_dict(self) -> dict[str, Any]:
        """The numbers, as plain values for JSON.

        Returns
        -------
        dict of str to object
            Infinite and unknown ones are None.
        """
        known = self.analysis
        return {
            "method": self.method,
            "outcome": self.outcome,
            "misfit": self.misfit,
            "first_misfit": self.first_misfit,
            "parameters": {one.key: {**_plain(one), "is_determined": one.is_determined} for one in self.parameters},
            "residuals": dict(self.residuals),
            "spreads": {name: _known(value) for name, value in self.spreads.items()},
            "correlation": None if known is None else _finite(known.correlation),
            "sensitivity": None if known is None else _finite(known.sensitivity),
            "undetermined": self.undetermined,
            "runs": self.runs,
            "failures": list(self.failures),
            "unused": self.unused,
        }


def calibration_of(
    scene: Scene,
    model: FitModel,
    start: tuple[Floats, Curves],
    best: tuple[Floats, Curves],
    known: Analysis | None,
    *,
    method: str,
    outcome: str,
    path: Path | None,
    unused: int = 0,
) -> Calibration:
    """The result: shares and curves at the start and at the best values, and how far these are known."""
    errors = np.full(len(model.parameters), np.inf) if known is None else known.errors
    fitted = []
    for one, first, share, error in zip(model.parameters, start[0], best[0], errors, strict=True):
        reach = min(float(error), 10.0) if np.isfinite(error) else math.nan
        end = "lower" if share < NEAR else "upper" if share > 1.0 - NEAR else ""
        around = one.at(float(share) - reach), one.at(float(share) + reach)
        sides = ("lower", share - NORMAL_95 * error < 0.0), ("upper", share + NORMAL_95 * error > 1.0)
        reaches = "" if known is None else " and ".join(side for side, is_held in sides if is_held)
        values = one.at(float(first)), one.at(float(share)), *around
        fitted.append(FittedParameter(one.key, one.unit, *values, float(error), end, reaches))
    in_units = _rms_by_column(model.columns, best[1].residuals)
    trials = [(model.values(key), None if one.failure else one.misfit) for key, one in model.known.items()]
    failures = [one.failure for one in model.known.values() if one.failure]
    return Calibration(
        fitted, model.columns, best[1].misfit, start[1].misfit, in_units, known, method, outcome, trials,
        len(model.known) * model.starts, failures, unused, scene, start[1], best[1], path,
    )  # fmt: skip


def _rms_by_column(columns: Sequence[DataColumn], scaled: Floats) -> dict[str, float]:
    """Root mean square of each column, in its unit, of values of all columns in their scales."""
    parts = np.split(scaled, np.cumsum([len(column.time) for column in columns])[:-1])
    return {
        column.name: float(np.sqrt(np.mean((part * column.scale) ** 2)))
        for column, part in zip(columns, parts, strict=True)
    }


def _plain(one: FittedParameter) -> dict[str, Any]:
    """Without numbers that JSON lacks."""
    names = ("unit", "start", "value", "low", "high", "error", "end")
    return {name: _known(getattr(one, name)) for name in names}


def _known(value: str | float) -> str | float | None:
    return None if isinstance(value, float) and not np.isfinite(value) else value


def _finite(matrix: Floats) -> list[list[float | None]]:
    return [[float(value) if np.isfinite(value) else None for value in row] for row in matrix]
