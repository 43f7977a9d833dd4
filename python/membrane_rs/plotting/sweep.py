"""A sweep in one figure: maps over two parameters, or each number against each parameter, with the spread over starts.

Numbers are means over starts. In a grid of one parameter, or of several, each panel shows the mean at each value, over
all values of the others (a main effect), with a bar of one standard deviation between starts, and all runs as dots.
Samples are shown one by one. A run that has failed is a cross below. In a map over two parameters the
number is written into each cell, if there is room.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._validation import check_kind
from membrane_rs.errors import InputError
from membrane_rs.plotting.columns import axis_label, prefixed
from membrane_rs.plotting.figure import add_letters, finished, new_figure, plain_text
from membrane_rs.plotting.responses import Response, Row, responses_of
from membrane_rs.plotting.style import INCH, Style, style_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from membrane_rs.plotting.styled_figure import StyledFigure

GOOD = "finished"
LEAST_SPREAD = 1e-6
"""A spread over starts that is a smaller share of the mean is not written into the cell of a map."""
FLAT = 0.72
"""Height of a panel, over that of a panel against time."""
MOST_ACROSS = 8
"""Parameters in one figure."""
WRAP = 22
"""Letters in a line beside a panel."""
LOG_RATIO = 20.0
"""Ratio of the largest to the smallest value from which a list of values is shown on a logarithmic axis."""
MOST_CELLS = 12
"""Values of a parameter up to which ticks and cells of a map are all labelled."""
TICK_LETTERS, CELL_LETTERS = 56, 60
"""Letters across a map that have room below it, and, smaller, in its cells."""
FAILED_COLOR = "#B22222"


@dataclass(frozen=True)
class Varied:
    """A parameter: the key by which rows have its values, its unit, its values in their order, and its scale."""

    key: str
    unit: str = ""
    values: Sequence[Any] = ()
    is_log: bool = False

    @property
    def is_number(self) -> bool:
        """Whether all its values are numbers."""
        return all(isinstance(value, int | float) and not isinstance(value, bool) for value in self.values)

    @property
    def has_log_axis(self) -> bool:
        """Whether its axis is logarithmic."""
        if not self.is_number or min(self.values) <= 0:
            return False
        return self.is_log or max(self.values) >= LOG_RATIO * min(self.values)

    def place(self, value: Any) -> float:
        """Where a value lies on its axis."""
        return float(value) if self.is_number else float(list(self.values).index(value))


def plot_sweep(
    rows: Sequence[Row],
    parameters: Sequence[Varied],
    columns: Sequence[str] | None = None,
    *,
    sampled: bool = False,
    units: Mapping[str, str] | None = None,
    path: Path | str | None = None,
    title: str = "",
    dpi: float | None = None,
    style: Style | str | Path | Mapping[str, Any] | None = None,
) -> Figure:
    """Draw the rows of a sweep.

    Parameters
    ----------
    rows : sequence of mappings
        As `membrane_rs.study.Sweep.rows`.
    parameters : sequence of Varied
        What was varied.
    columns : sequence of str, optional
        Numbers of the rows, a panel for each. Default: up to four in which runs differ.
    sampled : bool
        Whether values are samples of ranges.
    units : mapping, optional
        Units of the measures that were recorded, by name.
    path, title, dpi, style
        As in `plot_comparison`.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InputError
        No run or no parameter, a column that no run has, no run with a number.
    OutputError
        `path` cannot be written.
    """
    look = style_of(style)
    check_kind(title, str, "title", "a text")
    if not rows or not parameters:
        raise InputError("a sweep without runs, or without parameters, has no figure; plot_ensemble shows starts alone")
    shown = responses_of(_good(rows), columns, units or {}, [one.key for one in parameters])
    with look.context():
        if len(parameters) == 2 and not sampled and min(len(one.values) for one in parameters) > 1:
            figure = _maps(rows, parameters, shown, look)
        else:
            figure = _effects(rows, parameters, shown, look, sampled=sampled)
        if look.title and title:
            figure.suptitle(plain_text(title))
    return finished(figure, path, dpi)


def by_point(rows: Sequence[Row], keys: Sequence[str]) -> dict[tuple[Hashable, ...], list[Row]]:
    """The rows of each combination of values: one for each start."""
    found: dict[tuple[Hashable, ...], list[Row]] = {}
    for row in rows:
        found.setdefault(tuple(row[key] for key in keys), []).append(row)
    return found


def mean_and_spread(values: Floats) -> tuple[float, float]:
    """Mean and standard deviation of what is finite; NaN for no value, and for one alone."""
    some = values[np.isfinite(values)]
    return (
        float(some.mean()) if len(some) else math.nan,
        float(some.std(ddof=1)) if len(some) > 1 else math.nan,
    )


def _good(rows: Sequence[Row]) -> list[Row]:
    return [row for row in rows if row["outcome"] == GOOD]


def _effects(
    rows: Sequence[Row], parameters: Sequence[Varied], shown: Sequence[Response], style: Style, *, sampled: bool
) -> StyledFigure:
    """A panel for each number (upwards) and parameter (across)."""
    across = parameters[:MOST_ACROSS]
    width, height = style.size(FLAT * len(shown), extra=6.0)
    figure = new_figure(style, (width * max(1.0, 0.62 * len(across)), height))
    panels = figure.subplots(len(shown), len(across), sharex="col", sharey="row", squeeze=False)
    for response, line in zip(shown, panels, strict=True):
        factor, unit = prefixed(response.unit, [response.values(_good(rows))])
        for axes, parameter in zip(line, across, strict=True):
            _draw_effect(axes, rows, parameters, parameter, (response, factor), sampled=sampled)
        line[0].set_ylabel(_wrapped(response.label, unit))
    for axes, parameter in zip(panels[-1], across, strict=True):
        if not parameter.is_number:  # names in place of numbers
            _set_axis(axes.xaxis, parameter)
        axes.set_xlabel(axis_label(plain_text(parameter.key), parameter.unit))
        if parameter.has_log_axis:
            _set_log_axis(axes, parameter, sampled=sampled)
    add_letters(list(panels.ravel()), style)
    _add_failures(figure, rows)
    if len(across) < len(parameters):
        figure.supxlabel(f"the first {len(across)} of {len(parameters)} parameters")
    figure.align_ylabels(list(panels[:, 0]))
    return figure


def _draw_effect(
    axes: Axes,
    rows: Sequence[Row],
    parameters: Sequence[Varied],
    parameter: Varied,
    scaled: tuple[Response, float],
    *,
    sampled: bool,
) -> None:
    """One panel: all runs as dots, means over starts, and what failed."""
    response, factor = scaled
    keys, good = [one.key for one in parameters], _good(rows)
    points = by_point(good, keys)
    places = [parameter.place(row[parameter.key]) for row in good]
    has_starts = any(len(some) > 1 for some in points.values())
    if sampled:
        means = [mean_and_spread(response.values(some) / factor) for some in points.values()]
        x = [parameter.place(some[0][parameter.key]) for some in points.values()]
        bars = [spread for _, spread in means] if has_starts else None
        axes.errorbar(x, [mean for mean, _ in means], bars, fmt="o", markersize=3.5, elinewidth=0.8, capsize=1.5)
    else:
        axes.plot(places, response.values(good) / factor, "o", color="0.6", markersize=2.5, zorder=1)
        x, y, bars = [], [], []
        for value in parameter.values:
            some = [found for found in points.values() if found[0][parameter.key] == value]
            if some:
                of_points = [mean_and_spread(response.values(found) / factor) for found in some]
                x.append(parameter.place(value))
                y.append(mean_and_spread(np.array([mean for mean, _ in of_points]))[0])
                squares = np.array([spread**2 for _, spread in of_points])
                bars.append(math.sqrt(mean_and_spread(squares)[0]))
        line = "-" if parameter.is_number else ""
        axes.errorbar(
            x, y, bars if has_starts else None, fmt="o" + line, markersize=3.5, elinewidth=0.9, capsize=2.0, zorder=3
        )
    failed = [parameter.place(row[parameter.key]) for row in rows if row["outcome"] != GOOD]
    axes.plot(
        failed, [0.03] * len(failed), "x", color=FAILED_COLOR, markersize=4.5, transform=axes.get_xaxis_transform()
    )


def _maps(rows: Sequence[Row], parameters: Sequence[Varied], shown: Sequence[Response], style: Style) -> StyledFigure:
    """A map for each number: one parameter across, one upwards; in each cell the mean, and its spread over starts."""
    across, up = parameters
    columns = min(len(shown), 2)
    lines = -(-len(shown) // columns)
    width, height = style.size(lines, extra=8.0)
    figure = new_figure(style, (width * (1.0 if columns == 1 else 1.6), 1.2 * height))
    panels = figure.subplots(lines, columns, squeeze=False).ravel()
    points = by_point(rows, [across.key, up.key])
    for axes, response in zip(panels, shown, strict=False):
        factor, unit = prefixed(response.unit, [response.values(_good(rows))])
        cells = np.full((len(up.values), len(across.values), 2), math.nan)
        for (x, y), some in points.items():
            place = list(up.values).index(y), list(across.values).index(x)
            cells[place] = mean_and_spread(response.values(_good(some)) / factor)
        image = axes.imshow(cells[..., 0], origin="lower", aspect="auto", cmap="viridis")
        bar = figure.colorbar(image, ax=axes, label=_wrapped(response.label, unit))
        bar.ax.ticklabel_format(axis="y", useOffset=False)
        axes.grid(visible=False)
        _write_cells(axes, cells, points, parameters)
        for axis, parameter, room in ((axes.xaxis, across, TICK_LETTERS), (axes.yaxis, up, 0)):
            _set_axis(axis, parameter, room)
            axis.set_label_text(axis_label(plain_text(parameter.key), parameter.unit))
    for axes in panels[len(shown) :]:
        axes.set_visible(False)
    add_letters(list(panels[: len(shown)]), style)
    if words := _failures(rows):
        figure.supxlabel(words, color=FAILED_COLOR, fontsize="small")
    return figure


def _write_cells(
    axes: Axes, cells: Floats, points: Mapping[tuple[Any, ...], Sequence[Row]], parameters: Sequence[Varied]
) -> None:
    """The number in each cell, with its spread, and what has failed there."""
    across, up = parameters
    if len(up.values) > MOST_CELLS:
        return
    texts: dict[tuple[int, int], str] = {}
    finite = cells[..., 0][np.isfinite(cells[..., 0])]
    middle = 0.5 * (finite.min() + finite.max()) if len(finite) else 0.0
    for (x, y), some in points.items():
        k, j = list(up.values).index(y), list(across.values).index(x)
        mean, spread = cells[k, j]
        failed = [str(row["outcome"]) for row in some if row["outcome"] != GOOD]
        lines = [f"{mean:.3g}"] if math.isfinite(mean) else [] if failed else ["no value"]
        lines += [f"± {spread:.1g}"] if spread > LEAST_SPREAD * abs(mean) else []
        lines += [f"{failed.count(word)} {word}" for word in dict.fromkeys(failed)]
        texts[k, j] = "\n".join(lines)
    longest = max(len(line) for text in texts.values() for line in text.splitlines())
    if len(across.values) * (longest + 1) > CELL_LETTERS:
        return
    for (k, j), text in texts.items():
        mean = cells[k, j, 0]
        color = FAILED_COLOR if not math.isfinite(mean) else "white" if mean < middle else "black"
        axes.text(j, k, text, ha="center", va="center", color=color, fontsize="x-small")


def _set_axis(axis: Any, parameter: Varied, room: int = 0) -> None:
    """Ticks at values by their numbers in the list, as many as there is room for: letters, where it is known."""
    words = [_word(value) for value in parameter.values]
    ticks = _some(range(len(words)))
    looks: dict[str, Any] = {}
    if room and not parameter.is_number and len(words) * (max(map(len, words)) + 2) > room:
        looks = {"rotation": 20.0, "ha": "right"}
    elif room and parameter.is_number:
        step = -(-len(words) * (max(map(len, words)) + 2) // room)
        ticks = list(range(0, len(words), max(step, -(-len(words) // MOST_CELLS))))
    axis.set_ticks(ticks, [words[k] for k in ticks], **looks)


def _set_log_axis(axes: Axes, parameter: Varied, *, sampled: bool) -> None:
    """A logarithmic axis, whose ticks are the values themselves where they are few."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    axes.set_xscale("log")
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: _word(value)))
    if not sampled and 1 < len(parameter.values) <= 8:
        axes.set_xticks(list(parameter.values))
    else:
        decades = math.log10(max(parameter.values) / min(parameter.values))
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if decades < 2.0 else (1.0,), numticks=7))


