"""Commands on one scene: run, resume, check; and the list of built-in scenes."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from membrane_rs.cli.application import FAILED, app, exit_code, reported_errors, warnings_of_run
from membrane_rs.cli.options import (
    Checkpoint,
    Dt,
    Frames,
    Integrator,
    NoPictures,
    Out,
    Overwrite,
    SceneArgument,
    ShortSteps,
    SpectralRadius,
    Substeps,
    Tolerance,
    Until,
    load,
    report,
    simulation_of,
    substeps_of,
    with_settings,
)
from membrane_rs.cli.progress import Bar, progress_bar, terminal

if TYPE_CHECKING:
    from membrane_rs.runs import Simulation
    from membrane_rs.scene import Scene

NOBODY = dict.fromkeys(("pid", "host", "start"), "unknown")


@app.command()
def run(
    scene: SceneArgument,
    *,
    until: Until = None,
    integrator: Integrator = None,
    dt: Dt = None,
    tolerance: Tolerance = None,
    spectral_radius: SpectralRadius = None,
    substeps: Substeps = None,
    short_steps: ShortSteps = None,
    out: Out = None,
    frames: Frames = None,
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
) -> None:
    """Run a scene and write its results into a folder."""
    with reported_errors():
        from membrane_rs.check import unaccepted_errors

        wanted: dict[str, Any] = {
            "until": until, "integrator": integrator, "dt": dt, "tolerance": tolerance,
            "spectral_radius": spectral_radius, "substeps": substeps_of(substeps, short_steps), "frames": frames,
        }  # fmt: skip
        loaded = load(scene)
        end = wanted.pop("until") if loaded.stages else None
        chosen = with_settings(loaded, wanted)
        folder = out or Path("runs") / chosen.name
        sim = simulation_of(chosen)
        if unaccepted_errors(chosen) and not despite_errors:
            _refuse(sim, folder, overwrite)
        _run(sim, folder, overwrite, pictures=not no_pictures, crossings=crossings, until=end, checkpoint=checkpoint)


@app.command()
def resume(
    source: Annotated[
        Path, typer.Argument(metavar="SOURCE", help="A run's folder, or a saved state, such as its state.npz.")
    ],
    *,
    until: Until = None,
    out: Out = None,
    frames: Frames = None,
    overwrite: Overwrite = False,
    no_pictures: NoPictures = False,
) -> None:
    """Continue a run in its folder; or a saved state, into a folder of its own."""
    with reported_errors():
        from membrane_rs.errors import InputError
        from membrane_rs.results.summary import folder_of_run
        from membrane_rs.runs import Simulation

        source = folder_of_run(source)
        if source.is_dir():
            for option, value in (("--out", out), ("--frames", frames), ("--overwrite", overwrite or None)):
                if value is not None:
                    raise InputError(f"{option}: a run is continued in its own folder; leave it out, or name a state")
            _resume(source, until, no_pictures=no_pictures)
            return
        sim = Simulation.restore(source)
        report(sim.audit())
        end = sim.planned_end if until is None else until
        if end <= sim.time:
            raise InputError(f"--until = {end}: the state is at {sim.time:.6g} s already; give a later time (s)")
        folder = out or source.parent.with_name(f"{source.parent.resolve().name}-continued")
        _run(sim, folder, overwrite, pictures=not no_pictures, until=end, frames=frames)


@app.command()
def scenes() -> None:
    """List the built-in scenes."""
    with reported_errors():
        from membrane_rs import scenes as built_in

        names = built_in.names()
        width = max(map(len, names))
        for name in names:
            typer.echo(f"{name:<{width}}  {built_in.describe(name)}")


@app.command()
def check(
    scene: SceneArgument,
    *,
    integrator: Integrator = None,
    dt: Dt = None,
    substeps: Substeps = None,
    short_steps: ShortSteps = None,
    until: Until = None,
) -> None:
    """Report faults and risks of a scene, the stability limit and the expected cost, without running it."""
    with reported_errors():
        from membrane_rs.check import audit, facts
        from membrane_rs.errors import InputError
        from membrane_rs.scene.staging import planned_starts

        wanted: dict[str, Any] = {
            "until": until, "integrator": integrator, "dt": dt, "substeps": substeps_of(substeps, short_steps),
        }  # fmt: skip
        chosen = load(scene)
        end = wanted.pop("until") if chosen.stages else None
        if end is not None and not 0.0 < end <= chosen.run.until:
            most = chosen.run.until
            raise InputError(f"--until = {end}: must be above 0, and at most {most:g}, where the stages end (s)")
        chosen = with_settings(chosen, wanted)
        typer.echo(f"Scene    {chosen.name}")
        for name, count in chosen.counts().items():
            typer.echo(f"  {name:<10} {count:>9,}")
        for name, words in facts(chosen).items():
            typer.echo(f"  {name:<10} {words}")
        found = audit(chosen)
        typer.echo(f"\nAudit\n{_indented(str(found))}")
        for k, (stage, start) in enumerate(zip(chosen.stages, planned_starts(chosen.stages), strict=False)):
            duration = stage.duration if end is None else min(stage.duration, end - start)
            if duration <= 0.0:
                break
            latest = "at most " if stage.measure is not None else ""
            typer.echo(f"\nStage    {stage.name}, {latest}{duration:g} s")
            _report_run(chosen.staged(k), duration, is_later=k > 0)
        if not chosen.stages:
            typer.echo("")
            _report_run(chosen, chosen.run.until)
        if not found.ok:
            raise typer.Exit(FAILED)


def _report_run(scene: Scene, duration: float, *, is_later: bool = False) -> None:
    """Step and cost of a scene without stages, or of one of its stages, for so long [s]."""
    from membrane_rs.check.redundancy import step_savings
    from membrane_rs.runs import Simulation

    sim = Simulation(scene)
    typer.echo(f"Run      {duration:g} s by {sim.integrator}")
    typer.echo(f"  stable step  {sim.stable_dt():.4g} s, limited by {sim.limiting_part}")
    typer.echo(f"  step         {sim.dt:.4g} s{', later chosen by the tolerance' if sim.is_adaptive else ''}")
    if sim.slow_laws:
        typer.echo(f"  once a step  {', '.join(sim.slow_laws)}; the others in {scene.run.substeps} substeps")
    shares = ", ".join(f"{law} {100 * share:.0f} %" for law, share in sim.contiguous_shares.items())
    typer.echo(f"  contiguous   {shares or 'none'} (share of elements in contiguous batches, the fast ones)")
    savings = step_savings(scene)
    if not savings:
        typer.echo("  savings      none: no single part sets the step, others are within 2 % of it")
    for saving in savings:
        typer.echo(f"  savings      {saving.part}: without it {saving.limit:.4g} s, {saving.gain:.3g} times as long")
        typer.echo(f"               {saving.advice}")
    sim._check_end(duration)
    steps, seconds = _expected_cost(sim, duration, is_later=is_later)
    cost = "in a time that only a run shows" if seconds is None else f"about {_duration(seconds)} on this machine"
    typer.echo(f"  cost         {steps:,} steps, {cost}")


def _refuse(sim: Simulation, folder: Path, overwrite: bool) -> None:
    """End without a step, for the errors of the audit; the summary in the folder holds them."""
    from membrane_rs.errors import SceneError
    from membrane_rs.runs import RunFolder

    reason = "the audit found errors; mend them, or run all the same with --despite-errors"
    results = RunFolder(folder, overwrite, pictures=False)
    results.start(sim)
    results.finish(sim, SceneError(reason))
    typer.secho(f"Error: {reason}", fg="red", err=True)
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
) -> None:
    """Run with a progress bar; report the folder of the results, or how to continue."""
    from membrane_rs.runs import RunFolder

    console = terminal()
    settings = sim.scene.run
    with progress_bar(console, sim.time, sim.planned_end if until is None else until) as show, _stopped(show, folder):
        results = RunFolder(folder, overwrite, pictures=pictures, crossings=crossings, progress=show.pictures)
        if settings.relax > 0 and sim.time == 0.0 and not sim.is_relaxed:
            show.relaxing()
        with warnings_of_run():
            sim.run(until, frames, progress=show.steps, observers=(results,), checkpoint=checkpoint)
    typer.echo(f"Results are in {folder}")


def _resume(folder: Path, until: float | None, *, no_pictures: bool) -> None:
    """Continue a run in its folder with a progress bar; report what was there, and the results."""
    from membrane_rs.results import read_summary
    from membrane_rs.runs import resume

    before = read_summary(folder)
    come = before.get("time", before.get("start_time", 0.0))
    if before["outcome"] == "finished" and (until is None or until <= come):
        typer.echo(f"The run in {folder} is finished, at {come:.6g} s; nothing is left to do. Go on with --until.")
        return
    process = "process {pid} on {host}, since {start}".format(**NOBODY | before.get("process", {}))
    typer.echo(f"{folder}: {before['outcome']} ({process}); its last checkpoint is at {come:.6g} s", err=True)
    end = before.get("request", {}).get("until", come) if until is None else until
    with progress_bar(terminal(), come, end) as show, _stopped(show, folder), warnings_of_run():
        resume(folder, until, pictures=False if no_pictures else None, progress=show.steps, drawing=show.pictures)
    typer.echo(f"Results are in {folder}")


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
            typer.echo(f"Continue with: membrane-rs resume {folder}", err=True)
        raise typer.Exit(exit_code(stop)) from None


def _expected_cost(sim: Simulation, duration: float, *, is_later: bool) -> tuple[int, float | None]:
    """Number of steps in so long [s], and their time [s], extrapolated from a few hundred steps.

    A later stage begins elsewhere than the scene, from where it is stepped here, and may become unstable there; None
    where it is so at once.
    """
    from membrane_rs.errors import UnstableError

    steps = max(1, round(duration / sim.dt))
    taken, began, spent = 0, time.perf_counter(), 0.0
    while taken < min(steps, 300) and spent < 2.0:
        batch = min(20, steps - taken)
        try:
            sim.step(batch)
        except UnstableError:
            if not is_later:
                raise
            break
        taken += batch
        spent = time.perf_counter() - began
    if sim.is_adaptive and taken:
        steps = max(1, round(duration / sim.time * taken))
    return steps, steps * spent / taken if taken else None


def _duration(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.3g} s"
    return f"{seconds / 60:.3g} min" if seconds < 5400 else f"{seconds / 3600:.3g} h"


def _indented(text: str) -> str:
    return "\n".join(f"  {line}" for line in text.splitlines())
