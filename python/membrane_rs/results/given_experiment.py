"""Measured curves as callers give them: a CSV file, an `Experiment`, a mapping of arrays, or a table of pandas."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol, TypeAlias

import numpy as np

from membrane_rs._validation import show
from membrane_rs.errors import InputTypeError
from membrane_rs.results.experiment import TIME, Experiment, converted, header, headings
from membrane_rs.results.experiment_file import read_experiment


class DataFrame(Protocol):
    """What is needed of a table of pandas."""

    @property
    def columns(self) -> Any:
        """Names of the columns."""

    @property
    def index(self) -> Any:
        """Names of the rows, which may be the times."""

    @property
    def iloc(self) -> Any:
        """Columns by their place."""


ExperimentLike: TypeAlias = str | Path | Experiment | Mapping[str, Any] | DataFrame
"""What stands for measured curves."""


def is_experiment(given: object) -> bool:
    """Whether something stands for measured curves."""
    return isinstance(given, str | os.PathLike | Experiment | Mapping) or is_data_frame(given)


def is_data_frame(given: object) -> bool:
    """Whether something is a table of pandas."""
    return all(hasattr(given, name) for name in ("columns", "index", "iloc"))


def experiment_of(
    given: ExperimentLike, units: Mapping[str, str] | None = None, place: str = "data", name: str = "measured"
) -> Experiment:
    """Measured curves, in the units that are wanted.

    Parameters
    ----------
    given : path, Experiment, mapping or pandas.DataFrame
        A CSV file (`read_experiment`), an `Experiment`, or columns by name, one of them "time" [s], or the index of
        that name. Names may be followed by units in brackets, as in files: "time [ms]", "hub_torque [mN m]".
    units : mapping of str to str, optional
        As for `Experiment.in_units`.
    place : str
        What messages call it.
    name : str
        Name of curves that have none.

    Raises
    ------
    InputError, InputTypeError, MissingFileError
        What is no table of measured curves.
    """
    if isinstance(given, Experiment):
        return given.in_units(units or {})
    if isinstance(given, str | os.PathLike):
        return read_experiment(given, units)
    if isinstance(given, Mapping):
        known = getattr(given, "units", {})
        return _from_columns(list(given.items()), known, place, name).in_units(units or {})
    if is_data_frame(given):
        frame: Any = given
        known = getattr(frame, "attrs", {}).get("units", {})
        return _from_columns(_columns_of(frame), known, place, name).in_units(units or {})
    raise InputTypeError(
        f"{place} = {show(given)}: must be the path of a CSV file, an Experiment, a mapping of names to arrays, or a "
        "DataFrame of pandas"
    )


def _from_columns(given: list[tuple[Any, Any]], known: object, place: str, name: str) -> Experiment:
    """Curves of columns by names with units. Raises InputError and InputTypeError."""
    keys, values = [key for key, _ in given], [one for _, one in given]
    units = headings(keys, place)
    columns = dict(zip(units, values, strict=True))
    if isinstance(known, Mapping):
        units = {own: unit or str(known.get(key) or "") for key, (own, unit) in zip(keys, units.items(), strict=True)}
    time, unit = columns.pop(TIME), units.pop(TIME)
    made = Experiment(name, time, columns, units)
    if not unit or unit == "s":
        return made
    return Experiment(name, converted(made.time, unit, "s", f"{place}, column 'time'"), columns, units)


def _columns_of(frame: Any) -> list[tuple[Any, Any]]:
    """Names and values of a table of pandas; its index, if that is the time."""
    found = [(name, _array_of(frame.iloc[:, k])) for k, name in enumerate(frame.columns)]
    index = getattr(frame.index, "name", None)
    names = {parts[0] for name, _ in found if isinstance(name, str) and (parts := header(name))}
    if isinstance(index, str) and (parts := header(index)) and parts[0] == TIME and TIME not in names:
        found.insert(0, (index, _array_of(frame.index)))
    return found


def _array_of(column: Any) -> Any:
    """The values of a column; missing ones of the numbers of pandas as NaN."""
    if hasattr(column.dtype, "na_value") and getattr(column.dtype, "kind", "O") in "fiu":
        return column.to_numpy(dtype=np.float64, na_value=np.nan)
    return column.to_numpy()
