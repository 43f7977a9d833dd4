"""The run of a scene, its results in memory, and the folder of its results."""

from __future__ import annotations

from typing import TYPE_CHECKING

from membrane_rs._on_demand import OnDemand

if TYPE_CHECKING:
    from membrane_rs.runs.frames import RunFrame, RunFrames
    from membrane_rs.runs.opening import open_run
    from membrane_rs.runs.result import Run
    from membrane_rs.runs.resuming import resume
    from membrane_rs.runs.run_folder import RunFolder
    from membrane_rs.runs.running import run
    from membrane_rs.runs.simulation import Simulation
    from membrane_rs.runs.viewing import view

__all__ = ["Run", "RunFolder", "RunFrame", "RunFrames", "Simulation", "open_run", "resume", "run", "view"]

if not TYPE_CHECKING:  # a type checker would take every name for one that is there
    _on_demand = OnDemand(
        __name__,
        {
            "membrane_rs.runs.frames": ("RunFrame", "RunFrames"),
            "membrane_rs.runs.opening": ("open_run",),
            "membrane_rs.runs.result": ("Run",),
            "membrane_rs.runs.resuming": ("resume",),
            "membrane_rs.runs.run_folder": ("RunFolder",),
            "membrane_rs.runs.running": ("run",),
            "membrane_rs.runs.simulation": ("Simulation",),
            "membrane_rs.runs.viewing": ("view",),
        },
    )
    __getattr__, __dir__ = _on_demand, _on_demand.names
