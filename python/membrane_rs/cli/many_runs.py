"""What the commands that make many runs of a scene share: their options, progress, and what an interrupt leaves."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypedDict, TypeVar, get_args, get_type_hints

import typer

from membrane_rs.cli.application import exit_code
from membrane_rs.cli.options import Jobs, Out, RecordNames, Until, count_option, quantity_option, report_audit
from membrane_rs.cli.progress import run_counter

if TYPE_CHECKING:
    from membrane_rs.scene import Scene
    from membrane_rs.study.common.many_runs import Where

Study = TypeVar("Study")


HERE: Where = "processes"
"""Where the runs of a command are made without a cluster: a process that dies ends its own run alone."""
Samples = Annotated[int | None, count_option(help="Rows of each history. Default: the scene's.")]
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
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Remove the runs of another request in the folder.")]
Retry = Annotated[bool, typer.Option("--retry", help="Make runs again that crashed or ran out of time.")]


class RunOptions(TypedDict):
    """Options of all commands of many runs."""

    until: Until
    samples: Samples
    record: RecordNames
    shift: Shift
    time_limit: TimeLimit
    jobs: Jobs
    dask: Dask
    out: Out
    overwrite: Overwrite
    retry: Retry


def takes_run_options(function: Callable[..., None]) -> Callable[..., None]:
    """A command with `**options: Unpack[RunOptions]`, which takes each of them by its name."""
    own = inspect.signature(function, eval_str=True).parameters.values()
    named = [one for one in own if one.kind is not inspect.Parameter.VAR_KEYWORD]
    for name, kind in get_type_hints(RunOptions, include_extras=True).items():
        default = False if get_args(kind)[0] is bool else None
        named.append(inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=kind))
    function.__signature__ = inspect.Signature(named)  # type: ignore[attr-defined]
    return function


def make_runs(study: Callable[..., Study], scene: Scene, kind: str, options: RunOptions) -> tuple[Study, Path]:
    """Make the runs of a study, and show their progress; what it found, and the folder.

    Parameters
    ----------
    study :
        Takes the scene, and by their names the options, `executor` and `progress`.
    scene :
        From which the runs depart.
    kind :
        Of the study, by which its folder is named where none is given.
    options :
        Of the command.
    """
    from membrane_rs.study.common.cluster import cluster
    from membrane_rs.study.common.kept_runs import count_kept

    given: dict[str, Any] = {name: value for name, value in options.items() if value is not None}
    address, folder = given.pop("dask", None), given.setdefault("out", Path("runs") / f"{scene.name}-{kind}")
    report_audit(scene)
    try:
        with run_counter() as progress, nullcontext(HERE) if address is None else cluster(address) as executor:
            return study(scene, executor=executor, progress=progress, **given), folder
    except KeyboardInterrupt as stop:
        kept = count_kept(folder)
        if not kept:
            raise
        typer.echo(f"Stopped. {kept} runs are kept in {folder}; the same command goes on with them.", err=True)
        raise typer.Exit(exit_code(stop)) from None
