"""Measured curves as data: times, columns named as those of a history, and their units.

A column "<name>_std" holds the standard deviations of the column "<name>", in the same unit where it has none of its
own.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._given_arrays import numeric
from membrane_rs._quantities import conversion
from membrane_rs._read_only import ReadOnly
from membrane_rs._validation import nearest, show
from membrane_rs.errors import InputError, InputTypeError

TIME = "time"
DEVIATION = "_std"
"""Ending of the name of a column that holds the standard deviations of another one."""
MOST_COLUMNS = 1000
_HEADER = re.compile(r"\s*(?P<name>[^\[\]()]*?)\s*(?:\[\s*(?P<unit>[^\[\]]*?)\s*\]|\((?P<round>.*)\))?\s*")


def checked_units(units: Mapping[str, str] | None) -> Mapping[str, str]:
    """Units by column, such as {"hub_torque": "N m"}; none for None. Raises InputTypeError for what is no table."""
    if units is None:
        return {}
    if not isinstance(units, Mapping) or not all(isinstance(unit, str) for unit in units.values()):
        raise InputTypeError(f"units = {show(units)}: must be units by column, such as {{'hub_torque': 'N m'}}")
    return units


@dataclass(frozen=True, eq=False)
class Experiment:
    """Curves that were measured.

    Attributes
    ----------
    name : str
        What they are called; of a file its name without the ending.
    time : (n,) float
        Ascending times [s].
    columns : mapping of str to (n,) float
        Measured values by the name of their column, in its unit, NaN where there is none; the time is not among them.
    units : mapping of str to str, optional
        The unit of each column, as text; empty or missing where it is that of the history.

    Raises
    ------
    InputError, InputTypeError
        Times that do not ascend, columns that are no numbers, of another length or infinite, units that are no texts.

    Examples
    --------
    >>> import numpy as np
    >>> from membrane_rs.results import Experiment
    >>> torque = {"hub_torque": np.array([0.5, np.nan])}
    >>> measured = Experiment("drop", np.array([0.0, 1.0]), torque, {"hub_torque": "N m"})
    >>> measured.curve("hub_torque")
    (array([0.]), array([0.5]))
    """

    name: str
    time: Floats
    columns: Mapping[str, Floats]
    units: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Take plain lists as arrays. Raises InputError and InputTypeError."""
        if not isinstance(self.name, str):
            raise InputTypeError(f"name = {show(self.name)}: must be a text")
        time = _values(self.time, f"{self.name}: time", None)
        if not np.isfinite(time).all():
            raise InputError(f"{self.name}: a time is missing; give one for each value, or leave the value out")
        check_ascends(time, self.name)
        if not isinstance(self.columns, Mapping) or not all(isinstance(name, str) for name in self.columns):
            raise InputTypeError(f"{self.name}: columns = {show(self.columns)}: must be a mapping of names to arrays")
        if not 1 <= len(self.columns) <= MOST_COLUMNS:
            raise InputError(f"{self.name}: has {len(self.columns)} columns beside the time; give 1 to {MOST_COLUMNS}")
        if not isinstance(self.units, Mapping):
            raise InputTypeError(f"{self.name}: units = {show(self.units)}: must be a mapping of columns to texts")
        columns = {
            name: _values(given, f"{self.name}, column {name!r}", len(time)) for name, given in self.columns.items()
        }
        units = {name: self._unit_of(name) for name in columns}
        for name, value in (("time", time), ("columns", ReadOnly(columns)), ("units", ReadOnly(units))):
            object.__setattr__(self, name, value)

    def _unit_of(self, name: str) -> str:
        """The unit of a column; of standard deviations that of their column, where they have none of their own."""
        unit = self.units.get(name, "") or self.units.get(_column_of(name), "")
        if not isinstance(unit, str):
            raise InputTypeError(f"{self.name}, column {name!r}: unit {show(unit)}: must be a text, such as 'N m'")
        return unit

    def in_units(self, units: Mapping[str, str]) -> Experiment:
        """The same curves in other units.

        Parameters
        ----------
        units : mapping of str to str
            The wanted unit by column, empty for a plain number; other columns stay as they are. Standard deviations
            follow their column. A column whose unit is not known is taken to be in the wanted one.

        Returns
        -------
        Experiment
            The curves.

        Raises
        ------
        InputError
            A unit of another dimension, or an unknown one.

        Examples
        --------
        >>> from membrane_rs.results import Experiment
        >>> measured = Experiment("drop", [0.0, 1.0], {"hub_torque": [250.0, 500.0]}, {"hub_torque": "mN m"})
        >>> measured.in_units({"hub_torque": "N m"}).columns["hub_torque"]
        array([0.25, 0.5 ])
        """
        units = checked_units(units)
        columns, found = dict(self.columns), dict(self.units)
        for name, unit in self.units.items():
            own = units.get(name, units.get(_column_of(name)))
            if own is None:
                continue
            if unit and unit != own:
                place = f"{self.name}, column {name!r}"
                columns[name] = converted(columns[name], unit, own, place, is_difference=name.endswith(DEVIATION))
            found[name] = own
        return replace(self, columns=columns, units=found)

    def curve(self, name: str) -> tuple[Floats, Floats]:
        """Times and values of a column, where there are any.

        Parameters
        ----------
        name : str
            One of `columns`.

        Returns
        -------
        times : (k,) float
            [s]
        values : (k,) float
            In the unit of the column, `units`.

        Raises
        ------
        InputError
            No such column.
        """
        if not isinstance(name, str) or name not in self.columns:
            raise InputError(f"column {show(name)}: {self.name} has none; it has {', '.join(self.columns)}")
        values = self.columns[name]
        known = np.isfinite(values)
        return self.time[known], values[known]


