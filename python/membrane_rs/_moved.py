"""Old public places of names: each still leads to the new one, and its warning says which that is.

A module whose names have moved sets `__getattr__ = Moved(__name__, {new place: names})`. Where it has
nothing else, it sets `__all__ = __getattr__.names()` and `__dir__ = __getattr__.names` too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

from membrane_rs._renamed import deprecated


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

    def names(self) -> list[str]:
        """The names that the old module still leads from: its `__all__`, and its `__dir__`."""
        return sorted(self.new)

    def __call__(self, name: str) -> Any:
        """The object of that name, with a DeprecationWarning. Raises AttributeError for other names."""
        if name not in self.new:
            raise AttributeError(f"module {self.module!r} has no attribute {name!r}")
        place, new = self.new[name]
        deprecated(f"{self.module}.{name}", f"import {new} from {place}")
        return getattr(import_module(place), new)
