"""Drag of thin air."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from membrane_rs._validation import NonNegative, Positive, Unit, validated
from membrane_rs.scene.law import Law, Surroundings


@validated
class AirDrag(Law):
    """Drag of thin air: rho V^2 S_n / 6 on each node of a triangle, against the node's velocity V.

    S_n is the triangle's area projected on the plane normal to V; rho = p / (287 T).

    Parameters
    ----------
    pressure : float
        p [Pa], 0 or above.
    temperature : float
        T [K], above 0.
    air : str
        "still": at rest in the chamber. "turning": turning with the hub.
    """

    kind: ClassVar[str] = "air_drag"
    pressure: Annotated[NonNegative, Unit("Pa")] = 4.5
    temperature: Annotated[Positive, Unit("K")] = 293.0
    air: Literal["still", "turning"] = "still"

    def why_idle(self, scene: Surroundings) -> str | None:
        """Without a membrane, air or a motion against it there is no drag."""
        if scene.mesh is None:
            return "the scene has no membrane"
        if self.pressure == 0:
            return "its pressure is 0: there is no air"
        assembly = scene.assemble()
        if self.air == "turning" and len(assembly.fixed) == assembly.node_count:
            return "nothing moves in this scene"
        return None
