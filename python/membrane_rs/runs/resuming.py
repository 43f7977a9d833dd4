"""A run that was killed or interrupted goes on in its folder, from its last checkpoint."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from membrane_rs._files import path_of
from membrane_rs._validation import number_of, show
from membrane_rs.errors import InputError
from membrane_rs.results.history_table import HistoryTable
from membrane_rs.results.record import Progress
from membrane_rs.results.recorded import Measures, Recorded, RecordTable, record_table
from membrane_rs.results.summary import SUMMARY, folder_of_run, read_summary
from membrane_rs.runs import signals
from membrane_rs.runs.request import Request
from membrane_rs.runs.run_folder import RunFolder
from membrane_rs.runs.simulation import Simulation
from membrane_rs.scene.stage import Stage
from membrane_rs.simulation.checkpoint import STATE
from membrane_rs.simulation.observer import Observer
from membrane_rs.simulation.stopping import Stop, StopWhen


def resume(
    folder: str | Path,
    until: float | None = None,
    *,
    pictures: bool | None = None,
    observers: Sequence[Observer[Simulation]] = (),
    progress: Callable[[Simulation], None] | None = None,
    drawing: Progress | None = None,
    record: Recorded | None = None,
    stop_when: StopWhen | None = None,
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
    observers : sequence of observers, optional
        Further ones, as for `Simulation.run`.
    progress : callable, optional
        Called with the simulation at each output, and about every 0.1 s of wall time.
    drawing : callable, optional
        Called with (what is drawn, pictures done, pictures in all), as the `progress` of `RunFolder`.
    record, stop_when
        The functions that the run was given, as for `membrane_rs.run`, since no file holds them: the same measures with
        the same units, and what may end the run. Known measures are recorded by their names again, and need not be
        given. A run that `stop_when` has ended goes on beyond, to a later `until`, without it, unless it is given
        again.

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
        The run became unstable, its checkpoint is damaged, or `until` is before it; functions that the run was given
        are missing, or others are given.
    InputTypeError
        No path, no time, or no function.

    Examples
    --------
    >>> import tempfile
    >>> from membrane_rs import Simulation, resume, scenes
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run = Simulation(scenes.load("spinning-tether")).run(0.01, 2, folder, samples=3, pictures=False)
    ...     resume(folder, until=0.02, pictures=False).time
    0.02
    """
    path = folder_of_run(path_of(folder, "folder"))
    summary = read_summary(path)
    request = Request.of(summary, str(path / SUMMARY))
    if summary["outcome"].startswith("unstable"):
        raise InputError(f"{path}: the run ended {summary['outcome']}; it cannot go on: change the scene or its step")
    end = request.until if until is None else number_of("until", until)
    is_stopped = "stopped" in summary and summary["outcome"].startswith("stopped")
    measures, stop = _measures(path, request, record), _stop(path, request, stop_when, is_stopped=is_stopped)
    stop_table = None if stop is None else stop.table
    request = replace(request, pictures=request.pictures if pictures is None else pictures, stop=stop_table)
    with signals.interruptible():
        results = RunFolder(path, True, pictures=request.pictures, crossings=request.crossings, progress=drawing)
        with results.reopened():
            # What had ended a run is not looked for from before that, where the run goes on beyond.
            sim = Simulation._of_file(path / STATE, stop=None if is_stopped else stop)
            _check_known(path, sim, request, measures)
            if end < sim.time:
                raise InputError(f"until = {end} s: the run has come to {sim.time:.6g} s already; give a later time")
            if (summary["outcome"] == "finished" or is_stopped) and end == request.until:
                sim._end_stop()
                return sim
            if end != request.until:
                request = request.until_later(end)
            sim.run(
                end,
                request.frames,
                samples=request.samples if request.every is None else None,
                every=request.every,
                record=measures,
                stop_when=stop,
                observers=(*observers, results),
                progress=progress,
                checkpoint=request.checkpoint,
            )
    return sim


def _measures(path: Path, request: Request, record: Recorded | None) -> RecordTable:
    """The measures that a run recorded: known ones by their names, and the functions of a user. Raises InputError where
    these are not those that it recorded.
    """
    given, table = Measures(record), record_table(record)
    functions = [name for name in request.record if name not in request.known]
    for name in functions:
        if table.get(name) is None:
            words = ", ".join(f"{show(known)}: ..." for known in functions)
            raise InputError(
                f"{path}: the run records {show(name)}, a function, which no file holds; resume it from Python: "
                f"membrane_rs.resume(folder, record={{{words}}})"
            )
    for name, unit in given.units.items():
        if name in given.known:
            continue  # recorded, or a column that each history has: `_check_known`
        if name not in functions:
            what = "records the known measure of that name" if name in request.known else "does not record it"
            raise InputError(f"record[{show(name)}]: the run in {path} {what}; leave it out")
        if unit != request.record[name]:
            known = f"the run in {path} has it in {request.record[name]!r}"
            raise InputError(f"record[{show(name)}]: is given in {unit!r}, but {known}; give that unit")
    return {name: table.get(name) for name in (*request.record, *given.known)}


def _check_known(path: Path, sim: Simulation, request: Request, measures: RecordTable) -> None:
    """Refuse known measures that are neither recorded nor columns of each history. Raises InputError."""
    for name in HistoryTable(sim, Measures(measures)).measures.units:
        if name not in request.record:
            raise InputError(f"record[{show(name)}]: the run in {path} does not record it; leave it out")


def _stop(path: Path, request: Request, stop_when: StopWhen | None, *, is_stopped: bool) -> Stop | None:
    """What may end a run. Raises InputError where that was a function, which is not given, or is another one."""
    if stop_when is not None:
        stop = Stop(stop_when)
        if stop.table != request.stop:
            what = f"has {_stop_words(request.stop)}" if request.stop else "has none"
            given = f"stop_when = {_stop_words(stop.table)}: the run in {path} {what}"
            raise InputError(f"{given}; give that, or run the scene again")
        return stop
    if request.stop is None or is_stopped:
        return None
    if isinstance(request.stop, str):
        raise InputError(
            f"{path}: the run ends by {_stop_words(request.stop)}, which no file holds; resume it from Python: "
            "membrane_rs.resume(folder, stop_when=...)"
        )
    return Stop(request.stop)


def _stop_words(stop: str | Mapping[str, Any]) -> str:
    """What may end a run, of what a file says of it."""
    if not isinstance(stop, str):
        return Stop(stop).described
    name = stop.removeprefix(Stage.ONLY_IN_PYTHON).rpartition("<locals>.")[2]
    return "a lambda" if name == "<lambda>" else f"the function {show(name)}"
