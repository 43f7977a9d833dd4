"""The laws of force that a scene may hold, as plain checked values.

A law here says what a scene wants; the core holds the kernel of the same name, with its equation and its
energy. A law that a scene leaves out costs nothing. Units are SI; angles are in radians.

The model is that of Okuizumi et al. (Trans. JSASS Aerospace Tech. Japan 10, 2012); where the paper leaves a choice
open, the docstring says what was chosen.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from membrane_rs._on_demand import OnDemand

if TYPE_CHECKING:
    from membrane_rs.scene.law import Law
    from membrane_rs.scene.laws.air_drag import AirDrag
    from membrane_rs.scene.laws.bending import Bending
    from membrane_rs.scene.laws.catalogue import LAWS
    from membrane_rs.scene.laws.cord_drag import CordDrag
    from membrane_rs.scene.laws.creases import Creases
    from membrane_rs.scene.laws.gravity import Gravity
    from membrane_rs.scene.laws.mass_damping import MassDamping
    from membrane_rs.scene.laws.point_forces import PointForces
    from membrane_rs.scene.laws.pressure import Pressure
    from membrane_rs.scene.laws.rectangles import Rectangles
    from membrane_rs.scene.laws.self_contact import SelfContact
    from membrane_rs.scene.laws.solar_pressure import SolarPressure
    from membrane_rs.scene.laws.spin import Spin
    from membrane_rs.scene.laws.spool_contact import SpoolContact
    from membrane_rs.scene.laws.spring_damping import SpringDamping
    from membrane_rs.scene.laws.springs import Springs
    from membrane_rs.scene.laws.triangles import Triangles

__all__ = [
    "LAWS",
    "AirDrag",
    "Bending",
    "CordDrag",
    "Creases",
    "Gravity",
    "Law",
    "MassDamping",
    "PointForces",
    "Pressure",
    "Rectangles",
    "SelfContact",
    "SolarPressure",
    "Spin",
    "SpoolContact",
    "SpringDamping",
    "Springs",
    "Triangles",
]

if not TYPE_CHECKING:  # a type checker would take every name for one that is there
    _on_demand = OnDemand(
        __name__,
        {
            "membrane_rs.scene.law": ("Law",),
            "membrane_rs.scene.laws.air_drag": ("AirDrag",),
            "membrane_rs.scene.laws.bending": ("Bending",),
            "membrane_rs.scene.laws.catalogue": ("LAWS",),
            "membrane_rs.scene.laws.cord_drag": ("CordDrag",),
            "membrane_rs.scene.laws.creases": ("Creases",),
            "membrane_rs.scene.laws.gravity": ("Gravity",),
            "membrane_rs.scene.laws.mass_damping": ("MassDamping",),
            "membrane_rs.scene.laws.point_forces": ("PointForces",),
            "membrane_rs.scene.laws.pressure": ("Pressure",),
            "membrane_rs.scene.laws.rectangles": ("Rectangles",),
            "membrane_rs.scene.laws.self_contact": ("SelfContact",),
            "membrane_rs.scene.laws.solar_pressure": ("SolarPressure",),
            "membrane_rs.scene.laws.spin": ("Spin",),
            "membrane_rs.scene.laws.spool_contact": ("SpoolContact",),
            "membrane_rs.scene.laws.spring_damping": ("SpringDamping",),
            "membrane_rs.scene.laws.springs": ("Springs",),
            "membrane_rs.scene.laws.triangles": ("Triangles",),
        },
    )
    __getattr__, __dir__ = _on_demand, _on_demand.names
