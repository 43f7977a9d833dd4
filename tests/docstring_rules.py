"""What the docstring of a public name must have, and what it lacks: parameters, results, units, errors, an example.

- Each parameter is in "Parameters" (an attribute of a result in "Attributes"), and no other is; what is returned is in
  "Returns".
- A float, or an array of them, has its unit in brackets, as pint knows it: [m], [N m], [-] for a plain number; or it
  says "in its unit", "in the unit of" where that depends on something else. A property says it in its text. The unit of
  a field of a checked class is the one in which it is checked.
- "Raises" has the errors of `raised_errors.raised`. Those of a class hold for its methods too.
- An example is there, or the method is in that of its class.
"""

from __future__ import annotations

import builtins
import inspect
import re
from collections.abc import Iterator
from functools import cached_property
from typing import Any

from membrane_rs import errors, units
from membrane_rs.errors import InputError, InputTypeError
from numpydoc.docscrape import NumpyDocString, Parameter
from raised_errors import raised
from website.public import INTERFACES, PublicName, members

FLOAT = re.compile(r"\b(float|float64|Floats)\b")
IN_BRACKETS = re.compile(r"\[([^\[\]]+)\]")
ELSEWHERE = re.compile(r"\bin (its|their) unit\b|\bin the unit\b|\bunit of\b", flags=re.IGNORECASE)
OF_PRINT = ("-", "pt", "inch")
"""No unit; and those of figures, which pint takes for others."""


def faults(name: PublicName) -> dict[str, str]:
    """What a public name and its members lack, by path."""
    value = name.value
    found = {name.path: lacks(value)}
    if name.kind == "class":
        for member in members(value):
            found[f"{name.path}.{member}"] = lacks(inspect.getattr_static(value, member), value)
    return {path: ", ".join(what) for path, what in found.items() if what}


def lacks(value: Any, owner: type | None = None) -> list[str]:
    """What the docstring of a function or a class lacks, or that of a method or a property of `owner`.

    Methods of an interface are called by the package, not by users: its class has an example, and
    `test_recipes.py` has more.
    """
    function = plain(value)
    text = inspect.getdoc(function) or ""
    if not text:
        return ["a docstring"]
    is_class = inspect.isclass(value)
    if is_class and issubclass(value, BaseException):
        return list(_units(value, docs_of(value)))
    if isinstance(value, property | cached_property):
        is_float = FLOAT.search(str(inspect.signature(function).return_annotation))
        lacking = ["a unit"] if is_float and not has_unit(text) else []
        return lacking + list(_errors(function, owner))
    found = [f"parameter {name}" for name in parameters(function) if name not in described(function)]
    found += [f"no parameter {row.name}" for row in _unknown(function)]
    doc = NumpyDocString(text)
    if not is_class:
        returned = inspect.signature(function).return_annotation
        is_silent = returned in ("None", None, inspect.Signature.empty) or doc["Returns"] or doc["Yields"]
        found += [] if is_silent else ["Returns"]
    found += [*_units(value if is_class else function, [doc]), *_errors(function, owner)]
    examples = (inspect.getdoc(owner) or "") if owner is not None else ""
    is_shown = doc["Examples"] or f".{function.__name__}(" in examples
    return found if is_shown or owner in INTERFACES else [*found, "Examples"]


def plain(member: Any) -> Any:
    """The function of a method or of a property."""
    if isinstance(member, property):
        return member.fget
    return member.func if isinstance(member, cached_property) else getattr(member, "__func__", member)


def parameters(value: Any) -> list[str]:
    """Names of parameters that a caller gives."""
    if inspect.isclass(value) and getattr(value, "_is_protocol", False):
        return []
    names = list(inspect.signature(value).parameters)
    is_method = not inspect.isclass(value) and names[:1] in (["self"], ["cls"]) and "." in value.__qualname__
    return [name for name in names[is_method:] if not name.startswith("_")]


def docs_of(value: Any) -> list[NumpyDocString]:
    """The docstring of a function, or those of a class and of the interface that it implements."""
    kinds = (
        [kind for kind in value.__mro__ if kind is value or kind in INTERFACES] if inspect.isclass(value) else [value]
    )
    return [NumpyDocString(inspect.getdoc(kind) or "") for kind in kinds if inspect.getdoc(kind) and kind is not object]


def names_of(row: Parameter) -> list[str]:
    """The names that share a description."""
    return [name.strip().lstrip("*") for name in row.name.split(",")]


def described(value: Any) -> set[str]:
    """Names of the parameters, and of the attributes of results, that a docstring or that of a base class describes."""
    rows = [row for doc in docs_of(value) for row in (*doc["Parameters"], *doc["Attributes"])]
    return {name for row in rows for name in names_of(row)}


def has_unit(text: str) -> bool:
    """Whether a text says a unit, or what the unit depends on."""
    return bool(units_in(text)) or ELSEWHERE.search(text) is not None


def units_in(text: str) -> list[str]:
    """The units in brackets in a text."""
    parts = [part.strip() for found in IN_BRACKETS.findall(text) for part in found.split(",")]
    return [part for part in parts if part in OF_PRINT or _is_unit(part)]


def _is_unit(text: str) -> bool:
    try:
        units.convert(1.0, text, text)
    except InputError:
        return False
    return not re.fullmatch(r"[\d.]*", text)


def _unknown(function: Any) -> list[Parameter]:
    """Rows of "Parameters" that are no parameters."""
    known = parameters(function)
    return [
        row
        for row in NumpyDocString(inspect.getdoc(function) or "")["Parameters"]
        if known and not set(names_of(row)) <= set(known)
    ]


def _units(value: Any, docs: list[NumpyDocString]) -> Iterator[str]:
    """Rows that say neither a unit nor what it depends on, or another than that of the field."""
    for doc in docs:
        for section in ("Parameters", "Attributes", "Returns", "Yields"):
            for row in doc[section]:
                text = " ".join((row.type, *row.desc))
                kind = row.type or (row.name if section in ("Returns", "Yields") else "")
                if FLOAT.search(kind) and not has_unit(text):
                    yield f"a unit of {row.name or 'what is returned'}"
                yield from (
                    f"the unit [{unit}] of {name}"
                    for name, unit in _of_fields(value, row)
                    if unit not in units_in(text)
                )


def _of_fields(value: Any, row: Parameter) -> Iterator[tuple[str, str]]:
    """The units of the fields of a checked class that a row describes."""
    fields = getattr(value, "__pydantic_fields__", {})
    for name in names_of(row):
        if name in fields and (unit := units.of(value, name)):
            yield name, unit


def _errors(function: Any, owner: type | None) -> Iterator[str]:
    """Errors that are raised and not listed, and those listed that are none."""
    own = _listed(function)
    found = raised(function, function if inspect.isclass(function) else owner)
    if hasattr(function, "__plain_init__"):
        found |= {InputError, InputTypeError}
    known = own if owner is None else own | _listed(owner)
    yield from sorted(f"error {error.__name__}" for error in found if error.__name__ not in known)
    yield from sorted(f"no error {name}" for name in own if not _is_error(name))


def _listed(value: Any) -> set[str]:
    rows = NumpyDocString(inspect.getdoc(value) or "")["Raises"]
    return {name.strip() for row in rows for name in (row.type or row.name).split(",")}


def _is_error(name: str) -> bool:
    value = getattr(errors, name, getattr(builtins, name, None))
    return inspect.isclass(value) and issubclass(value, BaseException)
