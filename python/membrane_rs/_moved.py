"""Old public places of names: each still leads to the new one, and says it.

A module whose names have moved sets `__getattr__ = Moved(__name__, {new place: names})`.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any


class Moved:
    """The `__getattr__` of a module whose names stand elsewhere.

    Parameters
    ----------
    module : str
        The old module.
    places : mapping of str to sequence of str
        The names that each new module holds.
    """

    def __init__(self, module: str, places: Mapping[str, Sequence[str]]) -> None:
        self.module = module
        self.place_of = {name: place for place, names in places.items() for name in names}

    def __call__(self, name: str) -> Any:
        """The object of that name, with a DeprecationWarning. Raises AttributeError for other names."""
        place = self.place_of.get(name)
        if place is None:
            raise AttributeError(f"module {self.module!r} has no attribute {name!r}")
        warnings.warn(
            f"{self.module}.{name} is deprecated; import {name} from {place}", DeprecationWarning, stacklevel=2
        )
        return getattr(import_module(place), name)
