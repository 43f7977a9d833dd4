"""Results of a run as data: its history, its frames, its summary, and what is measured on a scene in motion.

meshio is imported where it is used, not here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from membrane_rs._on_demand import OnDemand

if TYPE_CHECKING:
    from membrane_rs.results.crossing_counts import CrossingCounts, read_crossings
    from membrane_rs.results.experiment import Experiment
    from membrane_rs.results.experiment_file import read_experiment
    from membrane_rs.results.history import read_history
    from membrane_rs.results.measures import deployment_rate, peak_stress
    from membrane_rs.results.pvd import read_pvd, write_pvd
    from membrane_rs.results.run_history import RunHistory
    from membrane_rs.results.summary import read_summary
    from membrane_rs.results.vtk import read_frame, write_frame

__all__ = [
    "CrossingCounts",
    "Experiment",
    "RunHistory",
    "deployment_rate",
    "peak_stress",
    "read_crossings",
    "read_experiment",
    "read_frame",
    "read_history",
    "read_pvd",
    "read_summary",
    "write_frame",
    "write_pvd",
]

if not TYPE_CHECKING:  # a type checker would take every name for one that is there
    _on_demand = OnDemand(
        __name__,
        {
            "membrane_rs.results.crossing_counts": ("CrossingCounts", "read_crossings"),
            "membrane_rs.results.experiment": ("Experiment",),
            "membrane_rs.results.experiment_file": ("read_experiment",),
            "membrane_rs.results.history": ("read_history",),
            "membrane_rs.results.measures": ("deployment_rate", "peak_stress"),
            "membrane_rs.results.pvd": ("read_pvd", "write_pvd"),
            "membrane_rs.results.run_history": ("RunHistory",),
            "membrane_rs.results.summary": ("read_summary",),
            "membrane_rs.results.vtk": ("read_frame", "write_frame"),
        },
    )
    __getattr__, __dir__ = _on_demand, _on_demand.names
