"""The curves of a scene as a function of parameters, at the times of measured data, and their distance from these.

A parameter is a share of its range, from 0 to 1; the range of a logarithmic one is that of its logarithm. A residual is
(mean over starts of the curve - datum) / (scale of the column). All points of one question run in parallel.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._validation import nearest, show
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.results.experiment import DEVIATION, Experiment
from membrane_rs.study.common.many_runs import ManyRuns, Progress
from membrane_rs.study.common.one_run import RunPoint, RunResult
from membrane_rs.study.common.vary import Parameter
from membrane_rs.units import number

LARGEST, SMALLEST = 1e60, 1e-60
"""Bounds of measured values and of their standard deviations, in the unit of the column, so that squares are finite."""
FAILED_SCALE, FAILED_FACTOR = 10.0, 2.0
"""Residuals of parameters whose runs fail: in spreads of their columns, and at least so many times the largest misfit
of those that ran, so that none is taken for better than these.
"""


class BudgetSpent(Exception):  # noqa: N818 - no error: the best values so far are the answer
    """More runs were asked for than a fit may make."""


@dataclass(frozen=True)
class DataColumn:
    """One measured curve of a calibration.

    Attributes
    ----------
    name, unit : str
        Of the column.
    time, values : (n,) float
        When it was measured [s], and what, in its unit.
    scale : (n,) float
        Standard deviation of each value, in its unit; without one given, that of all values.
    has_deviation : bool
        Whether the standard deviations were given.

    Examples
    --------
    >>> import numpy as np
    >>> from membrane_rs.study import DataColumn
    >>> DataColumn("hub_force", "N", np.arange(2.0), np.ones(2), np.full(2, 0.1), True).unit
    'N'
    """

    name: str
    unit: str
    time: Floats
    values: Floats
    scale: Floats
    has_deviation: bool


def data_columns(
    data: Experiment, columns: Sequence[str] | None, uncertainty: Mapping[str, float | str] | None, until: float
) -> list[DataColumn]:
    """The curves of measured data up to a time [s].

    Raises
    ------
    InputError, InputTypeError
        A standard deviation that is not above 0, or of no column; nothing measured in that time.
    """
    if uncertainty is not None and not isinstance(uncertainty, Mapping):
        raise InputTypeError(f"uncertainty = {show(uncertainty)}: must be a table of standard deviations by column")
    given = dict(uncertainty or {})
    names = [name for name in data.columns if name.removesuffix(DEVIATION) not in set(data.columns) - {name}]
    chosen = list(columns) if isinstance(columns, Iterable) and not isinstance(columns, str) else None
    if columns is not None and (chosen is None or not all(isinstance(name, str) for name in chosen)):
        raise InputTypeError(f"columns = {show(columns)}: must be a list of names of columns of the data")
    for place, wanted in (("columns", chosen or ()), ("uncertainty", given)):
        stranger = next((name for name in wanted if name not in names), None)
        if stranger is not None:
            raise InputError(f"{place}: {data.name} has no column {show(stranger)}; it has {', '.join(names)}")
    names = names if chosen is None else list(dict.fromkeys(chosen))
    found = []
    for name in names:
        known = np.isfinite(data.columns[name]) & (data.time >= 0.0) & (data.time <= until)
        time, values = data.time[known], data.columns[name][known]
        if not len(time):
            if columns is None:
                continue
            raise InputError(f"columns: {data.name} has no value of {name!r} from 0 to {until:g} s; leave it out")
        if np.abs(values).max() > LARGEST:
            k = int(np.abs(values).argmax())
            place = f"{data.name}, column {name!r}"
            raise InputError(f"{place}: {values[k]:g} at {time[k]:g} s is beyond {LARGEST:g}; correct it, or its unit")
        deviation = _deviation(data, name, given, known, data.units.get(name, ""))
        sizes = float(np.std(values)), float(np.abs(values).max()), 1.0
        spread = next(size for size in sizes if size > SMALLEST)
        scale = np.full(len(time), spread) if deviation is None else deviation
        found.append(DataColumn(name, data.units.get(name, ""), time, values, scale, deviation is not None))
    if not found:
        raise InputError(f"{data.name}: has no value from 0 to {until:g} s; give data of that time, or another until")
    return found


def _deviation(
    data: Experiment,
    name: str,
    given: Mapping[str, float | str],
    known: np.ndarray[tuple[int], np.dtype[np.bool_]],
    unit: str,
) -> Floats | None:
    """(n,) standard deviations of a column, where they are known."""
    if name in given:
        place = f"uncertainty of {name}"
        deviation = number(given[name], unit, place)
        if not SMALLEST <= deviation <= LARGEST:
            raise InputError(f"{place} = {deviation:g}: must be above 0, from {SMALLEST:g} to {LARGEST:g}")
        return np.full(int(known.sum()), deviation)
    if name + DEVIATION not in data.columns:
        return None
    values = data.columns[name + DEVIATION][known]
    if not ((values >= SMALLEST) & (values <= LARGEST)).all():
        raise InputError(
            f"{data.name}, column {name + DEVIATION!r}: must be above 0, from {SMALLEST:g} to {LARGEST:g}, wherever "
            f"{name!r} has a value"
        )
    return values


@dataclass
class Curves:
    """What the runs of one set of parameters showed.

    Attributes
    ----------
    residuals : (n,) float
        Of all columns, one after the other.
    noise : (n,) float
        Standard error of the mean over the starts, in the same scales; NaN with one start.
    runs : sequence of RunResult
        One for each start.
    failure : str
        Why there are no curves; empty where there are.
    """

    residuals: Floats
    noise: Floats
    runs: Sequence[RunResult]
    failure: str = ""

    @property
    def misfit(self) -> float:
        """Root mean square of the residuals."""
        return math.sqrt(float(np.mean(self.residuals**2)))


@dataclass
class FitModel:
    """Residuals of parameters, each set of which runs once.

    Attributes
    ----------
    runs : ManyRuns
        Makes the runs.
    parameters : sequence of Parameter
        Ranges.
    columns : sequence of DataColumn
        What was measured.
    starts : int
        Runs of each set: of the scene's own start, and of perturbed ones.
    most_runs : int
        A question that would need more raises `BudgetSpent`.
    progress : callable, optional
        As `ManyRuns` has it.
    known : dict
        By shares, what was found, in the order of the questions.
    """

    runs: ManyRuns
    parameters: Sequence[Parameter]
    columns: Sequence[DataColumn]
    starts: int
    most_runs: int
    progress: Progress | None = None
    known: dict[tuple[float, ...], Curves] = field(default_factory=dict)

    def values(self, shares: Sequence[float] | Floats) -> dict[str, float]:
        """The values of the scene by key."""
        return {one.key: one.at(float(share)) for one, share in zip(self.parameters, shares, strict=True)}

    def curves(self, shares: Sequence[Floats]) -> list[Curves]:
        """The curves of some sets of parameters; those that are not known run in parallel."""
        keys = [tuple(round(float(share), 12) for share in one) for one in shares]
        new = [key for key in dict.fromkeys(keys) if key not in self.known]
        if (len(self.known) + len(new)) * self.starts > self.most_runs:
            raise BudgetSpent
        points = [RunPoint(self.values(key), start) for key in new for start in range(self.starts)]
        made = self.runs.all_results(points, self.progress) if points else []
        for k, key in enumerate(new):
            self.known[key] = self._curves(made[k * self.starts : (k + 1) * self.starts])
        worst = max((one.misfit for one in self.known.values() if not one.failure), default=0.0)
        for failed in (self.known[key] for key in new if self.known[key].failure):
            failed.residuals = failed.residuals * max(1.0, FAILED_FACTOR * worst / failed.misfit)
        return [self.known[key] for key in keys]

    def best(self) -> tuple[Floats, Curves]:
        """The shares with the least misfit of all that ran. Raises InputError where none did."""
        ran = {key: found for key, found in self.known.items() if not found.failure}
        if not ran:
            raise InputError(f"no run came to its end: {next(iter(self.known.values())).failure}")
        key = min(ran, key=lambda key: ran[key].misfit)
        return np.array(key), ran[key]

    def _curves(self, runs: Sequence[RunResult]) -> Curves:
        failed = next((run for run in runs if not run.is_finished), None)
        residuals, noise = [], []
        for column in self.columns:
            if failed is not None:
                residuals.append(
                    np.full(
                        len(column.time), FAILED_SCALE * (float(np.std(column.values)) or float(column.scale.max()))
                    )
                    / column.scale
                )
                noise.append(np.full(len(column.time), math.nan))
                continue
            each = np.array([at_times(run, column) for run in runs])
            residuals.append((each.mean(axis=0) - column.values) / column.scale)
            deviation = each.std(axis=0, ddof=1) if len(runs) > 1 else np.full(len(column.time), math.nan)
            noise.append(deviation / math.sqrt(len(runs)) / column.scale)
        text = "" if failed is None else f"{_named(failed)} {failed.outcome}: {failed.message}"
        return Curves(np.concatenate(residuals), np.concatenate(noise), runs, text)


def check_recorded(columns: Sequence[DataColumn], known: Iterable[str]) -> None:
    """Refuse data of columns that no run has, before any is made. Raises InputError."""
    for column in columns:
        if column.name not in known:
            names = [name for name in known if name != "time"]
            raise InputError(
                f"column {column.name!r} of the data: no run records it; {nearest(column.name, names)}; or name the "
                "columns to compare (columns), or record it (record)"
            )


def at_times(run: RunResult, column: DataColumn) -> Floats:
    """(n,) values of a run at the times of measured ones, linear between its samples. Raises InputError."""
    found = np.interp(column.time, run.history["time"], run.history[column.name])
    if not np.isfinite(found).all():
        raise InputError(f"column {column.name!r} of the data: the runs have no finite value there; leave it out")
    return found


def _named(run: RunResult) -> str:
    return ", ".join(f"{key} = {value:.6g}" for key, value in run.point.values.items())
