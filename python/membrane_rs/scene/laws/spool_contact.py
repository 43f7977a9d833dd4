"""Contact with the spool."""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np

from membrane_rs._validation import Flag, Positive, Unit, validated
from membrane_rs.scene.builder import Builder
from membrane_rs.scene.law import Law, StiffThrough, Surroundings
from membrane_rs.scene.reach import nearest_radii
from membrane_rs.scene.spool import Spool


@validated
class SpoolContact(Law):
    """Keeps tether nodes outside the spool, a cylinder about z, by a penalty: F = stiffness * depth.

    Deep inside, the force might push a node out on another side. So a run stops where a node goes deeper than half
    the radius (half the half-height where that is smaller), or passes a twentieth of it within one step. Only nodes
    have contact: the segments of a cord are chords, which sink in between them.

    Parameters
    ----------
    radius : float
        Radius of the spool [m], above 0.
    stiffness : float
        Of the penalty, for each node [N/m], above 0.
    half_height : float or None
        Half of the spool's height [m]: it reaches from -half_height to +half_height. None: endless.
    membrane : bool
        True: the nodes of the membrane are kept outside too.
    """

    kind: ClassVar[str] = "spool_contact"
    stiff_through: ClassVar[StiffThrough] = "law"
    radius: Annotated[Positive, Unit("m")] = 0.025
    stiffness: Annotated[Positive, Unit("N/m")] = 200.0
    half_height: Annotated[Positive | None, Unit("m")] = None
    membrane: Flag = False

    @property
    def spool(self) -> Spool:
        """The spool that nodes are kept outside of."""
        return Spool(self.radius, self.half_height)

    def add_contacts(self, builder: Builder) -> None:
        """Nodes of the cords, and of the membrane where it is kept outside too."""
        builder.add_contacts(builder.cord_nodes)
        if self.membrane:
            builder.add_contacts(np.arange(builder.mesh_count))

    def why_idle(self, scene: Surroundings) -> str | None:
        """Without contact nodes, or where none of them can reach the spool: springs to fixed nodes are too short."""
        assembly = scene.assemble()
        if len(assembly.contacts) == 0:
            return "no tether's node and no node of the membrane can meet the spool"
        if len(assembly.fixed) == 0 or len(assembly.bridges):
            return None
        limits = (law.edge_strain_limit for law in scene.laws)
        nearest = nearest_radii(assembly, scene.mesh, next((limit for limit in limits if limit is not None), None))
        if not (nearest > self.radius).all():
            return None
        least = nearest.min()
        return f"nothing can come nearer to the axis than {least:.4g} m, and the spool ends at {self.radius:g} m"

    def step_advice(self, gain: float) -> str:
        """A smaller stiffness."""
        return f"a stiffness of {self.stiffness / gain**2:.3g} N/m or less would take it out of the limit"
