"""Commands on one scene: run, resume, check; and the list of built-in scenes."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from membrane_rs.cli.application import FAILED, INTERRUPTED, app, reported_errors
from membrane_rs.cli.options import (
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
    substeps_of,
    with_settings,
)
from membrane_rs.cli.progress import progress_bar, terminal

if TYPE_CHECKING:
    from membrane_rs.runs import Simulation


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
) -> None:
    """Run a scene and write its results into a folder."""
    with reported_errors():
        from membrane_rs.runs import Simulation

        wanted = {
            "until": until, "integrator": integrator, "dt": dt, "tolerance": tolerance,
            "spectral_radius": spectral_radius, "substeps": substeps_of(substeps, short_steps), "frames": frames,
        }  # fmt: skip
        chosen = with_settings(load(scene), wanted)
        folder = out or Path("runs") / chosen.name
        _run(Simulation(chosen), folder, overwrite, pictures=not no_pictures)


@app.command()
def resume(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A saved state, such as state.npz in a run's folder.")],
    *,
    until: Until = None,
    out: Out = None,
    frames: Frames = None,
    overwrite: Overwrite = False,
    no_pictures: NoPictures = False,
) -> None:
    """Continue a saved state to the end, into a folder of its own."""
    with reported_errors():
        from membrane_rs.errors import InputError
        from membrane_rs.runs import Simulation

        sim = Simulation.restore(file)
        settings = sim.scene.run
        end = settings.until if until is None else until
        if end <= sim.time:
            raise InputError(f"--until = {end}: the state is at {sim.time:.6g} s already; give a later time (s)")
        folder = out or file.parent.with_name(f"{file.parent.resolve().name}-continued")
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
        from membrane_rs.check.redundancy import idle_laws, step_savings
        from membrane_rs.check.step_accuracy import step_accuracy
        from membrane_rs.runs import Simulation

        wanted = {"until": until, "integrator": integrator, "dt": dt, "substeps": substeps_of(substeps, short_steps)}
        chosen = with_settings(load(scene), wanted)
        typer.echo(f"Scene    {chosen.name}")
        for name, count in chosen.counts().items():
            typer.echo(f"  {name:<10} {count:>9,}")
        sound = True
        if chosen.mesh is not None:
            audit = chosen.mesh.audit(chosen.material, springs=chosen.negative_springs != "unused")
            sound = audit.ok
            typer.echo(f"\nMesh\n{_indented(str(audit))}")
        idle = idle_laws(chosen)
        if idle:
            typer.echo("\nLaws without effect in this scene; leave them out")
            width = max(len(kind) for kind, _ in idle)
            for kind, why in idle:
                typer.echo(f"  {kind:<{width}}  {why}")
        sim = Simulation(chosen)
        typer.echo(f"\nRun      {chosen.run.until:g} s by {sim.integrator}")
        typer.echo(f"  stable step  {sim.stable_dt():.4g} s, limited by {sim.limiting_part}")
        typer.echo(f"  step         {sim.dt:.4g} s{', later chosen by the tolerance' if sim.is_adaptive else ''}")
        if sim.slow_laws:
            typer.echo(f"  once a step  {', '.join(sim.slow_laws)}; the others in {chosen.run.substeps} substeps")
        shares = ", ".join(f"{law} {100 * share:.0f} %" for law, share in sim.contiguous_shares.items())
        typer.echo(f"  contiguous   {shares or 'none'} (share of elements in contiguous batches, the fast ones)")
        savings = step_savings(chosen)
        if not savings:
            typer.echo("  savings      none: no single part sets the step, others are within 2 % of it")
        for saving in savings:
            typer.echo(
                f"  savings      {saving.part}: without it {saving.limit:.4g} s, {saving.gain:.3g} times as long"
            )
            typer.echo(f"               {saving.advice}")
        _warn_of_step(sim)
        if warning := step_accuracy(chosen).warning():
            typer.secho(warning, fg="yellow", err=True)
        steps, seconds = _expected_cost(sim)
        typer.echo(f"  cost         {steps:,} steps, about {_duration(seconds)} on this machine")
        if not sound:
            raise typer.Exit(FAILED)


def _run(
    sim: Simulation,
    folder: Path,
    overwrite: bool,
    *,
    pictures: bool,
    until: float | None = None,
    frames: int | None = None,
) -> None:
    """Run with a progress bar; report the folder of the results, or how to continue."""
    from membrane_rs.runs import RunFolder

    console = terminal()
    settings = sim.scene.run
    with progress_bar(console, sim.time, settings.until if until is None else until) as show:
        results = RunFolder(folder, overwrite, pictures=pictures, progress=show.pictures)
        _warn_of_step(sim)
        if settings.relax > 0 and sim.time == 0.0 and not sim.is_relaxed:
            show.relaxing()
            sim.relax()
        try:
            sim.run(until=until, frames=frames, progress=show.steps, observers=(results,))
        except KeyboardInterrupt:
            show.stop()
            state = folder / "state.npz"
            typer.echo(f"Stopped at {sim.time:.6g} s. The results so far are in {folder}", err=True)
            if state.is_file() and sim.time < (settings.until if until is None else until):
                typer.echo(f"Continue with: membrane-rs resume {state}", err=True)
            raise typer.Exit(INTERRUPTED) from None
    typer.echo(f"Results are in {folder}")


def _warn_of_step(sim: Simulation) -> None:
    """Warn of a step above the stability limit: the monitor stops such a run, but only later."""
    limit = sim.stable_dt()
    if sim.dt > limit:
        text = f"Warning: dt = {sim.dt:.4g} s is above the stability limit of {limit:.4g} s; leave dt out"
        typer.secho(text, fg="yellow", err=True)


def _expected_cost(sim: Simulation) -> tuple[int, float]:
    """Number of steps to the end, and their time [s], extrapolated from a few hundred steps."""
    steps = max(1, round(sim.scene.run.until / sim.dt))
    taken, began, spent = 0, time.perf_counter(), 0.0
    while taken < min(steps, 300) and spent < 2.0:
        batch = min(20, steps - taken)
        sim.step(batch)
        taken += batch
        spent = time.perf_counter() - began
    if sim.is_adaptive:
        steps = max(1, round(sim.scene.run.until / sim.time * taken))
    return steps, steps * spent / taken


def _duration(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.3g} s"
    return f"{seconds / 60:.3g} min" if seconds < 5400 else f"{seconds / 3600:.3g} h"


def _indented(text: str) -> str:
    return "\n".join(f"  {line}" for line in text.splitlines())
