"""Checked, frozen dataclasses; all that they are made of can be imported from here.

A class made with `validated` checks its fields when it is built. An error is described in one line, which
names the field, the value and the allowed range:

    Material.thickness = -1e-06: must be greater than 0 (m)

NaN, infinities, booleans and strings are no numbers; numpy scalars are. pydantic does the work.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import field
from numbers import Integral, Real
from typing import Any, TypeGuard, TypeVar

import numpy as np
from pydantic import ConfigDict, Field, ValidationError
from pydantic.dataclasses import dataclass
from pydantic_core import ErrorDetails
from typing_extensions import dataclass_transform

from membrane_rs._fields import checked_class, in_si, is_table, is_whole, range_of, unit_of
from membrane_rs._messages import nearest, show
from membrane_rs._numbers import (
    AUTO,
    MOST,
    NO_NUMBERS,
    Auto,
    Count,
    Finite,
    Flag,
    Fraction,
    Nodes,
    NodeSets,
    NonNegative,
    Numbers,
    OuterUnit,
    Pair,
    Place,
    Points,
    Positive,
    Rows,
    Times,
    TriangleSets,
    Unit,
    UnitOf,
    Vector,
    Whole,
    numbers,
)
from membrane_rs._quantities import in_python
from membrane_rs._renamed import deprecated, new_names
from membrane_rs.errors import InputError, InputTypeError, MembraneError

__all__ = [
    "AUTO",
    "MOST",
    "NO_NUMBERS",
    "Auto",
    "Count",
    "Finite",
    "Flag",
    "Fraction",
    "NodeSets",
    "Nodes",
    "NonNegative",
    "Numbers",
    "OuterUnit",
    "Pair",
    "Place",
    "Points",
    "Positive",
    "Rows",
    "Times",
    "TriangleSets",
    "Unit",
    "UnitOf",
    "Vector",
    "Whole",
    "build",
    "check_kind",
    "check_text",
    "checked_class",
    "computable",
    "count_of",
    "flag_of",
    "flags_of",
    "in_si",
    "is_list",
    "is_table",
    "is_whole",
    "nearest",
    "number_of",
    "numbers",
    "range_of",
    "show",
    "texts_of",
    "unit_of",
    "validated",
]

T = TypeVar("T")

_TYPE_ERRORS = {"wrong_type", "string_type", "unexpected_keyword_argument", "unexpected_positional_argument"}
_TYPE_ERRORS |= {"missing_argument", "missing", "multiple_argument_values", "dataclass_type"}


@dataclass_transform(frozen_default=True, field_specifiers=(field, Field))
def validated(cls: type[T]) -> type[T]:
    """Make a frozen dataclass that checks its fields, given by position or by name.

    A `__post_init__` may check fields against each other and raise `InputError`.

    Raises (the class, when built)
    ------------------------------
    InputTypeError
        A field of the wrong type, a missing or an unknown one.
    InputError
        A value outside its range.
    """
    config = ConfigDict(extra="forbid", arbitrary_types_allowed=True)
    made: Any = dataclass(cls, frozen=True, config=config)
    plain: Callable[..., None] = made.__init__

    renamed = new_names(made)

    def checked(self: Any, /, *args: Any, **values: Any) -> None:
        # Where both are given the old name holds: `dataclasses.replace` gives each new one too.
        is_replaced = values.keys() >= set(made.__pydantic_fields__)
        for old in [old for old in renamed if old in values]:
            if renamed[old] in values and not is_replaced:
                what = f"{made.__name__}.{old}: is the old name of {renamed[old]}, which is given too"
                raise InputTypeError(f"{what}; leave {old} out")
            deprecated(f"{made.__name__}.{old}", f"use {renamed[old]}")
            values[renamed[old]] = values.pop(old)
        try:
            with computable(made.__name__):
                plain(self, *args, **values)
        except ValidationError as error:
            raise _as_input_error(error, made, made.__name__) from None

    def unpickled(self: Any, state: dict[str, Any]) -> None:
        """Unpickle; fields that an earlier version pickled get their new names."""
        self.__dict__.update({renamed.get(name, name): value for name, value in state.items()})

    if renamed:
        made.__setstate__ = unpickled
    checked.__name__ = "__init__"
    checked.__wrapped__ = plain  # type: ignore[attr-defined]
    made.__init__ = checked
    made.__plain_init__ = plain
    result: type[T] = made
    return result


def build(cls: type[T], values: Mapping[str, Any], name: str) -> T:
    """Build a validated class from a table, calling it `name` in errors (for instance "laws.creases").

    Text with a unit is taken for a number, here alone: in Python a field takes numbers.

    Raises
    ------
    InputError, InputTypeError
        As the class does.
    """
    made: Any = cls
    instance: T = made.__new__(made)
    given = in_si(made, values, name)
    for old, new in new_names(made).items():
        if old in given and new in given:
            raise InputError(f"{name}.{old}: is the old name of {new}, which is there too; leave {old} out")
        if old in given:
            deprecated(f"{name}.{old}", f"write {new}")
            given[new] = given.pop(old)
    try:
        with computable(name):
            made.__plain_init__(instance, **given)
    except ValidationError as error:
        raise _as_input_error(error, made, name) from None
    return instance


@contextmanager
def computable(where: str, kind: type[InputError] = InputError) -> Iterator[None]:
    """Turn an overflow or a division by zero, which only values beyond all nature cause, into an error of `kind`."""
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise"):
            yield
    except ArithmeticError as error:
        if isinstance(error, MembraneError):
            raise
        reason = " ".join(str(error).split())
        raise kind(f"{where}: a value is too large or too small to compute with ({reason}); give SI units") from None


def number_of(name: str, value: object, unit: str = "s") -> float:
    """A finite number, or a numpy scalar as one. Raises InputTypeError and InputError, which name it and its unit."""
    words = f" ({unit})" if unit else ""
    if isinstance(value, np.ndarray) and value.ndim == 0 and not isinstance(value, np.ma.MaskedArray):
        value = value[()]
    if isinstance(value, NO_NUMBERS) or not isinstance(value, Real):
        raise InputTypeError(f"{name} = {show(value)}: must be a number{words}{in_python(value, unit)}")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise InputError(f"{name} = {number}: must be finite{words}")
    return number


def check_kind(value: object, kind: type | tuple[type, ...], name: str, wanted: str) -> None:
    """Refuse what is not of a kind. Raises InputTypeError, which names it and what is `wanted`."""
    if not isinstance(value, kind):
        raise InputTypeError(f"{name} = {show(value)}: must be {wanted}")


def count_of(name: str, value: object, least: int, most: int, what: str = "") -> int:
    """A whole number within bounds.

    Raises InputTypeError and InputError, which name it and its bounds; `what` says more of it, such as the unit.
    """
    words = f" ({what})" if what else ""
    if not isinstance(value, Integral) or isinstance(value, NO_NUMBERS):
        raise InputTypeError(f"{name} = {show(value)}: must be a whole number, from {least:,} to {most:,}{words}")
    count = int(value)
    if not least <= count <= most:
        raise InputError(f"{name} = {show(count)}: must be from {least:,} to {most:,}{words}")
    return count


def flag_of(name: str, value: object) -> bool:
    """True or False, also as numpy's and as 1 or 0. Raises InputTypeError for anything else, which may mean either."""
    if not isinstance(value, bool | np.bool_ | int) or value not in (0, 1):
        raise InputTypeError(f"{name} = {show(value)}: must be True or False")
    return bool(value)


