"""Looking at a run, at that of a folder, or at the start of a scene."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from membrane_rs import scenes
from membrane_rs._files import path_of
from membrane_rs._messages import nearest, show
from membrane_rs.errors import MissingFileError
from membrane_rs.results.frame_fields import Frame, FrameFields
from membrane_rs.results.run_history import RunHistory
from membrane_rs.results.summary import SUMMARY
from membrane_rs.runs.frames import KeptFrames
from membrane_rs.runs.opening import open_run
from membrane_rs.runs.result import Run
from membrane_rs.runs.simulation import Simulation
from membrane_rs.scene import Scene

if TYPE_CHECKING:
    from membrane_rs.plotting.viewer import NotebookView


def view(
    run: Run | Scene | str | Path,
    *,
    color: str = "film",
    camera: str = "turning",
    scale: str = "run",
    time: float | None = None,
    where: str | None = None,
) -> NotebookView | None:
    """Look at a run in a window, with a slider for the time; in a notebook, in a page of the cell.

    Parameters
    ----------
    run : Run, Scene, str or Path
        A run; its folder, or the summary.json in it; or a scene, the name of a built-in one or a TOML file, of which
        the start is shown.
    color : str
        What the membrane is coloured by at first: "film", as in snapshots, or a field that the run has, such as
        "state", "speed" or "crease_angle".
    camera : {"turning", "fixed"}
        Whether the camera turns with the hub.
    scale : {"run", "frame"}
        Whether the colours span the values of the whole run, or of each frame.
    time : float, optional
        Of the frame that is shown first, the nearest one [s]. Default: the first.
    where : {"window", "notebook", "browser", "picture"}, optional
        "browser" serves a page until Ctrl-C, "picture" gives a picture, to be saved. Default: a notebook where
        Python runs in one, else a window.

    Returns
    -------
    NotebookView or None
        What a notebook shows, a picture where trame is not installed; None once a window is closed.

    Raises
    ------
    InputError
        A word that is none of those, a field that the run lacks, or a run without frames.
    InputTypeError
        A time that is no number.
    MissingFileError, SceneError, OutputError
        Neither a folder of a run nor a scene, or damaged files.
    DisplayError
        A window where there is no display.
    MissingExtraError
        pyvista or matplotlib is not installed.

    Examples
    --------
    >>> import membrane_rs
    >>> run = membrane_rs.run("hanging-strip", 0.01, frames=3)
    >>> membrane_rs.view(run, color="speed", where="picture")
    <view of hanging-strip at 0.000 s, coloured by speed>
    """
    return run_of(run).view(color=color, camera=camera, scale=scale, time=time, where=where)


def run_of(source: Run | Scene | str | Path) -> Run:
    """A run as it is, that of a folder, or the start of a scene."""
    if isinstance(source, Run):
        return source
    if not isinstance(source, Scene):
        path = path_of(source, "run")
        if path.name == SUMMARY or path.is_dir():
            return open_run(path)
        check_is_there(source)
    return start_of(scenes.scene_of(source))


def check_is_there(source: str | Path) -> None:
    """Raise MissingFileError for what names neither the folder of a run nor a scene, with the nearest name."""
    path, built_in = path_of(source, "run"), scenes.names()
    if str(source) in built_in or path.exists():
        return
    runs = [str(summary.parent) for place in (path.parent, Path("runs")) for summary in place.glob(f"*/{SUMMARY}")]
    meant = nearest(str(source), {*built_in, *runs})
    raise MissingFileError(f"{show(str(source))}: is neither the folder of a run nor a scene; {meant}")


def start_of(scene: Scene) -> Run:
    """A run of one frame: the start of a scene."""
    sim = Simulation(scene)
    history = RunHistory({"time": np.array([sim.time]), "hub_angle": np.array([sim.hub_angle])})
    frames = KeptFrames([Frame.of(sim)], FrameFields(sim), history)
    return Run(sim.scene, history, frames, {"outcome": "not begun"})
