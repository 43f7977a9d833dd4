"""Flat shapes and texts before the picture, placed in pixels from its lower left corner."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.plotting.picture import Color

INK: Color = (0.13, 0.15, 0.19)
MUTED: Color = (0.47, 0.50, 0.56)
ACCENT: Color = (0.16, 0.42, 0.66)
FAINT: Color = (0.82, 0.84, 0.87)
PAPER: Color = (1.0, 1.0, 1.0)


class Text:
    """A text; `at` is its lower left corner, or another one by `across` and `up`: 0 left or low, 1 centre, 2."""

    def __init__(self, plotter: Any, size: int, color: Color = INK, *, bold: bool = False) -> None:
        from vtkmodules.vtkRenderingCore import vtkTextActor

        self.actor = vtkTextActor()
        self._plotter, self.words = plotter, ""
        look = self.actor.GetTextProperty()
        look.SetFontFamilyToArial()
        look.SetFontSize(size)
        look.SetColor(color)
        look.SetBold(bold)
        plotter.renderer.AddViewProp(self.actor)

    def say(self, words: str) -> None:
        """Show other words."""
        self.words = words
        self.actor.SetInput(words)

    def place(self, x: float, y: float, across: int = 0, up: int = 0) -> None:
        """Move it to a place."""
        look = self.actor.GetTextProperty()
        look.SetJustification(across)
        look.SetVerticalJustification(up)
        self.actor.SetPosition(x, y)

    def look(self, color: Color, *, bold: bool = False) -> None:
        """Change colour and weight."""
        self.actor.GetTextProperty().SetColor(color)
        self.actor.GetTextProperty().SetBold(bold)

    def size(self) -> tuple[float, float]:
        """Width and height as drawn [pixels]."""
        size = [0.0, 0.0]
        self.actor.GetSize(self._plotter.renderer, size)
        return size[0], size[1]


class Polygons:
    """Filled convex polygons of one colour."""

    def __init__(self, plotter: Any, color: Color, opacity: float = 1.0) -> None:
        from vtkmodules.vtkRenderingCore import vtkActor2D, vtkPolyDataMapper2D

        self._mapper, self.actor = vtkPolyDataMapper2D(), vtkActor2D()
        self.actor.SetMapper(self._mapper)
        self.actor.GetProperty().SetColor(color)
        self.actor.GetProperty().SetOpacity(opacity)
        plotter.renderer.AddViewProp(self.actor)

    def draw(self, corners: Sequence[Floats | Sequence[tuple[float, float]]]) -> None:
        """Show polygons of these corners (k, 2) [pixels] each."""
        import pyvista

        points = np.concatenate([np.asarray(each, dtype=np.float64) for each in corners])
        counts = [len(each) for each in corners]
        starts = np.cumsum([0, *counts[:-1]])
        faces = np.concatenate([[n, *range(start, start + n)] for n, start in zip(counts, starts, strict=True)])
        self._data = pyvista.PolyData(np.column_stack([points, np.zeros(len(points))]), faces=faces)
        self._mapper.SetInputData(self._data)


def rectangle(left: float, low: float, width: float, height: float) -> list[tuple[float, float]]:
    """Its corners."""
    return [(left, low), (left + width, low), (left + width, low + height), (left, low + height)]
