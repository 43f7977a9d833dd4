"""Figures of runs: curves, energy balance, snapshots, comparisons, sweeps; their style, and the files they go into."""

# pyvista, matplotlib and Pillow are imported where they are used, not here.

from __future__ import annotations

from membrane_rs.plotting.comparison import plot_comparison
from membrane_rs.plotting.crossings import plot_crossings
from membrane_rs.plotting.deployment import compare_runs, plot_deployment
from membrane_rs.plotting.energy import plot_energy
from membrane_rs.plotting.figure import save_figure
from membrane_rs.plotting.history import plot_history
from membrane_rs.plotting.run_figures import save_run_figures
from membrane_rs.plotting.snapshot_sheet import plot_snapshots
from membrane_rs.plotting.style import PAPER, SCREEN, Style

__all__ = [
    "PAPER",
    "SCREEN",
    "Style",
    "compare_runs",
    "plot_comparison",
    "plot_crossings",
    "plot_deployment",
    "plot_energy",
    "plot_history",
    "plot_snapshots",
    "save_figure",
    "save_run_figures",
]
