"""Names of a package whose modules are imported when such a name is first used.

A package sets `__getattr__ = OnDemand(__name__, {module: names})` and imports the same for type checkers alone.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any


class OnDemand:
    """The `__getattr__` of a package.

    Parameters
    ----------
    package : str
        The package.
    places : mapping of str to sequence of str
        The names that each module holds.
    modules : sequence of str
        Modules of the package that are its attributes too.
    """

    def __init__(self, package: str, places: Mapping[str, Sequence[str]], modules: Sequence[str] = ()) -> None:
        self.package, self.modules = package, tuple(modules)
        self.places = {name: place for place, names in places.items() for name in names}
        """The module of each name."""

    def __call__(self, name: str) -> Any:
        """The object of that name, which the package holds from then on. Raises AttributeError for other names."""
        if name in self.modules:
            return import_module(f"{self.package}.{name}")
        if name not in self.places:
            raise AttributeError(f"module {self.package!r} has no attribute {name!r}")
        found = getattr(import_module(self.places[name]), name)
        setattr(sys.modules[self.package], name, found)
        return found

    def names(self) -> list[str]:
        """All public names, and those that every module has: the `__dir__` of the package."""
        own = (name for name in vars(sys.modules[self.package]) if name.startswith("__"))
        return sorted({*self.places, *self.modules, *own})
