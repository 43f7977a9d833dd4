"""Outcomes of runs as a map: one parameter across, the step upwards, the predicted limit as a line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from membrane_rs.plotting.figure import plain_text, save_figure

_COLOURS = ("#4c9f70", "#f2c14e", "#f08a4b", "#b23a48", "#8d99ae")
"""One for each outcome, from good to bad; the last for what was refused."""


def draw_map(
    cells: Sequence[tuple[float, float, float, str, float]],
    outcomes: Sequence[str],
    path: Path,
    parameter: str,
    title: str = "",
) -> None:
    """Draw the map as a PNG, PDF or SVG figure, by the ending of `path`.

    `cells` are (value, step [s], predicted limit [s], outcome, time of the end [s]). In each cell that ended early
    stands when, in ms. Raises OutputError where `path` cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch, Rectangle

    values = sorted({cell[0] for cell in cells})
    steps = sorted({cell[1] for cell in cells})
    figure = Figure(figsize=(2.6 + 0.75 * len(values), 1.8 + 0.5 * len(steps)), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for value, step, _, outcome, time in cells:
        x, row = values.index(value), steps.index(step)
        colour = _COLOURS[outcomes.index(outcome)]
        axes.add_patch(Rectangle((x - 0.5, row - 0.5), 1.0, 1.0, facecolor=colour, edgecolor="white", linewidth=1.0))
        if outcome in outcomes[2:4]:
            axes.text(x, row, f"{1e3 * time:.3g}", ha="center", va="center", fontsize=8)
    limits = {cell[0]: cell[2] for cell in cells}
    heights = [_height(limits[value], steps) for value in values]
    sides = [x + side for x in range(len(values)) for side in (-0.5, 0.5)]
    (line,) = axes.plot(sides, [h for h in heights for _ in range(2)], color="black", linewidth=1.8)
    axes.set_xlim(-0.5, len(values) - 0.5)
    axes.set_ylim(-0.5, len(steps) - 0.5)
    axes.set_xticks(range(len(values)), [f"{value:g}" for value in values])
    axes.set_yticks(range(len(steps)), [_brief(1e6 * step) for step in steps])
    axes.set_xlabel(parameter)
    axes.set_ylabel("step [us]")
    axes.set_title(plain_text(title), fontsize=10)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    seen = {cell[3] for cell in cells}
    keys = [Patch(color=c, label=o) for o, c in zip(outcomes, _COLOURS, strict=True) if o in seen]
    line.set_label("predicted limit; in the cells: caught at [ms]")
    figure.legend(handles=[*keys, line], loc="outside lower center", ncols=2, frameon=False, fontsize=8)
    save_figure(figure, path)


def _brief(number: float) -> str:
    return f"{number:.0f}" if 100 <= number < 1e6 else f"{number:.3g}"


def _height(limit: float, steps: Sequence[float]) -> float:
    """Where a step lies between the rows of the map, which are even; at the border where it is beyond."""
    if not 0 < limit < math.inf:
        return math.nan
    last = len(steps) - 1
    if limit <= steps[0] or last == 0:
        return -0.5 if limit <= steps[0] else 0.5
    if limit >= steps[-1]:
        return last + 0.5
    row = next(row for row in range(last) if steps[row] <= limit < steps[row + 1])
    return row + math.log(limit / steps[row]) / math.log(steps[row + 1] / steps[row])
