"""The command that makes a page of runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from membrane_rs.cli.application import LOOKING, command, tell

Runs = Annotated[list[Path], typer.Argument(metavar="RUN...", help="Folders of runs.")]
Data = Annotated[
    list[Path] | None,
    typer.Option("--data", help="CSV of measured curves: time, and columns named as in history.csv. May be repeated."),
]


@command(
    LOOKING,
    example="run spinning-tether --until 0.01 --frames 3 --no-pictures\nreport runs/spinning-tether --out tether.html",
)
def report(
    runs: Runs,
    *,
    data: Data = None,
    out: Annotated[Path, typer.Option("--out", help="The file.")] = Path("report.html"),
    ensemble: Annotated[
        bool, typer.Option("--ensemble", help="Draw the mean of the runs and their spread: one scene, several starts.")
    ] = False,
    title: Annotated[
        str | None, typer.Option("--title", help="Default: the name of the scene, or of the runs.")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the file.")] = False,
) -> None:
    """Make one HTML page of runs: 3D, pictures, curves, energy, audit, timings, scene."""
    from membrane_rs.report import write_report

    file = write_report(list(runs), out, data=list(data or ()), ensemble=ensemble, title=title, overwrite=overwrite)
    typer.echo(file)
    tell(f"Open it in a browser: {file.resolve().as_uri()}")
