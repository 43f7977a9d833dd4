"""Where a run is looked at: in a window, in a notebook, or as a page for a browser."""

from __future__ import annotations

import sys
from pathlib import Path

from membrane_rs.plotting.viewer.notebook import NotebookView
from membrane_rs.plotting.viewer.page import serve
from membrane_rs.plotting.viewer.source import ViewedRun
from membrane_rs.plotting.viewer.viewer import FILM, RUN, TURNING, Viewer, one_of
from membrane_rs.plotting.viewer.window import Window

WINDOW, NOTEBOOK, BROWSER, PICTURE = "window", "notebook", "browser", "picture"


def look_at(
    run: ViewedRun,
    *,
    color: str = FILM,
    camera: str = TURNING,
    scale: str = RUN,
    time: float | None = None,
    where: str | None = None,
    folder: Path | None = None,
) -> NotebookView | None:
    """Look at a run: what `membrane_rs.view` does, once it has the run."""
    place = one_of("where", where or default_place(), (WINDOW, NOTEBOOK, BROWSER, PICTURE))
    viewer = Viewer(run, color, camera, scale)
    if time is not None:
        viewer.go_to(time)
    if place in (NOTEBOOK, PICTURE):
        return NotebookView(viewer, is_live=place == NOTEBOOK)
    if place == BROWSER:
        serve(viewer)
    else:
        Window(viewer, Path.cwd() if folder is None else folder).show()
    return None


def default_place() -> str:
    """In a notebook there, and as a picture where pyvista is set to static ones; else in a window."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    if getattr(shell, "kernel", None) is None:
        return WINDOW
    return PICTURE if _wants_pictures() else NOTEBOOK


def _wants_pictures() -> bool:
    """Whether pyvista is set to pictures in notebooks, as documentation sets it."""
    try:
        import pyvista
    except ModuleNotFoundError:
        return True
    return pyvista.global_theme.jupyter_backend in ("static", "none")
