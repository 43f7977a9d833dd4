"""The command that shows a run in a window."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from membrane_rs.cli import completion
from membrane_rs.cli.application import LOOKING, command
from membrane_rs.cli.options import Set, load, path_option, quantity_option
from membrane_rs.plotting.viewer.keys import KEYS


def with_keys(function: Callable[..., None]) -> Callable[..., None]:
    """Put the keys of the window into the help of a command, where its docstring has {keys}."""
    keys = "; ".join(f"{key.shown}: {key.words}" for key in KEYS)
    function.__doc__ = (function.__doc__ or "").format(keys=keys)
    return function


@command(LOOKING, example="view spinning-tether")
@with_keys
def view(
    source: Annotated[
        str,
        typer.Argument(
            metavar="RUN",
            help="A run's folder, or its summary.json; or a scene, by its name or file: its start is shown.",
            autocompletion=completion.runs_and_scenes,
        ),
    ],
    *,
    set_: Set = None,
    color: Annotated[
        str, typer.Option(help="What it is coloured by at first: film, or a field, such as state or speed.")
    ] = "film",
    camera: Annotated[str, typer.Option(help="turning: the camera turns with the hub; or fixed.")] = "turning",
    scale: Annotated[
        str, typer.Option(help="Colours span the values of the whole run (run), or of each frame (frame).")
    ] = "run",
    time: Annotated[
        float | None,
        quantity_option("s", help="Time [s], or as 20ms; the frame nearest to it is shown first. Default: the start."),
    ] = None,
    picture: Annotated[
        Path | None, path_option(help="Save a picture (PNG) into this file, which is not there yet; no window.")
    ] = None,
    browser: Annotated[
        bool, typer.Option("--browser", help="Serve it as a page for a browser on this machine, until Ctrl-C.")
    ] = False,
) -> None:
    """Look at a run in a window: a slider for the time, a list of colours; the mouse turns and zooms.

    Keys: {keys}.
    """
    from membrane_rs import view as look
    from membrane_rs._files import check_kind_of_file
    from membrane_rs.errors import InputError
    from membrane_rs.results.summary import SUMMARY
    from membrane_rs.runs.viewing import check_is_there

    if picture is not None:
        if browser:
            raise InputError("--picture and --browser: a picture is saved, or a page served; give one of them")
        check_kind_of_file(picture, "image/png", "a picture is PNG", ".png")
    is_run = Path(source).name == SUMMARY or Path(source).is_dir()
    if is_run and set_:
        raise InputError(f"--set {set_[0]}: {source} is a run, which has its values; set them before it is run")
    if not is_run:
        check_is_there(source)
    shown = source if is_run else load(source, set_)
    where = "picture" if picture is not None else "browser" if browser else "window"
    view_of_run = look(shown, color=color, camera=camera, scale=scale, time=time, where=where)
    if view_of_run is not None and picture is not None:
        view_of_run.save(picture)
