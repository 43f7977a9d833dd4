"""Looking at a run: in a window with a slider for the time, in a notebook, or as a picture."""

# viewer.py says what is shown, without any of these; canvas.py draws it.

from __future__ import annotations

from membrane_rs.plotting.camera import Camera
from membrane_rs.plotting.fields import Field
from membrane_rs.plotting.viewer.coloring import Scale
from membrane_rs.plotting.viewer.notebook import NotebookView
from membrane_rs.plotting.viewer.opening import look_at
from membrane_rs.plotting.viewer.shown import Shown
from membrane_rs.plotting.viewer.viewer import Viewer

__all__ = ["Camera", "Field", "NotebookView", "Scale", "Shown", "Viewer", "look_at"]
