"""Commands on runs of one scene: run, resume."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from membrane_rs.cli import completion
from membrane_rs.cli.application import (
    FAILED,
    RUNS,
    Json,
    command,
    exit_code,
    in_shell,
    print_json,
    show_error,
    tell,
    warnings_of_run,
)
from membrane_rs.cli.options import (
    Checkpoint,
    Dt,
    Frames,
    Integrator,
    NoPictures,
    Out,
    Overwrite,
    RecordNames,
    Samples,
    SceneArgument,
    Set,
    ShortSteps,
    SpectralRadius,
    Substeps,
    Tolerance,
    Until,
    load,
    path,
    path_option,
    quantity_option,
    report,
    simulation_of,
    substeps_of,
    with_settings,
)
from membrane_rs.cli.progress import Bar, progress_bar, terminal

if TYPE_CHECKING:
    from membrane_rs.runs import Simulation

Every = Annotated[
    float | None, quantity_option("s", help="Time between rows of the history [s], or as 1ms, in place of --samples.")
]
StopWhen = Annotated[
    str | None,
    typer.Option(
        metavar="CONDITION",
        help="End before --until as a measure passes a value: 'deployment_rate > 0.99', 'kinetic_energy < 0.1uJ'.",
    ),
]
NOBODY = dict.fromkeys(("pid", "host", "start"), "unknown")


@command(RUNS, example="run spinning-tether --until 0.01 --frames 5")
def run(
    scene: SceneArgument,
    *,
    set_: Set = None,
    until: Until = None,
    integrator: Integrator = None,
    dt: Dt = None,
    tolerance: Tolerance = None,
    spectral_radius: SpectralRadius = None,
    substeps: Substeps = None,
    short_steps: ShortSteps = None,
    out: Out = None,
    frames: Frames = None,
    samples: Samples = None,
    every: Every = None,
    record: RecordNames = None,
    stop_when: StopWhen = None,
    overwrite: Overwrite = False,
    no_pictures: NoPictures = False,
    despite_errors: Annotated[
        bool, typer.Option("--despite-errors", help="Run although the audit of the scene finds errors.")
    ] = False,
    crossings: Annotated[
        bool,
        typer.Option("--crossings", help="Count triangles that pass through each other at each frame: crossings.csv."),
    ] = False,
    checkpoint: Checkpoint = 10.0,
    json: Json = False,
) -> None:
    """Run a scene and write its results into a folder."""
    from membrane_rs.check import unaccepted_errors

    wanted: dict[str, Any] = {
        "until": until, "integrator": integrator, "dt": dt, "tolerance": tolerance,
        "spectral_radius": spectral_radius, "substeps": substeps_of(substeps, short_steps), "frames": frames,
        "samples": samples,
    }  # fmt: skip
    history = History(samples, every, record, stop_when)
    loaded = load(scene, set_)
    end = wanted.pop("until") if loaded.stages else None
    chosen = with_settings(loaded, wanted)
    folder = out or Path("runs") / chosen.name
    sim = simulation_of(chosen)
    with _reported(folder, json=json):
        if unaccepted_errors(chosen) and not despite_errors:
            _refuse(sim, folder, overwrite)
        _run(
            sim, folder, overwrite, pictures=not no_pictures, crossings=crossings, until=end, frames=frames,
            checkpoint=checkpoint, history=history,
        )  # fmt: skip


@command(RUNS, example="run spinning-tether --until 0.01 --no-pictures\nresume runs/spinning-tether --until 0.02")
def resume(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="SOURCE",
            help="A run's folder, or a saved state, such as its state.npz.",
            autocompletion=completion.runs,
            parser=path,
        ),
    ],
    *,
    until: Annotated[
        float | None, quantity_option("s", help="Simulated time at the end [s], or as 20ms. Default: the run's.")
    ] = None,
    out: Annotated[
        Path | None, path_option(help="Folder of a run from a saved state. Default: beside its own, FOLDER-continued.")
    ] = None,
    frames: Frames = None,
    samples: Samples = None,
    every: Every = None,
    record: RecordNames = None,
    stop_when: StopWhen = None,
    overwrite: Overwrite = False,
    no_pictures: NoPictures = False,
    json: Json = False,
    set_: Annotated[list[str] | None, typer.Option("--set", hidden=True, help="Is refused, with the reason.")] = None,
) -> None:
    """Continue a run in its folder; or a saved state, into a folder of its own."""
    from membrane_rs.errors import InputError
    from membrane_rs.results.summary import folder_of_run
    from membrane_rs.runs import Simulation

    if set_:
        raise InputError(
            f"--set {set_[0]}: a run is continued under the scene that it began with; leave it out. Another scene goes "
            "on from a saved state in Python: Simulation(scene.with_values(...), start=STATE)"
        )
    source = folder_of_run(source)
    if source.is_dir():
        fixed = {"--out": out, "--frames": frames, "--samples": samples, "--every": every, "--record": record,
                 "--stop-when": stop_when, "--overwrite": overwrite or None}  # fmt: skip
        for option, value in fixed.items():
            if value not in (None, []):
                raise InputError(
                    f"{option}: a run is continued in its own folder as it was asked for; leave it out, or name its "
                    "state.npz"
                )
        with _reported(source, json=json):
            _resume(source, until, no_pictures=no_pictures)
        return
    history = History(samples, every, record, stop_when)
    sim = Simulation.restore(source)
    report(sim.audit())
    end = sim.planned_end if until is None else until
    if end <= sim.time:
        raise InputError(f"--until = {end}: the state is at {sim.time:.6g} s already; give a later time (s)")
    folder = out or source.parent.with_name(f"{source.parent.resolve().name}-continued")
    with _reported(folder, json=json):
        _run(sim, folder, overwrite, pictures=not no_pictures, until=end, frames=frames, history=history)


def _refuse(sim: Simulation, folder: Path, overwrite: bool) -> None:
    """End without a step, for the errors of the audit; the summary in the folder holds them."""
    from membrane_rs.errors import SceneError
    from membrane_rs.runs import RunFolder

    reason = "the audit found errors; mend them, or run all the same with --despite-errors"
    results = RunFolder(folder, overwrite, pictures=False)
    results.start(sim)
    results.finish(sim, SceneError(reason))
    show_error(reason)
    raise typer.Exit(FAILED)


def _run(
    sim: Simulation,
    folder: Path,
    overwrite: bool,
    *,
    pictures: bool,
    crossings: bool = False,
    until: float | None = None,
    frames: int | None = None,
    checkpoint: float = 10.0,
    history: History,
) -> None:
    """Run with a progress bar; say how to continue where it is stopped."""
    from membrane_rs.runs import RunFolder

    console = terminal()
    settings = sim.scene.run
    with progress_bar(console, sim.time, sim.planned_end if until is None else until) as show, _stopped(show, folder):
        results = RunFolder(folder, overwrite, pictures=pictures, crossings=crossings, progress=show.pictures)
        if settings.relax > 0 and sim.time == 0.0 and not sim.is_relaxed:
            show.relaxing()
        with warnings_of_run():
            sim.run(until, frames, progress=show.steps, observers=(results,), checkpoint=checkpoint, **vars(history))


class History:
    """Which rows and columns the history of a run has, and what may end it: options of `run` and `resume`."""

    def __init__(self, samples: int | None, every: float | None, record: list[str] | None, stop: str | None) -> None:
        from membrane_rs.errors import InputError

        if samples is not None and every is not None:
            raise InputError(f"--every {every:g}: --samples {samples} is given too; leave one of them out")
        self.samples, self.every, self.record, self.stop_when = samples, every, record, stop


@contextmanager
def _reported(folder: Path, *, json: bool) -> Iterator[None]:
    """Report the folder of the results; or the summary there, also of a run that has failed or was interrupted."""
    from membrane_rs.errors import UnstableError
    from membrane_rs.results import read_summary

    try:
        yield
    except (UnstableError, typer.Exit):
        if json:
            print_json({"folder": str(folder), **read_summary(folder)})
        raise
    if json:
        print_json({"folder": str(folder), **read_summary(folder)})
    else:
        word = in_shell(folder)
        typer.echo(f"Results are in {folder}\n")
        typer.echo(f"  membrane-rs view {word}      # its motion, in a window")
        typer.echo(f"  membrane-rs report {word}    # a page: motion, curves, energy balance, audit")


def _resume(folder: Path, until: float | None, *, no_pictures: bool) -> None:
    """Continue a run in its folder with a progress bar; report what was there."""
    from membrane_rs.results import read_summary
    from membrane_rs.runs import resume

    before = read_summary(folder)
    come = before.get("time", before.get("start_time", 0.0))
    is_over = before["outcome"] == "finished" or bool(before.get("stopped"))
    if is_over and (until is None or until <= come):
        tell(f"The run in {folder} is finished, at {come:.6g} s; nothing is left to do. Go on with --until.")
        return
    process = "process {pid} on {host}, since {start}".format(**NOBODY | before.get("process", {}))
    tell(f"{folder}: {before['outcome']} ({process}); its last checkpoint is at {come:.6g} s")
    end = before.get("request", {}).get("until", come) if until is None else until
    with progress_bar(terminal(), come, end) as show, _stopped(show, folder), warnings_of_run():
        resume(folder, until, pictures=False if no_pictures else None, progress=show.steps, drawing=show.pictures)


@contextmanager
def _stopped(show: Bar, folder: Path) -> Iterator[None]:
    """Say where the results of a run are that a signal ends, and how to continue it."""
    try:
        yield
    except KeyboardInterrupt as stop:
        from membrane_rs.results import read_summary

        show.stop()
        summary = read_summary(folder) if (folder / "summary.json").is_file() else {}
        if summary.get("process", {}).get("pid") != os.getpid():
            raise  # nothing was written yet
        typer.echo(f"Stopped at {summary.get('time', 0.0):.6g} s. The results so far are in {folder}", err=True)
        if summary["outcome"] != "finished":
            typer.echo(f"Continue with: membrane-rs resume {in_shell(folder)}", err=True)
        raise typer.Exit(exit_code(stop)) from None
