"""Pictures of a membrane by pyvista, off-screen."""

from __future__ import annotations

from typing import Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.analysis.attitude import Turn
from membrane_rs.plotting.actors import LIGHTS, MembraneActors, aim, silence_vtk
from membrane_rs.plotting.camera import Camera, with_scale_bar
from membrane_rs.plotting.picture import Image, Subject
from membrane_rs.plotting.scenery import NONE, Scenery


class PyvistaPainter:
    """One plotter whose points are moved from picture to picture."""

    def __init__(self, subject: Subject, size: int) -> None:
        silence_vtk()
        self._camera = subject.camera
        self._plotter = _plotter(size)
        self._plotter.set_background("white")
        self._plotter.enable_anti_aliasing("msaa", multi_samples=8)
        self._actors = MembraneActors(self._plotter, subject, size)
        self._light(subject.camera)

    def paint(self, positions: Floats, turn: Turn = 0.0, around: Scenery = NONE) -> Image:
        """Picture (size, size, 3) of positions (N, 3) [m] and what is around, turned as the hub is."""
        camera = around.camera or self._camera
        self._actors.lift(camera.reach, camera.view)
        aim(self._plotter, camera)
        self._actors.show(positions, turn, around.solids, camera)
        self._plotter.render()
        picture: Image = self._plotter.screenshot(return_img=True)[:, :, :3].copy()
        return with_scale_bar(picture, camera) if around.scale_bar else picture

    def close(self) -> None:
        """Free the plotter's window."""
        self._plotter.close()

    def _light(self, seen: Camera) -> None:
        """Lights that stand still, as the camera does."""
        import pyvista

        reach, centre = seen.reach, seen.centre
        right = np.cross(seen.up, seen.view)
        for direction, intensity in LIGHTS:
            light = pyvista.Light(
                position=tuple(centre + 10.0 * reach * (np.array(direction) @ np.stack([right, seen.up, seen.view]))),
                intensity=intensity,
            )
            light.focal_point = tuple(centre)
            self._plotter.add_light(light)


def _plotter(size: int) -> Any:
    """An off-screen plotter without lights, untyped: pyvista's own stubs refuse calls that it documents."""
    import pyvista

    return pyvista.Plotter(off_screen=True, window_size=[size, size], lighting="none")
