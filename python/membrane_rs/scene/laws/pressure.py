"""Uniform pressure on the film."""

from __future__ import annotations

from typing import Annotated, ClassVar

from membrane_rs._validation import Finite, Unit, validated
from membrane_rs.scene.law import Law, Surroundings


@validated
class Pressure(Law):
    """Uniform pressure on the film, a follower load: F = p/6 (x1 - x0) x (x2 - x0) on each node of a triangle.

    It acts towards the side of each triangle's normal, from which its nodes are seen counter-clockwise. Its work is
    external; on a closed surface it leaves no force and no torque on the whole.

    Parameters
    ----------
    pressure : float
        p [Pa], the difference of the two sides' pressures; below zero it acts against the normal.
    """

    kind: ClassVar[str] = "pressure"
    pressure: Annotated[Finite, Unit("Pa")]

    def why_idle(self, scene: Surroundings) -> str | None:
        """A pressure of no strength, or nothing to act on."""
        if self.pressure == 0:
            return "its pressure is 0"
        return "there is no film" if scene.mesh is None else None
