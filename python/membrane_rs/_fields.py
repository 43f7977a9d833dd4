"""What the fields of checked classes are: their units and bounds, and numbers in place of texts with units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BeforeValidator

from membrane_rs._numbers import (
    AUTO,
    Auto,
    OuterUnit,
    Unit,
    UnitOf,
    number,
    numbers,
    pair,
    place,
    points,
    vector,
    whole,
)
from membrane_rs._quantities import to_si
from membrane_rs._renamed import new_names

BOUNDS = ((Gt, "gt", "greater than"), (Ge, "ge", "at least"), (Lt, "lt", "less than"), (Le, "le", "at most"))


def unit_of(cls: type, name: str, values: Mapping[str, Any] | None = None, outer: str | None = None) -> str | None:
    """The unit of a field of a validated class, or an empty text.

    Of one whose unit depends on another, which `values` holds, or on the field that the class stands in, of unit
    `outer`: None where these do not say it.
    """
    for item in metadata(cls, name):
        if isinstance(item, Unit):
            return item.symbol
        if isinstance(item, OuterUnit):
            return outer
        if isinstance(item, UnitOf):
            other = (values or {}).get(item.field)
            return item.units.get(other) if isinstance(other, str) else None
    return ""


def in_si(cls: type, values: Mapping[str, Any], where: str, outer: str | None = None) -> dict[str, Any]:
    """A table of values with numbers in place of texts with units, wherever the class takes a number, and None in place
    of "auto" for a number that may follow from others.

    Raises
    ------
    InputError, InputTypeError
        Text that is no number with a unit of the right dimension.
    """
    found = dict(values)
    renamed = new_names(cls)
    for key, value in values.items():
        if not isinstance(value, str | list | tuple | Mapping):
            continue
        name, place = renamed.get(key, key), f"{where}.{key}"
        inner = checked_class(cls, name)
        if isinstance(value, Mapping):
            if inner is not None:
                found[key] = in_si(inner, value, place, unit_of(cls, name))
            continue
        takes_number, takes_list = takes_numbers(cls, name)
        unit = unit_of(cls, name, values, outer)
        if not takes_number or unit is None:
            continue
        if isinstance(value, str) and not takes_list:
            found[key] = None if value.strip() == AUTO and is_automatic(cls, name) else to_si(value, unit, place)
        elif takes_list and not isinstance(value, str):
            found[key] = _listed_in_si(value, unit, place, 2)
    return found


def _listed_in_si(values: Sequence[object], unit: str, place: str, depth: int) -> Sequence[object]:
    """A list with numbers in place of texts with units, also in the lists that it holds to this depth."""
    if not any(isinstance(item, str | list | tuple) for item in values):
        return values
    return tuple(
        to_si(item, unit, f"{place}[{k}]")
        if isinstance(item, str)
        else _listed_in_si(item, unit, f"{place}[{k}]", depth - 1)
        if isinstance(item, list | tuple) and depth > 1
        else item
        for k, item in enumerate(values)
    )


def takes_numbers(cls: type, name: str) -> tuple[bool, bool]:
    """Whether a field takes a number that need not be whole, and whether it takes a list of them."""
    checks = {item.func for item in metadata(cls, name) if isinstance(item, BeforeValidator)}
    return bool({number, place} & checks) and not is_table(cls, name), bool(
        {vector, numbers, pair, place, points} & checks
    )


def range_of(cls: type, name: str) -> str:
    """The bounds of a field in words, or an empty text."""
    found: dict[str, float] = {}
    for item in metadata(cls, name):
        for kind, key, word in BOUNDS:
            if isinstance(item, kind):
                bound, narrower = getattr(item, key), max if kind in (Gt, Ge) else min
                found[word] = narrower(found.get(word, bound), bound)
    return " and ".join(f"{word} {bound:g}" for word, bound in found.items())


def is_whole(cls: type, name: str) -> bool:
    """Whether a field holds a whole number."""
    return any(isinstance(item, BeforeValidator) and item.func is whole for item in metadata(cls, name))


def is_automatic(cls: type, name: str) -> bool:
    """Whether a number follows from others where it is not given, so that texts may say "auto"."""
    return any(isinstance(item, Auto) for item in metadata(cls, name))


def is_table(cls: type, name: str) -> bool:
    """Whether a field is a table, whose entries have keys."""
    info = getattr(cls, "__pydantic_fields__", {}).get(name)
    return info is not None and get_origin(info.annotation) is dict


def metadata(cls: type, name: str) -> list[object]:
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


def checked_class(cls: type, name: str) -> type | None:
    """The validated class of a field, None where its values are of no such class."""
    info = getattr(cls, "__pydantic_fields__", {}).get(name)
    kinds = () if info is None else (info.annotation, *get_args(info.annotation))
    return next((kind for kind in kinds if hasattr(kind, "__pydantic_fields__")), None)
