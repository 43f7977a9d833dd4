"""The old place of names that now stand in `membrane_rs.analysis` and `membrane_rs.results`."""

from __future__ import annotations

from membrane_rs._moved import Moved

__getattr__ = Moved(
    __name__,
    {
        "membrane_rs.analysis.deployment": ("Corners", "corner_nodes"),
        "membrane_rs.analysis.strain": ("triangle_strains",),
        "membrane_rs.results": ("deployment_rate", "peak_stress"),
    },
)
__all__ = [*__getattr__.names()]  # noqa: PLE0604 - names only
__dir__ = __getattr__.names
