"""A uniform field of gravity."""

from __future__ import annotations

from typing import Annotated, ClassVar

from membrane_rs._validation import Unit, Vector, validated
from membrane_rs.scene.law import Law, Surroundings


@validated
class Gravity(Law):
    """A uniform field, fixed in inertial space: F = m g.

    Parameters
    ----------
    acceleration : tuple of float
        g (x, y, z) [m/s2].
    """

    kind: ClassVar[str] = "gravity"
    acceleration: Annotated[Vector, Unit("m/s2")] = (0.0, 0.0, -9.81)

    def why_idle(self, scene: Surroundings) -> str | None:
        """A field of no strength."""
        return None if any(self.acceleration) else "its acceleration is 0"
