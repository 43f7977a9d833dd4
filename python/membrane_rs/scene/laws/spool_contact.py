"""Contact with the spool."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar

import numpy as np

from membrane_rs._validation import Flag, Positive, Unit, validated
from membrane_rs.scene.builder import Builder
from membrane_rs.scene.law import Law, StiffThrough, Surroundings
from membrane_rs.scene.plausible import FILM, Doubt, implausible
from membrane_rs.scene.reach import nearest_radii
from membrane_rs.scene.scales import pull_of_spin, stiffest, widest_spool
from membrane_rs.scene.spool import Spool

THINNEST = 1e-4
"""Radius of a spool over that of the flat scene."""
STIFFEST = 1000.0
"""Stiffness of the penalty over that of the stiffest spring: the step is then some thirty times as short."""


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

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import SpoolContact
    >>> SpoolContact(radius=0.025).radius
    0.025
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

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """The spool is thinner than the scene is wide. Its penalty stops the cords that spin presses on it before they
        reach half of the radius, and is not many times stiffer than all else, whose step it would make shorter.

        A cord of tension T that is wound on the spool presses each node, l apart, by T l / R on it.
        """
        most = widest_spool(scene)
        bounds = {"least": THINNEST * most, "most": most}
        reason = f"the flat scene reaches to {most:.4g} m"
        lengths = {"mm": 1e-3, "cm": 1e-2}
        own = f"{where}.radius"
        yield from implausible(own, self.radius, "m", reason, **bounds, units=lengths, derived_from=("mesh",))
        assembly = scene.assemble()
        place, derived = f"{where}.stiffness", (own, *FILM, "laws.spin", "parts")
        units = {"kN/m": 1e3, "mN/m": 1e-3}
        most = STIFFEST * stiffest(scene)
        if self.stiffness > most > 0.0:
            reason = f"that is more than {STIFFEST:g} times the stiffest spring, {most / STIFFEST:.3g} N/m"
            yield from implausible(place, self.stiffness, "N/m", reason, most=most, units=units, derived_from=derived)
        elif len(assembly.cords) and len(assembly.fixed):
            tension = pull_of_spin(scene) / len(assembly.fixed)
            force = tension * float(np.median(assembly.cords.rest_length)) / self.radius
            reason = f"a cord that is wound on the spool presses each node on it by about {force:.3g} N, which sinks "
            reason += f"{force / self.stiffness:.3g} m into it; the run stops at half of the radius"
            least = 2.0 * force / self.radius
            yield from implausible(place, self.stiffness, "N/m", reason, least=least, units=units, derived_from=derived)

    def why_idle(self, scene: Surroundings) -> str | None:
        """Without contact nodes, or where none of them can reach the spool: springs to fixed nodes are too short."""
        assembly = scene.assemble()
        if len(assembly.contacts) == 0:
            return "no tether's node and no node of the membrane can meet the spool"
        if len(assembly.fixed) == 0 or len(assembly.bridges):
            return None
        limits = (law.edge_strain_limit for law in scene.laws)
        limit = next((limit for limit in limits if limit is not None), None)
        nearest = nearest_radii(assembly, scene.mesh, limit, self.radius)
        if not (nearest > self.radius).all():
            return None
        least = nearest.min()
        return f"nothing can come nearer to the axis than {least:.4g} m, and the spool ends at {self.radius:g} m"

    def step_advice(self, gain: float) -> str:
        """A smaller stiffness."""
        return f"a stiffness of {self.stiffness / gain**2:.3g} N/m or less would take it out of the limit"
