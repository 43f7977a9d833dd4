"""One panel of curves against time as SVG, for pages: its text is text, and its curves have classes by which a page
shows and hides them.
"""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.plotting.drawable import count_beyond, drawable, note_beyond
from membrane_rs.plotting.figure import plain_text
from membrane_rs.plotting.style import COLORS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_POINTS = 1500
"""Of a curve: of more samples the lowest and the highest of each part are drawn."""
SIZE = (6.0, 3.1)
"""Width and height [inch]."""
_LEFT, _RIGHT, _BOTTOM, _TOP = 0.78, 0.12, 0.48, 0.16
_LEGEND = 1.75
_POINTS = 72.0


@dataclass(frozen=True)
class Curve:
    """A curve of times (n,) [s] and values (n,)."""

    times: Floats
    values: Floats
    label: str = ""
    color: str = COLORS[0]
    key: str = ""
    """The class of its elements in the page."""
    line: str = "-"
    """matplotlib's style of the line; empty: none."""
    marker: str = ""
    """matplotlib's mark of each point; empty: none."""
    width: float = 1.6
    opacity: float = 1.0
    edges: tuple[Floats, Floats] | None = None
    """(n,) lower and upper edge of a band around it."""

    def edges_over(self, factor: float) -> tuple[Floats, Floats] | None:
        """The edges in another unit."""
        return None if self.edges is None else (self.edges[0] / factor, self.edges[1] / factor)


def panel_svg(
    curves: Sequence[Curve],
    label: str,
    *,
    level: float | None = None,
    ends: tuple[float, float] | None = None,
    stages: Sequence[tuple[str, float]] = (),
    legend: bool = False,
) -> str:
    """The panel as SVG.

    Its element has `data-time-scale`: x of the left and of the right end, the times there [s], y of the top and of the
    bottom, all in units of its viewBox.

    Parameters
    ----------
    curves : sequence of Curve
        In the order of drawing.
    label : str
        Of the values, with the unit.
    level : float, optional
        A value that is marked, where the curves come near it.
    ends : (float, float), optional
        Times at both ends [s]. Default: those of the curves.
    stages : sequence of (str, float)
        Name and start [s] of each stage.
    legend : bool
        Whether labels stand on the right.
    """
    from matplotlib import rc_context
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    width, height = SIZE[0] + (_LEGEND if legend else 0.0), SIZE[1]
    figure = Figure(figsize=(width, height))
    FigureCanvasSVG(figure)
    right = _RIGHT + (_LEGEND if legend else 0.0)
    place = (_LEFT / width, _BOTTOM / height, (width - _LEFT - right) / width, (height - _BOTTOM - _TOP) / height)
    axes = figure.add_axes(place)
    for curve in curves:
        _draw(axes, curve)
    _mark(axes, level, stages)
    note_beyond(axes, count_beyond(some for curve in curves for some in (curve.times, curve.values)))
    _finish(axes, label, ends)
    if legend:
        axes.legend(frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.03), borderaxespad=0.6)
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "membrane_rs"}), io.StringIO() as text:
        figure.savefig(text, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
        svg = text.getvalue()
    low, high = axes.get_xlim()
    scale = (place[0] * width, (place[0] + place[2]) * width, low, high, _TOP, height - _BOTTOM)
    factors = (_POINTS, _POINTS, 1.0, 1.0, _POINTS, _POINTS)
    numbers = " ".join(f"{value * factor:.9g}" for value, factor in zip(scale, factors, strict=True))
    svg = svg[svg.index("<svg") :].replace("<svg ", f'<svg data-time-scale="{numbers}" ', 1)
    return re.sub(r'id="curve-([\w-]+)\.\d+"', r'class="\1"', svg)


def thinned(times: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Samples that can be drawn; of many the lowest and the highest of each part, and both ends."""
    times, values = drawable(times), drawable(values)
    known = np.isfinite(times) & np.isfinite(values)
    times, values = times[known], values[known]
    if len(times) <= MOST_POINTS:
        return times, values
    parts = np.array_split(np.arange(len(times)), MOST_POINTS // 2)
    rows = {0, len(times) - 1}
    for part in parts:
        rows |= {int(part[np.argmin(values[part])]), int(part[np.argmax(values[part])])}
    kept = sorted(rows)
    return times[kept], values[kept]


def _draw(axes: Axes, curve: Curve) -> None:
    """The curve, and the band around it."""
    if curve.edges is not None:
        low, high = map(drawable, curve.edges)
        band = axes.fill_between(drawable(curve.times), low, high, color=curve.color, alpha=0.2, linewidth=0.0)
        band.set_gid(f"curve-{curve.key}.0")
    times, values = thinned(curve.times, curve.values)
    (line,) = axes.plot(
        times, values, color=curve.color, linestyle=curve.line or "none", marker=curve.marker or None, markersize=4.0,
        markerfacecolor="none", linewidth=curve.width, alpha=curve.opacity, label=plain_text(curve.label),
    )  # fmt: skip
    line.set_gid(f"curve-{curve.key}.1")


def _mark(axes: Axes, level: float | None, stages: Sequence[tuple[str, float]]) -> None:
    """The level, where the curves come near it, and the starts of the stages."""
    low, high = axes.get_ylim()
    if level is not None and low - (high - low) <= level <= high + (high - low):
        axes.axhline(level, color="0.55", linewidth=0.8, zorder=1)
    for k, (name, start) in enumerate(stages):
        if k:
            axes.axvline(start, color="0.6", linewidth=0.7, zorder=1)
        axes.annotate(
            plain_text(name), (start, 1.0), (2, -2), xycoords=axes.get_xaxis_transform(), textcoords="offset points",
            fontsize=6.5, color="0.45", rotation=90, va="top", ha="left",
        )  # fmt: skip


def _finish(axes: Axes, label: str, ends: tuple[float, float] | None) -> None:
    """Scales, grid and labels."""
    axes.margins(x=0.0)
    if ends is not None and ends[1] > ends[0]:
        axes.set_xlim(*ends)
    axes.yaxis.set_label_coords(-0.62 / (SIZE[0] - _LEFT - _RIGHT), 0.5)
    axes.ticklabel_format(axis="y", useOffset=False, scilimits=(-3, 4))
    axes.yaxis.get_offset_text().set_fontsize(8)
    axes.set_xlabel("Time [s]", fontsize=9)
    axes.set_ylabel(plain_text(label), fontsize=9)
    axes.tick_params(labelsize=8, color="0.6")
    axes.grid(color="0.9", linewidth=0.8)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color("0.6")
