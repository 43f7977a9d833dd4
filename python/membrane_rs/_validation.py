"""Checked, frozen dataclasses, and the number types that they are made of.

A class made with `validated` checks its fields when it is built. An error is described in one line, which
names the field, the value and the allowed range:

    Material.thickness = -1e-06: must be greater than 0 (m)

NaN, infinities, booleans and strings are no numbers; numpy scalars are. pydantic does the work.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass as plain_dataclass
from dataclasses import field
from numbers import Integral, Real
from typing import Annotated, Any, TypeGuard, TypeVar, get_args, get_origin

import numpy as np
from annotated_types import Ge, Gt, Le, Lt
from pydantic import BeforeValidator, ConfigDict, Field, ValidationError
from pydantic.dataclasses import dataclass
from pydantic_core import ErrorDetails, PydanticCustomError
from typing_extensions import dataclass_transform

from membrane_rs._other_names import OTHER_NAMES
from membrane_rs._renamed import deprecated, new_names
from membrane_rs.errors import InputError, InputTypeError, MembraneError

T = TypeVar("T")

_TYPE_ERRORS = {"wrong_type", "unexpected_keyword_argument", "unexpected_positional_argument"}
_TYPE_ERRORS |= {"missing_argument", "missing", "multiple_argument_values", "dataclass_type"}
_BOUNDS = ((Gt, "gt", "greater than"), (Ge, "ge", "at least"), (Lt, "lt", "less than"), (Le, "le", "at most"))


@plain_dataclass(frozen=True)
class Unit:
    """The unit of a field, for messages and for scene files."""

    symbol: str


def _wrong_type(wanted: str) -> PydanticCustomError:
    return PydanticCustomError("wrong_type", "must be {wanted}", {"wanted": wanted})


MOST = 10**9
"""A larger count or node index is taken as an input error."""


NO_NUMBERS = (bool, np.bool_, np.timedelta64)
"""Types that count as numbers in Python or numpy, and are none here."""


def _number(value: object) -> float:
    if isinstance(value, NO_NUMBERS) or not isinstance(value, Real):
        raise _wrong_type("a number")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise PydanticCustomError("not_finite", "must be finite")
    return number


def _is_whole(value: object) -> TypeGuard[Integral]:
    return isinstance(value, Integral) and not isinstance(value, NO_NUMBERS)


def _whole(value: object) -> int:
    if not _is_whole(value):
        raise _wrong_type("a whole number")
    return int(value)


def _listed(value: object) -> object:
    """Lists and numpy arrays as tuples; anything else as it is."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    return tuple(value) if isinstance(value, list) else value


def _vector(value: object) -> object:
    value = _listed(value)
    if not isinstance(value, tuple) or len(value) != 3:
        raise _wrong_type("three numbers (x, y, z)")
    return value


def _numbers(value: object) -> object:
    value = _listed(value)
    if not isinstance(value, tuple):
        raise _wrong_type("a list of numbers")
    return value


def _nodes(value: object) -> object:
    value = _listed(value)
    if isinstance(value, str):
        if not value:
            raise PydanticCustomError("empty", "must be the name of a node set, not an empty text")
        return value
    if not isinstance(value, tuple) or not all(map(_is_whole, value)):
        raise _wrong_type("the name of a node set or a list of node indices")
    nodes = tuple(int(i) for i in value)
    if not nodes or min(nodes) < 0 or max(nodes) > MOST:
        raise PydanticCustomError("bad_nodes", f"must hold at least one node, none below 0 or above {MOST}")
    if len(set(nodes)) < len(nodes):
        raise PydanticCustomError("bad_nodes", "must not name a node twice")
    return nodes


def _flag(value: object) -> bool:
    if not isinstance(value, bool):
        raise _wrong_type("true or false")
    return value


