"""The command figures: those of a run, for a paper."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from membrane_rs.cli import completion
from membrane_rs.cli.application import LOOKING, Json, command, print_json, tell
from membrane_rs.cli.options import count_option, path_option


@command(
    LOOKING,
    example="run spinning-tether --until 0.01 --frames 3 --no-pictures\n"
    "figures runs/spinning-tether --format pdf,png --width 85mm",
)
def figures(
    run: Annotated[
        Path,
        typer.Argument(
            metavar="RUN", help="The folder of a run, whichever way it ended.", autocompletion=completion.runs
        ),
    ],
    *,
    out: Annotated[
        Path | None, path_option(help="Folder of the figures. Default: figures/ in that of the run.")
    ] = None,
    formats: Annotated[
        list[str] | None,
        typer.Option(
            "--format",
            metavar="FORMATS",
            help="Of pdf, svg and png, separated by commas. May be given several times. Default: pdf.",
        ),
    ] = None,
    style: Annotated[
        str, typer.Option(help="paper or screen; a style sheet of matplotlib by its name or its file.")
    ] = "paper",
    width: Annotated[
        str | None,
        typer.Option(help="Width of a figure with its unit, as 85mm; single (85 mm) or double (174 mm)."),
    ] = None,
    snapshots: Annotated[int, count_option(help="Number of snapshots, spread evenly over the run.")] = 6,
    columns: Annotated[
        str,
        typer.Option(help="Columns of history.csv for a figure of them, separated by commas; + joins two in a panel."),
    ] = "",
    json: Json = False,
) -> None:
    """Draw the figures of a run for a paper: curves, energy balance, snapshots with letters and a scale bar."""
    from membrane_rs.plotting import save_run_figures
    from membrane_rs.runs import open_run

    opened = open_run(run)
    panels = [panel.split("+") for panel in columns.split(",")] if columns else []
    files = save_run_figures(
        opened,
        out or (opened.path or run) / "figures",
        [name.strip().lower() for name in ",".join(formats or ["pdf"]).split(",")],
        style=style,
        width=width,
        times=snapshots,
        columns=panels,
        progress=None if json else lambda file: tell(f"Wrote {file}"),
    )
    if json:
        print_json([str(file) for file in files])
