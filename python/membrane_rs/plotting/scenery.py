"""What of a picture changes with the time beside the membrane: bodies in motion, and the camera."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.analysis.attitude import Turn, turned
from membrane_rs.plotting.camera import Camera
from membrane_rs.plotting.picture import spool_of
from membrane_rs.scene import Scene
from membrane_rs.scene.bodies import Body
from membrane_rs.scene.solid import Solid
from membrane_rs.simulation.stepper import Stepper

SAME = 1e-6
"""Difference of radii, over the radius, up to which a body about the hub's axis is the spool."""
PLANE_SHARE = 0.8
"""Half the side of a plane's square, over what the camera reaches."""
LENGTH_SHARE, LEAST_SHARE = 0.6, 0.05
"""Half the length of an endless cylinder as drawn: this share of the membrane's length along it, or of its size."""
FAR = 1.5
"""A body that is farther out than the membrane by this factor need not fit into a picture."""


@dataclass(frozen=True)
class Scenery:
    """Bodies as they stand, in the frame that turns with the hub, and the camera; None: that of the subject. Without
    `scale_bar` the picture has none.
    """

    solids: tuple[Solid, ...] = ()
    camera: Camera | None = None
    scale_bar: bool = True


NONE = Scenery()


class Started(Protocol):
    """What has a start, such as the record of a stage."""

    @property
    def start(self) -> float:
        """Time [s]."""


class BodiesInTime:
    """The bodies that are at work at each time of a run, but for the spool, which a subject holds.

    `stowed` (N, 3) [m] is a shape by which endless cylinders are given ends.
    """

    def __init__(self, sim: Stepper, stowed: Floats) -> None:
        self._begin(sim.scene, sim.stages, stowed)

    @classmethod
    def of_scene(cls, scene: Scene, stages: Sequence[Started], stowed: Floats) -> BodiesInTime:
        """The same of a scene and the stages that a run of it has come to."""
        made = cls.__new__(cls)
        made._begin(scene, stages, stowed)
        return made

    def _begin(self, scene: Scene, stages: Sequence[Started], stowed: Floats) -> None:
        self._scene, self._stages, self._stowed = scene, list(stages), stowed
        self._spool = spool_of(scene)
        self._bodies: dict[int, list[Body]] = {}

    def at(self, time: float, stage: int | None = None) -> tuple[Solid, ...]:
        """Each copy of each body at a time [s], finite; in which stage, matters at a boundary."""
        index = stage_at(self._stages, time) if stage is None else stage
        found = [solid for body in self._at_work(index) if not self._is_spool(body) for solid in body.solids(time)]
        return tuple(_ended(solid, self._stowed) for solid in found)

    def _at_work(self, index: int) -> list[Body]:
        if index not in self._bodies:
            starts = [stage.start for stage in self._stages[: index + 1]]
            scene: Scene = self._scene.staged(index, starts) if self._stages else self._scene
            self._bodies[index] = list(scene.bodies)
        return self._bodies[index]

    def _is_spool(self, body: Body) -> bool:
        own, spool = body.spool, self._spool
        return own is not None and spool is not None and abs(own.radius - spool.radius) <= SAME * spool.radius


def stage_at(stages: Sequence[Started], time: float) -> int:
    """Index of the stage at a time [s]: at a boundary that which ends, since the shape there is its last; 0 without."""
    return max((k for k, stage in enumerate(stages) if stage.start < time), default=0)


def reach_of(positions: Floats, solids: Iterable[Solid]) -> float:
    """What a camera at the origin must reach to see a shape (N, 3) [m] and the cylinders near it, as they turn [m]."""
    reach = float(np.linalg.norm(positions, axis=1).max())
    cylinders = [solid for solid in solids if solid.radius is not None]
    outer = [max(map(np.linalg.norm, cylinder_ends(solid))) + (solid.radius or 0.0) for solid in cylinders]
    return float(max([reach, *(far for far in outer if far < FAR * reach)]))


def turned_solid(solid: Solid, turn: Turn) -> Solid:
    """The same turned as the hub is: from its frame to the fixed one."""
    centre, direction = turned(np.stack([solid.centre, solid.direction]), turn)
    return replace(solid, centre=centre, direction=direction)


def cylinder_ends(solid: Solid) -> tuple[Floats, Floats]:
    """Both ends of the axis of a finite cylinder, (3,) [m] each."""
    half = (solid.half_length or 0.0) * solid.direction
    return solid.centre - half, solid.centre + half


def plane_corners(solid: Solid, camera: Camera) -> Floats:
    """(4, 3) corners [m] of the square that shows a plane, around the point of it nearest to the camera's centre."""
    normal = solid.direction
    centre = camera.centre - ((camera.centre - solid.centre) @ normal) * normal
    side = np.cross(normal, (0.0, 1.0, 0.0) if abs(normal[1]) < 0.9 else (1.0, 0.0, 0.0))
    side *= PLANE_SHARE * camera.reach / np.linalg.norm(side)
    other = np.cross(normal, side)
    corners: Floats = centre + np.stack([side + other, other - side, -side - other, side - other])
    return corners


def _ended(solid: Solid, points: Floats) -> Solid:
    """The same with ends: an endless cylinder is a little longer than the membrane along it."""
    if solid.radius is None or solid.half_length is not None:
        return solid
    along = (points - solid.centre) @ solid.direction
    low, high = float(along.min()), float(along.max())
    half = max(LENGTH_SHARE * (high - low), LEAST_SHARE * float(np.ptp(points, axis=0).max()))
    return replace(solid, centre=solid.centre + 0.5 * (low + high) * solid.direction, half_length=half)
