"""A membrane and what is around it, as actors of a pyvista plotter: off-screen, in a window, in a notebook."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from membrane_rs._arrays import Floats, Ints
from membrane_rs.analysis.attitude import Turn, turned
from membrane_rs.plotting.camera import ANGLE_DEG, Camera
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
    Subject,
)
from membrane_rs.plotting.scenery import cylinder_ends, plane_corners, turned_solid
from membrane_rs.scene.solid import Solid

Colors = NDArray[np.uint8]
"""(k, 3), 0 to 255."""

LIFT = 0.004
"""How far lines stand before the faces, as a share of what the picture reaches."""
FILM_LIGHT, FIELD_LIGHT = (0.75, 0.38), (0.35, 0.66)
"""Shares of the colour of the film, and of a field on it, that come from the lights and from all sides: so a field can
be read from any side.
"""
COLORED_SHARE = 1.0 / 200.0
"""Width of coloured lines, as a share of the picture."""
LIGHTS = (((-0.70, 0.70, 0.75), 0.85), ((0.45, -0.20, 0.90), 0.40))
"""Direction (to the right, upwards, to the camera) and intensity: a bright light from the left, a weak one from the
right.
"""


class MembraneActors:
    """The actors of one subject in a `pyvista.Plotter` that has no lights; `size` of its pictures [pixels]."""

    def __init__(self, plotter: Any, subject: Subject, size: int) -> None:
        self._plotter, self._size = plotter, size
        self._points = np.zeros((_highest_node(subject) + 1, 3))
        self._moving: list[Any] = []
        self._faces: list[tuple[Any, Any]] = []
        self._lines: list[Any] = []
        self._solids: list[Any] = []
        self._colored: tuple[Any, Any] | None = None
        if len(subject.triangles):
            self._add_membrane(subject)
        self._add_lines(subject.creases, CREASE, max(1.5, size / 280.0))
        self._add_lines(subject.cords, CORD, max(1.5, size / 300.0))
        if len(subject.tips):
            tips = self._cloud(np.column_stack([np.ones(len(subject.tips), np.int64), subject.tips]), "verts")
            plotter.add_mesh(
                tips,
                color=TIP,
                style="points",
                point_size=size / 55.0,
                render_points_as_spheres=True,
                ambient=0.5,
            )
        self._spool = [] if subject.spool is None else self._add_spool(subject.spool)

    def show(self, positions: Floats, turn: Turn, solids: Sequence[Solid], camera: Camera) -> None:
        """Move all to positions (N, 3) [m], turned as the hub is; `camera` bounds what is endless."""
        points = turned(positions, turn)
        for cloud in self._moving:
            cloud.points = points[: cloud.n_points]
        for actor in self._spool:
            actor.user_matrix = _matrix(turn)
        self._place(solids, turn, camera)

    def lift(self, reach: float, view: Floats) -> None:
        """Lift lines from the faces they lie in towards a camera in the direction `view` (3,), which reaches so far
        [m].
        """
        for actor in (*self._lines, *([self._colored[1]] if self._colored else [])):
            actor.position = tuple(LIFT * reach * view)

    def color_triangles(self, upper: Colors, lower: Colors, light: tuple[float, float] = FILM_LIGHT) -> None:
        """Colour both sides of the film, (m, 3) each; `light`: shares that come from the lights and from all sides."""
        for (cloud, actor), colors in zip(self._faces, (upper, lower), strict=True):
            cloud.cell_data["colors"] = colors
            actor.mapper.SetColorModeToDirectScalars()
            actor.mapper.SetScalarModeToUseCellFieldData()
            actor.mapper.SetInterpolateScalarsBeforeMapping(False)
            actor.mapper.SelectColorArray("colors")
            actor.prop.diffuse, actor.prop.ambient = light

    def color_nodes(self, values: Floats, table: Any, light: tuple[float, float] = FIELD_LIGHT) -> None:
        """Colour the film by values (N,) on its nodes, linear between them, by a `vtkLookupTable`."""
        for cloud, actor in self._faces:
            cloud.point_data["values"] = values[: cloud.n_points]
            actor.mapper.SetColorModeToMapScalars()
            actor.mapper.SetScalarModeToUsePointFieldData()
            actor.mapper.SetInterpolateScalarsBeforeMapping(True)
            actor.mapper.SetLookupTable(table)
            actor.mapper.SetUseLookupTableScalarRange(True)
            actor.mapper.SelectColorArray("values")
            actor.prop.diffuse, actor.prop.ambient = light

    def color_lines(self, pairs: Ints, colors: Colors) -> None:
        """Show coloured lines (k, 2) in place of creases and cords; none: these."""
        for actor in self._lines:
            actor.visibility = not len(pairs)
        if self._colored is not None:
            self._colored[1].visibility = bool(len(pairs))
        if not len(pairs):
            return
        cells = np.column_stack([np.full(len(pairs), 2), pairs]).ravel()
        if self._colored is None:
            self._colored = self._add_colored(cells, int(pairs.max()) + 1, colors)
        cloud = self._colored[0]
        cloud.lines = cells
        cloud.cell_data["colors"] = colors

    def _add_colored(self, cells: Ints, nodes: int, colors: Colors) -> tuple[Any, Any]:
        """Lines with colours of their own, and their actor."""
        import pyvista

        cloud = pyvista.PolyData(np.zeros((max(nodes, len(self._points)), 3)), lines=cells)
        cloud.cell_data["colors"] = colors
        width = COLORED_SHARE * self._size
        actor = self._plotter.add_mesh(
            cloud, scalars="colors", rgb=True, line_width=width, lighting=False, show_scalar_bar=False,
            reset_camera=False, render=False,
        )  # fmt: skip
        self._moving.append(cloud)
        return cloud, actor

    def _cloud(self, cells: Ints, kind: str) -> Any:
        """Points that move, with cells (k, 1 + nodes) of one kind: "faces", "lines" or "verts"."""
        import pyvista

        named: dict[str, Any] = {kind: cells.ravel()}
        cloud = pyvista.PolyData(self._points.copy(), **named)
        self._moving.append(cloud)
        return cloud

    def _add_membrane(self, subject: Subject) -> None:
        """The two faces, each drawn where the other is hidden, flat shaded so that folds show."""
        faces = np.column_stack([np.full(len(subject.triangles), 3), subject.triangles])
        for back in (False, True):
            cloud = self._cloud(faces, "faces")
            actor = self._plotter.add_mesh(
                cloud,
                scalars=film_colors(subject, back),
                rgb=True,
                culling="front" if back else "back",
                diffuse=FILM_LIGHT[0],
                ambient=FILM_LIGHT[1],
                specular=0.15,
                specular_power=12.0,
                smooth_shading=False,
                show_scalar_bar=False,
                show_edges=subject.has_edges,
                edge_color=EDGE,
                edge_opacity=EDGE_SHARE,
                line_width=1.0,
            )
            self._faces.append((cloud, actor))

    def _add_lines(self, pairs: Ints, color: Color, width: float) -> None:
        """Straight lines between pairs of nodes, lifted towards the camera from the faces they lie in."""
        if not len(pairs):
            return
        lines = self._cloud(np.column_stack([np.full(len(pairs), 2), pairs]), "lines")
        self._lines.append(self._plotter.add_mesh(lines, color=color, line_width=width, lighting=False))

    def _add_spool(self, spool: tuple[float, float, float]) -> list[Any]:
        """The spool, and a bar on its top that shows how far it has turned."""
        import pyvista

        radius, low, high = spool
        body = pyvista.Cylinder(
            center=(0.0, 0.0, 0.5 * (low + high)),
            direction=(0.0, 0.0, 1.0),
            radius=radius,
            height=high - low,
            resolution=60,
        )
        (left, near), (right, far) = MARK[0], MARK[2]
        bar = np.array((left, right, near, far, 0.0, 0.05)) * radius + (0.0, 0.0, 0.0, 0.0, high, high)
        mark = pyvista.Box(bounds=tuple(bar))
        return [
            self._plotter.add_mesh(body, color=SPOOL, diffuse=0.7, ambient=0.35),
            self._plotter.add_mesh(mark, color=CORD),
        ]

    def _place(self, solids: Sequence[Solid], turn: Turn, camera: Camera) -> None:
        """Bodies as they stand, in place of those shown before."""
        import pyvista

        for actor in self._solids:
            self._plotter.remove_actor(actor, render=False)
        self._solids = []
        for solid in (turned_solid(solid, turn) for solid in solids):
            if solid.radius is None:
                mesh = pyvista.PolyData(plane_corners(solid, camera), faces=np.array([4, 0, 1, 2, 3]))
            else:
                low, high = cylinder_ends(solid)
                mesh = pyvista.Cylinder(
                    center=0.5 * (low + high),
                    direction=solid.direction,
                    radius=solid.radius,
                    height=float(np.linalg.norm(high - low)),
                    resolution=24,
                )
            opacity = PLANE_OPACITY if solid.radius is None else 1.0
            actor = self._plotter.add_mesh(
                mesh, color=BODY, diffuse=0.7, ambient=0.35, opacity=opacity, reset_camera=False, render=False
            )
            self._solids.append(actor)


def _matrix(turn: Turn) -> Floats:
    """(4, 4) matrix that turns an actor as the hub is."""
    matrix = np.eye(4)
    matrix[:3, :3] = turned(np.eye(3), turn).T
    return matrix


def film_colors(subject: Subject, back: bool) -> Colors:
    """(m, 3) colour of each triangle of the bare film, of its upper or lower face."""
    return np.round(255.0 * subject.colors(back)).astype(np.uint8)


def aim(plotter: Any, seen: Camera) -> None:
    """Set the camera of a plotter."""
    camera, centre, distance = plotter.camera, seen.centre, seen.distance
    camera.position, camera.focal_point = tuple(centre + distance * seen.view), tuple(centre)
    camera.up, camera.view_angle = tuple(seen.up), ANGLE_DEG
    camera.clipping_range = (0.4 * distance, 1.6 * distance)


def silence_vtk() -> None:
    """Keep VTK from writing warnings about missing displays to the terminal."""
    from vtkmodules.vtkCommonCore import vtkLogger

    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)


def _highest_node(subject: Subject) -> int:
    """The highest node index that is drawn."""
    parts = (subject.triangles, subject.creases, subject.cords, subject.tips)
    return max(int(part.max()) for part in parts if len(part))
