"""A run is read from its folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._files import path_of
from membrane_rs.errors import MembraneError, OutputError
from membrane_rs.results.history import HISTORY, read_history
from membrane_rs.results.pvd import PVD, read_pvd
from membrane_rs.results.run_history import RunHistory
from membrane_rs.results.summary import SUMMARY, folder_of_run, read_summary
from membrane_rs.runs.frames import FilesOfFrames
from membrane_rs.runs.result import Run
from membrane_rs.scene import Scene
from membrane_rs.scene.scene import SCENE_FILE
from membrane_rs.scene.toml import read_scene


def open_run(path: str | Path) -> Run:
    """The run in a folder, whichever way it ended, or as far as it has come. Its frames are read when they are asked
    for, one at a time.

    Parameters
    ----------
    path : path
        The folder, or its summary.json.

    Returns
    -------
    Run
        The same as `membrane_rs.run` gives. Where measures of stages were functions, which no file holds, its scene is
        without these.

    Raises
    ------
    MissingFileError
        No run in the folder.
    OutputError
        Its files are damaged.
    InputError, InputTypeError
        No path; a history of no run.

    Examples
    --------
    >>> import membrane_rs, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     made = membrane_rs.run("spinning-tether", 1e-3, frames=3, out=folder + "/run", pictures=False)
    ...     again = membrane_rs.open_run(folder + "/run")
    ...     again.frames[-1].positions.shape
    (11, 3)
    """
    folder = folder_of_run(path_of(path))
    summary = read_summary(folder)
    history_file = folder / HISTORY
    table = dict(read_history(history_file)) if history_file.is_file() else {"time": _EMPTY, "hub_angle": _EMPTY}
    _check_times(table["time"], history_file)
    history = RunHistory(table, _recorded(summary, folder / SUMMARY))
    scene = _scene(folder / SCENE_FILE)
    frames = FilesOfFrames(_frames(folder), history, scene.assemble().node_count)
    return Run(scene, history, frames, summary, folder)


_EMPTY: Any = ()


def _scene(path: Path) -> Scene:
    """The scene of a run. Raises OutputError where it is no scene."""
    try:
        return Scene(**vars(read_scene(path, without_functions=True)))
    except MembraneError as error:
        raise type(error)(f"{path}: is no scene of a run: {error}") from None


def _frames(folder: Path) -> list[tuple[float, Path]]:
    """Times [s] and files of the frames, all of them inside the folder. Raises OutputError."""
    path = folder / PVD
    frames = read_pvd(path) if path.is_file() else []
    _check_times([time for time, _ in frames], path)
    inside = folder.resolve()
    for _, file in frames:
        try:
            is_inside = inside in file.resolve().parents
        except (OSError, RuntimeError):  # links in a circle
            is_inside = False
        if not is_inside:
            raise OutputError(
                f"{path}: names {str(file)!r}, which is not in the folder of the run; run the scene again"
            )
    return frames


def _check_times(times: Sequence[float] | Floats, path: Path) -> None:
    """Refuse times that do not go on, by which no sample and no frame is found. Raises OutputError."""
    if not np.isfinite(times).all() or (np.diff(times) < 0.0).any():
        raise OutputError(f"{path}: its times are not finite, or go back; run the scene again")


def _recorded(summary: Mapping[str, Any], path: Path) -> dict[str, str]:
    """Units of the measures that a run recorded. Raises OutputError."""
    found = (summary.get("request") or {}).get("record") or {}
    if not isinstance(found, dict) or not all(isinstance(unit, str) for unit in found.values()):
        raise OutputError(f"{path}: its request.record is no table of measures and their units; run the scene again")
    return found
