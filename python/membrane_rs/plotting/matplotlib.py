"""Pictures of a membrane by matplotlib, for machines on which VTK cannot render."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs.plotting.camera import with_scale_bar
from membrane_rs.plotting.picture import (
    CORD,
    CREASE,
    EDGE,
    EDGE_SHARE,
    MARK,
    SPOOL,
    TIP,
    Color,
    Image,
    Subject,
    turned,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SIDES = 40
_ABOVE = 1e-3
"""How much nearer lines count as than the faces they lie in, as a share of what the picture reaches."""


class MatplotlibPainter:
    """Draws each picture from nothing; faces are sorted by depth, so crossing layers may show through."""

    def __init__(self, subject: Subject, size: int) -> None:
        self._subject = subject
        self._size = size
        self._beside = _faces_beside(subject.creases, subject.triangles)

    def paint(self, positions: Floats, hub_angle: float = 0.0) -> Image:
        """Picture (size, size, 3) of positions (N, 3) [m], turned about z by `hub_angle` [rad]."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        figure = Figure(figsize=(self._size / 100.0, self._size / 100.0), dpi=100)
        canvas: Any = FigureCanvasAgg(figure)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_axis_off()
        axes.set(xlim=(-1.0, 1.0), ylim=(-1.0, 1.0))
        self._draw(axes, turned(positions, hub_angle), hub_angle)
        canvas.draw()
        picture: Image = np.array(canvas.buffer_rgba(), dtype=np.uint8)[:, :, :3]
        return with_scale_bar(picture, self._subject.camera)

    def close(self) -> None:
        """Nothing is held."""

    def _draw(self, axes: Axes, points: Floats, hub_angle: float) -> None:
        """Faces, lines and the spool, the farthest first, then tip masses."""
        from matplotlib.collections import PolyCollection

        subject, lift = self._subject, _ABOVE * self._subject.reach
        pieces = _Pieces()
        edge = (*EDGE, EDGE_SHARE)
        depth = np.zeros(0)
        if len(subject.triangles):
            depth = self._add_faces(pieces, points[subject.triangles], edge if subject.has_edges else None)
        place, near = subject.camera.project(points)
        beside = depth[self._beside].max(axis=1) if len(subject.creases) else np.zeros(0)
        width = max(0.7, self._size / 450.0)
        pieces.add_lines(place, subject.creases, beside + lift, CREASE, width)
        pieces.add_lines(place, subject.cords, near[subject.cords].max(axis=1) + lift, CORD, 1.6 * width)
        if subject.spool is not None:
            self._add_spool(pieces, *subject.spool, hub_angle)
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
        subject, camera = self._subject, self._subject.camera
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

    def _add_spool(self, pieces: _Pieces, radius: float, low: float, high: float, hub_angle: float) -> None:
        """A cylinder from `low` to `high` [m], and the mark on its top."""
        camera = self._subject.camera
        angle = np.linspace(0.0, 2.0 * np.pi, _SIDES + 1)
        rim = radius * np.column_stack([np.cos(angle), np.sin(angle)])
        lower, upper = (np.column_stack([rim, np.full(len(rim), z)]) for z in (low, high))
        mark = turned(np.array([(radius * x, radius * y, high) for x, y in MARK]), hub_angle)
        sides = [np.stack([lower[k], lower[k + 1], upper[k + 1], upper[k]]) for k in range(_SIDES)]
        dark: Color = (0.7 * SPOOL[0], 0.7 * SPOOL[1], 0.7 * SPOOL[2])
        top = max(0.0, 1e-6 * radius)
        for k, (shape, color) in enumerate([*((side, dark) for side in sides), (upper, SPOOL), (mark, CORD)]):
            place, near = camera.project(shape)
            lifted = max(0, k - _SIDES + 1) * (top + 1e-3 * radius)
            pieces.polygons.append(place)
            pieces.depths.append(float(near.mean() if k < _SIDES else camera.project(upper)[1].max()) + lifted)
            pieces.faces.append((*color, 1.0))
            pieces.edges.append((*color, 1.0))
            pieces.widths.append(0.4)


class _Pieces:
    """Polygons of a picture, with what each is sorted by and looks like."""

    def __init__(self) -> None:
        self.polygons: list[Floats] = []
        self.depths: list[float] = []
        self.faces: list[tuple[float, ...]] = []
        self.edges: list[tuple[float, ...]] = []
        self.widths: list[float] = []

    def add_lines(self, place: Floats, pairs: Ints, depths: Floats, color: Color, width: float) -> None:
        """Straight lines between pairs of nodes."""
        self.polygons += list(place[pairs])
        self.depths += depths.tolist()
        self.faces += [(*color, 1.0)] * len(pairs)
        self.edges += [(*color, 1.0)] * len(pairs)
        self.widths += [width] * len(pairs)


def _faces_beside(pairs: Ints, triangles: Ints) -> Ints:
    """(c, 2) the triangles on both sides of each pair of nodes; twice the same where there is one."""
    found: dict[tuple[int, int], list[int]] = {}
    for corner in range(3):
        ends = np.sort(triangles[:, [corner, (corner + 1) % 3]], axis=1)
        for k, (a, b) in enumerate(ends.tolist()):
            found.setdefault((a, b), []).append(k)
    beside = [found.get((min(a, b), max(a, b)), [0]) for a, b in pairs.tolist()]
    return np.array([[faces[0], faces[-1]] for faces in beside], dtype=np.int64).reshape(-1, 2)
