"""Looking at a run: in a window with a slider for the time, in a notebook, or as a picture."""

# viewer.py says what is shown, without any of these; canvas.py draws it.

from __future__ import annotations

from typing import TYPE_CHECKING

from membrane_rs._on_demand import OnDemand

if TYPE_CHECKING:
    from membrane_rs.plotting.camera import Camera
    from membrane_rs.plotting.fields import Field
    from membrane_rs.plotting.viewer.coloring import Scale
    from membrane_rs.plotting.viewer.notebook import NotebookView
    from membrane_rs.plotting.viewer.opening import look_at
    from membrane_rs.plotting.viewer.shown import Shown
    from membrane_rs.plotting.viewer.viewer import Viewer

__all__ = ["Camera", "Field", "NotebookView", "Scale", "Shown", "Viewer", "look_at"]

if not TYPE_CHECKING:  # a type checker would take every name for one that is there
    _on_demand = OnDemand(
        __name__,
        {
            "membrane_rs.plotting.camera": ("Camera",),
            "membrane_rs.plotting.fields": ("Field",),
            "membrane_rs.plotting.viewer.coloring": ("Scale",),
            "membrane_rs.plotting.viewer.notebook": ("NotebookView",),
            "membrane_rs.plotting.viewer.opening": ("look_at",),
            "membrane_rs.plotting.viewer.shown": ("Shown",),
            "membrane_rs.plotting.viewer.viewer": ("Viewer",),
        },
    )
    __getattr__, __dir__ = _on_demand, _on_demand.names
