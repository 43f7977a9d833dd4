"""Looking at a run: in a window, or in a notebook. viewer.py says what is shown, without either; canvas.py draws it."""

from __future__ import annotations

from membrane_rs.plotting.viewer.notebook import NotebookView
from membrane_rs.plotting.viewer.opening import look_at
from membrane_rs.plotting.viewer.viewer import Viewer

__all__ = ["NotebookView", "Viewer", "look_at"]
