"""Names and modules of a package that are imported when they are first used.

A package sets `__getattr__ = OnDemand(__name__, {module: names})` and imports the same for type checkers alone.

Several threads may use names first at once. The import system then locks one module at a time: a thread holds the locks
of the modules whose code it runs and waits for the modules that those import. Two threads cannot wait for each other as
long as no circle of modules waits for itself. A circle needs no circle of imports where the file of a package imports
modules of that package: a thread that imports `package.module` holds the lock of the module and waits for the
package, another that imports `package` waits for the module. Hence the rules, which tests and import contracts keep:

- The file of a package imports none of its own modules: their names come on demand. `cli` alone is exempt: one thread
  enters it, at one place.
- Modules do not import one another in circles, nor take a name on demand from a package that holds them.
- No lock beside those of the import system. A module takes names on demand while it is imported, so a lock here would
  be waited for by a thread that holds locks of modules, and the import system would not see the circle.

Third-party packages keep no such rules. The first lookup imports those that nearly every module needs, from one place.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from types import ModuleType
from typing import Any


def _imported(module: str) -> ModuleType:
    """A module of the package, after the third-party packages that it may need."""
    import_module("membrane_rs._third_party")
    return import_module(module)


class OnDemand:
    """The `__getattr__` of a package: of the names given, and of all its public modules.

    Parameters
    ----------
    package : str
        The package.
    places : mapping of str to sequence of str
        The names that each module holds.
    old : callable, optional
        What finds former names, or raises AttributeError.
    """

    def __init__(
        self, package: str, places: Mapping[str, Sequence[str]], old: Callable[[str], Any] | None = None
    ) -> None:
        self.package, self.old = package, old
        self.places = {name: place for place, names in places.items() for name in names}
        """The module of each name."""

    def __call__(self, name: str) -> Any:
        """The object of that name, which the package holds from then on. Raises AttributeError for other names."""
        if name in self.places:
            found = getattr(_imported(self.places[name]), name)
            setattr(sys.modules[self.package], name, found)
            return found
        if not name.startswith("_") and name in self.modules():
            return _imported(f"{self.package}.{name}")
        if self.old is not None:
            return self.old(name)
        raise AttributeError(f"module {self.package!r} has no attribute {name!r}")

    def modules(self) -> list[str]:
        """The public modules of the package, imported or not."""
        from pkgutil import iter_modules  # slow to import

        found = (module.name for module in iter_modules(sys.modules[self.package].__path__))
        return [name for name in found if not name.startswith("_")]

    def names(self) -> list[str]:
        """All public names, and those that every module has: the `__dir__` of the package."""
        own = (name for name in vars(sys.modules[self.package]) if name.startswith("__"))
        return sorted({*self.places, *self.modules(), *own})
