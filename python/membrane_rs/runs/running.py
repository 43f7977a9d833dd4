"""A scene is run, and what it has shown is given back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from membrane_rs import scenes
from membrane_rs._validation import flags_of
from membrane_rs.errors import Interrupted, MembraneError
from membrane_rs.results.recorded import Recorded
from membrane_rs.runs.memory import RunMemory
from membrane_rs.runs.opening import open_run
from membrane_rs.runs.request import CHECKPOINT
from membrane_rs.runs.result import Run
from membrane_rs.runs.run_folder import RunFolder
from membrane_rs.runs.simulation import Simulation
from membrane_rs.scene import Scene
from membrane_rs.simulation.motion import Motion
from membrane_rs.simulation.observer import Observer
from membrane_rs.simulation.stopping import StopWhen


def run(
    scene: Scene | str | Path,
    until: float | None = None,
    *,
    integrator: str | None = None,
    dt: float | None = None,
    start: Motion | str | Path | None = None,
    record: Recorded | None = None,
    every: float | None = None,
    samples: int | Sequence[float] | None = None,
    frames: int | Sequence[float] | None = None,
    stop_when: StopWhen | None = None,
    out: str | Path | None = None,
    overwrite: bool = False,
    pictures: bool = True,
    crossings: bool = False,
    checkpoint: float = CHECKPOINT,
    observers: Sequence[Observer[Simulation]] = (),
    progress: Callable[[Simulation], None] | None = None,
) -> Run:
    """Run a scene, and give back its history, frames and summary.

    Parameters
    ----------
    scene : Scene, str or path
        A scene, the name of a built-in one, or the path of a scene file.
    until : float, optional
        Time at the end [s]. Default: the scene's; with stages the end of the last one, at the latest.
    integrator : str, optional
        Name of the method, one of `membrane_rs.integrators()`. Default: the scene's.
    dt : float, optional
        Step [s]. Default: as for `Simulation`.
    start : Simulation or path, optional
        Whose motion it goes on from: another simulation, or a saved state. Default: the scene's own start.
    record : sequence of str, or mapping of str to callable, (callable, str) or None, optional
        Measures: names of those of `Stage`, such as "largest_speed"; or by the name of a column a function of the
        simulation that gives a number and only reads, that and the unit of the number, such as "N m", or None for a
        measure of `Stage`.
    every : float, optional
        Time between two rows of the history [s], in place of `samples`. Evenly spaced frames are then at the nearest
        rows, and snapshots of the scene at the next.
    samples : int or sequence of float, optional
        Rows of the history, evenly spaced from time 0 to the end, or their times [s]; each frame is one too. Default:
        the scene's.
    frames : int or sequence of float, optional
        How many shapes to keep, evenly spaced, or their times [s]. Default: the scene's.
    stop_when : callable, str or mapping, optional
        What ends the run before its time: a function of the simulation that gives a truth value, or a number that
        passes zero; or a measure of `Stage` and a value, as "kinetic_energy < 0.1 uJ" or as
        {"measure": name, "above": value}, or "below". The time is found as
        the end of a stage is, whatever the step.
    out : path, optional
        Folder of the results; see `membrane_rs.runs.RunFolder`. Default: all stays in memory.
    overwrite, pictures, crossings : bool
        For the folder: replace an earlier run; draw pictures at the end; count the triangles that pass through each
        other at each frame.
    checkpoint : float
        For the folder: seconds of wall time between two checkpoints [s].
    observers : sequence of observers, optional
        Further ones, see `membrane_rs.simulation.Observer`.
    progress : callable, optional
        Called with the simulation at each output, and about every 0.1 s of wall time.

    Returns
    -------
    Run
        What it has shown.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range or of a wrong type, a measure that gives no number, an option that has no effect.
    SceneError, MissingFileError
        No scene of that name, no such file, or a scene file that is wrong.
    UnstableError
        The run stopped itself; `run` of the error is what was recorded by then.
    Interrupted
        Ctrl-C or another signal; `run` of it likewise.
    OutputError
        The folder holds another run, or cannot be written.
    MissingExtraError
        Pictures are to be drawn, and the extra "plot" is not installed.

    Examples
    --------
    >>> import membrane_rs
    >>> made = membrane_rs.run(
    ...     "spinning-tether",
    ...     until=0.02,
    ...     frames=3,
    ...     every=0.005,
    ...     record={"tension": (lambda sim: sim.cord_tensions().max(), "N")},
    ... )
    >>> made.outcome, made.history["time"].tolist()
    ('finished', [0.0, 0.005, 0.01, 0.015, 0.02])
    >>> made.history["tension"].shape, made.history.units["tension"], made.frames[-1].positions.shape
    ((5,), 'N', (11, 3))
    >>> made = membrane_rs.run("spinning-tether", until=0.02, record=["largest_speed"], stop_when="hub_angle > 9 deg")
    >>> made.outcome[:31], made.history.units["largest_speed"]
    ('stopped: hub_angle above 0.1570', 'm/s')
    """
    overwrite, pictures, crossings = flags_of(overwrite=overwrite, pictures=pictures, crossings=crossings)
    sim = Simulation(scenes.scene_of(scene), integrator, dt, start=start)
    recorder = RunMemory() if out is None else RunFolder(out, overwrite, pictures=pictures, crossings=crossings)
    try:
        sim.run(
            until,
            frames,
            samples=samples,
            record=record,
            every=every,
            stop_when=stop_when,
            observers=[*observers, recorder] if isinstance(observers, Sequence) else observers,
            progress=progress,
            overwrite=overwrite and out is None,  # refused there
            pictures=pictures,
            crossings=crossings and out is None,
            checkpoint=checkpoint,
        )
    except BaseException as error:
        _keep(error, recorder)
        raise
    result = recorder.result() if isinstance(recorder, RunMemory) else open_run(recorder.path)
    assert result is not None, "a run that has ended without an error has a result"
    return result


def _keep(error: BaseException, recorder: RunMemory | RunFolder) -> None:
    """Give an error what the run had recorded by then."""
    with suppress(MembraneError):  # the run's own error is the one to tell
        found: Run | None = None
        if isinstance(recorder, RunMemory):
            found = recorder.result()
        elif recorder.has_begun:
            found = open_run(recorder.path)
        if found is not None and isinstance(error, MembraneError | Interrupted):
            error.run = found
