"""Elements by names of sets or by indices."""

from __future__ import annotations

from collections.abc import Sequence


def groups_of(wanted: str | Sequence[str] | Sequence[int]) -> Sequence[str] | Sequence[Sequence[int]]:
    """Names of sets one by one, or indices as one group."""
    if isinstance(wanted, str):
        return [wanted]
    names = [name for name in wanted if isinstance(name, str)]
    return names or [tuple(index for index in wanted if not isinstance(index, str))]


def has_numbers(wanted: str | Sequence[str] | Sequence[int] | None) -> bool:
    """Whether these are indices, which belong to one mesh, and no names of sets."""
    return wanted is not None and not isinstance(wanted, str) and not isinstance(wanted[0], str)