def flags_of(**flags: object) -> tuple[bool, ...]:
    """Flags by name, as `flag_of` has each."""
    return tuple(flag_of(name, flag) for name, flag in flags.items())


def is_list(values: object) -> TypeGuard[Collection[Any]]:
    """Whether something is a list, a tuple, an array of one dimension or the like; neither a text nor a table."""
    is_listed = isinstance(values, Collection) and not isinstance(values, str | bytes | Mapping)
    return is_listed and getattr(values, "ndim", 1) == 1


def texts_of(name: str, values: object, wanted: str) -> list[str]:
    """A list of texts. Raises InputTypeError for anything else, a text alone among it, which names it."""
    if is_list(values):
        found = list(values)
        if all(isinstance(text, str) for text in found):
            return found
    raise InputTypeError(f"{name} = {show(values)}: must be {wanted}")


def check_text(text: str, name: str, kind: type[InputError] = InputError) -> None:
    """Refuse a text that UTF-8, and so no file, can hold: one with half of a surrogate pair. Raises `kind`."""
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise kind(
            f"{name} {show(ascii(text))}: character {error.start} is half of a surrogate pair, which no text file "
            "holds; replace it"
        ) from None


def _as_input_error(error: ValidationError, cls: type, prefix: str) -> InputError:
    details = error.errors(include_url=False)
    for detail in details:
        inner = detail.get("ctx", {}).get("error")
        if isinstance(inner, InputError):
            owner, where, _ = _owner((*detail["loc"], "itself"), cls, prefix)
            own, text = owner.__name__, str(inner)
            begins = text.startswith((f"{own}.", f"{own}:"))
            return type(inner)(f"{where}{text.removeprefix(own)}" if begins else text)
    text = "; ".join(_explain(detail, cls, prefix) for detail in details)
    if all(detail["type"] in _TYPE_ERRORS for detail in details):
        return InputTypeError(text)
    return InputError(text)


