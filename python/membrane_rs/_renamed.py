"""Old names of attributes, fields and keys: each still leads to the new one, and its warning says which that is.

A class keeps an old name of an attribute, and a checked class that of a field, as `old = Renamed("new")`. A dict with
old keys is a `RenamedKeys`. A function whose name was that of another one is decorated with `takes_name_of`.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from functools import wraps
from inspect import Parameter, signature
from typing import Any, TypeVar

from typing_extensions import ParamSpec

Given = ParamSpec("Given")
Result = TypeVar("Result")

REMOVAL = "0.4"
"""The version in which deprecated names are removed."""


def deprecated(old: str, remedy: str, depth: int = 1) -> None:
    """Give a DeprecationWarning at the place that called so many functions above the caller of this one."""
    text = f"{old} is deprecated and is removed in version {REMOVAL}; {remedy}"
    warnings.warn(text, DeprecationWarning, stacklevel=2 + depth)


def takes_name_of(other: Callable[..., Any]) -> Callable[[Callable[Given, Result]], Callable[Given, Result]]:
    """Decorate a function whose name was that of another one, which is called something else now.

    Calls with arguments that the other function alone accepts lead to it, with a DeprecationWarning.
    """

    def decorate(function: Callable[Given, Result]) -> Callable[Given, Result]:
        own = signature(function).parameters
        most = sum(one.kind is not Parameter.KEYWORD_ONLY for one in own.values())
        others = set(signature(other).parameters) - set(own)

        @wraps(function)
        def call(*args: Given.args, **named: Given.kwargs) -> Result:
            if len(args) <= most and not others & set(named):
                return function(*args, **named)
            name = function.__name__
            deprecated(f"{name} with the arguments of {other.__name__}", f"call {other.__name__}, its new name")
            found: Result = other(*args, **named)
            return found

        return call

    return decorate


class Renamed:
    """An old name of an attribute or a method: reads and sets the new one, with a DeprecationWarning."""

    def __init__(self, new: str) -> None:
        self.new = new

    def __set_name__(self, owner: type, name: str) -> None:
        self.old = name

    def __get__(self, instance: object, owner: type | None = None) -> Any:
        holder: Any = owner if instance is None else instance
        deprecated(f"{(owner or type(instance)).__name__}.{self.old}", f"use {self.new}")
        return getattr(holder, self.new)

    def __set__(self, instance: object, value: Any) -> None:
        deprecated(f"{type(instance).__name__}.{self.old}", f"use {self.new}")
        setattr(instance, self.new, value)


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

    def copy(self) -> RenamedKeys:
        """A dict with the same entries that answers old keys too."""
        return RenamedKeys(self._name, self, self._renamed)

    def _old(self, key: str) -> Any:
        if key not in self._renamed:
            raise KeyError(key)
        deprecated(f"{self._name}[{key!r}]", f"use {self._renamed[key]!r}", depth=2)
        return self[self._renamed[key]]
