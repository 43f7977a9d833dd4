"""Commands that make many runs of a scene: sweep, ensemble."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typing_extensions import Unpack

from membrane_rs.cli import completion
from membrane_rs.cli.application import FAILED, MANY_RUNS, Json, command, print_json, tell
from membrane_rs.cli.many_runs import RunOptions, make_runs, takes_run_options
from membrane_rs.cli.options import SceneArgument, Set, count_option, load

if TYPE_CHECKING:
    from membrane_rs.scene import Scene
    from membrane_rs.study import Sweep

Vary = Annotated[
    list[str] | None,
    typer.Option(
        "--vary",
        metavar="KEY=VALUES",
        autocompletion=completion.keys,
        help="Values of the scene: a list (laws.creases.stiffness=1,3,10; run.integrator=rk4,leapfrog), values evenly "
        "spaced (material.thickness=5um:10um:6) or by their logarithms (laws.springs.buckling=10:1000:log5); for "
        "samples a range (10:1000, 10:1000:log). May be given several times.",
    ),
]
Sample = Annotated[
    str, typer.Option(metavar="DESIGN", help="grid: all combinations; lhs:20: a Latin hypercube; sobol:32: Sobol.")
]
Table = Annotated[
    str | None, typer.Option(metavar="FORMAT", help="parquet or csv. Default: parquet where pyarrow is installed.")
]
Plot = Annotated[
    list[str] | None,
    typer.Option("--plot", metavar="COLUMN", help="A column to draw. Default: those in which runs differ most."),
]


@command(
    MANY_RUNS,
    example="sweep spinning-tether --vary laws.spin.frequency=1,2,4 --starts 2 --until 10ms --samples 11 --out freq",
)
@takes_run_options
def sweep(
    scene: SceneArgument,
    *,
    vary: Vary = None,
    set_: Set = None,
    starts: Annotated[int, count_option(help="Runs of each combination: the scene's start and perturbed ones.")] = 1,
    sample: Sample = "grid",
    seed: Annotated[int, count_option(help="Of the samples.")] = 0,
    table: Table = None,
    plot: Plot = None,
    json: Json = False,
    **options: Unpack[RunOptions],
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
    asked = partial(study, vary=varied, starts=starts, sample=sample, seed=seed, table=table)
    found, folder = make_runs(asked, chosen, "sweep", options)
    say = tell if json else typer.echo
    say(found.summary())
    _draw(lambda: found.plot(plot, path=folder / "sweep.png", title=chosen.name), say)
    _finish(found, folder, say, json=json, scene=chosen)


@command(MANY_RUNS, example="ensemble spinning-tether --starts 3 --until 10ms --samples 11 --out starts")
@takes_run_options
def ensemble(
    scene: SceneArgument,
    *,
    set_: Set = None,
    starts: Annotated[int, count_option(help="Runs: from the scene's own start, and from perturbed ones.")] = 8,
    table: Table = None,
    plot: Plot = None,
    json: Json = False,
    **options: Unpack[RunOptions],
) -> None:
    """Run a scene from perturbed starts: mean and spread of its curves, as a figure and as tables.

    Ctrl-C stops and keeps the runs that are done; the same command goes on with them.
    """
    from membrane_rs.study import ensemble as study

    chosen = load(scene, set_)
    found, folder = make_runs(partial(study, starts=starts, table=table), chosen, "ensemble", options)
    say = tell if json else typer.echo
    say(found.summary())
    _draw(lambda: found.save(folder, plot, title=chosen.name), say)
    _finish(found.runs, folder, say, json=json, scene=chosen)


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
