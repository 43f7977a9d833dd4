"""A body as it stands at one instant, for pictures."""

from __future__ import annotations

from dataclasses import dataclass

from membrane_rs._arrays import Floats


@dataclass(frozen=True)
class Solid:
    """A cylinder or a plane as it stands at one instant, in the frame that turns with the hub.

    Attributes
    ----------
    centre : (3,) float
        The middle of a cylinder, or a point of a plane [m].
    direction : (3,) float
        Unit vector along the axis or the normal [-].
    radius : float or None
        Of a cylinder [m]; None: a plane.
    half_length : float or None
        From the centre to each end [m]; None: endless.

    Examples
    --------
    >>> from membrane_rs import Cylinder
    >>> solid = Cylinder("drum", 0.1).solids(0.0)[0]
    >>> solid.centre, solid.radius, solid.half_length
    (array([0., 0., 0.]), 0.1, None)
    """

    centre: Floats
    direction: Floats
    radius: float | None = None
    half_length: float | None = None
