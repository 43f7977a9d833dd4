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
    """Look at a run: what `membrane_rs.view` does, once it has the run.

    Parameters
    ----------
    run : Run
        With one frame or more.
    color : str
        "film", or a field that the run has, such as "speed".
    camera : {"turning", "fixed"}
        Whether the camera turns with the hub.
    scale : {"run", "frame"}
        Whether the colours span the values of the whole run, or of each frame.
    time : float, optional
        Of the frame that is shown first, the nearest one [s]. Default: the first.
    where : {"window", "notebook", "browser", "picture"}, optional
        Default: a notebook where Python runs in one, else a window.
    folder : Path, optional
        Where pictures of the window are saved. Default: the current one.

    Returns
    -------
    NotebookView or None
        What a notebook shows; None once a window is closed.

    Raises
    ------
    InputError
        A word that is none of those, a field that the run lacks, or a run without frames.
    OutputError
        A damaged frame.
    DisplayError
        A window where there is no display.
    MissingExtraError
        pyvista or matplotlib is not installed.

    Examples
    --------
    >>> import membrane_rs
    >>> from membrane_rs.plotting.viewer import look_at
    >>> look_at(membrane_rs.run("hanging-strip", until=0.01, frames=2), where="picture")
    <view of hanging-strip at 0.000 s, coloured by film>
    """
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
