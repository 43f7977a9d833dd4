"""Crossings against time: pairs of triangles that pass through each other, where a run counts them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from membrane_rs._arrays import Floats
from membrane_rs._given_arrays import numeric
from membrane_rs._validation import check_kind
from membrane_rs.errors import InputTypeError
from membrane_rs.plotting.drawing import Drawing
from membrane_rs.plotting.figure import add_title, finished, new_figure, save_figure
from membrane_rs.plotting.panels import add_legend, line_look, space_times
from membrane_rs.plotting.stage_marks import mark_stages, stage_starts
from membrane_rs.plotting.style import INCH, SCREEN, Style, style_of
from membrane_rs.results.crossing_counts import CROSSINGS, read_crossings
from membrane_rs.simulation.stepper import Stepper

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from membrane_rs.plotting.styled_figure import StyledFigure

KINDS = ("crossing", "overlapping", "touching")
SCREEN_CROSSINGS = replace(SCREEN, panel_height=3.4 * INCH)


class CrossingsPicture(Drawing):
    """Draws crossings.png where crossings were counted, at two frames or more."""

    own_files = ("crossings.png",)

    def draw(self, sim: Stepper) -> None:
        """Draw it."""
        if (self.record.path / CROSSINGS).is_file():
            counts = read_crossings(self.record.path)
            if len(counts["time"]) > 1:
                marks = stage_starts(self.record.table), [record.name for record in sim.stages]
                figure = _figure(counts, sim.scene.name, SCREEN_CROSSINGS, marks)
                save_figure(figure, self.record.path / "crossings.png")


def plot_crossings(
    table: Mapping[str, Any],
    path: Path | str | None = None,
    title: str = "",
    dpi: float | None = None,
    *,
    style: Style | str | Path | Mapping[str, Any] | None = None,
) -> Figure:
    """Crossings of a run against time: pairs of triangles that pass through each other.

    Parameters
    ----------
    table : mapping of str to (samples,) arrays
        "time" [s] and "crossing"; drawn too where one is above 0, "overlapping" and "touching": what
        `membrane_rs.results.read_crossings` reads, and `CrossingCounts.table` gives.
    path : path, optional
        A PNG, PDF or SVG file, by its ending. Default: none is written.
    title : str
        Where the style has one.
    dpi : float, optional
        Resolution of a PNG file [1/inch]. Default: the style's.
    style : Style, str, path or mapping, optional
        "screen" (the default), "paper", a `Style`, a style sheet of matplotlib, or its parameters.

    Returns
    -------
    matplotlib.figure.Figure
        Without pyplot: nothing has to be closed.

    Raises
    ------
    InputTypeError
        A table without these columns, or columns that are no lists of numbers of equal length.
    InputError
        Another ending of `path`, or `dpi` that is not from 10 to 2400.
    OutputError
        `path` cannot be written.

    Examples
    --------
    >>> from membrane_rs.plotting import plot_crossings
    >>> figure = plot_crossings({"time": [0.0, 0.1, 0.2], "crossing": [0, 3, 1]}, style="paper")
    >>> figure.axes[0].get_ylabel()
    'Pairs of triangles'
    """
    check_kind(title, str, "title", "a text")
    check_kind(table, Mapping, "table", "counts by name, as read_crossings gives them")
    found = {}
    for name in ("time", "crossing", *(kind for kind in KINDS[1:] if kind in table)):
        if name not in table:
            raise InputTypeError(f"table: has no column {name!r}; give what read_crossings gives")
        found[name] = numeric(table[name], f"table[{name!r}]", "fiu", "numbers")
        if found[name].shape != found["time"].shape or found[name].ndim != 1:
            raise InputTypeError(f"table: the columns {', '.join(found)} must be lists of equal length")
    return finished(_figure(found, title, style_of(style, SCREEN_CROSSINGS)), path, dpi)


def _figure(
    table: Mapping[str, Floats],
    title: str,
    style: Style,
    marks: tuple[Sequence[tuple[int, float]], Sequence[str]] = ((), ()),
) -> StyledFigure:
    """Counts in one panel; `marks` are index and start [s] of each stage, and the names of stages."""
    from matplotlib.ticker import MaxNLocator

    with style.context():
        figure = new_figure(style, style.size(1))
        axes = figure.subplots()
        shown = [kind for kind in KINDS if kind == KINDS[0] or (kind in table and table[kind].any())]
        for k, kind in enumerate(shown):
            axes.plot(table["time"], table[kind], marker=".", label=kind, **line_look(k))
        mark_stages([axes], *marks)
        axes.set_ylim(bottom=0.0)
        axes.margins(x=0.0)
        space_times(axes, style)
        axes.set_xlabel("Time [s]")
        axes.set_ylabel("Pairs of triangles")
        axes.yaxis.set_major_formatter("{x:,.0f}")
        axes.yaxis.set_major_locator(MaxNLocator("auto", integer=True))
        add_title(axes, title, style)
        if len(shown) > 1:
            add_legend(figure, [axes], style)
    return figure
