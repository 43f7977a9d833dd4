"""Drag of air on cords."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal

import numpy as np

from membrane_rs._arrays import Ints
from membrane_rs._validation import NonNegative, Positive, Unit, validated
from membrane_rs.mesh import Mesh
from membrane_rs.scene.hub import Hub
from membrane_rs.scene.law import Law, Surroundings
from membrane_rs.scene.plausible import Doubt, implausible

THINNEST = 1e-6
"""Diameter of a fibre below which no cord is [m]: those of carbon have 5 um."""
BLUNTEST = 3.0
"""Drag coefficient beyond that of any section across the flow [-]: a flat plate has 2."""


@validated
class CordDrag(Law):
    """Drag of air across the segments of cords: 0.5 rho C_d d l w^2 on each, against its velocity w across itself.

    w is the mean velocity of its two nodes relative to the air, without the part along the segment; l is its present
    length. Half of the drag acts on either node. A boltrope has none, for the film beside it has
    (`AirDrag`).

    Parameters
    ----------
    diameter : float
        d of all cords [m], above 0.
    coefficient : float
        C_d of the flow across them [-], 0 or above: some 1.1 for a round cord at Reynolds numbers of 100 to 2e5.
    density : float
        rho of the air [kg/m3], 0 or above.
    air : str
        "still": at rest in the chamber. "turning": turning with the hub.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import CordDrag
    >>> CordDrag(diameter=1e-3).coefficient
    1.1
    """

    kind: ClassVar[str] = "cord_drag"
    exerts_outside_torque: ClassVar[bool] = True
    diameter: Annotated[Positive, Unit("m")]
    coefficient: NonNegative = 1.1
    density: Annotated[NonNegative, Unit("kg/m3")] = 1.204
    air: Literal["still", "turning"] = "still"

    def turns_whole(self, hub: Hub) -> bool:
        """Air that turns with the hub acts between sail and hub."""
        return self.air == "still"

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """A cord is thicker than a fibre, thinner than its segments are long, and no blunter than any section."""
        lengths = scene.assemble().cords.rest_length
        most = float(np.median(lengths)) if len(lengths) else float("inf")
        reason, units = "the flow is that across a slender segment, longer than it is thick", {"mm": 1e-3, "um": 1e-6}
        place = f"{where}.diameter"
        derived = ("parts",)
        yield from implausible(
            place, self.diameter, "m", reason, least=THINNEST, most=most, units=units, derived_from=derived
        )
        blunt = f"a flat plate across the flow has 2, and nothing more than {BLUNTEST:g}"
        yield from implausible(f"{where}.coefficient", self.coefficient, "", blunt, most=BLUNTEST)

    def why_idle(self, scene: Surroundings) -> str | None:
        """Without cords, air or a motion against it there is no drag."""
        assembly = scene.assemble()
        if len(assembly.cords) == 0:
            return "the scene has no cords"
        if scene.mesh is not None and _are_edges(scene.mesh, assembly.cords.nodes):
            return "all cords lie along edges of the film, which have none"
        if self.density == 0 or self.coefficient == 0:
            return f"its {'density' if self.density == 0 else 'coefficient'} is 0"
        if self.air == "turning" and len(assembly.fixed) == assembly.node_count:
            return "nothing moves in this scene"
        return None


def _are_edges(mesh: Mesh, pairs: Ints) -> bool:
    """Whether all pairs of nodes (s, 2) are edges of the mesh."""
    return bool(pairs.max() < mesh.node_count) and bool(mesh.find_edges(pairs)[1].all())
