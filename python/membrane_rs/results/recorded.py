"""Measures that a run records: functions of the simulation, each a column of the history, with its unit."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any

from membrane_rs._validation import check_text, show
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.simulation.measures import reading
from membrane_rs.simulation.motion import Motion

LONGEST_NAME = 100
"""Characters of the name of a measure, and of its unit."""
MOST = 1000
"""More measures than this are taken as an input error."""
Recorded = Mapping[str, Callable[[Any], float] | tuple[Callable[[Any], float], str]]
"""By the name of its column, a function that takes the simulation and gives a number, or that and its unit."""


class Measures:
    """The measures of a run, checked.

    Raises
    ------
    InputError, InputTypeError
        A name or a unit that no column can have, something that is no function.
    """

    def __init__(self, given: Recorded | None = None) -> None:
        if given is None:
            given = {}
        if not isinstance(given, Mapping):
            raise InputTypeError(f"record = {show(given)}: must be a table of names and functions, such as {_EXAMPLE}")
        if len(given) > MOST:
            raise InputError(f"record: {len(given)} measures; must be at most {MOST}")
        self._functions: dict[str, Callable[[Any], float]] = {}
        self.units: dict[str, str] = {}
        """By name, empty for a number alone."""
        for name, item in given.items():
            check_column(name, f"record: the name {show(name)}")
            where = f"record[{show(name)}]"
            function, unit = item if isinstance(item, tuple) and len(item) == 2 else (item, "")
            if not callable(function):
                what = "must be a function of the simulation, or a function and its unit, such as"
                raise InputTypeError(f"{where} = {show(item)}: {what} {_EXAMPLE}")
            check_unit(unit, f"{where}: the unit {show(unit)}")
            self._functions[name], self.units[name] = function, unit

    def check_names(self, columns: Collection[str]) -> None:
        """Refuse a name that another column has. Raises InputError."""
        twice = next((name for name in self.units if name in columns), None)
        if twice is not None:
            raise InputError(f"record[{twice!r}]: is the name of a column that each history has; give it another one")

    def values(self, sim: Motion) -> list[float]:
        """All measures now. Raises InputError and InputTypeError for one that gives no number or changes something."""
        return [
            reading(function, sim, f"record[{name!r}]", self.units[name] or "a number")
            for name, function in self._functions.items()
        ]


_EXAMPLE = '{"speed": (lambda sim: abs(sim.velocities).max(), "m/s")}'


def check_column(name: object, where: str) -> None:
    """Refuse what cannot name a column. Raises InputError and InputTypeError, which begin with `where`."""
    if not isinstance(name, str):
        raise InputTypeError(f"{where}: must be a text")
    check_text(name, where)
    if not 1 <= len(name) <= LONGEST_NAME or not name.isprintable() or name != name.strip():
        raise InputError(f"{where}: must be 1 to {LONGEST_NAME} characters in one line, without blanks at its ends")


def check_unit(unit: object, where: str) -> None:
    """Refuse what is no text of a unit. Raises InputError and InputTypeError, which begin with `where`."""
    if not isinstance(unit, str):
        raise InputTypeError(f"{where}: must be a text such as 'N m', empty for a number alone")
    check_text(unit, where)
    if len(unit) > LONGEST_NAME or not unit.isprintable():
        raise InputError(f"{where}: must be at most {LONGEST_NAME} characters in one line")
