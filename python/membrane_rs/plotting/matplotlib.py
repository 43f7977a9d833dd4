"""Pictures of a membrane by matplotlib, for machines on which VTK cannot render."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs.analysis.attitude import Turn, turned
from membrane_rs.plotting.camera import Camera, with_scale_bar
from membrane_rs.plotting.picture import (
    BODY,
    CORD,
    CREASE,
    EDGE,
    EDGE_SHARE,
    MARK,
    PLANE_OPACITY,
    SPOOL,
    TIP,
    Color,
    Image,
    Subject,
)
from membrane_rs.plotting.scenery import NONE, Scenery, cylinder_ends, plane_corners, turned_solid
from membrane_rs.scene.solid import Solid

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SIDES, _SIDES_OF_BODY = 40, 16
_ABOVE = 1e-3
"""How much nearer lines count as than the faces they lie in, as a share of what the picture reaches."""


class MatplotlibPainter:
    """Draws each picture from nothing; faces are sorted by depth, so crossing layers may show through."""

    def __init__(self, subject: Subject, size: int) -> None:
        self._subject = subject
        self._size = size
        self._beside = _faces_beside(subject.creases, subject.triangles)

    def paint(self, positions: Floats, turn: Turn = 0.0, around: Scenery = NONE) -> Image:
        """Picture (size, size, 3) of positions (N, 3) [m] and what is around, turned as the hub is."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        figure = Figure(figsize=(self._size / 100.0, self._size / 100.0), dpi=100)
        canvas: Any = FigureCanvasAgg(figure)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_axis_off()
        axes.set(xlim=(-1.0, 1.0), ylim=(-1.0, 1.0))
        camera = around.camera or self._subject.camera
        pieces = _Pieces(camera)
        for solid in around.solids:
            _add_solid(pieces, solid, turn)
        self._draw(axes, turned(positions, turn), turn, pieces)
        canvas.draw()
        picture: Image = np.array(canvas.buffer_rgba(), dtype=np.uint8)[:, :, :3]
        return with_scale_bar(picture, camera) if around.scale_bar else picture

    def close(self) -> None:
        """Nothing is held."""

    def _draw(self, axes: Axes, points: Floats, turn: Turn, pieces: _Pieces) -> None:
        """Faces, lines, spool and what pieces there are, the farthest first, then tip masses."""
        from matplotlib.collections import PolyCollection

        subject, camera, lift = self._subject, pieces.camera, _ABOVE * pieces.camera.reach
        edge = (*EDGE, EDGE_SHARE)
        depth = np.zeros(0)
        if len(subject.triangles):
            depth = self._add_faces(pieces, points[subject.triangles], edge if subject.has_edges else None)
        place, near = camera.project(points)
        beside = depth[self._beside].max(axis=1) if len(subject.creases) else np.zeros(0)
        width = max(0.7, self._size / 450.0)
        pieces.add_lines(place, subject.creases, beside + lift, CREASE, width)
        pieces.add_lines(place, subject.cords, near[subject.cords].max(axis=1) + lift, CORD, 1.6 * width)
        if subject.spool is not None:
            _add_spool(pieces, *subject.spool, turn)
        order = np.argsort(np.array(pieces.depths), kind="stable")
        chosen = [[pieces.polygons[k] for k in order], [pieces.faces[k] for k in order]]
        axes.add_collection(
            PolyCollection(
                chosen[0],
                facecolors=chosen[1],
                edgecolors=[pieces.edges[k] for k in order],
                linewidths=[pieces.widths[k] for k in order],
                capstyle="round",
            )
        )
        if len(subject.tips):
            x, y = place[subject.tips].T
            axes.scatter(x, y, color=TIP, s=(self._size / 90.0) ** 2, zorder=3)

    def _add_faces(self, pieces: _Pieces, corners: Floats, edge: tuple[float, ...] | None) -> Floats:
        """Triangles (m, 3, 3) shaded by their slope to the light; the nearness of each (m,) [m]."""
        subject, camera = self._subject, pieces.camera
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
        away = normals @ camera.view < 0.0
        tone = np.where(away[:, None], subject.colors(True), subject.colors(False))
        light = -0.45 * np.cross(camera.up, camera.view) + 0.35 * camera.up + 0.82 * camera.view
        shade = tone * (0.45 + 0.55 * np.abs(normals @ light))[:, None]
        place, near = camera.project(corners.reshape(-1, 3))
        depth: Floats = near.reshape(-1, 3).mean(axis=1)
        pieces.polygons += list(place.reshape(-1, 3, 2))
        pieces.depths += depth.tolist()
        pieces.faces += [(*color, 1.0) for color in shade]
        # Without lines of their own, faces are outlined in their own tone: no gaps between them.
        pieces.edges += [edge] * len(shade) if edge is not None else [(*color, 1.0) for color in shade]
        pieces.widths += [0.4] * len(shade)
        return depth


