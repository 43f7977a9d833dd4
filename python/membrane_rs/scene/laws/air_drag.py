"""Drag of thin air."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated, ClassVar, Literal

from membrane_rs._validation import NonNegative, Positive, Unit, validated
from membrane_rs.analysis.extent import span
from membrane_rs.scene.hub import Hub
from membrane_rs.scene.law import Law, Surroundings
from membrane_rs.scene.plausible import FILM, Doubt, implausible

GAS_CONSTANT = 287.0
"""R of air [J/(kg K)]."""
HEAVY_AIR = 0.1
"""Mass of the air beside the film, over that of the film, from which the law no longer holds."""


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

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import AirDrag
    >>> AirDrag(pressure=4.5).temperature
    293.0
    """

    kind: ClassVar[str] = "air_drag"
    exerts_outside_torque: ClassVar[bool] = True
    pressure: Annotated[NonNegative, Unit("Pa")] = 4.5
    temperature: Annotated[Positive, Unit("K")] = 293.0
    air: Literal["still", "turning"] = "still"

    def turns_whole(self, hub: Hub) -> bool:
        """Air that turns with the hub acts between sail and hub."""
        return self.air == "still"

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """The law is that of thin air, without added mass: air beside the film, about as deep as the film is wide,
        weighs less than a tenth of it. Air is liquid below 79 K at 1 bar, and films decompose by 800 K.
        """
        kelvin, celsius = f"{where}.temperature", self.temperature + 273.15
        for finding in implausible(kelvin, self.temperature, "K", "air is a gas from 79 K on", least=79.0, most=800.0):
            meant = f"were {self.temperature:g} degrees Celsius meant? That is {celsius:.4g} K"
            yield replace(finding, remedy=meant) if self.temperature < 79.0 else finding
        if scene.mesh is not None and scene.material is not None:
            film = scene.material.density * scene.material.thickness
            air = span(scene.mesh.reference) / (GAS_CONSTANT * self.temperature)
            share = self.pressure * air / film
            reason = f"the air beside the film weighs {100 * share:.3g} % of it, and the law is that of thin air"
            most = HEAVY_AIR * film / air
            yield from implausible(f"{where}.pressure", self.pressure, "Pa", reason, most=most, derived_from=FILM)

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
