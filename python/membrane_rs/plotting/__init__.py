"""Figures of runs: curves, energy balance, snapshots, comparisons, sweeps; their style, and the files they go into."""

# pyvista, matplotlib and Pillow are imported where they are used, not here.

from __future__ import annotations

from typing import TYPE_CHECKING

from membrane_rs._on_demand import OnDemand

if TYPE_CHECKING:
    from membrane_rs.plotting.comparison import plot_comparison
    from membrane_rs.plotting.crossings import plot_crossings
    from membrane_rs.plotting.deployment import compare_runs, plot_deployment
    from membrane_rs.plotting.energy import plot_energy
    from membrane_rs.plotting.figure import save_figure
    from membrane_rs.plotting.history import plot_history
    from membrane_rs.plotting.momentum import plot_momentum
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
    "plot_momentum",
    "plot_snapshots",
    "save_figure",
    "save_run_figures",
]

if not TYPE_CHECKING:  # a type checker would take every name for one that is there
    _on_demand = OnDemand(
        __name__,
        {
            "membrane_rs.plotting.comparison": ("plot_comparison",),
            "membrane_rs.plotting.crossings": ("plot_crossings",),
            "membrane_rs.plotting.deployment": ("compare_runs", "plot_deployment"),
            "membrane_rs.plotting.energy": ("plot_energy",),
            "membrane_rs.plotting.figure": ("save_figure",),
            "membrane_rs.plotting.history": ("plot_history",),
            "membrane_rs.plotting.momentum": ("plot_momentum",),
            "membrane_rs.plotting.run_figures": ("save_run_figures",),
            "membrane_rs.plotting.snapshot_sheet": ("plot_snapshots",),
            "membrane_rs.plotting.style": ("PAPER", "SCREEN", "Style"),
        },
    )
    __getattr__, __dir__ = _on_demand, _on_demand.names
