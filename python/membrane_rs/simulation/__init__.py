"""A scene in motion: its state, its steps, its observers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from membrane_rs._moved import Moved
from membrane_rs._on_demand import OnDemand

if TYPE_CHECKING:
    from membrane_rs.simulation.fold_result import FoldIncrement, FoldResult
    from membrane_rs.simulation.folded import fold
    from membrane_rs.simulation.hub import AngularMomentum, HubLoad, HubMotor
    from membrane_rs.simulation.methods import IntegratorFacts, integrators
    from membrane_rs.simulation.motion import Motion
    from membrane_rs.simulation.observer import Observer
    from membrane_rs.simulation.readings import BodyLoad, FilmStress
    from membrane_rs.simulation.stepper import Stepper
    from membrane_rs.simulation.timeline import StageRecord

__all__ = [
    "AngularMomentum",
    "BodyLoad",
    "FilmStress",
    "FoldIncrement",
    "FoldResult",
    "HubLoad",
    "HubMotor",
    "IntegratorFacts",
    "Motion",
    "Observer",
    "StageRecord",
    "Stepper",
    "fold",
    "integrators",
]

if not TYPE_CHECKING:  # a type checker would take every name for one that is there
    _on_demand = OnDemand(
        __name__,
        {
            "membrane_rs.simulation.fold_result": ("FoldIncrement", "FoldResult"),
            "membrane_rs.simulation.folded": ("fold",),
            "membrane_rs.simulation.hub": ("AngularMomentum", "HubLoad", "HubMotor"),
            "membrane_rs.simulation.methods": ("IntegratorFacts", "integrators"),
            "membrane_rs.simulation.motion": ("Motion",),
            "membrane_rs.simulation.observer": ("Observer",),
            "membrane_rs.simulation.readings": ("BodyLoad", "FilmStress"),
            "membrane_rs.simulation.stepper": ("Stepper",),
            "membrane_rs.simulation.timeline": ("StageRecord",),
        },
        Moved(__name__, {"membrane_rs": ("Simulation",)}),
    )
    __getattr__, __dir__ = _on_demand, _on_demand.names
