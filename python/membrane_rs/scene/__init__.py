"""A scene: what is simulated, made of what, under which laws, with which parts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from membrane_rs._on_demand import OnDemand

if TYPE_CHECKING:
    from membrane_rs.scene.assembly import Assembly
    from membrane_rs.scene.plausible import Doubt
    from membrane_rs.scene.scene import Scene
    from membrane_rs.scene.spool import Spool

__all__ = ["Assembly", "Doubt", "Scene", "Spool"]

if not TYPE_CHECKING:  # a type checker would take every name for one that is there
    _on_demand = OnDemand(
        __name__,
        {
            "membrane_rs.scene.assembly": ("Assembly",),
            "membrane_rs.scene.plausible": ("Doubt",),
            "membrane_rs.scene.scene": ("Scene",),
            "membrane_rs.scene.spool": ("Spool",),
        },
    )
    __getattr__, __dir__ = _on_demand, _on_demand.names
