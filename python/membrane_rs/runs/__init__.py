"""The run of a scene, and the folder of its results."""

from __future__ import annotations

from membrane_rs.runs.resuming import resume
from membrane_rs.runs.run_folder import RunFolder
from membrane_rs.runs.simulation import Simulation

__all__ = ["RunFolder", "Simulation", "resume"]
