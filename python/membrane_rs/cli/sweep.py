"""Commands that make many runs of a scene: sweep, ensemble."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from membrane_rs.cli.application import FAILED, MANY_RUNS, Json, command, exit_code, print_json, tell
from membrane_rs.cli.options import (
    Jobs,
    Out,
    SceneArgument,
    Set,
    Until,
    count_option,
    load,
    quantity_option,
    report_audit,
)
from membrane_rs.cli.progress import run_counter

if TYPE_CHECKING:
    from membrane_rs.scene import Scene
    from membrane_rs.study import Sweep
    from membrane_rs.study.common.many_runs import Progress, Where

Vary = Annotated[
    list[str] | None,
    typer.Option(
        "--vary",
        metavar="KEY=VALUES",
        help="Values of the scene: a list (laws.creases.stiffness=1,3,10; run.integrator=rk4,leapfrog), values evenly "
        "spaced (material.thickness=5um:10um:6) or by their logarithms (laws.springs.buckling=10:1000:log5); for "
        "samples a range (10:1000, 10:1000:log). May be given several times.",
    ),
]
Sample = Annotated[
    str, typer.Option(metavar="DESIGN", help="grid: all combinations; lhs:20: a Latin hypercube; sobol:32: Sobol.")
]
Samples = Annotated[int | None, count_option(help="Rows of each history. Default: the scene's.")]
RecordNames = Annotated[
    list[str] | None, typer.Option("--record", metavar="NAME", help="A further measure, such as largest_speed.")
]
Shift = Annotated[
    float | None,
    quantity_option("m", help="Standard deviation of the coordinates of perturbed starts [m]. Default: 1e-12."),
]
TimeLimit = Annotated[
    float | None, quantity_option("s", help="Wall time after which a run is ended [s]. Default: none.")
]
Dask = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="Address of a scheduler of dask, such as tcp://127.0.0.1:8786.")
]
Table = Annotated[
    str | None, typer.Option(metavar="FORMAT", help="parquet or csv. Default: parquet where pyarrow is installed.")
]
Plot = Annotated[
    list[str] | None,
    typer.Option("--plot", metavar="COLUMN", help="A column to draw. Default: those in which runs differ most."),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Remove the runs of another request in the folder.")]
Retry = Annotated[bool, typer.Option("--retry", help="Make runs again that crashed or ran out of time.")]


@command(
    MANY_RUNS,
    example="sweep spinning-tether --vary laws.spin.frequency=1,2,4 --starts 2 --until 10ms --samples 11 --out freq",
)
def sweep(
    scene: SceneArgument,
    *,
    vary: Vary = None,
    set_: Set = None,
    starts: Annotated[int, count_option(help="Runs of each combination: the scene's start and perturbed ones.")] = 1,
    sample: Sample = "grid",
    seed: Annotated[int, count_option(help="Of the samples.")] = 0,
    until: Until = None,
    samples: Samples = None,
    record: RecordNames = None,
    shift: Shift = None,
    time_limit: TimeLimit = None,
    jobs: Jobs = None,
    dask: Dask = None,
    table: Table = None,
    plot: Plot = None,
    out: Out = None,
    overwrite: Overwrite = False,
    retry: Retry = False,
    json: Json = False,
) -> None:
    """Run a scene for combinations of values: one table, one figure, and a row that says what failed and why.

    Ctrl-C stops and keeps the runs that are done; the same command goes on with them.
    """
    from membrane_rs.errors import InputError
    from membrane_rs.study import sweep as study
    from membrane_rs.study.common.vary import split_vary

    varied = split_vary(vary or [])
    if not varied:
        raise InputError(
            "sweep: nothing is varied; give --vary KEY=VALUES, such as --vary laws.creases.stiffness=1,3,10 (starts "
            "alone: membrane-rs ensemble)"
        )
    chosen = load(scene, set_)
    folder = out or Path("runs") / f"{chosen.name}-sweep"

    common = _given(
        until=until, samples=samples, record=record, shift=shift, time_limit=time_limit, jobs=jobs, out=folder,
        table=table, overwrite=overwrite, retry=retry,
    )  # fmt: skip

    def make(executor: Where, progress: Progress) -> Sweep:
        return study(
            chosen, varied, starts=starts, sample=sample, seed=seed, executor=executor, progress=progress, **common
        )

    found = _made(make, chosen, folder, dask)
    say = tell if json else typer.echo
    say(found.summary())
    _draw(lambda: found.plot(plot, path=folder / "sweep.png", title=chosen.name), say)
    _finish(found, folder, say, json=json, scene=chosen)


@command(MANY_RUNS, example="ensemble spinning-tether --starts 3 --until 10ms --samples 11 --out starts")
def ensemble(
    scene: SceneArgument,
    *,
    set_: Set = None,
    starts: Annotated[int, count_option(help="Runs: from the scene's own start, and from perturbed ones.")] = 8,
    until: Until = None,
    samples: Samples = None,
    record: RecordNames = None,
    shift: Shift = None,
    time_limit: TimeLimit = None,
    jobs: Jobs = None,
    dask: Dask = None,
    table: Table = None,
    plot: Plot = None,
    out: Out = None,
    overwrite: Overwrite = False,
    retry: Retry = False,
    json: Json = False,
) -> None:
    """Run a scene from perturbed starts: mean and spread of its curves, as a figure and as tables.

    Ctrl-C stops and keeps the runs that are done; the same command goes on with them.
    """
    from membrane_rs.study import Ensemble
    from membrane_rs.study import ensemble as study

    chosen = load(scene, set_)
    folder = out or Path("runs") / f"{chosen.name}-ensemble"

    common = _given(
        until=until, samples=samples, record=record, shift=shift, time_limit=time_limit, jobs=jobs, out=folder,
        table=table, overwrite=overwrite, retry=retry,
    )  # fmt: skip

    def make(executor: Where, progress: Progress) -> Sweep:
        return study(chosen, starts, executor=executor, progress=progress, **common).runs

    found = Ensemble(_made(make, chosen, folder, dask))
    say = tell if json else typer.echo
    say(found.summary())
    _draw(lambda: found.save(folder, plot, title=chosen.name), say)
    _finish(found.runs, folder, say, json=json, scene=chosen)


def _given(**options: Any) -> dict[str, Any]:
    """What both studies take, as far as it was given."""
    return {name: value for name, value in options.items() if value is not None}


def _made(make: Callable[[Where, Progress], Sweep], scene: Scene, folder: Path, dask: str | None) -> Sweep:
    """The runs, with their progress; where they are interrupted, how to go on with them."""
    from membrane_rs.study.common.kept_runs import count_kept

    report_audit(scene)
    try:
        with run_counter() as progress:
            if dask is None:
                return make("processes", progress)
            with _cluster(dask) as executor:
                return make(executor, progress)
    except KeyboardInterrupt as stop:
        kept = count_kept(folder)
        if not kept:
            raise
        typer.echo(f"Stopped. {kept} runs are kept in {folder}; the same command goes on with them.", err=True)
        raise typer.Exit(exit_code(stop)) from None


@contextmanager
def _cluster(address: str) -> Iterator[Any]:
    """An executor of a scheduler of dask. Raises InputError where there is none."""
    from membrane_rs.study.common.cluster import cluster

    with cluster(address) as executor:
        yield executor


def _draw(draw: Callable[[], Any], say: Callable[[str], None]) -> None:
    """Draw the figure; the table is there, whatever keeps it from being drawn."""
    from membrane_rs.errors import InputError, MissingExtraError

    try:
        draw()
    except (InputError, MissingExtraError) as error:
        say(f"No figure: {error}")


def _finish(found: Sweep, folder: Path, say: Callable[[str], None], *, json: bool, scene: Scene) -> None:
    """Where the results are; an error where no run came to its end."""
    say(f"Results are in {folder}")
    if json:
        print_json({"scene": scene.name, "folder": str(folder), "outcomes": found.outcomes(), "runs": list(found.rows)})
    if len(found.failures()) == len(found.rows):
        raise typer.Exit(FAILED)
