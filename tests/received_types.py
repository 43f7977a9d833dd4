"""Types that users receive: what public functions, methods and properties return, and the attributes of such types.

An annotation is read as text, since some name types that are imported for type checkers alone; its names are looked up
where the function stands, then among all classes of the package.
"""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, get_args

import membrane_rs
from docstring_rules import plain
from numpydoc.docscrape import NumpyDocString
from website.public import members, public_names

NAME = re.compile(r"(?<![\w.])[A-Za-z_]\w*(?![\w(])")
"""Neither a name of another module, such as pd.DataFrame, nor what is called, such as Unit("m")."""
OPERATORS = ("__getitem__", "__iter__", "__call__", "__enter__")


def received(value: Any) -> set[type]:
    """Classes of this package that a caller is given by a function, or by the members of a class."""
    if not inspect.isclass(value):
        return _named(_returned(value), _globals(value))
    found: set[type] = set()
    cls: Any = value
    operators = [name for name in OPERATORS if inspect.isfunction(inspect.getattr_static(value, name, None))]
    for name in (*members(cls), *operators):
        function = plain(inspect.getattr_static(value, name))
        found |= _named(_returned(function), _globals(function))
    names = vars(inspect.getmodule(value))
    if dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            found |= set() if field.name.startswith("_") else _named(field.type, names)
    for row in NumpyDocString(inspect.getdoc(value) or "")["Attributes"]:
        found |= _named(row.type, names)
    return found - {value}


def undescribed() -> dict[str, str]:
    """Types without a page in the reference, each with a public name that gives it, and those that they give."""
    public = {name.value for name in public_names() if name.kind in ("class", "exception")}
    found: dict[str, str] = {}
    waiting = [(name.path, name.value) for name in public_names() if name.kind in ("class", "function")]
    seen: set[type] = set()
    while waiting:
        path, value = waiting.pop()
        for kind in sorted(received(value) - public - seen, key=lambda kind: kind.__qualname__):
            seen.add(kind)
            found[f"{kind.__module__}.{kind.__qualname__}"] = path
            waiting.append((f"{kind.__module__}.{kind.__qualname__}", kind))
    return found


def _returned(function: Any) -> Any:
    return inspect.signature(function).return_annotation


def _globals(function: Any) -> dict[str, Any]:
    return getattr(inspect.unwrap(function), "__globals__", {})


def _named(annotation: Any, names: dict[str, Any]) -> set[type]:
    """The classes of this package in an annotation."""
    if not isinstance(annotation, str):
        return set(_classes(annotation))
    found: set[type] = set()
    for word in NAME.findall(annotation):
        value = names[word] if word in names else _all_classes().get(word)
        found |= set(_classes(value))
    return found


def _classes(value: Any) -> Iterator[type]:
    """A class of this package, or those in an alias; a protocol is no type of anything that is made."""
    if inspect.isclass(value) and not get_args(value):
        is_own = value.__module__.startswith("membrane_rs") and not value.__name__.startswith("_")
        if is_own and not getattr(value, "_is_protocol", False):
            yield value
    else:
        for part in get_args(value):
            yield from _classes(part)


@cache
def _all_classes() -> dict[str, type]:
    """The classes of all modules of the package, by name."""
    root = Path(membrane_rs.__file__).parent
    found: dict[str, type] = {}
    for path in sorted(root.rglob("*.py")):
        if path.name != "__main__.py":
            name = ".".join(["membrane_rs", *path.relative_to(root).with_suffix("").parts]).removesuffix(".__init__")
            module: ModuleType = importlib.import_module(name)
            own = {k: v for k, v in vars(module).items() if inspect.isclass(v) and v.__module__ == name}
            found |= own
    return found
