"""A run that was killed or interrupted goes on in its folder, from its last checkpoint."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from membrane_rs._files import path_of
from membrane_rs._validation import number_of
from membrane_rs.errors import InputError
from membrane_rs.results.record import Progress
from membrane_rs.results.state import STATE
from membrane_rs.results.summary import SUMMARY, folder_of_run, read_summary
from membrane_rs.runs import signals
from membrane_rs.runs.request import Request
from membrane_rs.runs.run_folder import RunFolder
from membrane_rs.runs.simulation import Simulation
from membrane_rs.simulation.observer import Observer


def resume(
    folder: str | Path,
    until: float | None = None,
    *,
    pictures: bool | None = None,
    observers: Sequence[Observer[Simulation]] = (),
    progress: Callable[[Simulation], None] | None = None,
    drawing: Progress | None = None,
) -> Simulation:
    """Continue the run of a folder in the same folder, from its last checkpoint to its end.

    State, history and frames are then the same, bit by bit, as those of the run that nobody stopped. A run that is
    finished stays as it is, unless `until` is later than its end.

    Parameters
    ----------
    folder : path
        The folder of a run that no process goes on with, or its summary.json.
    until : float, optional
        Another end [s], not before the checkpoint. Frames and samples that were evenly spaced continue with their
        spacing; lists of times are not continued. Default: the end that the run was asked for.
    pictures : bool, optional
        Draw pictures at the end. Default: what the run was asked for.
    observers, progress
        As for `Simulation.run`; `drawing` is the `progress` of `RunFolder`.

    Returns
    -------
    Simulation
        At the end of the run.

    Raises
    ------
    MissingFileError
        No run in the folder, or no checkpoint of it.
    OutputError
        Another run goes on in the folder; its files are damaged; it cannot be written.
    InputError
        The run became unstable, its checkpoint is damaged, or `until` is before it.
    """
    path = folder_of_run(path_of(folder, "folder"))
    summary = read_summary(path)
    request = Request.of(summary, str(path / SUMMARY))
    if summary["outcome"].startswith("unstable"):
        raise InputError(f"{path}: the run ended {summary['outcome']}; it cannot go on: change the scene or its step")
    end = request.until if until is None else number_of("until", until)
    request = replace(request, pictures=request.pictures if pictures is None else pictures)
    with signals.interruptible():
        results = RunFolder(path, True, pictures=request.pictures, crossings=request.crossings, progress=drawing)
        with results.reopened():
            sim = Simulation.restore(path / STATE)
            if end < sim.time:
                raise InputError(f"until = {end} s: the run has come to {sim.time:.6g} s already; give a later time")
            if summary["outcome"] == "finished" and end == request.until:
                return sim
            if end != request.until:
                request = request.until_later(end)
            sim.run(
                end,
                request.frames,
                samples=request.samples,
                observers=(*observers, results),
                progress=progress,
                checkpoint=request.checkpoint,
            )
    return sim
