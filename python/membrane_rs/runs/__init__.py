"""The run of a scene, its results in memory, and the folder of its results."""

from __future__ import annotations

from membrane_rs.runs.frames import RunFrame, RunFrames
from membrane_rs.runs.opening import open_run
from membrane_rs.runs.result import Run
from membrane_rs.runs.resuming import resume
from membrane_rs.runs.run_folder import RunFolder
from membrane_rs.runs.running import run
from membrane_rs.runs.simulation import Simulation
from membrane_rs.runs.viewing import view

__all__ = ["Run", "RunFolder", "RunFrame", "RunFrames", "Simulation", "open_run", "resume", "run", "view"]
