"""Pictures and curves. pyvista, matplotlib and Pillow are imported where they are used, not here."""

from __future__ import annotations

from membrane_rs.plotting.crossings import plot_crossings
from membrane_rs.plotting.deployment import compare_runs, plot_deployment

__all__ = ["compare_runs", "plot_crossings", "plot_deployment"]
