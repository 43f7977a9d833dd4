"""Old public names: each still leads to the new one, and says it.

A module whose names have moved sets `__getattr__ = Moved(__name__, {new place: names})`. A class keeps an old name of
an attribute, and a checked class that of a field, as `old = Renamed("new")`. A dict with old keys is a `RenamedKeys`.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

REMOVAL = "0.4"
"""The version in which what is deprecated now goes."""


def deprecated(old: str, remedy: str, depth: int = 1) -> None:
    """Give a DeprecationWarning at the place that called so many functions above the caller of this one."""
    text = f"{old} is deprecated and goes with version {REMOVAL}; {remedy}"
    warnings.warn(text, DeprecationWarning, stacklevel=2 + depth)


class Moved:
    """The `__getattr__` of a module whose names are found elsewhere or under another name.

    Parameters
    ----------
    module : str
        The old module.
    places : mapping of str to sequence of str, or to mapping of str to str
        The names that each new module holds; or the old names, each with the new one.
    """

    def __init__(self, module: str, places: Mapping[str, Sequence[str] | Mapping[str, str]]) -> None:
        self.module = module
        self.new: dict[str, tuple[str, str]] = {}
        """(module, name) that an old name leads to."""
        for place, names in places.items():
            renamed = names if isinstance(names, Mapping) else {name: name for name in names}
            self.new |= {old: (place, new) for old, new in renamed.items()}

    def __call__(self, name: str) -> Any:
        """The object of that name, with a DeprecationWarning. Raises AttributeError for other names."""
        if name not in self.new:
            raise AttributeError(f"module {self.module!r} has no attribute {name!r}")
        place, new = self.new[name]
        deprecated(f"{self.module}.{name}", f"import {new} from {place}")
        return getattr(import_module(place), new)


class Renamed:
    """An old name of an attribute or a method: gives the new one, with a DeprecationWarning."""

    def __init__(self, new: str) -> None:
        self.new = new

    def __set_name__(self, owner: type, name: str) -> None:
        self.old = name

    def __get__(self, instance: object, owner: type | None = None) -> Any:
        if instance is None:
            return self
        deprecated(f"{type(instance).__name__}.{self.old}", f"use {self.new}")
        return getattr(instance, self.new)


def new_names(cls: type) -> dict[str, str]:
    """New names of a class's attributes, by their old ones."""
    return {name: item.new for name, item in vars(cls).items() if isinstance(item, Renamed)}


class RenamedKeys(dict[str, Any]):
    """A dict that answers old keys too, with a DeprecationWarning.

    Parameters
    ----------
    name : str
        What it is called in the warning.
    values : mapping
        Its entries.
    renamed : mapping of str to str
        New keys by old ones.
    """

    def __init__(self, name: str, values: Mapping[str, Any], renamed: Mapping[str, str]) -> None:
        super().__init__(values)
        self._name, self._renamed = name, renamed

    def __missing__(self, key: str) -> Any:
        return self._old(key)

    def get(self, key: str, default: Any = None) -> Any:
        """The entry of a key, new or old, or `default`."""
        if key in self:
            return self[key]
        return self._old(key) if key in self._renamed else default

    def _old(self, key: str) -> Any:
        if key not in self._renamed:
            raise KeyError(key)
        deprecated(f"{self._name}[{key!r}]", f"use {self._renamed[key]!r}", depth=2)
        return self[self._renamed[key]]
