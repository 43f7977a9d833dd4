"""The public names of the package, and where each is described: the pages of the reference, and the test of docstrings.

A name is described once, in the first of `PACKAGES` that has it; the others refer to it.
"""

from __future__ import annotations

import importlib
import inspect
from dataclasses import dataclass
from functools import cache
from typing import Any

from membrane_rs.folding import Pattern
from membrane_rs.scene.bodies import Body
from membrane_rs.scene.laws import Law
from membrane_rs.scene.parts import Part

PACKAGES = (
    "membrane_rs",
    "membrane_rs.scenes",
    "membrane_rs.folding",
    "membrane_rs.mesh",
    "membrane_rs.scene",
    "membrane_rs.scene.laws",
    "membrane_rs.scene.parts",
    "membrane_rs.scene.bodies",
    "membrane_rs.simulation",
    "membrane_rs.runs",
    "membrane_rs.results",
    "membrane_rs.plotting",
    "membrane_rs.check",
    "membrane_rs.study",
)
"""Packages whose `__all__` is public (docs/compatibility.md)."""
INTERFACES = (Law, Part, Body, Pattern)
"""Classes whose methods serve those who write another of their kind."""


@dataclass(frozen=True)
class PublicName:
    """A name in the `__all__` of a package."""

    package: str
    name: str

    @property
    def path(self) -> str:
        """With its package."""
        return f"{self.package}.{self.name}"

    @property
    def value(self) -> Any:
        """What it names."""
        return getattr(importlib.import_module(self.package), self.name)

    @property
    def kind(self) -> str:
        """The directive of autodoc that describes it."""
        if inspect.ismodule(self.value):
            return "module"
        if inspect.isclass(self.value):
            return "exception" if issubclass(self.value, BaseException) else "class"
        return "function" if callable(self.value) else "data"

    @property
    def group(self) -> str:
        """The module that defines it, as far as it says what the name is about."""
        return str(getattr(self.value, "__module__", self.package))


@cache
def public_names() -> tuple[PublicName, ...]:
    """All, in the order of the packages, each where it is described."""
    found: dict[int, PublicName] = {}
    names: list[PublicName] = []
    for package in PACKAGES:
        for name in importlib.import_module(package).__all__:
            public = PublicName(package, name)
            is_described = public.kind in ("class", "exception", "function") and id(public.value) in found
            if not is_described and public.kind != "module" and not name.startswith("__"):
                names.append(public)
                found[id(public.value)] = public
    return tuple(names)


def members(cls: type) -> list[str]:
    """Public methods and properties of a class, but for those of a class of `INTERFACES`."""
    interfaces = [base for base in cls.__mro__[1:] if base in INTERFACES]
    names: list[str] = []
    for owner in reversed(cls.__mro__):
        is_own = owner.__module__.startswith("membrane_rs") and owner not in interfaces
        for name, member in vars(owner).items():
            is_general = any(hasattr(base, name) for base in interfaces)
            if is_own and not is_general and not name.startswith("_") and name not in names and is_described(member):
                names.append(name)
    return names


def is_described(member: object) -> bool:
    """Whether a member of a class is a method or a property, neither a field nor a constant."""
    return isinstance(member, property | staticmethod | classmethod) or inspect.isroutine(member) or _is_cached(member)


def _is_cached(member: object) -> bool:
    return type(member).__name__ == "cached_property"