def header(text: str) -> tuple[str, str] | None:
    """Name and unit of a column from "hub_torque [mN m]" or "rate (1/s)"; None where there is no name."""
    found = _HEADER.fullmatch(text)
    return (found["name"], (found["unit"] or found["round"] or "").strip()) if found and found["name"] else None


def headings(texts: Iterable[object], where: str) -> dict[str, str]:
    """The unit of each column by its name, in their order; empty without one. Raises InputError and InputTypeError."""
    units: dict[str, str] = {}
    for k, text in enumerate(texts, start=1):
        if not isinstance(text, str) or (found := header(text)) is None:
            kind = InputError if isinstance(text, str) else InputTypeError
            raise kind(f"{where}, column {k}: {show(text)} is no name; write one such as 'hub_torque [N m]'")
        name, unit = found
        if name in units:
            raise InputError(f"{where}, column {k}: {show(name)} is there already; give each a name of its own")
        units[name] = unit
    check_has_time(units, where)
    return units


def check_ascends(time: Floats, where: str, lines: Sequence[int] | None = None) -> None:
    """Refuse times [s] that do not ascend; of a file with the line of the first such. Raises InputError."""
    late = np.flatnonzero(np.diff(time) <= 0.0)
    if len(late):
        k = int(late[0])
        place = where if lines is None else f"{where}, line {lines[k + 1]}"
        what = f"time {time[k + 1]:g} s comes after {time[k]:g} s"
        raise InputError(f"{place}: {what}; order the values by time, each time once")


def converted(values: Floats, unit: str, wanted: str, place: str, *, is_difference: bool = False) -> Floats:
    """Values in one unit as values in another; differences without the offset. Raises InputError with the place."""
    try:
        factor, offset = conversion(unit, wanted)
    except InputError as error:
        if not wanted:
            raise InputError(f"{place}: {unit!r} is no unit of a plain number; leave it out") from None
        raise InputError(f"{place}: {error}") from None
    return values * factor + (0.0 if is_difference else offset)


def check_has_time(names: Mapping[str, Any], place: str) -> None:
    """Refuse columns without one of times, or without others. Raises InputError."""
    if TIME not in names:
        near = "" if len(names) > MOST_COLUMNS else f"; {nearest(TIME, names)}" if names else ""
        there = f"the columns are {show(', '.join(names))}" if names else "there are no columns"
        raise InputError(f"{place}: no column is named 'time'; {there}{near}")
    if len(names) == 1:
        raise InputError(f"{place}: 'time' is the only column; add one that is named as in history.csv")


def _column_of(name: str) -> str:
    """The column whose standard deviations one of this name holds."""
    return name.removesuffix(DEVIATION) if name.endswith(DEVIATION) else ""


def _values(given: Any, place: str, count: int | None) -> Floats:
    """(n,) finite numbers and NaN. Raises InputError and InputTypeError."""
    found = np.array(numeric(given, place, "fiu", "real numbers, NaN where nothing was measured"), dtype=np.float64)
    if found.ndim != 1 or (count is not None and len(found) != count):
        wanted = "a list of one number or more" if count is None else f"a list of {count} numbers, as there are times"
        raise InputTypeError(f"{place}: has shape {found.shape}; must be {wanted}")
    if not len(found):
        raise InputError(f"{place}: holds no values; add the measured ones")
    if np.isinf(found).any():
        raise InputError(f"{place}: holds a value that is not finite; give NaN for what was not measured")
    return found
