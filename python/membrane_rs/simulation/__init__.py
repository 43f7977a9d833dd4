"""A scene in motion: its state, its steps, its observers."""

from __future__ import annotations

from membrane_rs._moved import Moved
from membrane_rs.simulation.methods import IntegratorFacts, integrators
from membrane_rs.simulation.motion import Motion
from membrane_rs.simulation.observer import Observer
from membrane_rs.simulation.readings import BodyLoad, FilmStress, HubLoad
from membrane_rs.simulation.stepper import Stepper
from membrane_rs.simulation.timeline import StageRecord

__all__ = [
    "BodyLoad",
    "FilmStress",
    "HubLoad",
    "IntegratorFacts",
    "Motion",
    "Observer",
    "StageRecord",
    "Stepper",
    "integrators",
]

__getattr__ = Moved(__name__, {"membrane_rs": ("Simulation",)})
