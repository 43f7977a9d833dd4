"""The command that lays curves of runs and experiments over each other."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from membrane_rs.cli import completion
from membrane_rs.cli.application import LOOKING, Json, command, print_json, tell
from membrane_rs.cli.options import numeric_option, path_option, words


@command(
    LOOKING,
    example="""run spinning-tether --until 0.01 --dt 1e-6 --no-pictures --out runs/fine
run spinning-tether --until 0.01 --dt 1e-5 --no-pictures --out runs/coarse
compare runs/fine runs/coarse --columns kinetic_energy,hub_torque --out energies.png""",
)
def compare(
    curves: Annotated[
        list[str],
        typer.Argument(
            metavar="CURVES",
            autocompletion=completion.runs,
            help="Folders of runs, and CSV files of measured curves: a column 'time' [s], others named as in "
            "history.csv, with units as in 'hub_torque [mN m]'.",
        ),
    ],
    *,
    columns: Annotated[
        str | None,
        typer.Option(
            help="Names of columns, separated by commas, or 'all'. Default: those of the CSV files; without any, "
            "deployment rate and phase."
        ),
    ] = None,
    reference: Annotated[
        str | None, typer.Option(help="Label of the curves with which the others are compared. Default: the first.")
    ] = None,
    labels: Annotated[
        str | None, typer.Option(help="One for each, separated by commas. Default: names of folders and files.")
    ] = None,
    out: Annotated[Path, path_option(help="The figure: PNG, PDF or SVG, by its ending.")] = Path("comparison.png"),
    no_figure: Annotated[bool, typer.Option("--no-figure", help="Print the table alone.")] = False,
    style: Annotated[str, typer.Option(help="Of the figure: screen, paper, or matplotlib's style sheet.")] = "screen",
    title: Annotated[str, typer.Option(help="Above the figure, where the style has one.")] = "",
    dpi: Annotated[float | None, numeric_option(help="Resolution of a PNG [1/inch]. Default: the style's.")] = None,
    json: Json = False,
) -> None:
    """Lay curves of runs and experiments over each other, and tabulate their differences from one of them.

    Two curves are compared over the time that both cover, at the samples of the one that has fewer there; the other is
    interpolated linearly.
    """
    from membrane_rs.study import compare as study

    found = study(
        curves,
        columns if columns in (None, "all") else words(columns, "--columns"),
        reference=reference,
        labels=None if labels is None else words(labels, "--labels"),
    )
    if not no_figure:
        found.plot(out, title=title, dpi=dpi, style=style)
        tell(f"The figure is {out}")
    if json:
        print_json({**found.as_dict(), "figure": None if no_figure else str(out)})
        return
    typer.echo(found.summary())
