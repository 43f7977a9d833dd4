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
from membrane_rs.runs.recorder import Recorder
from membrane_rs.scene.bodies import Body
from membrane_rs.scene.laws import Law
from membrane_rs.scene.parts import Part
from membrane_rs.simulation import Observer

PACKAGES = (
    "membrane_rs",
    "membrane_rs.scenes",
    "membrane_rs.folding",
    "membrane_rs.mesh",
    "membrane_rs.scene",
    "membrane_rs.scene.laws",
    "membrane_rs.scene.parts",
    "membrane_rs.scene.bodies",
    "membrane_rs.scene.components",
    "membrane_rs.simulation",
    "membrane_rs.runs",
    "membrane_rs.results",
    "membrane_rs.plotting",
    "membrane_rs.plotting.viewer",
    "membrane_rs.report",
    "membrane_rs.check",
    "membrane_rs.study",
    "membrane_rs.units",
)
"""Packages whose `__all__` is public (docs/compatibility.md)."""
INTERFACES = (Law, Part, Body, Pattern, Observer, Recorder)
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
        return "function" if inspect.isroutine(self.value) else "data"

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


@cache
def members(cls: type) -> tuple[str, ...]:
    """Public methods and properties of a class, but for those of a class of `INTERFACES`.

    What two public classes share is described in the first of them alone: all of a motion in `Simulation`.
    """
    before = [public.value for public in public_names() if public.kind == "class"]
    before = before[: before.index(cls)] if cls in before else []
    shared = [other for other in before if cls in other.__mro__]
    interfaces = [base for base in INTERFACES if base is not cls and (base in cls.__mro__ or _is_observer(cls, base))]
    names: list[str] = []
    for owner in reversed(cls.__mro__):
        is_own = owner.__module__.startswith("membrane_rs") and owner not in interfaces
        for name, member in vars(owner).items():
            is_general = any(hasattr(base, name) for base in interfaces) or any(name in members(x) for x in shared)
            if is_own and not is_general and not name.startswith("_") and name not in names and is_described(member):
                names.append(name)
    return tuple(names)


def _is_observer(cls: type, base: type) -> bool:
    """Whether a class is an observer by its methods alone, as protocols have it."""
    return base is Observer and all(hasattr(cls, name) for name in vars(Observer) if not name.startswith("_"))


def is_described(member: object) -> bool:
    """Whether a member of a class is a method or a property, neither a field nor a constant."""
    return isinstance(member, property | staticmethod | classmethod) or inspect.isroutine(member) or _is_cached(member)


def _is_cached(member: object) -> bool:
    return type(member).__name__ == "cached_property"
