"""The picture of a viewer: the membrane and what is around it, the time, the legend, and a scale bar that follows the
camera. The window, the notebook and the fallback of the notebook show the same.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from membrane_rs.plotting.actors import FIELD_LIGHT, FILM_LIGHT, LIGHTS, MembraneActors, aim, silence_vtk
from membrane_rs.plotting.camera import ANGLE_DEG, BAR_SHARE, Camera, bar_length
from membrane_rs.plotting.columns import axis_label, prefixed
from membrane_rs.plotting.fields import MISSING
from membrane_rs.plotting.picture import Image
from membrane_rs.plotting.viewer.coloring import Scale
from membrane_rs.plotting.viewer.flat import INK, MUTED, Polygons, Text, rectangle
from membrane_rs.plotting.viewer.viewer import Viewer

MARGIN = 26
"""Around the picture [pixels]."""
REFERENCE_SIZE = 800
"""Widths of lines and sizes of points are those of a snapshot of this size."""
LEGEND = (0.34, 16, 100)
"""Height of the legend, as a share of the picture, and the widths of its bar and of all [pixels]."""


LABELS = 5
"""Of the legend."""


class Canvas:
    """Draws what a viewer shows into an untyped `pyvista.Plotter` without lights.

    `foot` is left free below it [pixels]; all lengths in pixels are multiplied by `zoom`.
    """

    def __init__(self, plotter: Any, viewer: Viewer, foot: int = 0, zoom: int = 1) -> None:
        self.plotter, self.viewer, self._foot, self._zoom = plotter, viewer, foot, zoom
        self.set_background()
        plotter.enable_anti_aliasing("msaa", multi_samples=8)
        self._actors = MembraneActors(plotter, viewer.subject, REFERENCE_SIZE * zoom)
        self._light()
        self._name, self._words = Text(plotter, 15 * zoom, MUTED), Text(plotter, 24 * zoom)
        self._name.say(viewer.name)
        self._bar, self._bar_words = Polygons(plotter, INK), Text(plotter, 14 * zoom)
        self._legend, self._legend_title = _legend(plotter, 14 * zoom), Text(plotter, 15 * zoom)
        self._laid_out: tuple[float, ...] = ()
        self._has_names = False
        self.aim(viewer.camera())
        plotter.renderer.AddObserver("StartEvent", self._before_render)

    def set_background(self) -> None:
        """White, and a little blue above."""
        self.plotter.set_background("white", top="#eaf0f6")

    def aim(self, camera: Camera) -> None:
        """Look from a camera."""
        aim(self.plotter, camera)
        self._camera = camera
        self._fit(*self.plotter.window_size)
        self.plotter.renderer.ResetCameraClippingRange()

    def draw(self) -> None:
        """Show what the viewer shows now; the caller renders."""
        shown = self.viewer.shown()
        if len(self.viewer.subject.triangles):
            if shown.node_values is not None and shown.scale is not None:
                self._actors.color_nodes(shown.node_values, _lookup_table(shown.scale))
            else:
                light = FILM_LIGHT if shown.scale is None else FIELD_LIGHT
                self._actors.color_triangles(shown.upper, shown.lower, light)
        self._actors.color_lines(shown.lines, shown.line_colors)
        self._actors.show(shown.positions, shown.hub_angle, shown.solids, self._camera)
        self._words.say(self.viewer.words())
        self._show_scale(shown.scale)
        self.plotter.renderer.ResetCameraClippingRange()

    def look_as(self, other: Canvas) -> None:
        """Look from where another canvas is looked at from now."""
        self._camera = other._camera
        ours, theirs = self.plotter.camera, other.plotter.camera
        ours.position, ours.focal_point, ours.up = theirs.position, theirs.focal_point, theirs.up

    def image(self) -> Image:
        """The picture (height, width, 3)."""
        picture: Image = self.plotter.screenshot(return_img=True)[:, :, :3].copy()
        return picture

    def _light(self) -> None:
        """Lights that go with the camera."""
        import pyvista

        for direction, intensity in LIGHTS:
            light = pyvista.Light(position=direction, intensity=intensity, light_type="camera light")
            light.positional = False
            self.plotter.add_light(light)

    def _show_scale(self, scale: Scale | None) -> None:
        self._legend.SetVisibility(scale is not None)
        self._has_names = scale is not None and bool(scale.field.categories)
        if scale is None:
            self._legend_title.say("")
            return
        factor, unit = prefixed(scale.field.unit, [np.array([scale.low, scale.high])])
        self._legend_title.say(axis_label(scale.field.label, unit))
        self._legend.SetLookupTable(_lookup_table(scale, factor))
        if self._has_names:
            self._legend.SetNumberOfLabels(0)
            self._legend.SetDrawTickLabels(False)
            self._legend.SetDrawAnnotations(True)
        else:
            self._legend.SetDrawTickLabels(True)
            self._legend.SetDrawAnnotations(False)
            self._legend.SetNumberOfLabels(LABELS if scale.high > scale.low else 1)
            self._legend.SetLabelFormat(f"%.{digits_of(scale.low / factor, scale.high / factor)}g")

    def _before_render(self, *_: Any) -> None:
        """What depends on the camera, and on the size of the picture where that changed."""
        camera = self.plotter.camera
        position, focus = np.array(camera.position), np.array(camera.focal_point)
        distance = float(np.linalg.norm(position - focus))
        self._actors.lift(self._camera.reach, (position - focus) / max(distance, 1e-300))
        width, height = self.plotter.window_size
        if (width, height) != self._laid_out[:2]:
            self._fit(width, height)
        half = distance * float(np.tan(np.radians(0.5 * camera.view_angle)))
        state = (width, height, half, self._has_names)
        if state != self._laid_out:
            self._laid_out = state
            self._lay_out(width, height, 2.0 * half / height)

    def _fit(self, width: int, height: int) -> None:
        """Let the camera see its reach above the foot, and across a picture that is narrower than high."""
        half = np.tan(np.radians(0.5 * ANGLE_DEG)) * height / max(1, min(width, height - self._foot))
        self.plotter.camera.view_angle = 2.0 * float(np.degrees(np.arctan(half)))
        self.plotter.camera.SetWindowCenter(0.0, -self._foot / height)

    def _lay_out(self, width: int, height: int, metres_per_pixel: float) -> None:
        zoom, margin = self._zoom, MARGIN * self._zoom
        self._name.place(margin, height - margin, up=2)
        self._words.place(margin, height - margin - 24 * zoom, up=2)
        length = bar_length(BAR_SHARE * min(width, height) * metres_per_pixel)
        pixels, low = length / metres_per_pixel, self._foot + margin
        self._bar.draw([rectangle(margin, low, pixels, 3 * zoom)])
        self._bar_words.say(_length(length))
        self._bar_words.place(margin + 0.5 * pixels, low + 9 * zoom, across=1)
        share, thick, wide = LEGEND
        # Names of categories stand to the left of the bar, numbers to its right.
        tall, left = share * height, width - margin - (thick if self._has_names else wide) * zoom
        bottom = 0.5 * (height + self._foot - tall)
        self._legend.SetPosition(left / width, bottom / height)
        self._legend.SetWidth(wide * zoom / width)
        self._legend.SetHeight(share)
        self._legend.SetBarRatio(thick / wide)
        self._legend_title.place(width - margin, bottom + tall + 16 * zoom, across=2)


def canvas_of(viewer: Viewer, size: tuple[int, int], zoom: int = 1) -> Canvas:
    """The picture of a viewer, off-screen, drawn."""
    import pyvista

    silence_vtk()
    plotter: Any = pyvista.Plotter(off_screen=True, window_size=list(size), lighting="none", notebook=False)
    canvas = Canvas(plotter, viewer, zoom=zoom)
    canvas.draw()
    return canvas


def digits_of(low: float, high: float) -> int:
    """Digits by which the labels of a legend between two values differ, 3 or more."""
    labels = [low + k * (high - low) / (LABELS - 1) for k in range(LABELS)]
    return next((n for n in range(3, 9) if len({f"{label:.{n}g}" for label in labels}) == LABELS), 3)


def _length(metres: float) -> str:
    """Such as "5 cm"."""
    for unit, size in (("m", 1.0), ("cm", 1e-2), ("mm", 1e-3)):
        if metres >= size * (1.0 - 1e-9):
            return f"{metres / size:.12g} {unit}"
    return f"{metres / 1e-6:.6g} µm"


def _legend(plotter: Any, size: int) -> Any:
    from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor

    legend = vtkScalarBarActor()
    legend.SetUnconstrainedFontSize(True)
    legend.SetTextPositionToSucceedScalarBar()
    legend.SetTextPad(6)
    for look in (legend.GetLabelTextProperty(), legend.GetAnnotationTextProperty()):
        look.SetFontFamilyToArial()
        look.SetFontSize(size)
        look.SetColor(INK)
        look.SetBold(False)
        look.SetItalic(False)
        look.SetShadow(False)
    legend.SetVisibility(False)
    plotter.renderer.AddViewProp(legend)
    return legend


def _lookup_table(scale: Scale, factor: float = 1.0) -> Any:
    """The colours of a scale for VTK; its values are divided by a factor."""
    from vtkmodules.vtkCommonCore import vtkLookupTable

    colors = scale.colors / 255.0
    table: Any = vtkLookupTable()
    table.SetNanColor(*(share / 255.0 for share in MISSING), 1.0)
    table.SetNumberOfTableValues(len(colors))
    for row, color in enumerate(colors):
        table.SetTableValue(row, *color, 1.0)
    categories = scale.field.categories
    if categories:
        table.SetTableRange(-0.5, len(categories) - 0.5)
        for value, name in enumerate(categories):
            table.SetAnnotation(float(value), name)
    else:
        low, high = scale.low / factor, scale.high / factor
        around = 0.0 if high > low else abs(low) or 1.0  # a uniform field has the colour in the middle
        table.SetTableRange(low - around, high + around)
    return table