class _Pieces:
    """Polygons of a picture, with what each is sorted by and looks like."""

    def __init__(self, camera: Camera) -> None:
        self.camera = camera
        self.polygons: list[Floats] = []
        self.depths: list[float] = []
        self.faces: list[tuple[float, ...]] = []
        self.edges: list[tuple[float, ...]] = []
        self.widths: list[float] = []

    def add(self, shape: Floats, color: Color, depth: float | None = None, opacity: float = 1.0) -> None:
        """A plane polygon (n, 3) [m], as near as its middle or as it is said [m]."""
        place, near = self.camera.project(shape)
        self.polygons.append(place)
        self.depths.append(float(near.mean()) if depth is None else depth)
        self.faces.append((*color, opacity))
        self.edges.append((*color, opacity))
        self.widths.append(0.4)

    def add_cylinder(self, ends: Floats, radius: float, color: Color, sides: int) -> tuple[Floats, float]:
        """A cylinder from end to end (2, 3) [m]; the rim of that to the camera, and its nearness [m]."""
        along = ends[1] - ends[0]
        along /= np.linalg.norm(along)
        across = np.cross((0.0, 1.0, 0.0) if abs(along[1]) < 0.9 else (0.0, 0.0, 1.0), along)
        across /= np.linalg.norm(across)
        angle = np.linspace(0.0, 2.0 * np.pi, sides + 1)[:, None]
        rim = radius * (np.cos(angle) * across + np.sin(angle) * np.cross(along, across))
        lower, upper = ends[0] + rim, ends[1] + rim
        dark: Color = (0.7 * color[0], 0.7 * color[1], 0.7 * color[2])
        for k in range(sides):
            self.add(np.stack([lower[k], lower[k + 1], upper[k + 1], upper[k]]), dark)
        seen = upper if along @ self.camera.view > 0.0 else lower
        nearness = float(self.camera.project(seen)[1].max()) + 1e-3 * radius
        self.add(seen, color, nearness)
        return seen, nearness

    def add_lines(self, place: Floats, pairs: Ints, depths: Floats, color: Color, width: float) -> None:
        """Straight lines between pairs of nodes."""
        self.polygons += list(place[pairs])
        self.depths += depths.tolist()
        self.faces += [(*color, 1.0)] * len(pairs)
        self.edges += [(*color, 1.0)] * len(pairs)
        self.widths += [width] * len(pairs)


def _add_spool(pieces: _Pieces, radius: float, low: float, high: float, turn: Turn) -> None:
    """A cylinder from `low` to `high` [m], and the mark on its top."""
    _, nearness = pieces.add_cylinder(np.array([(0.0, 0.0, low), (0.0, 0.0, high)]), radius, SPOOL, _SIDES)
    mark = np.array([(radius * x, radius * y, high) for x, y in MARK])
    pieces.add(turned(mark, turn), CORD, nearness + 1e-3 * radius)


def _add_solid(pieces: _Pieces, solid: Solid, turn: Turn) -> None:
    if solid.radius is None:
        pieces.add(plane_corners(turned_solid(solid, turn), pieces.camera), BODY, opacity=PLANE_OPACITY)
        return
    ends = turned(np.array(cylinder_ends(solid)), turn)
    pieces.add_cylinder(ends, solid.radius, BODY, _SIDES_OF_BODY)


def _faces_beside(pairs: Ints, triangles: Ints) -> Ints:
    """(c, 2) the triangles on both sides of each pair of nodes; twice the same where there is one."""
    found: dict[tuple[int, int], list[int]] = {}
    for corner in range(3):
        ends = np.sort(triangles[:, [corner, (corner + 1) % 3]], axis=1)
        for k, (a, b) in enumerate(ends.tolist()):
            found.setdefault((a, b), []).append(k)
    beside = [found.get((min(a, b), max(a, b)), [0]) for a, b in pairs.tolist()]
    return np.array([[faces[0], faces[-1]] for faces in beside], dtype=np.int64).reshape(-1, 2)
