"""Crossings against time: pairs of triangles that pass through each other, where a run counts them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from membrane_rs._arrays import Floats
from membrane_rs._files import path_of
from membrane_rs._given_arrays import numeric
from membrane_rs._validation import check_kind
from membrane_rs.errors import InputTypeError
from membrane_rs.plotting.drawing import Drawing
from membrane_rs.plotting.figure import plain_text, save_figure
from membrane_rs.plotting.stage_marks import mark_stages, stage_starts
from membrane_rs.results.crossing_counts import CROSSINGS, read_crossings
from membrane_rs.simulation.stepper import Stepper

KINDS = ("crossing", "overlapping", "touching")


class CrossingsPicture(Drawing):
    """Draws crossings.png where crossings were counted, at two frames or more."""

    own_files = ("crossings.png",)

    def draw(self, sim: Stepper) -> None:
        """Draw it."""
        if (self.record.path / CROSSINGS).is_file():
            counts = read_crossings(self.record.path)
            if len(counts["time"]) > 1:
                marks = stage_starts(self.record.table), [record.name for record in sim.stages]
                _picture(counts, self.record.path / "crossings.png", sim.scene.name, None, marks)


def plot_crossings(table: Mapping[str, Floats], path: Path | str, title: str = "", dpi: float | None = None) -> None:
    """Draw the crossings of a run against time as a PNG, PDF or SVG figure, by the ending of `path`.

    Parameters
    ----------
    table : mapping of str to (samples,) arrays
        "time" [s] and "crossing"; drawn too where one is above 0, "overlapping" and "touching": what
        `membrane_rs.results.read_crossings` reads, and `CrossingCounts.table` gives.
    path : path
        The figure.
    title : str
        Above it.
    dpi : float
        Pixels per inch; default 200.

    Raises
    ------
    InputTypeError
        A table without these columns, or columns that are no lists of numbers of equal length.
    InputError
        Another ending of `path`, or `dpi` that is not from 10 to 2400.
    OutputError
        `path` cannot be written.
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
    _picture(found, path_of(path), title, dpi)


def _picture(
    table: Mapping[str, Floats],
    path: Path,
    title: str,
    dpi: float | None,
    marks: tuple[Sequence[tuple[int, float]], Sequence[str]] = ((), ()),
) -> None:
    """Counts in one panel; `marks` are index and start [s] of each stage, and the names of stages."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 3.4), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    shown = [kind for kind in KINDS if kind == KINDS[0] or (kind in table and table[kind].any())]
    for k, kind in enumerate(shown):
        axes.plot(table["time"], table[kind], color=f"C{k}", linewidth=1.2, marker=".", markersize=3.0, label=kind)
    mark_stages([axes], *marks)
    axes.set_ylim(bottom=0.0)
    axes.margins(x=0.0)
    axes.set_xlabel("Time [s]")
    axes.set_ylabel("Pairs of triangles")
    axes.yaxis.set_major_formatter("{x:,.0f}")
    axes.grid(color="0.9")
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_title(plain_text(title), wrap=True)
    if len(shown) > 1:
        axes.legend(frameon=False)
    save_figure(figure, path, dpi)
