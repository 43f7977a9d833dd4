"""Parts that hold nodes: at rest in the turning frame, or moved in it as prescribed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar

from membrane_rs._validation import Nodes, Unit, validated
from membrane_rs.scene.builder import Builder
from membrane_rs.scene.components import Motion
from membrane_rs.scene.law import Surroundings
from membrane_rs.scene.part import Part
from membrane_rs.scene.plausible import Doubt, implausible
from membrane_rs.scene.scales import outermost
from membrane_rs.scene.schedule import Schedule

FARTHEST = 100.0
"""Displacement of moved nodes over the reach of the flat scene from the axis [-], beyond which it is hardly meant."""


@validated
class Fixed(Part):
    """Nodes held at rest in the turning frame.

    Parameters
    ----------
    nodes : str or sequence of int
        A node set, or node indices.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import Fixed
    >>> Fixed("corners", name="clamp").nodes
    'corners'
    """

    kind: ClassVar[str] = "fixed"
    nodes: Nodes

    def add_loads(self, builder: Builder, where: str) -> None:
        """Hold the nodes. Raises SceneError for nodes that are not there."""
        builder.fix(builder.nodes(self.nodes, where))


@validated
class Moved(Part):
    """Nodes that move as prescribed in the turning frame: turned about the hub's axis, and displaced along x, y and z.

        position(t) = R_z(turn(t)) a + (x(t), y(t), z(t))

    The anchor a of each node makes this its position at the start: it is that position where all schedules begin with
    0. The scene pulls at these nodes as at fixed ones; the work that their motion does is that of "moved" in
    `Simulation.ledger`. Without a schedule they are held, until a stage sets one. A part that moves nodes has
    precedence over those that fix them: a tether is wound in by moving its end on the hub.

    Parameters
    ----------
    nodes : str or sequence of int
        A node set, or node indices.
    x, y, z : Schedule or None
        Displacement [m]; None: none.
    turn : Schedule or None
        Turn about the axis of the hub [rad], counter-clockwise seen from +z; None: none.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import Moved, Schedule
    >>> Moved("end", x=Schedule([0.0, 0.5], [0.0, 0.01])).nodes
    'end'
    """

    kind: ClassVar[str] = "moved"
    working_law: ClassVar[str | None] = "moved"
    nodes: Nodes
    x: Annotated[Schedule | None, Unit("m")] = None
    y: Annotated[Schedule | None, Unit("m")] = None
    z: Annotated[Schedule | None, Unit("m")] = None
    turn: Annotated[Schedule | None, Unit("rad")] = None

    def add_loads(self, builder: Builder, where: str) -> None:
        """Move the nodes. Raises SceneError for nodes that are not there, or that another part moves."""
        builder.move(Motion(builder.nodes(self.nodes, where), self.x, self.y, self.z, self.turn), where)

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """Nodes are displaced by less than `FARTHEST` times the reach of the flat scene from the axis."""
        reach = outermost(scene)
        for field, schedule in (("x", self.x), ("y", self.y), ("z", self.z)):
            if schedule is not None and reach > 0.0:
                way = max(schedule.values) - min(schedule.values)
                reason = f"nodes would move so far in a scene that reaches {reach:.4g} m from the axis"
                place, units, most = f"{where}.{field}", {"mm": 1e-3, "cm": 1e-2}, FARTHEST * reach
                yield from implausible(place, way, "m", reason, most=most, units=units, derived_from=("mesh",))
