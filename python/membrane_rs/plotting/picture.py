"""The subject of pictures of a membrane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from membrane_rs._arrays import Floats, Ints
from membrane_rs.mesh.queries import petal_of_triangles
from membrane_rs.plotting.camera import Camera
from membrane_rs.scene import Scene
from membrane_rs.scene.assembly import Assembly
from membrane_rs.scene.spool import Spool
from membrane_rs.simulation.motion import Motion

Image = NDArray[np.uint8]
Color = tuple[float, float, float]

# One tone per petal; the other face has the same tone mixed with BACK.
PETALS: tuple[Color, ...] = ((0.93, 0.72, 0.24), (0.36, 0.62, 0.80), (0.87, 0.50, 0.35), (0.50, 0.72, 0.48))
PLAIN: Color = (0.93, 0.72, 0.24)
BACK: Color = (0.62, 0.62, 0.66)
BACK_SHARE = 0.6
CREASE: Color = (0.25, 0.22, 0.20)
CORD: Color = (0.10, 0.10, 0.10)
SPOOL: Color = (0.55, 0.57, 0.60)
BODY: Color = (0.30, 0.42, 0.52)
PLANE_OPACITY = 0.25
TIP: Color = (0.75, 0.10, 0.12)
EDGE: Color = (0.30, 0.26, 0.20)
EDGE_SHARE = 0.35
"""Opacity of the edges of triangles."""
MOST_EDGED = 30_000
"""More triangles are drawn without their edges, which would hide them."""
MARK = ((0.15, -0.08), (0.9, -0.08), (0.9, 0.08), (0.15, 0.08))
"""Corners of the mark on the spool's top that shows how far it has turned, over the spool's radius."""

FARTHEST = 1e15
"""Distance of a node from the origin that a picture can show [m]: drawn in single precision, which holds its square."""


@dataclass(frozen=True)
class Subject:
    """What is drawn in every picture of a run, with one camera for all of them.

    triangles (m, 3), petals (m,) number or -1, creases (c, 2), cords (s, 2), tips (t,): node indices.
    spool: radius, lowest and highest z [m], or None.
    """

    triangles: Ints
    petals: NDArray[np.int8]
    creases: Ints
    cords: Ints
    tips: Ints
    spool: tuple[float, float, float] | None
    camera: Camera
    has_hub: bool = True
    """Whether a hub turns, so that the turning frame is not the fixed one."""

    @classmethod
    def of(cls, sim: Motion, shapes: Sequence[Floats]) -> Subject:
        """The subject of a simulation; its `shapes`, (N, 3) [m] each and the first one first, will fit in."""
        return cls.of_scene(sim.scene, sim.assembly, shapes)

    @classmethod
    def of_scene(cls, scene: Scene, assembly: Assembly, shapes: Sequence[Floats]) -> Subject:
        """The subject of a scene; its `shapes`, (N, 3) [m] each and the first one first, will fit in."""
        has_hub = any(law.turns_hub for law in scene.laws)
        seen = [assembly.reference, *shapes] if has_hub else shapes
        camera = Camera.of(seen, assembly.triangles, about_axis=has_hub)
        return cls(
            triangles=assembly.triangles,
            petals=petal_of_triangles(assembly.triangles, assembly.node_sets),
            creases=assembly.creases.nodes,
            cords=assembly.cords.nodes,
            tips=assembly.tips,
            spool=_spool(scene, shapes[0], camera.reach),
            camera=camera,
            has_hub=has_hub,
        )

    @property
    def reach(self) -> float:
        """What fits into the picture around its centre [m]."""
        return self.camera.reach

    @property
    def has_edges(self) -> bool:
        """Whether edges of triangles are drawn."""
        return len(self.triangles) <= MOST_EDGED

    def colors(self, back: bool) -> Floats:
        """Colour of each triangle's upper or lower face, (m, 3) in 0..1."""
        palette = np.array([*PETALS, PLAIN])
        number = np.where(self.petals < 0, len(PETALS), self.petals % len(PETALS))
        colors: Floats = palette[number]
        return (1.0 - BACK_SHARE) * colors + BACK_SHARE * np.array(BACK) if back else colors


def is_drawable(positions: Floats) -> bool:
    """Whether a shape (n, 3) [m] can be drawn; not that of a run which diverged, or of a damaged file."""
    return bool((np.abs(positions) < FARTHEST).all())


def spool_of(scene: Scene) -> Spool | None:
    """The spool that laws or parts describe; None for a scene without one."""
    described = (*(law.spool for law in scene.laws), *(part.spool for part in scene.parts))
    return next((spool for spool in described if spool is not None), None)


def _spool(scene: Scene, stowed: Floats, reach: float) -> tuple[float, float, float] | None:
    """Radius, lowest and highest z of the spool [m]; None for a scene without one."""
    spool = spool_of(scene)
    if spool is None:
        return None
    radius, half_height = spool
    if half_height is not None:
        return radius, -half_height, half_height
    z = stowed[:, 2]
    low, high = float(z.min()), float(z.max())
    margin = max(0.1 * (high - low), 0.01 * reach)
    return radius, low - margin, high + margin
