"""Pressure of sunlight on the film."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, field, replace
from typing import Annotated, Any, ClassVar

from membrane_rs._validation import Fraction, Positive, Unit, Vector, validated
from membrane_rs.errors import InputError
from membrane_rs.scene.components import Optics
from membrane_rs.scene.law import Law, Surroundings
from membrane_rs.scene.laws._factor import largest_factor
from membrane_rs.scene.optics import OF_SIDES, optics_of
from membrane_rs.scene.plausible import Doubt, implausible
from membrane_rs.scene.schedule import Schedule

ASTRONOMICAL_UNIT = 149_597_870_700.0
"""[m], by its definition."""
NEAREST, FARTHEST = 0.04 * ASTRONOMICAL_UNIT, 200.0 * ASTRONOMICAL_UNIT
"""Distances from the sun [m]: a little less than that of the nearest spacecraft, and more than that of the farthest."""


@validated
class SolarPressure(Law):
    """Pressure of sunlight on the film, by the optical properties of its two sides; each triangle lit as if alone.

    On a triangle of area A, with the direction s to the sun, the normal n of the side that is lit and cos a = n . s::

        F = -P A cos a [(1 - r_s) s + (2 r_s cos a + 2/3 r_d + k) n],   P = 4.56e-6 Pa (1 au / distance)^2
        k = (1 - r_s - r_d) (e_l B_l - e_d B_d) / (e_l + e_d)

    a third on each node, with the shares r_s and r_d of the lit side, the emissivities e and Lambert coefficients B of
    the lit and the dark side. The front of a triangle is the side of its normal, from which its nodes are seen
    counter-clockwise. The direction to the sun is fixed in inertial space, so that it turns in a frame that spins
    or tumbles. It falls on the film alone, not on the hub.

    There are no shadows: layers of a folded film do not shade each other, nor does a body shade the film, nor is light
    reflected from triangle to triangle. The work of the load is external.

    Parameters
    ----------
    front_specular : float
        r_s of the front: share of the light that it reflects as a mirror [-], from 0 to 1.
    front_diffuse : float
        r_d of the front: share that it reflects to all sides by Lambert's law [-], from 0 to 1 - r_s. The rest is
        absorbed.
    sun : tuple of float
        Direction to the sun (x, y, z) in inertial space, of any length but 0 [-]. Default: along the axis of the hub.
    distance : float
        From the sun [m], above 0; in files "1 au". Default: one astronomical unit, 149,597,870,700 m.
    back_specular : float or None
        r_s of the back [-]. None: that of the front. By keyword alone, as all that follow.
    back_diffuse : float or None
        r_d of the back [-]. None: that of the front.
    front_emissivity : float
        e of the front [-], from 0 to 1. With both sides alike, emission has no effect.
    front_lambert : float
        B of the front [-], from 0 to 1: momentum of emitted light along the normal, as a share of that of a beam.
        Default: that of Lambert's law.
    back_emissivity : float or None
        e of the back [-]. None: that of the front.
    back_lambert : float or None
        B of the back [-]. None: that of the front.
    factor : Schedule or None
        By which the load is multiplied, as a function of time [-], as in a shadow or on the way to the sun. None: 1.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type; shares of a side of more than 1 together, a direction 0, no
        side that emits.

    Examples
    --------
    >>> from membrane_rs import SolarPressure
    >>> aluminium = SolarPressure(0.84, 0.04, sun=(0.0, 0.6, 0.8), back_specular=0.1, back_diffuse=0.3)
    >>> aluminium.back_diffuse
    0.3
    """

    kind: ClassVar[str] = "solar_pressure"
    exerts_outside_torque: ClassVar[bool] = True
    front_specular: Fraction
    front_diffuse: Fraction
    sun: Vector = (0.0, 0.0, 1.0)
    distance: Annotated[Positive, Unit("m")] = ASTRONOMICAL_UNIT
    back_specular: Fraction | None = field(default=None, kw_only=True)
    back_diffuse: Fraction | None = field(default=None, kw_only=True)
    front_emissivity: Fraction = field(default=1.0, kw_only=True)
    front_lambert: Fraction = field(default=2.0 / 3.0, kw_only=True)
    back_emissivity: Fraction | None = field(default=None, kw_only=True)
    back_lambert: Fraction | None = field(default=None, kw_only=True)
    factor: Schedule | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        """Check the direction, and the shares of each side together."""
        if not any(self.sun):
            raise InputError(f"SolarPressure.sun = {self.sun}: must not be 0; (0, 0, 1) is the hub's axis")
        self._optics()

    def _optics(self) -> Optics:
        """Of both sides. Raises InputError."""
        names = [f"{side}_{name}" for side in ("front", "back") for name in OF_SIDES]
        given = {name: getattr(self, name) for name in names if getattr(self, name) is not None}
        return optics_of("SolarPressure", given)

    def core_parameters(self) -> dict[str, Any]:
        """All of them, with those of the front where the back has none of its own."""
        return asdict(self) | asdict(self._optics())

    def simpler(self) -> tuple[str, SolarPressure] | None:
        """Emission alike from both sides, which has no recoil."""
        found = self._optics()
        front, back = (found.front_emissivity, found.front_lambert), (found.back_emissivity, found.back_lambert)
        if front == back:
            return None
        return "recoil of emission", replace(self, back_emissivity=None, back_lambert=None)

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """A spacecraft is between the nearest and the farthest distance at which one was."""
        reason = f"spacecraft are {NEAREST / ASTRONOMICAL_UNIT:g} to {FARTHEST / ASTRONOMICAL_UNIT:g} au from the sun"
        yield from implausible(
            f"{where}.distance", self.distance, "m", reason, least=NEAREST, most=FARTHEST,
            units={"au": ASTRONOMICAL_UNIT, "km": 1e3},
        )  # fmt: skip

    def why_idle(self, scene: Surroundings) -> str | None:
        """No light, or nothing to fall on."""
        if largest_factor(self.factor) == 0.0:
            return "its factor is 0"
        return "there is no film" if scene.mesh is None else None
