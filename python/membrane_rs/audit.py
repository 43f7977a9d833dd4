"""The old place of names that now stand in `membrane_rs.mesh`."""

from __future__ import annotations

from membrane_rs._moved import Moved

__getattr__ = Moved(
    __name__,
    {
        "membrane_rs.mesh": ("Audit", "Finding"),
    },
)
__all__ = [*__getattr__.names()]  # noqa: PLE0604 - names only
__dir__ = __getattr__.names