def _owner(place: tuple[int | str, ...], cls: type, prefix: str) -> tuple[type, str, tuple[int | str, ...]]:
    """The class that a faulty field belongs to, which may be that of a field of `cls`; its name; the place in it."""
    by_position = getattr(cls, "__match_args__", ())
    if not place:
        return cls, prefix, place
    name = by_position[place[0]] if isinstance(place[0], int) and place[0] < len(by_position) else str(place[0])
    inner = checked_class(cls, name)
    if inner is None or len(place) == 1:
        return cls, prefix, (name, *place[1:])
    return _owner(place[1:], inner, f"{prefix}.{name}")


def _taken(cls: type) -> str:
    """The values that a class takes, in words: those by position, and those by keyword alone."""
    known = list(getattr(cls, "__pydantic_fields__", {}))
    by_position = getattr(cls, "__match_args__", ())
    by_keyword = ", ".join(name for name in known if name not in by_position)
    positions = ", ".join(name for name in known if name in by_position)
    if not by_keyword:
        return positions
    return f"{positions}, and by keyword {by_keyword}" if positions else f"by keyword {by_keyword}"


def _explain(detail: ErrorDetails, cls: type, prefix: str) -> str:
    """One thing that is wrong, in words."""
    cls, prefix, place = _owner(detail["loc"], cls, prefix)
    kind = detail["type"]
    if not place:
        return f"{prefix}: {detail['msg'].removeprefix('Value error, ')}"
    known = list(getattr(cls, "__pydantic_fields__", {}))
    name = str(place[0])
    if kind == "unexpected_keyword_argument":
        return f"{prefix}.{name}: no such key; {nearest(name, known)}"
    if kind == "unexpected_positional_argument":
        return f"{prefix}: too many values ({show(detail['input'])}); it takes {_taken(cls)}"
    kinds = (int, str) if is_table(cls, name) else (int,)
    where = f"{prefix}.{name}" + "".join(f"[{show(i)}]" for i in place[1:] if isinstance(i, kinds))
    unit = unit_of(cls, name)
    suffix = f" ({unit})" if unit else ""
    allowed = range_of(cls, name)
    if kind in ("missing", "missing_argument"):
        return f"{where}: is missing" + (f"; must be {allowed}" if allowed else "") + suffix
    text = detail["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
    if kind == "string_type":
        text = "must be a text"
    if kind == "dataclass_type" and (inner := checked_class(cls, name)) is not None:
        text = f"must be a {inner.__name__}, or a table with {', '.join(getattr(inner, '__pydantic_fields__', {}))}"
    if kind in ("greater_than", "greater_than_equal", "less_than", "less_than_equal"):
        text = f"must be {allowed}" if allowed else text
    elif allowed:
        text = f"{text}, {allowed}"
    advice = in_python(detail["input"], unit or "")
    return f"{where} = {show(detail['input'])}: {text}{suffix}{advice}"
