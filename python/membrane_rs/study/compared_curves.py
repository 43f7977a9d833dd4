"""What is compared: runs and measured curves, each with a label, its times and its columns."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._files import path_of
from membrane_rs._validation import show, texts_of
from membrane_rs.errors import InputError, InputTypeError, MissingFileError
from membrane_rs.results.experiment import Experiment
from membrane_rs.results.given_experiment import ExperimentLike, experiment_of, is_experiment
from membrane_rs.results.history import HISTORY
from membrane_rs.results.run_history import RunHistory
from membrane_rs.results.summary import SUMMARY
from membrane_rs.runs import Run, open_run

Compared: TypeAlias = Run | ExperimentLike
"""A run, the folder of one, or measured curves: a CSV file, an `Experiment`, arrays by name, a table of pandas."""


@dataclass(frozen=True, eq=False)
class Curves:
    """Columns against time, of a run or of an experiment.

    Attributes
    ----------
    label : str
        What it is called in tables and figures.
    table : RunHistory
        The columns by name, (samples,) each, "time" [s] among them, with their units.
    is_measured : bool
        Whether it is an experiment.

    Examples
    --------
    >>> import numpy as np
    >>> from membrane_rs.results import Experiment
    >>> from membrane_rs.study import compare
    >>> both = [Experiment(name, np.arange(3.0), {"hub_force": np.ones(3)}, {"hub_force": "N"}) for name in "ab"]
    >>> curves = compare(both).curves[0]
    >>> curves.label, curves.columns, curves.is_measured, curves.curve("hub_force")[1]
    ('a', ['hub_force'], True, array([1., 1., 1.]))
    """

    label: str
    table: RunHistory
    is_measured: bool

    @property
    def columns(self) -> list[str]:
        """Names of the columns without the time."""
        return [name for name in self.table if name != "time"]

    def curve(self, name: str) -> tuple[Floats, Floats]:
        """Times and values of a column, where there are any.

        Parameters
        ----------
        name : str
            Of the column.

        Returns
        -------
        (n,) float, (n,) float
            [s], and in the unit of the column.

        Raises
        ------
        InputError
            No such column.
        """
        time, values = self.table["time"], self.table[name]
        known = np.isfinite(values)
        return time[known], values[known]


def read_curves(given: Sequence[Compared] | Mapping[str, Compared], labels: Sequence[str] | None) -> list[Curves]:
    """All that is compared, runs read first: values of experiments are converted to their units.

    Raises
    ------
    InputError
        Fewer than two; another number of labels; a label twice; a unit of one that is no unit of another.
    MissingFileError, OutputError
        Of the files.
    """
    if isinstance(given, Mapping) and labels is None:
        given, labels = list(given.values()), [str(label) for label in given]
    if isinstance(given, str | Path) or not isinstance(given, Sequence):
        raise InputTypeError(f"curves = {show(given)}: must be a list of runs, folders of runs and CSV files")
    if len(given) < 2:
        raise InputError(f"compare: {len(given)} of two or more curves; name runs' folders and CSV files")
    names = _labels(given, labels)
    runs = {k: run for k, item in enumerate(given) if (run := _run(item)) is not None}
    units: dict[str, str] = {}
    found: dict[int, Curves] = {}
    for k, run in runs.items():
        for name, unit in run.history.units.items():
            if units.setdefault(name, unit) != unit:
                raise InputError(
                    f"{names[k]}: its column {show(name)} is in {unit!r}, that of another run in {units[name]!r}; "
                    "record it in the same unit"
                )
        found[k] = Curves(names[k], run.history, False)
    for k, item in enumerate(given):
        if k not in runs:
            assert not isinstance(item, Run)
            experiment = experiment_of(item, units, f"curves: {names[k]}", names[k])
            units |= {name: unit for name, unit in experiment.units.items() if unit and name not in units}
            table = {"time": experiment.time, **experiment.columns}
            found[k] = Curves(names[k], RunHistory(table, experiment.units), True)
    for curves in found.values():
        if not len(curves.table["time"]):
            raise InputError(f"{curves.label}: has no samples yet; compare it when it has run")
    return [found[k] for k in range(len(given))]


def _run(item: object) -> Run | None:
    """The run that something is or names; None for measured curves. Raises MissingFileError and InputTypeError."""
    if isinstance(item, Run):
        return item
    if not isinstance(item, str | os.PathLike) and is_experiment(item):
        return None
    path = path_of(item, "curves")
    if not path.exists():
        raise MissingFileError(f"no run and no file at {path}; name a run's folder, or a CSV file of measured curves")
    is_history = path.name == HISTORY and (path.parent / SUMMARY).is_file()
    if path.is_dir() or path.name == SUMMARY or is_history:
        return open_run(path.parent if is_history else path)
    return None


def _labels(given: Sequence[Compared], labels: Sequence[str] | None) -> list[str]:
    """One label each: those given, or names of folders and files; with their paths where these are the same."""
    if labels is not None:
        labels = texts_of("labels", labels, "a list of texts")
        if len(labels) != len(given):
            raise InputError(f"{len(labels)} labels for {len(given)} curves; give one for each, or none at all")
        found = labels
    else:
        short, long = zip(*(_names(item, k) for k, item in enumerate(given)), strict=True)
        found = [long[k] if short.count(name) > 1 else name for k, name in enumerate(short)]
    for label in found:
        if found.count(label) > 1:
            raise InputError(f"curves: {show(label)} stands for two of them; give each a label of its own")
    return found


def _names(item: Compared, index: int) -> tuple[str, str]:
    """A short and a long name."""
    if isinstance(item, Experiment):
        return item.name, f"{item.name} ({index + 1})"
    if not isinstance(item, str | os.PathLike | Run):
        return (f"measured {index + 1}",) * 2
    if isinstance(item, Run):
        name = item.scene.name if item.path is None else item.path.name
        return name, f"{name} ({index + 1})" if item.path is None else str(item.path)
    path = path_of(item, "curves")
    if path.is_dir():
        return path.resolve().name, str(path)
    return (path.parent.resolve().name if path.name in (SUMMARY, HISTORY) else path.stem), str(path)