Finite = Annotated[float, BeforeValidator(_number)]
"""A finite number."""
Positive = Annotated[float, BeforeValidator(_number), Gt(0)]
"""A finite number above 0."""
NonNegative = Annotated[float, BeforeValidator(_number), Ge(0)]
"""A finite number, 0 or above."""
Fraction = Annotated[float, BeforeValidator(_number), Ge(0), Le(1)]
"""A number between 0 and 1, both included."""
Count = Annotated[int, BeforeValidator(_whole), Ge(1), Le(MOST)]
"""A whole number, from 1 to 10^9."""
Whole = Annotated[int, BeforeValidator(_whole), Ge(0), Le(MOST)]
"""A whole number, from 0 to 10^9."""
Flag = Annotated[bool, BeforeValidator(_flag)]
"""True or False, and nothing that merely looks like it."""
Vector = Annotated[tuple[Finite, Finite, Finite], BeforeValidator(_vector)]
"""Three finite numbers, from a tuple, list or array."""
Times = Annotated[Sequence[NonNegative], BeforeValidator(_numbers)]
"""Any number of times, none negative, from a tuple, list or array."""
Numbers = Annotated[Sequence[Finite], BeforeValidator(_numbers)]
"""Any number of finite numbers, from a tuple, list or array."""
Nodes = Annotated[str | Sequence[int], BeforeValidator(_nodes)]
"""The name of a node set, or node indices (tuple, list or array), none twice."""


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

    Raises
    ------
    InputError, InputTypeError
        As the class does.
    """
    made: Any = cls
    instance: T = made.__new__(made)
    given = dict(values)
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
    if isinstance(value, np.ndarray) and value.ndim == 0 and not isinstance(value, np.ma.MaskedArray):
        value = value[()]
    if isinstance(value, NO_NUMBERS) or not isinstance(value, Real):
        raise InputTypeError(f"{name} = {show(value)}: must be a number ({unit})")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise InputError(f"{name} = {number}: must be finite ({unit})")
    return number


def check_kind(value: object, kind: type | tuple[type, ...], name: str, wanted: str) -> None:
    """Refuse what is not of a kind. Raises InputTypeError, which names it and what is `wanted`."""
    if not isinstance(value, kind):
        raise InputTypeError(f"{name} = {show(value)}: must be {wanted}")


def check_text(text: str, name: str, kind: type[InputError] = InputError) -> None:
    """Refuse a text that UTF-8, and so no file, can hold: one with half of a surrogate pair. Raises `kind`."""
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise kind(
            f"{name} {show(ascii(text))}: character {error.start} is half of a surrogate pair, which no text file "
            "holds; replace it"
        ) from None


def nearest(word: str, known: Iterable[str]) -> str:
    """The end of a message about an unknown word: the known word that means it, or the nearest one, or all of them."""
    words = sorted(known)
    other = word.strip().lower().replace("'", "").replace("-", "_").replace(" ", "_")
    for name, unit in OTHER_NAMES.get(other, ()):
        if name in words:
            return f"did you mean '{name}'{f' ({unit})' if unit else ''}?"
    close = difflib.get_close_matches(word, words, n=1)
    return f"did you mean '{close[0]}'?" if close else "known are: " + ", ".join(words)


def unit_of(cls: type, name: str) -> str:
    """The unit of a field of a validated class, or an empty text."""
    for item in _metadata(cls, name):
        if isinstance(item, Unit):
            return item.symbol
    return ""


def show(value: object) -> str:
    """A value as messages show it: short, and in one line."""
    if isinstance(value, float):
        return repr(float(value))
    try:
        text = " ".join(repr(value).split())
    except ValueError:  # Python writes no integer of more than some thousand digits
        return "a number of thousands of digits"
    return text if len(text) <= 60 else text[:57] + "..."


def range_of(cls: type, name: str) -> str:
    """The bounds of a field in words, or an empty text."""
    found: dict[str, float] = {}
    for item in _metadata(cls, name):
        for kind, key, word in _BOUNDS:
            if isinstance(item, kind):
                bound, narrower = getattr(item, key), max if kind in (Gt, Ge) else min
                found[word] = narrower(found.get(word, bound), bound)
    return " and ".join(f"{word} {bound:g}" for word, bound in found.items())


def is_whole(cls: type, name: str) -> bool:
    """Whether a field holds a whole number."""
    return any(isinstance(item, BeforeValidator) and item.func is _whole for item in _metadata(cls, name))


def is_table(cls: type, name: str) -> bool:
    """Whether a field is a table, whose entries have keys."""
    info = getattr(cls, "__pydantic_fields__", {}).get(name)
    return info is not None and get_origin(info.annotation) is dict


def _metadata(cls: type, name: str) -> list[object]:
    """What is annotated to a field, at any depth (an optional field keeps it inside its union)."""
    info = getattr(cls, "__pydantic_fields__", {}).get(name)
    if info is None:
        return []
    found: list[object] = list(info.metadata)
    waiting: list[Any] = [info.annotation]
    while waiting:
        kind = waiting.pop()
        found.extend(getattr(kind, "__metadata__", ()))
        waiting.extend(get_args(kind))
    return found


def _as_input_error(error: ValidationError, cls: type, prefix: str) -> InputError:
    details = error.errors(include_url=False)
    for detail in details:
        inner = detail.get("ctx", {}).get("error")
        if isinstance(inner, InputError):
            owner, where, _ = _owner((*detail["loc"], "itself"), cls, prefix)
            own, text = f"{owner.__name__}.", str(inner)
            return type(inner)(f"{where}.{text.removeprefix(own)}" if text.startswith(own) else text)
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


def checked_class(cls: type, name: str) -> type | None:
    """The validated class of a field, None where its values are of no such class."""
    info = getattr(cls, "__pydantic_fields__", {}).get(name)
    kinds = () if info is None else (info.annotation, *get_args(info.annotation))
    return next((kind for kind in kinds if hasattr(kind, "__pydantic_fields__")), None)


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
        return f"{prefix}: too many values ({show(detail['input'])}); it takes {', '.join(known)}"
    kinds = (int, str) if is_table(cls, name) else (int,)
    where = f"{prefix}.{name}" + "".join(f"[{show(i)}]" for i in place[1:] if isinstance(i, kinds))
    unit = unit_of(cls, name)
    suffix = f" ({unit})" if unit else ""
    allowed = range_of(cls, name)
    if kind in ("missing", "missing_argument"):
        return f"{where}: is missing" + (f"; must be {allowed}" if allowed else "") + suffix
    text = detail["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
    if kind == "dataclass_type" and (inner := checked_class(cls, name)) is not None:
        text = f"must be a {inner.__name__}, or a table with {', '.join(getattr(inner, '__pydantic_fields__', {}))}"
    if kind in ("greater_than", "greater_than_equal", "less_than", "less_than_equal"):
        text = f"must be {allowed}" if allowed else text
    elif allowed:
        text = f"{text}, {allowed}"
    return f"{where} = {show(detail['input'])}: {text}{suffix}"
