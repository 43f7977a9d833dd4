"""The command that makes a page of runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from membrane_rs.cli import completion
from membrane_rs.cli.application import LOOKING, Json, command, print_json, tell
from membrane_rs.cli.options import path_option

Runs = Annotated[
    list[Path],
    typer.Argument(metavar="RUN...", help="Folders of runs, or their summary.json.", autocompletion=completion.runs),
]
Data = Annotated[
    list[Path] | None,
    typer.Option(
        "--data",
        metavar="FILE",
        help="CSV of measured curves: a column 'time' [s], others named as in history.csv, with units as in "
        "'hub_torque [mN m]'. May be given several times.",
    ),
]


@command(
    LOOKING,
    example="run spinning-tether --until 0.01 --frames 3 --no-pictures\nreport runs/spinning-tether --out tether.html",
)
def report(
    runs: Runs,
    *,
    data: Data = None,
    out: Annotated[Path, path_option(help="The file.")] = Path("report.html"),
    ensemble: Annotated[
        bool, typer.Option("--ensemble", help="Draw the mean of the runs and their spread: one scene, several starts.")
    ] = False,
    title: Annotated[
        str | None, typer.Option("--title", help="Default: the name of the scene, or of the runs.")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the file.")] = False,
    json: Json = False,
) -> None:
    """Make one HTML page of runs: 3D, pictures, curves, energy, audit, timings, scene."""
    from membrane_rs.report import write_report

    file = write_report(list(runs), out, data=list(data or ()), ensemble=ensemble, title=title, overwrite=overwrite)
    if json:
        print_json({"file": str(file)})
    else:
        typer.echo(file)
    tell(f"Open it in a browser: {file.resolve().as_uri()}")
