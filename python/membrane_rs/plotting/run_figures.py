"""All figures of a run as files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from membrane_rs._files import made_folder, path_of
from membrane_rs._validation import nearest, show
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.plotting.crossings import plot_crossings
from membrane_rs.plotting.deployment import plot_deployment
from membrane_rs.plotting.energy import plot_energy
from membrane_rs.plotting.figure import FORMATS, save_figure
from membrane_rs.plotting.history import plot_history
from membrane_rs.plotting.momentum import is_of_free_hub, plot_momentum
from membrane_rs.plotting.sheets import VIEWS
from membrane_rs.plotting.snapshot_sheet import COUNT, plot_snapshots
from membrane_rs.plotting.style import PAPER, Style, style_of
from membrane_rs.results.crossing_counts import CROSSINGS, read_crossings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ENDINGS = tuple(ending.removeprefix(".") for ending in FORMATS)


def save_run_figures(
    run: Any,
    folder: Path | str,
    formats: Sequence[str] = ("pdf",),
    *,
    style: Style | str | Path | Mapping[str, Any] | None = PAPER,
    width: float | str | None = None,
    times: int | Sequence[float] = COUNT,
    columns: Sequence[str | Sequence[str]] = (),
    progress: Callable[[Path], None] | None = None,
) -> list[Path]:
    """Write the figures of a run: deployment, energy, momentum of a free hub, snapshots, crossings where they were
    counted.

    Parameters
    ----------
    run : Run
        What `membrane_rs.run` and `membrane_rs.open_run` give.
    folder : path
        Where to; made where it is missing. Files of the same names are replaced.
    formats : sequence of str
        Of "pdf", "svg" and "png".
    style : Style, str, path or mapping
        "paper" (the default), "screen", a `Style`, a style sheet of matplotlib, or its parameters.
    width : float or str, optional
        In place of the style's: a number [mm], "85 mm", "single" or "double".
    times : int or sequence of float
        Number of snapshots, or their times [s], as for `plot_snapshots`.
    columns : sequence of str
        Of the history, for a figure "history", as for `plot_history`. Default: none.
    progress : callable, optional
        Called with each file that is written.

    Returns
    -------
    list of Path
        The files: "deployment", "energy", "momentum" with a hub that turns freely, "snapshots" and, with a hub that
        turns, "snapshots-turning", "crossings", "history", each with the endings of its formats. What a run has no data
        for is left out.

    Raises
    ------
    InputError
        A format, style, width, column or time that does not exist; a run with neither frames nor two samples.
    InputTypeError
        No run, no path, no list of formats.
    MissingFileError
        No style sheet of that name.
    OutputError
        A file cannot be written.

    Examples
    --------
    >>> import membrane_rs
    >>> from membrane_rs.plotting import save_run_figures
    >>> made = membrane_rs.run("spinning-tether", 0.01, frames=3)
    >>> [path.name for path in save_run_figures(made, "figures", ["svg"], times=2)]
    ['deployment.svg', 'energy.svg', 'snapshots.svg', 'snapshots-turning.svg']
    """
    if not all(hasattr(run, name) for name in ("scene", "history", "frames")):
        raise InputTypeError(f"run = {show(run)}: must be a Run, as membrane_rs.run and open_run give it")
    look = style_of(style, PAPER)
    if width is not None:
        look = replace(look, width=width)
    if isinstance(formats, str) or not isinstance(formats, Sequence) or not formats:
        raise InputTypeError(f"formats = {show(formats)}: must be a list of formats, of {', '.join(ENDINGS)}")
    for name in formats:
        if name not in ENDINGS:
            raise InputError(f"formats: {show(name)} is no format of a figure; {nearest(str(name), ENDINGS)}")
    folder = path_of(folder, "folder")
    files = []
    for name, figure in _figures(run, look, times, columns):
        made_folder(folder)
        for ending in dict.fromkeys(formats):
            files.append(folder / f"{name}.{ending}")
            save_figure(figure(), files[-1])
            if progress is not None:
                progress(files[-1])
    return files


def _figures(
    run: Any, style: Style, times: int | Sequence[float], columns: Sequence[str | Sequence[str]]
) -> list[tuple[str, Callable[[], Figure]]]:
    """The figures by name, each made once when it is asked for. Raises InputError."""
    title, history = run.scene.name, run.history
    made: list[tuple[str, Callable[[], Figure]]] = []
    if len(history["time"]) > 1:
        if np.isfinite(history["deployment_rate"]).any():
            made.append(("deployment", lambda: plot_deployment(run, title=title, style=style)))
        made.append(("energy", lambda: plot_energy(run, title=title, style=style)))
        if is_of_free_hub(history):
            made.append(("momentum", lambda: plot_momentum(run, title=title, style=style)))
    if len(run.frames):
        has_hub = any(law.turns_hub for law in run.scene.laws)
        for name, view in zip(("snapshots", "snapshots-turning"), reversed(VIEWS), strict=True):
            if view != "turning" or has_hub:
                made.append((name, _snapshots(run, times, title, view, style)))
    if run.path is not None and (run.path / CROSSINGS).is_file():
        counts = read_crossings(run.path)
        made.append(("crossings", lambda: plot_crossings(counts, title=title, style=style)))
    if columns:
        made.append(("history", lambda: plot_history(run, columns, title=title, style=style)))
    if not made:
        raise InputError("nothing to draw: the run has fewer than two samples, and no frame; let it come farther")
    return [(name, _once(draw)) for name, draw in made]


def _snapshots(run: Any, times: Any, title: str, view: str, style: Style) -> Callable[[], Figure]:
    return lambda: plot_snapshots(run, times, title=title, view=view, style=style)


def _once(draw: Callable[[], Figure]) -> Callable[[], Figure]:
    """The same figure for each format."""
    kept: list[Figure] = []

    def figure() -> Figure:
        if not kept:
            kept.append(draw())
        return kept[0]

    return figure
