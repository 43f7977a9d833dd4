"""The command line: words to calls, nothing else.

Exit codes: 0 fine; 1 the run failed, or `check` found errors; 2 wrong usage or a wrong scene file;
130 interrupted.
Heavy imports wait inside the commands, so that `--help` is quick.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from rich.console import Console

    from membrane_rs.scene import Scene
    from membrane_rs.simulation import Simulation
    from membrane_rs.study import Ablation, Chart

app = typer.Typer(
    name="membrane-rs",
    help="Simulate the folding, spinning and deployment of thin membranes.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

FAILED, USAGE, INTERRUPTED = 1, 2, 130

SceneArgument = Annotated[str, typer.Argument(metavar="SCENE", help="A built-in scene, or the path of a TOML file.")]
Until = Annotated[float | None, typer.Option(help="Simulated time at the end [s]. Default: the scene's.")]
Integrator = Annotated[str | None, typer.Option(help="Name of the method. Default: the scene's.")]
Dt = Annotated[float | None, typer.Option(help="Step [s]. Default: from the stability limit, or from the tolerance.")]
Tolerance = Annotated[float | None, typer.Option(help="Error of a step that dopri5 chooses. Default: the scene's.")]
ShortSteps = Annotated[
    int | None,
    typer.Option(help="Short steps in a step of leapfrog, for laws that are not slow. Default: the scene's."),
]
Out = Annotated[Path | None, typer.Option(help="Folder of the results. Default: runs/ and the scene's name.")]
Frames = Annotated[int | None, typer.Option(help="Shapes written, evenly spaced. Default: the scene's.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace an earlier run in the same folder.")]
Ensemble = Annotated[int | None, typer.Option(help="Runs from perturbed starts; 0: none. Default: a few, or none.")]
Rows = Annotated[str, typer.Option(help="Rows of cells of a petal, parted by commas: the densities of the mesh.")]
Jobs = Annotated[int | None, typer.Option(help="Runs at once. Default: one on each core.")]
NoPictures = Annotated[bool, typer.Option("--no-pictures", help="Draw nothing at the end.")]


@app.command()
def run(
    scene: SceneArgument,
    *,
    until: Until = None,
    integrator: Integrator = None,
    dt: Dt = None,
    tolerance: Tolerance = None,
    short_steps: ShortSteps = None,
    out: Out = None,
    frames: Frames = None,
    overwrite: Overwrite = False,
    no_pictures: NoPictures = False,
) -> None:
    """Run a scene and write its results into a folder."""
    with _told_errors():
        from membrane_rs.simulation import Simulation

        wanted = {"until": until, "integrator": integrator, "dt": dt, "tolerance": tolerance, "frames": frames}
        wanted["short_steps"] = short_steps
        chosen = _with_settings(_load(scene), wanted)
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
    with _told_errors():
        from membrane_rs.errors import InputError
        from membrane_rs.simulation import Simulation

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
    with _told_errors():
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
    short_steps: ShortSteps = None,
    until: Until = None,
) -> None:
    """Tell what is wrong or risky in a scene, and what its run will cost, before anything runs."""
    with _told_errors():
        from membrane_rs.simulation import Simulation
        from membrane_rs.study.needs import idle_laws, step_savings

        wanted = {"until": until, "integrator": integrator, "dt": dt, "short_steps": short_steps}
        chosen = _with_settings(_load(scene), wanted)
        typer.echo(f"Scene    {chosen.name}")
        for name, count in chosen.counts().items():
            typer.echo(f"  {name:<10} {count:>9,}")
        sound = True
        if chosen.mesh is not None:
            audit = chosen.mesh.audit(chosen.material, springs=chosen.law("triangles") is None)
            sound = audit.ok
            typer.echo(f"\nMesh\n{_indented(str(audit))}")
        idle = idle_laws(chosen)
        if idle:
            typer.echo("\nLaws that cannot matter here; leave them out")
            width = max(len(kind) for kind, _ in idle)
            for kind, why in idle:
                typer.echo(f"  {kind:<{width}}  {why}")
        sim = Simulation(chosen)
        typer.echo(f"\nRun      {chosen.run.until:g} s by {sim.integrator}")
        typer.echo(f"  stable step  {sim.stable_dt():.4g} s, limited by {sim.limiting_part}")
        typer.echo(f"  step         {sim.dt:.4g} s{' at first, then by the tolerance' if sim.is_adaptive else ''}")
        if sim.slow_laws:
            typer.echo(f"  once a step  {', '.join(sim.slow_laws)}; the rest in {chosen.run.short_steps} short steps")
        savings = step_savings(chosen)
        if not savings:
            typer.echo("  saves        nothing: no single part sets the step, others are within 2 % of it")
        for saving in savings:
            typer.echo(
                f"  saves        {saving.part}: without it {saving.limit:.4g} s, {saving.gain:.3g} times as long"
            )
            typer.echo(f"               {saving.advice}")
        _warn_of_step(sim)
        steps, seconds = _expected_cost(sim)
        typer.echo(f"  cost         {steps:,} steps, about {_duration(seconds)} of stepping on this machine")
        if not sound:
            raise typer.Exit(FAILED)


@app.command()
def stability(
    scene: SceneArgument,
    *,
    parameter: Annotated[str, typer.Option(help="A value of the scene, by its name in the scene file.")] = (
        "laws.spring_damping.ratio"
    ),
    values: Annotated[str, typer.Option(help="What it takes, parted by commas.")] = "0,0.02,0.1,0.5,2",
    steps: Annotated[str, typer.Option(help="Shares of the stable step, parted by commas.")] = (
        "0.25,0.5,0.75,0.95,1.05,1.5"
    ),
    integrator: Annotated[str | None, typer.Option(help="Methods, parted by commas. Default: all.")] = None,
    until: Until = None,
    out: Out = None,
) -> None:
    """Map how runs end, step against a parameter: fine, inaccurate, energy injected, blown up."""
    with _told_errors():
        from membrane_rs.study.stability import explicit_integrators, stability_map, write_map

        chosen = _load(scene)
        names = integrator.split(",") if integrator else explicit_integrators(chosen)
        cells = stability_map(
            chosen,
            parameter,
            _numbers(values, "--values"),
            methods=names,
            shares=_numbers(steps, "--steps"),
            until=until,
            progress=lambda cell: typer.echo(
                f"{cell.integrator:<12} {parameter} = {cell.value:<10g} dt = {cell.dt:.4g} s  "
                f"({cell.dt / cell.limit:.2f} of the limit)  {cell.outcome}, t = {cell.time:.4g} s"
            ),
        )
        for path in write_map(cells, parameter, out or Path("runs") / f"{chosen.name}-stability", chosen.name):
            typer.echo(f"Wrote {path}")


def _numbers(text: str, option: str) -> list[float]:
    from membrane_rs.errors import InputError

    try:
        return [float(word) for word in text.split(",")]
    except ValueError:
        raise InputError(f"{option} = {text!r}: must be numbers parted by commas") from None


@app.command()
def chart(
    scene: SceneArgument,
    *,
    integrators: Annotated[str | None, typer.Option(help="Methods, with commas between. Default: all.")] = None,
    until: Until = None,
    steps: Annotated[int, typer.Option(help="Steps below the limit, each half the last; as many tolerances.")] = 6,
    curves: Annotated[
        bool, typer.Option("--curves/--pointwise", help="Compare rate and phase, not positions.")
    ] = False,
    ensemble: Ensemble = None,
    density: Annotated[str, typer.Option(help="Other meshes, such as 0.5,2 times as dense; with --curves.")] = "",
    error: Annotated[float, typer.Option(help="The error to reach at least cost.")] = 1e-3,
    repeats: Annotated[int | None, typer.Option(help="Runs of which the time is the median. Default: 3, or 1.")] = None,
    budget: Annotated[float | None, typer.Option(help="Leave out what takes longer on one core [s].")] = None,
    mesh: Annotated[bool, typer.Option("--mesh", help="Chart the mesh in place of the step: see mesh-study.")] = False,
    rows: Rows = "8,16",
    jobs: Jobs = None,
    out: Out = None,
) -> None:
    """Chart what accuracy costs: each method over a ladder of steps, against a far finer reference."""
    with _told_errors():
        from membrane_rs.study import chart as charted

        if mesh:
            _study_meshes(scene, rows=rows, forms=None, ensemble=ensemble or 0, until=until, jobs=jobs, out=out)
            return

        chosen = _load(scene)
        names = [name.strip() for name in integrators.split(",")] if integrators is not None else None
        meshes = _numbers(density, "--density") if density else []
        found = charted(
            chosen, names, until, steps=steps, curves=curves, members=ensemble, densities=meshes, wanted=error,
            repeats=repeats, budget=budget, jobs=jobs, progress=_tell,
        )  # fmt: skip
        _save(found, out or Path("runs") / f"{chosen.name}-chart")


@app.command()
def ablate(
    scene: SceneArgument,
    *,
    until: Until = None,
    tolerance: Annotated[float, typer.Option(help="Allowed change: of the rate, in turns, of the peaks.")] = 0.01,
    ensemble: Ensemble = None,
    integrator: Integrator = None,
    share: Annotated[float | None, typer.Option(help="Steps as shares of the stability limit.")] = None,
    dense_until: Annotated[float | None, typer.Option(help="End of the run on the denser mesh [s].")] = None,
    jobs: Jobs = None,
    out: Out = None,
) -> None:
    """Leave out each law and part in turn; write the smallest scene that keeps the tolerance."""
    with _told_errors():
        from membrane_rs.study import ablate as ablated

        chosen, members = _load(scene), 5 if ensemble is None else ensemble
        found = ablated(
            chosen, until, tolerance=tolerance, members=members, integrator=integrator, share=share,
            dense_until=dense_until, jobs=jobs, progress=_tell,
        )  # fmt: skip
        _save(found, out or Path("runs") / f"{chosen.name}-ablation")


@app.command("mesh-study")
def mesh_study(
    scene: SceneArgument = "okuizumi-model-1",
    *,
    rows: Rows = "8,16",
    forms: Annotated[str | None, typer.Option(help="Of the parameters, parted by commas. Default: all.")] = None,
    ensemble: Annotated[int, typer.Option(help="Runs from perturbed starts, on each mesh, beside the true one.")] = 0,
    until: Until = None,
    jobs: Jobs = None,
    out: Out = None,
) -> None:
    """Run a square sail at several mesh densities: do its curves approach a limit, and at what rate?"""
    with _told_errors():
        _study_meshes(
            scene,
            rows=rows,
            forms=forms.split(",") if forms else None,
            ensemble=ensemble,
            until=until,
            jobs=jobs,
            out=out,
        )


def _study_meshes(
    scene: str,
    *,
    rows: str,
    forms: list[str] | None,
    ensemble: int,
    until: float | None,
    jobs: int | None,
    out: Path | None,
) -> None:
    from membrane_rs.study import FORMS, jobs_of, write_mesh_study
    from membrane_rs.study import mesh_study as study

    chosen = _load(scene)
    folder = out or Path("runs") / f"{chosen.name}-mesh-study"
    counts = [_whole(number, "--rows") for number in _numbers(rows, "--rows")]
    made = study(
        chosen, jobs_of(counts, forms or list(FORMS), 1 + ensemble, until), folder / "runs", workers=jobs, tell=_tell
    )
    typer.echo(f"{write_mesh_study(made, folder)}\nResults are in {folder}")


def _whole(number: float, option: str) -> int:
    from membrane_rs.errors import InputError

    if not number.is_integer() or number < 1:
        raise InputError(f"{option} = {number:g}: must be whole numbers from 1 on, parted by commas")
    return int(number)


def main() -> None:
    """Entry point of the command `membrane-rs`."""
    try:
        app()
    except KeyboardInterrupt:
        raise SystemExit(INTERRUPTED) from None


def _load(scene: str) -> Scene:
    """A built-in scene by name; a path by its ending or its slash."""
    from membrane_rs import scenes as built_in
    from membrane_rs.scene import Scene

    if scene.endswith(".toml") or "/" in scene or Path(scene).is_file():
        return Scene.from_toml(scene)
    return built_in.load(scene)


def _with_settings(scene: Scene, wanted: dict[str, Any]) -> Scene:
    """The scene with the run settings that were given on the command line."""
    from dataclasses import asdict, replace

    from membrane_rs._validation import build
    from membrane_rs.run_settings import RunSettings

    given = {name: value for name, value in wanted.items() if value is not None}
    return replace(scene, run=build(RunSettings, asdict(scene.run) | given, "run")) if given else scene


def _tell(words: str) -> None:
    """What a study just did; its result goes to the standard output."""
    typer.echo(words, err=True)


def _save(study: Ablation | Chart, folder: Path) -> None:
    study.save(folder)
    typer.echo(f"{study.summary()}\nResults are in {folder}")


def _run(
    sim: Simulation,
    folder: Path,
    overwrite: bool,
    *,
    pictures: bool,
    until: float | None = None,
    frames: int | None = None,
) -> None:
    """Run with a progress bar, and tell where the results are or how to go on."""
    from membrane_rs.output import RunFolder

    console = _console()
    settings = sim.scene.run
    with _progress_bar(console, sim.time, settings.until if until is None else until) as show:
        results = RunFolder(folder, overwrite, pictures=pictures, progress=show.pictures)
        _warn_of_step(sim)
        if settings.settle > 0 and sim.step_count == 0:
            show.settling()
            sim.settle()
        try:
            sim.run(until=until, frames=frames, progress=show.steps, observers=(results,))
        except KeyboardInterrupt:
            show.stop()
            state = folder / "state.npz"
            typer.echo(f"Stopped at {sim.time:.6g} s. What was written so far is in {folder}", err=True)
            if state.is_file() and sim.time < (settings.until if until is None else until):
                typer.echo(f"Continue with: membrane-rs resume {state}", err=True)
            raise typer.Exit(INTERRUPTED) from None
    typer.echo(f"Results are in {folder}")


def _warn_of_step(sim: Simulation) -> None:
    """Say so where the step is above the stability limit: the watch will stop the run, but late."""
    limit = sim.stable_dt()
    if sim.dt > limit:
        text = f"Warning: dt = {sim.dt:.4g} s is above the stability limit of {limit:.4g} s; leave dt out"
        typer.secho(text, fg="yellow", err=True)


class _Bar:
    """What the progress bar shows: simulated time, steps per second, time left; then the pictures."""

    def __init__(self, progress: Any, start: float, end: float) -> None:
        self._progress = progress
        self._start, self._end = start, end
        self._began = self._shown = time.perf_counter()
        self._first_step: int | None = None
        self._task = progress.add_task("", total=end - start, detail="")
        self._pictures_task: Any = None

    def steps(self, sim: Simulation) -> None:
        """Called by the run now and then."""
        now = time.perf_counter()
        if self._first_step is None:
            self._first_step, self._began = sim.step_count, now
        rate = (sim.step_count - self._first_step) / max(now - self._began, 1e-9)
        detail = f"{sim.time:.4f} of {self._end:g} s  {rate:,.0f} steps/s"
        self._progress.update(self._task, completed=sim.time - self._start, detail=detail)

    def pictures(self, what: str, done: int, total: int) -> None:
        """Called by the run's folder for each picture."""
        if self._pictures_task is None:
            self._pictures_task = self._progress.add_task("", total=total, detail=what)
        self._progress.update(self._pictures_task, completed=done, detail=f"{done} of {total} {what}")

    def settling(self) -> None:
        """Say what comes before the run."""
        self._progress.update(self._task, detail="settling")

    def stop(self) -> None:
        """Leave the screen to other words."""
        self._progress.stop()


@contextmanager
def _progress_bar(console: Console, start: float, end: float) -> Iterator[_Bar]:
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    detail = TextColumn("{task.fields[detail]}")
    columns = (BarColumn(bar_width=24), detail, TimeRemainingColumn(), TextColumn("left"))
    with Progress(*columns, console=console, disable=not console.is_terminal) as progress:
        yield _Bar(progress, start, end)


def _expected_cost(sim: Simulation) -> tuple[int, float]:
    """Steps to the end, and the seconds they take, from a few hundred real ones."""
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


def _console() -> Console:
    from rich.console import Console

    return Console(stderr=True)


@contextmanager
def _told_errors() -> Iterator[None]:
    """One red line for what a user can mend; a traceback is for our own mistakes."""
    from membrane_rs.errors import InputError, MembraneError, MissingFileError

    try:
        yield
    except MembraneError as error:
        typer.secho(f"Error: {' '.join(str(error).split())}", fg="red", err=True)
        raise typer.Exit(USAGE if isinstance(error, (InputError, MissingFileError)) else FAILED) from None
    except KeyboardInterrupt:
        typer.echo("Stopped; nothing was written.", err=True)
        raise typer.Exit(INTERRUPTED) from None


if __name__ == "__main__":
    main()
