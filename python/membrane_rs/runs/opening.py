"""A run is read from its folder."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._files import path_of
from membrane_rs._validation import show
from membrane_rs._warning import warn
from membrane_rs.errors import MembraneError, MissingFileError, OutputError
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
        No run in the folder, or no history of it.
    OutputError
        Its files are damaged.
    InputError, InputTypeError
        No path; a history of no run.

    Warns
    -----
    UserWarning
        Frames or samples that its summary counts are missing.

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
    table = _table(folder, summary)
    history = RunHistory(table, _recorded(summary, folder / SUMMARY, table))
    scene = _scene(folder / SCENE_FILE)
    frames = FilesOfFrames(_frames(folder, summary), history, scene.assemble().node_count)
    return Run(scene, history, frames, summary, folder)


_EMPTY: Any = ()


def _table(folder: Path, summary: Mapping[str, Any]) -> Mapping[str, Floats]:
    """The columns of the history; empty for a run that has not come to its first sample. Raises OutputError.

    Warns where it has another number of samples than the summary says.
    """
    path, count = folder / HISTORY, summary.get("samples")
    if os.path.lexists(path):
        table = dict(read_history(path))
    elif count or (count is None and "time" in summary):
        found = f"{count} samples" if count else f"the run came to {summary['time']:.6g} s"
        what = f"no history at {path}, though {SUMMARY} says: {found}"
        raise MissingFileError(f"{what}; put it back, or run the scene again")
    else:
        table = {"time": _EMPTY, "hub_angle": _EMPTY}
    _check_times(table["time"], path, "line", 2)
    if count is not None and len(table["time"]) != count:
        warn(f"{path}: has {len(table['time'])} samples, and {SUMMARY} says {count}; the run is not whole")
    return table


def _scene(path: Path) -> Scene:
    """The scene of a run. Raises MissingFileError where there is none, and OutputError for what is no scene."""
    if not path.is_file():
        raise MissingFileError(
            f"no scene at {path}: the run has not come to its first step, or the file was removed; put it back, resume "
            "the run, or run the scene again"
        )
    try:
        return Scene(**vars(read_scene(path, without_functions=True)))
    except MembraneError as error:
        raise type(error)(f"{path}: is no scene of a run: {error}") from None


def _frames(folder: Path, summary: Mapping[str, Any]) -> list[tuple[float, Path]]:
    """Times [s] and files of the frames, all of them inside the folder. Raises OutputError.

    Warns of frames that the summary counts and the folder lacks.
    """
    path, count = folder / PVD, summary.get("frames")
    frames = read_pvd(path) if os.path.lexists(path) else []
    _check_times([time for time, _ in frames], path, "frame", 0)
    inside = folder.resolve()
    lacking: list[Path] = []
    for _, file in frames:
        try:
            found = file.resolve()
            is_inside = inside in found.parents and not found.is_symlink()  # links in a circle, from Python 3.13 on
        except (OSError, RuntimeError):  # and before
            is_inside = False
        if not is_inside:
            raise OutputError(
                f"{path}: names {str(file)!r}, which is not in the folder of the run; run the scene again"
            )
        if not file.exists():
            lacking.append(file)
    if lacking:
        what = f"{len(lacking)} of its {len(frames)} frames are not there, the first {lacking[0]}"
        warn(f"{path}: {what}; put them back")
    if count is not None and len(frames) != count:
        what = f"lists {len(frames)} frames" if frames else "is not there, or lists no frame"
        warn(f"{path}: {what}, and {SUMMARY} says {count}; the run is not whole")
    return frames


def _check_times(times: Sequence[float] | Floats, path: Path, what: str, first: int) -> None:
    """Refuse times that do not go on, by which no sample and no frame is found. Raises OutputError, which names the
    place: what it is, counted from `first` on.
    """
    is_wrong = ~np.isfinite(times)
    is_wrong[1:] |= np.diff(times) <= 0.0
    if is_wrong.any():
        k = int(is_wrong.argmax())
        time, before = float(times[k]), f" after {float(times[k - 1])!r}" if k else ""
        raise OutputError(
            f"{path}: {what} {first + k} has the time {time!r} s{before}; times must be finite and go on; run the "
            "scene again"
        )


def _recorded(summary: Mapping[str, Any], path: Path, table: Mapping[str, Any]) -> dict[str, str]:
    """Units of the measures that a run recorded. Raises OutputError."""
    found = (summary.get("request") or {}).get("record") or {}
    if not isinstance(found, dict) or not all(isinstance(unit, str) for unit in found.values()):
        raise OutputError(f"{path}: its request.record is no table of measures and their units; run the scene again")
    lacking = next((name for name in found if name not in table), None)
    if lacking is not None and len(table["time"]):
        raise OutputError(
            f"{path.parent / HISTORY}: lacks the column {show(lacking)}, which {SUMMARY} says was recorded; run the "
            "scene again"
        )
    return found
