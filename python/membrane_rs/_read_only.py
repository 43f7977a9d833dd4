"""Dictionaries that nobody changes, as fields of frozen classes."""

from __future__ import annotations

from typing import Any, NoReturn, TypeVar

from membrane_rs.errors import InputTypeError

K = TypeVar("K")
V = TypeVar("V")


class ReadOnly(dict[K, V]):
    """A dictionary that is read, compared, copied and pickled as any other; what would change it raises
    InputTypeError. `table | {...}` is another one, which can be changed.
    """

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise InputTypeError("the table is read-only; build what holds it with another: replace(stage, set={...})")

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[type[ReadOnly[K, V]], tuple[dict[K, V]]]:
        """Pickle and copy by the entries, since an empty one takes none later."""
        return type(self), (dict(self),)
