"""Types of the fields of checked classes: numbers with bounds, lists of them, nodes, flags; and their units.

NaN, infinities, booleans and strings are no numbers; numpy scalars are.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence, Sized
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Annotated, TypeGuard

import numpy as np
from annotated_types import Ge, Gt, Le
from pydantic import BeforeValidator, PlainValidator, WithJsonSchema
from pydantic_core import PydanticCustomError


@dataclass(frozen=True)
class Unit:
    """The unit of a field, for messages and for scene files."""

    symbol: str


@dataclass(frozen=True)
class UnitOf:
    """A field whose unit depends on the value of another one, a text."""

    field: str
    units: Mapping[str, str]
    """By values of that field."""


@dataclass(frozen=True)
class OuterUnit:
    """A field in the unit of the field that its class stands in."""


@dataclass(frozen=True)
class Auto:
    """A number that follows from others where it is not given: None in Python, the text `AUTO` in files and at the
    command line.
    """


AUTO = "auto"
"""What a file or an option says for a number that is not given."""


def wrong_type(wanted: str) -> PydanticCustomError:
    """An error of type, of one line."""
    return PydanticCustomError("wrong_type", "must be {wanted}", {"wanted": wanted})


MOST = 10**9
"""A larger count or node index is taken as an input error."""
MOST_POINTS = 10**5
"""Points of a polygon, at most."""


NO_NUMBERS = (bool, np.bool_, np.timedelta64)
"""Types that count as numbers in Python or numpy, and are none here."""


def number(value: object) -> float:
    """A finite number as float."""
    if isinstance(value, NO_NUMBERS) or not isinstance(value, Real):
        raise wrong_type("a number")
    try:
        found = float(value)
    except OverflowError:
        found = math.inf
    if not math.isfinite(found):
        raise PydanticCustomError("not_finite", "must be finite")
    return found


def _is_whole(value: object) -> TypeGuard[Integral]:
    return isinstance(value, Integral) and not isinstance(value, NO_NUMBERS)


def whole(value: object) -> int:
    """A whole number as int."""
    if not _is_whole(value):
        raise wrong_type("a whole number")
    return int(value)


def listed(value: object) -> object:
    """Lists and numpy arrays as tuples; anything else as it is."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    return tuple(value) if isinstance(value, list | range) else value


def vector(value: object) -> object:
    """Three of something, as a tuple."""
    return _of_length(value, 3, "three numbers (x, y, z)")


def numbers(value: object) -> object:
    """A list of something, as a tuple."""
    value = listed(value)
    if not isinstance(value, tuple):
        raise wrong_type("a list of numbers")
    return value


def pair(value: object) -> object:
    """Two of something, as a tuple."""
    return _of_length(value, 2, "two numbers")


def _of_length(value: object, count: int, wanted: str) -> object:
    value = listed(value)
    if not isinstance(value, tuple) or len(value) != count:
        raise wrong_type(wanted)
    return value


def points(value: object) -> object:
    """A list of points in a plane, as a tuple of tuples."""
    if isinstance(value, Sized) and getattr(value, "shape", None) != () and len(value) > MOST_POINTS:
        raise PydanticCustomError("too_many", f"must hold at most {MOST_POINTS} points")
    value = listed(value)
    found = tuple(listed(point) for point in value) if isinstance(value, tuple) else ()
    if not found or not all(isinstance(point, tuple) and len(point) == 2 for point in found):
        raise wrong_type("a list of points (x, y)")
    return found


def nodes(value: object) -> object:
    """The name of a node set, or indices as a tuple."""
    return _name_or_indices(listed(value), "node", "the name of a node set or a list of node indices")


def _name_or_indices(value: object, one: str, wanted: str) -> object:
    if isinstance(value, str):
        if not value:
            raise PydanticCustomError("empty", f"must be the name of a {one} set, not an empty text")
        return value
    return _indices(value, wanted, one)


def rows(value: object) -> object:
    """Indices as a tuple."""
    return _indices(listed(value), "a list of indices", "row")


def _indices(value: object, wanted: str, one: str) -> tuple[int, ...]:
    if not isinstance(value, tuple) or not all(map(_is_whole, value)):
        raise wrong_type(wanted)
    found = tuple(int(i) for i in value)
    if not found or min(found) < 0 or max(found) > MOST:
        raise PydanticCustomError("bad_nodes", f"must hold at least one {one}, none below 0 or above {MOST}")
    if len(set(found)) < len(found):
        raise PydanticCustomError("bad_nodes", f"must not name a {one} twice")
    return found


def place(value: object) -> object:
    """A point as three numbers, a node index, or a text that names a node."""
    value = listed(value)
    if isinstance(value, str) and value:
        return value
    if isinstance(value, tuple) and len(value) == 3:
        return tuple(map(number, value))
    if _is_whole(value) and 0 <= int(value) <= MOST:
        return int(value)
    raise wrong_type("three numbers (x, y, z), a node index, or the name of a node set")


