"""Bodies of prescribed motion, which push what touches them: cylinders and planes.

A body has no mass: its motion is given by schedules, in the frame that turns with the hub. Film and cords feel it by a
penalty, whose work is listed under the body's name; damping and friction have a row of their own, "<name>_friction".
Units are SI; angles are in radians.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import asdict, field
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from annotated_types import Le

from membrane_rs._arrays import Floats
from membrane_rs._validation import Count, Flag, NonNegative, Positive, Unit, Vector, show, validated
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.scene.law import Surroundings
from membrane_rs.scene.plausible import FILM, Doubt, implausible
from membrane_rs.scene.scales import stiffest, widest_spool
from membrane_rs.scene.schedule import Schedule
from membrane_rs.scene.solid import Solid
from membrane_rs.scene.spool import Spool

__all__ = ["BODIES", "CORE_KINDS", "Body", "Cylinder", "Plane", "Solid"]

CORE_KINDS = ("body", "body_friction")
"""The laws of the core that bodies become."""
LONGEST_NAME = 40
"""Letters of the longest name of a body."""
MOST_COPIES = 1000
ROUGHEST = 10.0
"""Coefficient of friction beyond which it is hardly meant."""
MOST_DAMPED = 100.0
"""Ratio of damping to critical damping beyond which it is hardly meant."""
THINNEST = 1e-4
"""Radius of a cylinder over the reach of the flat scene."""
STIFFEST = 1000.0
"""Stiffness of the penalty over that of the stiffest spring: the step is then some thirty times as short."""


@validated
class Body:
    """A rigid body without mass, of prescribed motion, as checked values.

    In the frame of the hub it is first tilted about the horizontal line through its centre and across the azimuth of
    the centre (a positive angle leans the z axis outward); then it travels; then all is turned about the hub's axis,
    its copies evenly round it. Without a schedule it stays at its place.

    Parameters
    ----------
    name : str
        Letters, digits and underscores, a letter first, at most 40: of its forces, energies and work. No other body and
        no law has it.
    centre : tuple of float
        A point of the axis, the middle of a cylinder with ends, or a point of the plane (x, y, z) [m].
    direction : tuple of float
        Of a cylinder's axis, or of a plane's normal (x, y, z) [-], of any length above 0.
    copies : int
        Equal bodies, turned evenly about the hub's axis, 1 to 1000.
    turn : Schedule or None
        About the hub's axis, z [rad].
    travel_x, travel_y, travel_z : Schedule or None
        Along the axes, before the turn [m].
    travel_radial : Schedule or None
        Away from the hub's axis, before the turn; along x for a centre on the axis [m].
    tilt : Schedule or None
        Of its direction [rad].
    spin : Schedule or None
        About its own direction; it only matters with friction [rad].
    stiffness : float
        Of the penalty, for each element that touches it [N/m], above 0. A force F causes a depth of F/stiffness.
    damping : float
        Ratio of the damping of an approach to critical damping [-], 0 or above. It begins with the depth. A contact
        never pulls.
    friction : float
        Coulomb's coefficient [-], 0 or above.
    friction_speed : float
        Speed of sliding below which friction is viscous [m/s], above 0: what is held creeps more slowly than this.
    membrane, cords : bool
        Whether the membrane and the cords feel it.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs.scene.bodies import BODIES
    >>> BODIES["plane"]("floor").solids(0.0)[0].centre.tolist()
    [0.0, 0.0, 0.0]
    """

    kind: ClassVar[str]
    """Its name in scene files."""
    name: str
    centre: Annotated[Vector, Unit("m")] = field(default=(0.0, 0.0, 0.0), kw_only=True)
    direction: Vector = field(default=(0.0, 0.0, 1.0), kw_only=True)
    copies: Annotated[Count, Le(MOST_COPIES)] = field(default=1, kw_only=True)
    turn: Annotated[Schedule | None, Unit("rad")] = field(default=None, kw_only=True)
    travel_x: Annotated[Schedule | None, Unit("m")] = field(default=None, kw_only=True)
    travel_y: Annotated[Schedule | None, Unit("m")] = field(default=None, kw_only=True)
    travel_z: Annotated[Schedule | None, Unit("m")] = field(default=None, kw_only=True)
    travel_radial: Annotated[Schedule | None, Unit("m")] = field(default=None, kw_only=True)
    tilt: Annotated[Schedule | None, Unit("rad")] = field(default=None, kw_only=True)
    spin: Annotated[Schedule | None, Unit("rad")] = field(default=None, kw_only=True)
    stiffness: Annotated[Positive, Unit("N/m")] = field(default=200.0, kw_only=True)
    damping: NonNegative = field(default=0.0, kw_only=True)
    friction: NonNegative = field(default=0.0, kw_only=True)
    friction_speed: Annotated[Positive, Unit("m/s")] = field(default=1e-3, kw_only=True)
    membrane: Flag = field(default=True, kw_only=True)
    cords: Flag = field(default=True, kw_only=True)

    def __post_init__(self) -> None:
        """Check name, direction, and what feels the body."""
        own = type(self).__name__
        if not isinstance(self.name, str):
            raise InputTypeError(f"{own}.name = {show(self.name)}: must be a text")
        if len(self.name) > LONGEST_NAME or not re.fullmatch("[A-Za-z][A-Za-z0-9_]*", self.name, re.ASCII):
            what = f"must be letters, digits and underscores, a letter first, {LONGEST_NAME} at most"
            raise InputError(f"{own}.name = {show(self.name)}: {what}")
        if not any(self.direction):
            raise InputError(f"{own}.direction = {self.direction}: must not be 0; (0, 0, 1) is the hub's axis")
        if not (self.membrane or self.cords):
            raise InputError(f"{own}.membrane = False: with cords = False nothing feels the body; set one of them")

    @property
    def friction_name(self) -> str | None:
        """Name of the law of its damping and friction; None without these."""
        return f"{self.name}_friction" if self.damping > 0.0 or self.friction > 0.0 else None

    def core_laws(self) -> list[tuple[str, dict[str, Any]]]:
        """Kind and parameters of the laws that the core is given.

        Returns
        -------
        list of (str, dict)
            One or two.
        """
        parameters = {**asdict(self), "shape": self.kind, **self.shape_parameters()}
        contact, friction = CORE_KINDS
        return [(contact, parameters)] + ([(friction, parameters)] if self.friction_name else [])

    @property
    def spool(self) -> Spool | None:
        """The spool that it is, round the axis of the hub for good; None for another body."""
        return None

    @property
    def is_felt_by_nodes(self) -> bool:
        """Whether nodes alone feel it, though it is curved."""
        return False

    def shape_parameters(self) -> dict[str, Any]:
        """Parameters of the core that a shape does not give as fields of its own.

        Returns
        -------
        dict of str to object
            By name.
        """
        return {}

    def solids(self, time: float) -> list[Solid]:
        """Each of its copies as it stands at a time [s], in the frame that turns with the hub.

        Parameters
        ----------
        time : float
            [s]

        Returns
        -------
        list of Solid
            One for each copy.
        """
        along = np.array(self.direction) / math.hypot(*self.direction)
        centre, across = np.array(self.centre), math.hypot(*self.centre[:2])
        radial = np.array([*centre[:2] / across, 0.0]) if across > 0.0 else np.array((1.0, 0.0, 0.0))
        travel = [_at(schedule, time) for schedule in (self.travel_x, self.travel_y, self.travel_z)]
        centre = centre + np.array(travel) + _at(self.travel_radial, time) * radial
        tilted = _rotated(along, np.array((-radial[1], radial[0], 0.0)), _at(self.tilt, time))
        given = self.shape_parameters()
        sizes = [given.get(key, getattr(self, key, None)) for key in ("radius", "half_length")]
        up = np.array((0.0, 0.0, 1.0))
        angles = [_at(self.turn, time) + math.tau * copy / self.copies for copy in range(self.copies)]
        return [Solid(_rotated(centre, up, angle), _rotated(tilted, up, angle), *sizes) for angle in angles]

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """The penalty is not many times stiffer than all else, whose step it would make shorter.

        Parameters
        ----------
        scene : Surroundings
            The scene.
        where : str
            Place in the scene, for messages.

        Returns
        -------
        iterator of Doubt
            One for each value.
        """
        most = STIFFEST * stiffest(scene)
        if most > 0.0:
            place, units = f"{where}.stiffness", {"kN/m": 1e3, "mN/m": 1e-3}
            reason = f"that is more than {STIFFEST:g} times the stiffest spring, {most / STIFFEST:.3g} N/m"
            derived = (*FILM, "parts")
            yield from implausible(place, self.stiffness, "N/m", reason, most=most, units=units, derived_from=derived)
        reason = f"more than {ROUGHEST:g} is hardly met: rubber on rubber has about 1"
        yield from implausible(f"{where}.friction", self.friction, "", reason, most=ROUGHEST)
        reason = f"that is a ratio to critical damping, of which more than {MOST_DAMPED:g} only makes the step shorter"
        yield from implausible(f"{where}.damping", self.damping, "", reason, most=MOST_DAMPED, units={"percent": 0.01})
        if self.spin is not None and self.friction == 0.0:
            message, remedy = f"{where}.spin: is without effect, since the body has no friction", "give it friction"
            yield Doubt("warning", "idle_spin", 1, message, f"{remedy}, or leave spin out", place=f"{where}.spin")


@validated
class Cylinder(Body):
    """A cylinder, such as a guide bar or a spool. Its other parameters are those of `Body`.

    A run stops where something goes deeper than half of the radius into it, or passes a twentieth of the radius within
    one step, since it might come out on the other side.

    Parameters
    ----------
    radius : float
        [m], above 0.
    half_length : float or None
        From the centre to each end, where a cap of the same radius rounds it off [m]. None: endless.
    felt_by : {"edges", "nodes", "triangles"}
        What feels it. Edges of the film and segments of cords: each is one contact, at its nearest point. Nodes alone
        pass between them what is thinner than an edge is long. "triangles": edges, and triangles beside them, which
        feel the ends of a cylinder. A triangle that the axis pierces is an error at the start, and stops a run.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import Cylinder, Schedule
    >>> post = Cylinder("post", 0.005, centre=(0.1, 0.0, 0.0), travel_z=Schedule([0.0, 1.0], [0.0, 0.02]))
    >>> post.radius, post.felt_by
    (0.005, 'edges')
    """

    kind: ClassVar[str] = "cylinder"
    radius: Annotated[Positive, Unit("m")]
    half_length: Annotated[Positive | None, Unit("m")] = field(default=None, kw_only=True)
    felt_by: Literal["edges", "nodes", "triangles"] = field(default="edges", kw_only=True)

    @property
    def spool(self) -> Spool | None:
        """The spool that it is where it lies on the axis of the hub and no schedule takes it away."""
        leaves = (self.travel_x, self.travel_y, self.travel_z, self.travel_radial, self.tilt)
        is_on_axis = not any((*self.centre, *self.direction[:2]))
        return Spool(self.radius, self.half_length) if is_on_axis and leaves.count(None) == len(leaves) else None

    @property
    def is_felt_by_nodes(self) -> bool:
        """Whether nodes alone feel it."""
        return self.felt_by == "nodes"

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """Its radius lies between a ten-thousandth of the reach of the flat scene and that reach, too."""
        yield from super().implausible_values(scene, where)
        most = widest_spool(scene)
        place, units, reason = f"{where}.radius", {"mm": 1e-3, "cm": 1e-2}, f"the flat scene reaches to {most:.4g} m"
        bounds = {"least": THINNEST * most, "most": most}
        yield from implausible(place, self.radius, "m", reason, **bounds, units=units, derived_from=("mesh", "parts"))


@validated
class Plane(Body):
    """The half-space below a plane, whose normal is `direction`: a floor by default.

    Nodes feel it, which is exact for the edges and triangles between them. Its parameters are those of `Body`.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import Plane
    >>> Plane("floor", centre=(0.0, 0.0, -0.1), friction=0.3).direction
    (0.0, 0.0, 1.0)
    """

    kind: ClassVar[str] = "plane"

    def shape_parameters(self) -> dict[str, Any]:
        """No radius, no length; nodes feel it."""
        return {"radius": None, "half_length": None, "felt_by": "nodes"}


def _at(schedule: Schedule | None, time: float) -> float:
    return 0.0 if schedule is None else schedule.at(time)


def _rotated(vector: Floats, axis: Floats, angle: float) -> Floats:
    """A vector about an axis of length 1 [rad]."""
    cosine, sine = math.cos(angle), math.sin(angle)
    turned: Floats = cosine * vector + sine * np.cross(axis, vector) + (1.0 - cosine) * (axis @ vector) * axis
    return turned


BODIES: dict[str, type[Body]] = {body.kind: body for body in (Cylinder, Plane)}
"""The one list of bodies: its `kind` in a scene file, and its class."""
