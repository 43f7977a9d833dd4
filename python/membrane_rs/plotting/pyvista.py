"""Pictures of a membrane by pyvista, off-screen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs.plotting.camera import ANGLE_DEG, Camera, with_scale_bar
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
    turned,
)
from membrane_rs.plotting.scenery import NONE, Scenery, cylinder_ends, plane_corners, turned_solid
from membrane_rs.scene.solid import Solid

LIFT = 0.004
"""How far lines stand before the faces, as a share of what the picture reaches."""


class PyvistaPainter:
    """One plotter whose points are moved from picture to picture."""

    def __init__(self, subject: Subject, size: int) -> None:
        import pyvista

        _silence_vtk()
        self._points = np.zeros((_highest_node(subject) + 1, 3))
        self._camera = subject.camera
        self._plotter = _plotter(size)
        self._plotter.set_background("white")
        self._plotter.enable_anti_aliasing("msaa", multi_samples=8)
        self._moving: list[Any] = []
        if len(subject.triangles):
            self._add_membrane(subject)
        self._lines: list[Any] = []
        self._solids: list[Any] = []
        self._add_lines(subject.creases, CREASE, max(1.5, size / 280.0))
        self._add_lines(subject.cords, CORD, max(1.5, size / 300.0))
        if len(subject.tips):
            tips = self._cloud(np.column_stack([np.ones(len(subject.tips), np.int64), subject.tips]), "verts")
            self._plotter.add_mesh(
                tips,
                color=TIP,
                style="points",
                point_size=size / 55.0,
                render_points_as_spheres=True,
                ambient=0.5,
            )
        self._spool = None
        if subject.spool is not None:
            radius, low, high = subject.spool
            body = pyvista.Cylinder(
                center=(0.0, 0.0, 0.5 * (low + high)),
                direction=(0.0, 0.0, 1.0),
                radius=radius,
                height=high - low,
                resolution=60,
            )
            # A bar on the top shows how far the spool has turned.
            (left, near), (right, far) = MARK[0], MARK[2]
            bar = np.array((left, right, near, far, 0.0, 0.05)) * radius + (0.0, 0.0, 0.0, 0.0, high, high)
            mark = pyvista.Box(bounds=tuple(bar))
            self._spool = [
                self._plotter.add_mesh(body, color=SPOOL, diffuse=0.7, ambient=0.35),
                self._plotter.add_mesh(mark, color=CORD),
            ]
        self._light(subject.camera)

    def paint(self, positions: Floats, hub_angle: float = 0.0, around: Scenery = NONE) -> Image:
        """Picture (size, size, 3) of positions (N, 3) [m] and what is around, turned about z by `hub_angle` [rad]."""
        points = turned(positions, hub_angle)
        camera = around.camera or self._camera
        self._aim(camera)
        for cloud in self._moving:
            cloud.points = points[: cloud.n_points]
        for actor in self._spool or ():
            actor.orientation = (0.0, 0.0, float(np.degrees(hub_angle)))
        self._place(around.solids, hub_angle, camera)
        self._plotter.render()
        picture: Image = self._plotter.screenshot(return_img=True)[:, :, :3].copy()
        return with_scale_bar(picture, camera)

    def close(self) -> None:
        """Free the plotter's window."""
        self._plotter.close()

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
            colors = np.round(255.0 * subject.colors(back)).astype(np.uint8)
            self._plotter.add_mesh(
                cloud,
                scalars=colors,
                rgb=True,
                culling="front" if back else "back",
                diffuse=0.75,
                ambient=0.38,
                specular=0.15,
                specular_power=12.0,
                smooth_shading=False,
                show_scalar_bar=False,
                show_edges=subject.has_edges,
                edge_color=EDGE,
                edge_opacity=EDGE_SHARE,
                line_width=1.0,
            )

    def _add_lines(self, pairs: Ints, color: Color, width: float) -> None:
        """Straight lines between pairs of nodes, lifted towards the camera from the faces they lie in."""
        if not len(pairs):
            return
        lines = self._cloud(np.column_stack([np.full(len(pairs), 2), pairs]), "lines")
        self._lines.append(self._plotter.add_mesh(lines, color=color, line_width=width, lighting=False))

    def _place(self, solids: Sequence[Solid], hub_angle: float, camera: Camera) -> None:
        """Bodies as they stand, in place of those of the last picture."""
        import pyvista

        for actor in self._solids:
            self._plotter.remove_actor(actor, render=False)
        self._solids = []
        for solid in (turned_solid(solid, hub_angle) for solid in solids):
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

    def _light(self, seen: Camera) -> None:
        """A bright light from the left, a weak one from the right."""
        import pyvista

        reach, centre = seen.reach, seen.centre
        right = np.cross(seen.up, seen.view)
        for direction, intensity in (((-0.70, 0.70, 0.75), 0.85), ((0.45, -0.20, 0.90), 0.40)):
            light = pyvista.Light(
                position=tuple(centre + 10.0 * reach * (np.array(direction) @ np.stack([right, seen.up, seen.view]))),
                intensity=intensity,
            )
            light.focal_point = tuple(centre)
            self._plotter.add_light(light)

    def _aim(self, seen: Camera) -> None:
        """Set the camera, and what depends on its reach."""
        for actor in self._lines:
            actor.position = tuple(LIFT * seen.reach * seen.view)
        camera, centre, distance = self._plotter.camera, seen.centre, seen.distance
        camera.position, camera.focal_point = tuple(centre + distance * seen.view), tuple(centre)
        camera.up, camera.view_angle = tuple(seen.up), ANGLE_DEG
        camera.clipping_range = (0.4 * distance, 1.6 * distance)


def _highest_node(subject: Subject) -> int:
    """The highest node index that is drawn."""
    parts = (subject.triangles, subject.creases, subject.cords, subject.tips)
    return max(int(part.max()) for part in parts if len(part))


def _plotter(size: int) -> Any:
    """An off-screen plotter without lights, untyped: pyvista's own stubs refuse calls that it documents."""
    import pyvista

    return pyvista.Plotter(off_screen=True, window_size=[size, size], lighting="none")


def _silence_vtk() -> None:
    """Keep VTK from writing warnings about missing displays to the terminal."""
    from vtkmodules.vtkCommonCore import vtkLogger

    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)
