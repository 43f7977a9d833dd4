"""Work against precision: one panel for each error and each cost, on logarithmic axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.plotting.figure import plain_text, save_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COSTS = {"evaluations": "Force evaluations", "seconds": "Time on one core [s]"}
"""What work is measured in, and its label."""
_MARKERS = "osD^vPX*"


@dataclass(frozen=True)
class Line:
    """One method in one row of panels.

    Attributes
    ----------
    label : str
        For the legend.
    costs : mapping
        (k,) for each of `COSTS`.
    errors : (k,) float64
        NaN where the run was stopped.
    beyond : (k,) bool
        Whether the step lies beyond the predicted limit.
    """

    label: str
    costs: Mapping[str, Floats]
    errors: Floats
    beyond: np.ndarray[tuple[int], np.dtype[np.bool_]]


@dataclass(frozen=True)
class Row:
    """One kind of error: its label, its lines, and what bounds it from below (NaN: nothing known).

    `reference` is the difference of the reference from itself at twice the step, `floor` the largest of an
    ensemble of perturbed starts.
    """

    label: str
    lines: Sequence[Line]
    reference: float
    floor: float
    wanted: float


def plot_work_precision(rows: Sequence[Row], path: Path, title: str) -> None:
    """Draw the panels as PNG, PDF or SVG, by the ending of `path`. Raises OutputError where that cannot be written."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    figure = Figure(figsize=(11.5, 0.8 + 3.6 * len(rows)), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(len(rows), len(COSTS), squeeze=False, sharey="row", sharex="col")
    for row, line_of_axes in zip(rows, panels, strict=True):
        low, high = _span(row)
        for axes, cost in zip(line_of_axes, COSTS, strict=True):
            axes.set(xscale="log", yscale="log", ylim=(low, high))
            for k, line in enumerate(row.lines):
                _draw(axes, line, line.costs[cost], k, high)
            _bounds(axes, row, low)
            axes.xaxis.set_minor_formatter(NullFormatter())
            left, right = axes.get_xlim()
            if right < 100 * left:  # else the powers of ten do
                axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if right < 20 * left else (1.0, 3.0)))
                axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.10g}"))
            axes.grid(color="0.92")
            axes.set_axisbelow(True)
            axes.spines[["top", "right"]].set_visible(False)
        line_of_axes[0].set_ylabel(row.label)
        line_of_axes[-1].legend(frameon=False, fontsize=9, loc="center left", bbox_to_anchor=(1.01, 0.5))
    for axes, label in zip(panels[-1], COSTS.values(), strict=True):
        axes.set_xlabel(label)
    figure.suptitle(plain_text(title))
    save_figure(figure, path)


def _span(row: Row) -> tuple[float, float]:
    """Lowest and highest error to show, with room for failed points above."""
    values = np.concatenate([line.errors for line in row.lines])
    known = [*values, row.reference, row.floor, row.wanted]
    shown = [value for value in known if np.isfinite(value) and value > 0.0] or [1.0]
    return min(shown) / 5.0, max(shown) * 10.0


def _draw(axes: Axes, line: Line, costs: Floats, k: int, high: float) -> None:
    colour, marker = f"C{k}", _MARKERS[k % len(_MARKERS)]
    done = np.isfinite(line.errors) & (line.errors > 0.0)
    axes.plot(costs[done], line.errors[done], marker + "-", color=colour, linewidth=1.2, label=line.label, zorder=2)
    hollow = done & line.beyond
    axes.plot(costs[hollow], line.errors[hollow], marker, color=colour, mfc="white", zorder=3)
    failed = ~np.isfinite(line.errors) & np.isfinite(costs)
    axes.plot(costs[failed], np.full(failed.sum(), high / 3.0), "x", color=colour, markersize=9, mew=2.0, zorder=3)


def _bounds(axes: Axes, row: Row, low: float) -> None:
    if np.isfinite(row.floor) and row.floor > low:
        label = "spread of perturbed starts"
        axes.axhspan(low, row.floor, color="0.5", alpha=0.18, linewidth=0, label=label, zorder=0)
    if np.isfinite(row.reference) and row.reference > 0.0:
        axes.axhline(row.reference, color="0.3", linewidth=1.0, linestyle=":", label="reference, at twice its step")
    if np.isfinite(row.wanted):
        axes.axhline(row.wanted, color="tab:green", linewidth=1.0, linestyle="--", label="wanted")
    if any((~np.isfinite(line.errors)).any() for line in row.lines):
        axes.plot([], [], "x", color="0.3", markersize=9, mew=2.0, label="stopped by the monitor")
    if any((np.isfinite(line.errors) & line.beyond).any() for line in row.lines):
        axes.plot([], [], "o", color="0.3", mfc="white", label="beyond the predicted limit")
