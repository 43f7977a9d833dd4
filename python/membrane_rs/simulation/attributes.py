"""Attributes of a simulation that can be set; a name that is none of them is an error, not a new attribute."""

from __future__ import annotations

from functools import cached_property

from membrane_rs._validation import nearest
from membrane_rs.errors import UnknownAttributeError

PACKAGE = __name__.partition(".")[0]
ONCE = ("scene", "assembly")
"""Set when a simulation is made, and never again: its core is built from them."""


class KnownAttributes:
    """Refuses to set what a class of this package does not have. A class of a user takes further attributes."""

    def __setattr__(self, name: str, value: object) -> None:
        """Set a known attribute, a private one, or one of a user's own class. Raises UnknownAttributeError."""
        kind = type(self)
        declared = [vars(base)[name] for base in kind.__mro__ if name in vars(base)]
        is_derived = bool(declared) and isinstance(declared[0], cached_property)
        if is_derived or (name in ONCE and name in self.__dict__):
            remedy = "make another simulation, which may go on from this one (start=)"
            raise UnknownAttributeError(f"{kind.__name__}.{name}: is read only; {remedy}")
        is_own = kind.__module__.partition(".")[0] == PACKAGE
        if is_own and not declared and name not in ONCE and name != "is_relaxed" and not name.startswith("_"):
            raise UnknownAttributeError(
                f"{kind.__name__}.{name}: no such attribute; {nearest(name, settable(kind))}. A class of your own that "
                "derives from this one may have more"
            )
        super().__setattr__(name, value)


def settable(kind: type) -> list[str]:
    """The attributes of a class that can be set."""
    found = {name: item for base in reversed(kind.__mro__) for name, item in vars(base).items()}
    names = [name for name, item in found.items() if isinstance(item, property) and item.fset is not None]
    return ["is_relaxed", *names]