def _wrapped(label: str, unit: str) -> str:
    """Label and unit in lines that fit beside a panel."""
    return "\n".join(wrap(axis_label(plain_text(label), unit), WRAP))


def _some(ticks: Sequence[int]) -> list[int]:
    """As many ticks as have room."""
    return list(ticks[:: max(1, -(-len(ticks) // MOST_CELLS))])


def _word(value: Any) -> str:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return plain_text(str(value)).strip()
    exact = f"{value:.6g}"
    return exact if float(exact) == value else f"{value:.4g}"


def _failures(rows: Sequence[Row]) -> str:
    """How many runs have failed, and of what."""
    failed = [str(row["outcome"]) for row in rows if row["outcome"] != GOOD]
    words = ", ".join(f"{failed.count(word)} {word}" for word in dict.fromkeys(failed))
    return f"{len(failed)} of {len(rows)} runs: {words}" if failed else ""


def _add_failures(figure: StyledFigure, rows: Sequence[Row]) -> None:
    """How many runs have failed, and what the crosses mean."""
    from matplotlib.lines import Line2D

    if words := _failures(rows):
        cross = Line2D([], [], marker="x", color=FAILED_COLOR, linestyle="none", markersize=4.5)
        figure.legend([cross], [words], loc="outside lower center")
        width, height = figure.get_size_inches()
        figure.set_size_inches(width, height + 6.0 / INCH)
