"""Pictures of a membrane by matplotlib, for machines on which VTK cannot render."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.plotting.picture import CORD, CREASE, SPOOL, TIP, VIEW_DIRECTION, Image, Subject, turned

if TYPE_CHECKING:
    from mpl_toolkits.mplot3d.axes3d import Axes3D

_LIGHT = np.array((-0.58, 0.23, 0.78))
_SIDES = 40


class MatplotlibPainter:
    """Draws each picture from nothing; triangles are sorted by depth, so crossing layers may show through."""

    def __init__(self, subject: Subject, size: int) -> None:
        self._subject = subject
        self._size = size

    def paint(self, positions: Floats, hub_angle: float = 0.0) -> Image:
        """Picture (size, size, 3) of positions (N, 3) [m], turned about z by `hub_angle` [rad]."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        figure = Figure(figsize=(self._size / 100.0, self._size / 100.0), dpi=100)
        canvas: Any = FigureCanvasAgg(figure)
        axes: Axes3D = figure.add_axes((0.0, 0.0, 1.0, 1.0), projection="3d")
        axes.set_axis_off()
        x, y, z = VIEW_DIRECTION
        axes.view_init(elev=np.degrees(np.arctan2(z, np.hypot(x, y))), azim=np.degrees(np.arctan2(y, x)))
        low, high = self._subject.centre - self._subject.reach, self._subject.centre + self._subject.reach
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
        axes.set_box_aspect((1.0, 1.0, 1.0), zoom=1.45)
        self._draw(axes, turned(positions, hub_angle))
        canvas.draw()
        picture: Image = np.array(canvas.buffer_rgba(), dtype=np.uint8)[:, :, :3]
        return picture

    def close(self) -> None:
        """Nothing is held."""

    def _draw(self, axes: Axes3D, points: Floats) -> None:
        """Faces shaded by their slope to the light, then lines and tip masses."""
        from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

        subject = self._subject
        patches, colors = [], []
        if len(subject.triangles):
            corners = points[subject.triangles]
            normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
            away = normals @ np.array(VIEW_DIRECTION) < 0.0
            tone = np.where(away[:, None], subject.colors(True), subject.colors(False))
            shade = 0.45 + 0.55 * np.abs(normals @ _LIGHT)
            patches += list(corners)
            colors += list(tone * shade[:, None])
        if subject.spool is not None:
            radius, low, high = subject.spool
            angle = np.linspace(0.0, 2.0 * np.pi, _SIDES + 1)
            rim = radius * np.column_stack([np.cos(angle), np.sin(angle)])
            lower = np.column_stack([rim, np.full(len(rim), low)])
            upper = np.column_stack([rim, np.full(len(rim), high)])
            middle = np.broadcast_to((0.0, 0.0, high), lower[1:].shape)
            # Triangles, as all else: matplotlib pads faces of fewer corners with what memory happens to hold.
            for face in ((lower[:-1], lower[1:], upper[1:]), (lower[:-1], upper[1:], upper[:-1])):
                patches += list(np.stack(face, axis=1))
            patches += list(np.stack([upper[:-1], upper[1:], middle], axis=1))
            colors += [0.7 * np.array(SPOOL)] * (2 * _SIDES) + [np.array(SPOOL)] * _SIDES
        if patches:
            axes.add_collection3d(Poly3DCollection(patches, facecolors=colors, edgecolors="none", antialiaseds=False))
        for pairs, color, width in ((subject.creases, CREASE, 0.5), (subject.cords, CORD, 1.5)):
            if len(pairs):
                axes.add_collection3d(Line3DCollection(points[pairs], colors=[color], linewidths=width))
        if len(subject.tips):
            axes.scatter(*points[subject.tips].T, color=TIP, s=30.0, depthshade=False)
