"""A uniform field of gravity."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, ClassVar

from membrane_rs._validation import Unit, Vector, validated
from membrane_rs.mesh import Finding
from membrane_rs.scene.law import Law, Surroundings
from membrane_rs.scene.plausible import implausible

STRONGEST = 30.0
"""A little more than at the surface of Jupiter, 24.8 m/s2; the Sun's is 274."""


@validated
class Gravity(Law):
    """A uniform field, fixed in inertial space: F = m g.

    Parameters
    ----------
    acceleration : tuple of float
        g (x, y, z) [m/s2].
    """

    kind: ClassVar[str] = "gravity"
    accelerates_all: ClassVar[bool] = True
    acceleration: Annotated[Vector, Unit("m/s2")] = (0.0, 0.0, -9.81)

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Finding]:
        """No planet's gravity is stronger than `STRONGEST`."""
        size = math.hypot(*self.acceleration)
        reason = f"gravity of more than {STRONGEST:g} m/s2 is that of no planet, and 9.81 m/s2 that of the Earth"
        units = {"cm/s2": 0.01, "mm/s2": 0.001}
        yield from implausible(f"{where}.acceleration", size, "m/s2", reason, most=STRONGEST, units=units)

    def why_idle(self, scene: Surroundings) -> str | None:
        """A field of no strength."""
        return None if any(self.acceleration) else "its acceleration is 0"
