"""The old place of names that now stand in `membrane_rs.results`, `membrane_rs.plotting` and `membrane_rs.runs`."""

from __future__ import annotations

from membrane_rs._moved import Moved

__getattr__ = Moved(
    __name__,
    {
        "membrane_rs.results": ("read_frame", "read_history", "read_pvd", "write_frame", "write_pvd"),
        "membrane_rs.plotting": ("compare_runs", "plot_deployment"),
        "membrane_rs.runs": ("RunFolder",),
    },
)
__all__ = [*__getattr__.names()]  # noqa: PLE0604 - names only
__dir__ = __getattr__.names
