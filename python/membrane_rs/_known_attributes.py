"""Attributes that can be set; a name that is none of them is an error, not a new attribute."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

from membrane_rs._validation import nearest
from membrane_rs.errors import UnknownAttributeError

PACKAGE = __name__.partition(".")[0]


class KnownAttributes:
    """Refuses to set what a class of this package does not have. A class of a user takes further attributes.

    Frozen dataclasses refuse it by themselves.
    """

    ONCE: ClassVar[tuple[str, ...]] = ()
    """Set when an object is made, and never again: what else it holds follows from them."""
    SETTABLE: ClassVar[tuple[str, ...]] = ()
    """Can be set, beside properties that have a setter."""
    INSTEAD: ClassVar[str] = "make another one"
    """What to do instead of setting what is read only."""

    if not TYPE_CHECKING:  # a checker of types would take any attribute where this method is

        def __setattr__(self, name: str, value: object) -> None:
            """Set a known attribute, a private one, or one of a user's own class. Raises UnknownAttributeError."""
            kind = type(self)
            declared = [vars(base)[name] for base in kind.__mro__ if name in vars(base)]
            is_derived = bool(declared) and isinstance(declared[0], cached_property)
            if is_derived or (name in self.ONCE and name in self.__dict__):
                raise UnknownAttributeError(f"{kind.__name__}.{name}: is read only; {self.INSTEAD}")
            is_own = kind.__module__.partition(".")[0] == PACKAGE
            if is_own and not declared and name not in (*self.ONCE, *self.SETTABLE) and not name.startswith("_"):
                known = settable(kind)
                advice = nearest(name, known) if known else f"nothing can be set; {self.INSTEAD}"
                raise UnknownAttributeError(
                    f"{kind.__name__}.{name}: no such attribute; {advice}. A class of your own that derives from "
                    "this one may have more"
                )
            super().__setattr__(name, value)

    def __delattr__(self, name: str) -> None:
        """Delete a private attribute, or one of a user's own class. Raises UnknownAttributeError for any other."""
        kind = type(self)
        own = [base for base in kind.__mro__ if base.__module__.partition(".")[0] == PACKAGE]
        is_declared = any(name in vars(base) for base in own)
        if not name.startswith("_") and (is_declared or name in (*self.ONCE, *self.SETTABLE)):
            raise UnknownAttributeError(f"{kind.__name__}.{name}: cannot be deleted; {self.INSTEAD}")
        super().__delattr__(name)


def settable(kind: type[KnownAttributes]) -> list[str]:
    """The attributes of a class that can be set."""
    found = {name: item for base in reversed(kind.__mro__) for name, item in vars(base).items()}
    names = [name for name, item in found.items() if isinstance(item, property) and item.fset is not None]
    return [*kind.SETTABLE, *names]
