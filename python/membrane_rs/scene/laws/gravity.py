"""A uniform field of gravity."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import field
from typing import Annotated, ClassVar

from membrane_rs._validation import Unit, Vector, validated
from membrane_rs.scene.hub import Hub
from membrane_rs.scene.law import Law, Surroundings
from membrane_rs.scene.laws._factor import largest_factor
from membrane_rs.scene.plausible import Doubt, implausible
from membrane_rs.scene.schedule import Schedule

STRONGEST = 30.0
"""A little more than at the surface of Jupiter, 24.8 m/s2; the Sun's is 274."""
EARTH, SAME = 9.81, 0.005
"""[m/s2], and how far other values of it differ [-]."""


@validated
class Gravity(Law):
    """A uniform field, fixed in inertial space: F = m g.

    A hub in six degrees of freedom has its weight too, and falls with the sail.

    Parameters
    ----------
    acceleration : tuple of float
        g (x, y, z) [m/s2].
    factor : Schedule or None
        By which g is multiplied, as a function of time [-]. None: 1. By keyword alone. With one it is a load without
        potential: its work is that of the forces.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import Gravity
    >>> Gravity().acceleration
    (0.0, 0.0, -9.81)
    >>> from membrane_rs import Schedule
    >>> Gravity(factor=Schedule([0.0, 0.5], [0.0, 1.0])).factor.at(0.25)
    0.5
    """

    kind: ClassVar[str] = "gravity"
    accelerates_all: ClassVar[bool] = True
    acceleration: Annotated[Vector, Unit("m/s2")] = (0.0, 0.0, -9.81)
    factor: Schedule | None = field(default=None, kw_only=True)

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """No planet's gravity is stronger than `STRONGEST`, and hardly anything has a thousandth of the Earth's."""
        size = math.hypot(*self.acceleration) * largest_factor(self.factor)
        reason = f"gravity of more than {STRONGEST:g} m/s2 is that of no planet, and 9.81 m/s2 that of the Earth"
        units = {"cm/s2": 0.01, "mm/s2": 0.001}
        least = 0.0
        if abs(1e3 * size / EARTH - 1.0) < SAME:
            least, units = EARTH * (1.0 - SAME), {"km/s2": 1e3}
            reason = "that is a thousandth of the gravity of the Earth, 9.81 m/s2"
        yield from implausible(f"{where}.acceleration", size, "m/s2", reason, least=least, most=STRONGEST, units=units)

    def turns_whole(self, hub: Hub) -> bool:
        """But along the axis that a bearing holds: about a point in space whatever falls gains angular momentum."""
        return hub.mass is not None or any(self.acceleration[:2])

    def why_idle(self, scene: Surroundings) -> str | None:
        """A field of no strength."""
        if not any(self.acceleration):
            return "its acceleration is 0"
        return "its factor is 0" if largest_factor(self.factor) == 0.0 else None
