"""Measures that a run records: functions of the simulation, or known ones by their names, each a column of the history,
with its unit.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

from membrane_rs._validation import check_text, nearest, show
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.scene.stage import MEASURE_UNITS
from membrane_rs.simulation.measures import OF_MOTION, reading
from membrane_rs.simulation.motion import Motion

LONGEST_NAME = 100
"""Characters of the name of a measure, and of its unit."""
MOST = 1000
"""More measures than this are taken as an input error."""
Measure = Callable[[Any], float]
RecordTable = Mapping[str, Measure | tuple[Measure, str] | None]
"""By the name of its column, a function that takes the simulation and gives a number, that and its unit, or None for
the known measure of this name: one of those by which stages end."""
Recorded = RecordTable | Sequence[str]
"""The same, or a list of names of known measures."""


class Measures:
    """The measures of a run, checked.

    Raises
    ------
    InputError, InputTypeError
        A name or a unit that no column can have, something that is no function, an unknown name without a function.
    """

    def __init__(self, given: Recorded | None = None) -> None:
        table = record_table(given)
        if len(table) > MOST:
            raise InputError(f"record: {len(table)} measures; must be at most {MOST}")
        self._functions: dict[str, Measure] = {}
        self.units: dict[str, str] = {}
        """By name, empty for a number alone."""
        self.known: list[str] = []
        """Names of the known ones."""
        for name, item in table.items():
            check_column(name, f"record: the name {show(name)}")
            where = f"record[{show(name)}]"
            if item is None:
                if name not in MEASURE_UNITS:
                    raise InputError(f"record: {show(name)} is no known measure; {nearest(name, MEASURE_UNITS)}")
                self.known.append(name)
                self.units[name] = MEASURE_UNITS[name]
                if name in OF_MOTION:  # what is not is a column of each history
                    self._functions[name] = OF_MOTION[name]
                continue
            function, unit = item if isinstance(item, tuple) and len(item) == 2 else (item, "")
            if not callable(function):
                what = "must be a function of the simulation, or a function and its unit, such as"
                raise InputTypeError(f"{where} = {show(item)}: {what} {_EXAMPLE}")
            check_unit(unit, f"{where}: the unit {show(unit)}")
            self._functions[name], self.units[name] = function, unit

    def beside(self, columns: Collection[str]) -> Measures:
        """Those that are no columns already, as known ones may be. Raises InputError for a function with the name of
        one.
        """
        there = [name for name in self.units if name in columns]
        twice = next((name for name in there if name not in self.known), None)
        if twice is not None:
            raise InputError(f"record[{twice!r}]: is the name of a column that each history has; give it another one")
        left = Measures()
        left._functions = {name: function for name, function in self._functions.items() if name not in there}
        left.units = {name: unit for name, unit in self.units.items() if name not in there}
        left.known = [name for name in self.known if name not in there]
        return left

    def values(self, sim: Motion) -> list[float]:
        """All measures now. Raises InputError and InputTypeError for one that gives no number or changes something."""
        return [
            reading(function, sim, f"record[{name!r}]", self.units[name]) for name, function in self._functions.items()
        ]


def record_table(given: Recorded | None) -> RecordTable:
    """What is to be recorded by the names of its columns. Raises InputTypeError for neither a table nor a list."""
    if given is None or isinstance(given, Mapping):
        return given or {}
    if isinstance(given, str) or not isinstance(given, Sequence):
        hint = f'a list of names such as ["largest_speed"], or a table of names and functions, such as {_EXAMPLE}'
        raise InputTypeError(f"record = {show(given)}: must be {hint}")
    return dict.fromkeys(check_column(name, f"record: the name {show(name)}") for name in given)


_EXAMPLE = '{"speed": (lambda sim: abs(sim.velocities).max(), "m/s")}'


def check_column(name: object, where: str) -> str:
    """The name of a column. Raises InputError and InputTypeError, which begin with `where`, for what cannot be one."""
    if not isinstance(name, str):
        raise InputTypeError(f"{where}: must be a text")
    check_text(name, where)
    if not 1 <= len(name) <= LONGEST_NAME or not name.isprintable() or name != name.strip():
        raise InputError(f"{where}: must be 1 to {LONGEST_NAME} characters in one line, without blanks at its ends")
    return name


def check_unit(unit: object, where: str) -> None:
    """Refuse what is no text of a unit. Raises InputError and InputTypeError, which begin with `where`."""
    if not isinstance(unit, str):
        raise InputTypeError(f"{where}: must be a text such as 'N m', empty for a number alone")
    check_text(unit, where)
    if len(unit) > LONGEST_NAME or not unit.isprintable():
        raise InputError(f"{where}: must be at most {LONGEST_NAME} characters in one line")
