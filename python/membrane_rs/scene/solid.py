"""A body as it stands at one instant, for pictures."""

from __future__ import annotations

from dataclasses import dataclass

from membrane_rs._arrays import Floats


@dataclass(frozen=True)
class Solid:
    """A cylinder, or a plane.

    centre (3,): the middle of a cylinder, or a point of a plane [m], in the frame that turns with the hub.
    direction (3,): of the axis or of the normal, of length 1.
    """

    centre: Floats
    direction: Floats
    radius: float | None = None
    """Of a cylinder [m]; None: a plane."""
    half_length: float | None = None
    """From the centre to each end [m]; None: endless."""
