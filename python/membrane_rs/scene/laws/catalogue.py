"""The one list of laws."""

from __future__ import annotations

from membrane_rs.scene.law import Law
from membrane_rs.scene.laws.air_drag import AirDrag
from membrane_rs.scene.laws.bending import Bending
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

LAWS: dict[str, type[Law]] = {
    law.kind: law
    for law in (
        Springs,
        Triangles,
        Rectangles,
        SpringDamping,
        Creases,
        Bending,
        AirDrag,
        CordDrag,
        Spin,
        Gravity,
        Pressure,
        SolarPressure,
        PointForces,
        SpoolContact,
        SelfContact,
        MassDamping,
    )
}
"""The one list of laws: the name of its table in a scene file, and its class."""