def node_sets(value: object) -> object:
    """The name of a node set, names as a tuple, or indices as a tuple."""
    return _names_or_indices(listed(value), "node")


def triangle_sets(value: object) -> object:
    """The same of triangles."""
    return _names_or_indices(listed(value), "triangle")


def _names_or_indices(value: object, one: str) -> object:
    wanted = f"the name of a {one} set, a list of such names or a list of {one} indices"
    if isinstance(value, str) or (isinstance(value, tuple) and all(map(_is_whole, value))):
        return _name_or_indices(value, one, wanted)
    if not isinstance(value, tuple) or not all(isinstance(name, str) for name in value):
        raise wrong_type(wanted)
    if "" in value:
        raise PydanticCustomError("empty", f"must hold names of {one} sets, not an empty text")
    if len(set(value)) < len(value):
        raise PydanticCustomError("bad_nodes", f"must not name a {one} set twice")
    return value


def flag(value: object) -> bool:
    """True or False."""
    if not isinstance(value, bool):
        raise wrong_type("true or false")
    return value


Finite = Annotated[float, BeforeValidator(number)]
"""A finite number."""
Positive = Annotated[float, BeforeValidator(number), Gt(0)]
"""A finite number above 0."""
NonNegative = Annotated[float, BeforeValidator(number), Ge(0)]
"""A finite number, 0 or above."""
Fraction = Annotated[float, BeforeValidator(number), Ge(0), Le(1)]
"""A number between 0 and 1, both included."""
Count = Annotated[int, BeforeValidator(whole), Ge(1), Le(MOST)]
"""A whole number, from 1 to 10^9."""
Whole = Annotated[int, BeforeValidator(whole), Ge(0), Le(MOST)]
"""A whole number, from 0 to 10^9."""
Flag = Annotated[bool, BeforeValidator(flag)]
"""True or False, and nothing that merely looks like it."""
Vector = Annotated[tuple[Finite, Finite, Finite], BeforeValidator(vector)]
"""Three finite numbers, from a tuple, list or array."""
Pair = Annotated[tuple[Finite, Finite], BeforeValidator(pair)]
"""Two finite numbers, from a tuple, list or array."""
Times = Annotated[Sequence[NonNegative], BeforeValidator(numbers)]
"""Any number of times, none negative, from a tuple, list or array."""
Numbers = Annotated[Sequence[Finite], BeforeValidator(numbers)]
"""Any number of finite numbers, from a tuple, list or array."""
Points = Annotated[Sequence[tuple[Finite, Finite]], BeforeValidator(points)]
"""Points in a plane, from a list, tuple or array of pairs."""
_ROWS_OF_FILES: dict[str, object] = {
    "type": "array", "items": {"type": "integer", "minimum": 0, "maximum": MOST}, "minItems": 1, "uniqueItems": True
}  # fmt: skip
Rows = Annotated[Sequence[int], BeforeValidator(rows), WithJsonSchema(_ROWS_OF_FILES)]
"""Indices (tuple, list or array), none twice."""
_NODES_OF_FILES: dict[str, list[dict[str, object]]] = {"anyOf": [{"type": "string", "minLength": 1}, _ROWS_OF_FILES]}
Nodes = Annotated[str | Sequence[int], BeforeValidator(nodes), WithJsonSchema(_NODES_OF_FILES)]
"""The name of a node set, or node indices (tuple, list or array), none twice."""
_PLACES_OF_FILES: dict[str, object] = {
    "anyOf": [
        {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3},
        {"type": "integer", "minimum": 0, "maximum": MOST},
        {"type": "string", "minLength": 1},
    ]
}
Place = Annotated[tuple[float, float, float] | int | str, BeforeValidator(place), WithJsonSchema(_PLACES_OF_FILES)]
"""A point (tuple, list or array), a node index, or a text that names a node."""
_NAMES_OF_FILES: dict[str, object] = {
    "type": "array", "items": {"type": "string", "minLength": 1}, "minItems": 1, "uniqueItems": True
}  # fmt: skip
_NODE_SETS_OF_FILES = {"anyOf": [*_NODES_OF_FILES["anyOf"], _NAMES_OF_FILES]}
NodeSets = Annotated[
    str | Sequence[str] | Sequence[int], PlainValidator(node_sets), WithJsonSchema(_NODE_SETS_OF_FILES)
]
"""The name of a node set, names of several, or node indices (tuple, list or array), none twice."""
TriangleSets = Annotated[
    str | Sequence[str] | Sequence[int], PlainValidator(triangle_sets), WithJsonSchema(_NODE_SETS_OF_FILES)
]
"""The same of triangle sets and triangle indices."""
