"""What is varied between the runs of a sweep: a key of the scene, and its values or the range that they are taken from.

    laws.creases.stiffness=1,3,10,30            a list: numbers, texts with units, true and false, names
    material.thickness=5 um:10 um:6             so many values, evenly spaced, both ends among them
    laws.springs.buckling=10:1000:log5          the same on a logarithmic scale
    laws.springs.buckling=10:1000               a range, from which samples are taken evenly
    laws.springs.buckling=10:1000:log           a range, from which they are taken evenly by their logarithms

All is checked against the scene before a run begins, and all faults are reported at once. Values become SI numbers.
Evenly spaced values and samples of a whole number are rounded to the nearest one.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from membrane_rs._validation import count_of, nearest, show
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.scene import Scene
from membrane_rs.scene.values import key_at
from membrane_rs.simulation import integrators

MOST_VALUES = 100_000
"""Values of one parameter."""
MOST_PARAMETERS = 100
FLAGS = ("is_range", "is_log", "is_whole")
SHOWN = 10
"""Faults that an error names."""
_COUNT = re.compile(r"(log)?\s*(\d*)")


@dataclass(frozen=True)
class Parameter:
    """What is varied.

    Attributes
    ----------
    key : str
        Its dotted key.
    unit : str
        Its unit; empty for a plain number.
    values : tuple
        Its values; those at both ends of a range.
    is_range : bool
        Whether samples are taken from between two values.
    is_log : bool
        Whether the values are spaced evenly by their logarithms.
    is_whole : bool
        Whether it is a whole number.

    Examples
    --------
    >>> from membrane_rs.study import Parameter
    >>> range_of = Parameter("laws.creases.stiffness", "", (1.0, 100.0), is_range=True, is_log=True)
    >>> range_of.at(0.5), range_of.spaced(3)
    (10.0, (1.0, 10.0, 100.0))
    >>> range_of.as_table()["values"]
    [1.0, 100.0]
    """

    key: str
    unit: str
    values: tuple[Any, ...]
    is_range: bool = False
    is_log: bool = False
    is_whole: bool = False

    def at(self, share: float) -> Any:
        """The value at a share of the range or of the list.

        Parameters
        ----------
        share : float
            From 0 to below 1 [-].

        Returns
        -------
        object
            In the unit of the parameter.
        """
        if not self.is_range:
            return self.values[min(int(share * len(self.values)), len(self.values) - 1)]
        return self._tidy(self._between(share))

    def spaced(self, count: int) -> tuple[Any, ...]:
        """Evenly spaced values of the range.

        Parameters
        ----------
        count : int
            How many.

        Returns
        -------
        tuple
            Each value once: of a whole number there may be fewer.

        Raises
        ------
        InputError, InputTypeError
            No number of values.
        """
        count = count_of("count", count, 1, MOST_VALUES, "values of a range")
        shares = np.linspace(0.0, 1.0, count) if count > 1 else [0.0]
        values = [self._tidy(self._between(float(share))) for share in shares]
        return tuple(dict.fromkeys(values))

    @property
    def is_number(self) -> bool:
        """Whether all its values are numbers."""
        return all(isinstance(value, int | float) and not isinstance(value, bool) for value in self.values)

    def _between(self, share: float) -> float:
        low, high = self.values
        if self.is_log:
            return math.exp(math.log(low) * (1.0 - share) + math.log(high) * share)
        return float(low * (1.0 - share) + high * share)

    def _tidy(self, value: float) -> float | int:
        """A value of twelve digits, so that tables show 0.3 and 100 and not their neighbours."""
        return round(value) if self.is_whole else float(f"{value:.12g}")

    def as_table(self) -> dict[str, Any]:
        """The same as plain values, without the key.

        Returns
        -------
        dict of str to object
            By the names of the attributes.
        """
        flags = {name: getattr(self, name) for name in FLAGS}
        return {"unit": self.unit, "values": list(self.values), **flags}


def parameters_of(scene: Scene, vary: Mapping[str, Any], *, sampled: bool = False) -> list[Parameter]:
    """The parameters of a sweep, checked.

    Parameters
    ----------
    scene : Scene
        Each value is tried on it alone.
    vary : mapping
        By dotted key a list of values, or a text as above without the key.
    sampled : bool
        Whether samples are taken, so that a range needs no number of values.

    Raises
    ------
    InputError, InputTypeError
        All that is wrong with keys, values and ranges.
    """
    if not isinstance(vary, Mapping):
        raise InputTypeError(f"vary = {show(vary)}: must be a table of keys with their values, such as {_EXAMPLE}")
    if len(vary) > MOST_PARAMETERS:
        raise InputError(f"vary: {len(vary)} keys; must be at most {MOST_PARAMETERS}")
    faults: dict[str, type[InputError]] = {}
    found: dict[str, Parameter] = {}
    for key, given in vary.items():
        try:
            parameter = _parameter(scene, key, given, sampled=sampled)
            if parameter.key in found:
                raise InputError(f"vary {show(key)}: is {parameter.key}, which is varied too; leave one of them out")
            found[parameter.key] = parameter
        except _SeveralError as several:
            faults |= several.faults
        except InputError as error:
            faults[str(error)] = type(error)
    if faults:
        more = f"; and {len(faults) - SHOWN} more faults" if len(faults) > SHOWN else ""
        kind = InputTypeError if set(faults.values()) == {InputTypeError} else InputError
        raise kind("; ".join(list(faults)[:SHOWN]) + more)
    return list(found.values())


EXAMPLE_KEY = "laws.creases.stiffness"
_EXAMPLE = f'{{"{EXAMPLE_KEY}": [1, 3, 10], "laws.springs.buckling": "10:1000:log5"}}'


class _SeveralError(InputError):
    """Several faults of one parameter."""

    def __init__(self, faults: Mapping[str, type[InputError]]) -> None:
        super().__init__("; ".join(faults))
        self.faults = faults


def split_vary(texts: Iterable[str]) -> dict[str, str]:
    """Keys and their values from texts such as "laws.creases.stiffness=1,3". Raises InputError."""
    found: dict[str, str] = {}
    for text in texts:
        key, sign, values = text.partition("=")
        key = key.strip()
        if not sign or not key:
            raise InputError(
                f"--vary {show(text)}: must be KEY=VALUES, such as laws.creases.stiffness=1,3,10 or "
                "laws.springs.buckling=10:1000:log5"
            )
        if key in found:
            raise InputError(f"--vary {key}: is given twice; give all its values at once, separated by commas")
        found[key] = values.strip()
    return found


def _parameter(scene: Scene, key: str, given: Any, *, sampled: bool) -> Parameter:
    if isinstance(given, str):
        ends, words, count = _parsed(key, given)
    else:
        ends, words, count = (), _listed(key, given), None
    values, own, unit = _tried(scene, key, ends or words)
    is_whole = isinstance(values[0], int) and not isinstance(values[0], bool)
    if not ends:
        seen: set[Any] = set()
        twice = next((value for value in values if value in seen or seen.add(value)), None)  # type: ignore[func-returns-value]
        if twice is not None:
            raise InputError(f"vary {key}: names {show(twice)} twice; give each value once")
        return Parameter(own, unit, values, is_whole=is_whole)
    low, high = (_end(key, value) for value in values)
    assert count is not None, "a range says how its values are spaced"
    is_log, number = count
    if low >= high:
        raise InputError(f"vary {key} = {show(given)}: must go from a lower to a higher value, {low:g} to {high:g}")
    if is_log and low <= 0.0:
        raise InputError(f"vary {key} = {show(given)}: a logarithmic range must begin above 0")
    spanned = Parameter(own, unit, (low, high), True, is_log, is_whole)
    if sampled:
        if number is not None:
            raise InputError(
                f"vary {key} = {show(given)}: the samples say how many values there are; leave {number} out"
            )
        return spanned
    if number is None:
        raise InputError(
            f"vary {key} = {show(given)}: must say how many values, such as :5 or :log5 behind it; only samples "
            "(lhs, sobol) take a range alone"
        )
    if not 2 <= number <= MOST_VALUES:
        raise InputError(f"vary {key} = {show(given)}: must be 2 to {MOST_VALUES:,} values")
    return Parameter(own, unit, spanned.spaced(number), is_log=is_log, is_whole=is_whole)


def _parsed(key: str, text: str) -> tuple[tuple[Any, ...], tuple[Any, ...], tuple[bool, int | None] | None]:
    """The ends of a range, or the values of a list, and how those of a range are spaced."""
    if ":" not in text:
        if (commas := text.count(",")) >= MOST_VALUES:
            raise InputError(f"vary {key}: {commas + 1:,} values; must be 1 to {MOST_VALUES:,}")
        words = [_value(word) for word in text.split(",")]
        if any(word == "" for word in words):
            raise InputError(f"vary {key} = {show(text)}: a value is missing; separate values by commas")
        return (), tuple(words), None
    low, high, *spacing = (word.strip() for word in text.split(":"))
    found = _COUNT.fullmatch(spacing[0] if spacing else "")
    if len(spacing) > 1 or found is None or (spacing and not spacing[0]) or len(found[2]) > len(str(MOST_VALUES)):
        raise InputError(
            f"vary {key} = {show(text)}: must be a list such as 1,3,10, a range such as 10:1000:5 or 10:1000:log5 "
            f"with at most {MOST_VALUES:,} values, or, for samples, 10:1000 or 10:1000:log"
        )
    return (_value(low), _value(high)), (), (bool(found[1]), int(found[2]) if found[2] else None)


def _listed(key: str, given: Any) -> tuple[Any, ...]:
    """A list of values from Python."""
    if hasattr(given, "tolist"):
        given = given.tolist()
    if not isinstance(given, Sequence) or isinstance(given, bytes | bytearray | memoryview):
        raise InputTypeError(f"vary[{show(key)}] = {show(given)}: must be a list of values, or a text as for --vary")
    if not 1 <= len(given) <= MOST_VALUES:
        raise InputError(f"vary[{show(key)}]: {len(given):,} values; must be 1 to {MOST_VALUES:,}")
    return tuple(given)


def _value(text: str) -> Any:
    """A value of the command line: a number, true or false, or a text, which may be a number with its unit."""
    text = text.strip()
    if text in ("true", "false"):
        return text == "true"
    try:
        return int(text) if re.fullmatch(r"[-+]?\d{1,18}", text) else float(text)
    except ValueError:
        return text


def _tried(scene: Scene, key: str, values: Sequence[Any]) -> tuple[tuple[Any, ...], str, str]:
    """What the scene has after each of the values was set, by which key, and its unit.

    Raises InputError for all that it does not accept.
    """
    if key == "name":
        raise InputError(f"vary {key}: is a text that no run depends on; vary a value, such as {EXAMPLE_KEY}")
    found: list[Any] = []
    faults: dict[str, tuple[list[str], type[InputError]]] = {}
    own, unit, methods = key, "", integrators()
    for value in values:
        try:
            changed = scene.with_values({key: value})
            if changed.run.integrator not in methods:
                raise InputError(f"{key} = {show(value)}: is no method; {nearest(changed.run.integrator, methods)}")
            if isinstance(value, bool) and key.count(".") == 1:  # a law, part or body as a whole
                found.append(value)
                continue
            found.append(_plain(key, changed.value(key)))
            own, unit = key_at(changed, key), changed.unit(key)
        except InputError as error:
            # The same words of several values are one fault.
            words = str(error).removeprefix(f"{key} = {show(value)}: ")
            faults.setdefault(words, ([], type(error)))[0].append("" if words == str(error) else show(value))
    if faults:
        raise _SeveralError({_fault(key, words, given): kind for words, (given, kind) in faults.items()})
    return tuple(found), own, unit


def _fault(key: str, words: str, values: Sequence[str]) -> str:
    """What is wrong with some values of a key."""
    if not values[0]:
        return words
    more = f" and {len(values) - SHOWN} more" if len(values) > SHOWN else ""
    return f"{key} = {', '.join(values[:SHOWN])}{more}: {words}"


def _plain(key: str, value: Any) -> Any:
    """A value, if a row of a table can hold it: a schedule, for one, is none. Raises InputTypeError."""
    items = value if isinstance(value, tuple | list) else (value,)
    if not all(isinstance(item, bool | int | float | str | None) for item in items):
        raise InputTypeError(f"vary {key}: {show(value)} is no number, text, true or false; vary a key inside of it")
    return tuple(value) if isinstance(value, list) else value


def _end(key: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputTypeError(f"vary {key}: {show(value)} is no number; a range needs two, else give a list")
    return value
