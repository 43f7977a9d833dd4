"""Pictures of docs/softening.md: mean curves and bands, distance against softening, error against cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from membrane_rs.plotting.figure import save_figure
from softening_cases import AGAIN, COARSE, FULL, RATIO, REDUCED, soft
from softening_distance import distance
from softening_runs import PHASE, RATE, Ensemble
from softening_tables import Point, front_of, points_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LABELS = {RATE: "Rate less the full model's mean", PHASE: "Phase less the full model's mean [deg]"}
DISTANCES = {RATE: "Distance of the rate", PHASE: "Distance of the phase [deg]"}
Groups = Mapping[str, Mapping[str, Ensemble]]
Panels: TypeAlias = np.ndarray[tuple[int, int], np.dtype[np.object_]]
CHANCE = "standard error of the difference"
SIZE = (5.0, 3.2)
"""Of a panel [inches]."""


def draw_curves(groups: Groups, factors: Sequence[int], picture: Path) -> None:
    """Band of the full model, and mean curves of softened films, less its mean: a column for each group."""
    figure, panels = _panels(len(groups))
    for (group, found), column in zip(groups.items(), panels.T, strict=True):
        column[0].set_title(group)
        for axes, (name, label) in zip(column, LABELS.items(), strict=True):
            full = found[FULL]
            mean = full.curves(name).mean(axis=0)
            curves = full.curves(name) - mean
            look = {"color": "0.85", "linewidth": 0, "label": f"{FULL}, lowest to highest start"}
            axes.fill_between(full.time, curves.min(axis=0), curves.max(axis=0), **look)
            axes.axhline(0.0, color="k", linewidth=1.6, label=f"{FULL}, mean")
            for k, factor in enumerate(factors):
                own = found[soft(factor)]
                if own.is_whole:
                    look = {"color": _shade(k, len(factors)), "linewidth": 1.1, "label": f"{soft(factor)}, mean"}
                    axes.plot(own.time, own.curves(name).mean(axis=0) - mean, **look)
            axes.set_ylabel(label)
            axes.margins(x=0.0)
        column[-1].set_xlabel("Time [s]")
    _finish(figure, panels, picture)


def draw_distances(groups: Groups, factors: Mapping[str, Sequence[int]], picture: Path) -> None:
    """Distance of the mean curves against the softening, and what of it is chance: a column for each group."""
    figure, panels = _panels(len(groups), sharey="row")
    for (group, found), column in zip(groups.items(), panels.T, strict=True):
        column[0].set_title(group)
        for axes, (name, label) in zip(column, DISTANCES.items(), strict=True):
            of = {1: found[AGAIN], **{factor: found[soft(factor)] for factor in factors[group]}}
            known = {factor: own for factor, own in of.items() if own.is_whole}
            every = [distance(found[FULL].curves(name), own.curves(name)) for own in known.values()]
            softenings = list(known)
            axes.fill_between(softenings, [one.error for one in every], color="0.88", linewidth=0, label=CHANCE)
            axes.plot(softenings, [one.value for one in every], "o-", color="C0", label="distance of the means")
            axes.plot(softenings, [one.net for one in every], "s--", color="C1", mfc="white", label="net of chance")
            axes.set_xscale("log")
            axes.set_ylabel(label)
            axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axes.xaxis.set_minor_formatter(NullFormatter())
        column[-1].set_xlabel("Softening (at 1: other starts of the full model)")
    _begin_at_zero(panels)
    _finish(figure, panels, picture)


def draw_front(groups: Groups, picture: Path) -> None:
    """Distance of the mean curves against processor time: a column for each group, the front as a line."""
    figure, panels = _panels(len(groups), sharey="row")
    for (group, found), column in zip(groups.items(), panels.T, strict=True):
        column[0].set_title(group)
        points = points_of(found)
        for axes, (name, label) in zip(column, DISTANCES.items(), strict=True):
            _draw_points(axes, points, name)
            error = distance(found[FULL].curves(name), found[AGAIN].curves(name)).error
            axes.axhspan(0.0, error, color="0.88", linewidth=0, label=CHANCE, zorder=0)
            axes.set(xscale="log", ylabel=label)
            axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axes.xaxis.set_minor_formatter(NullFormatter())
        column[-1].set_xlabel("Processor time of a run [s]")
    _begin_at_zero(panels)
    _finish(figure, panels, picture)


def _draw_points(axes: Axes, points: list[Point], column: str) -> None:
    on_front = front_of(points, column)
    steps = [(points[k][1], points[k][2][column]) for k in on_front]
    axes.plot(*np.array(steps).T, color="0.6", linewidth=1.0, label="front", zorder=1)
    marked = {FULL: AGAIN, REDUCED: REDUCED, RATIO: RATIO}
    softest = max((_softening(label) for label, *_ in points), default=1)
    for label, seconds, errors in points:
        is_coarse, factor = label.startswith(COARSE), _softening(label)
        colour = {FULL: "k", REDUCED: "C0", RATIO: "C3"}.get(label) or colormaps["viridis_r"](
            0.15 + 0.85 * np.log(factor) / max(np.log(softest), 1e-9)
        )
        marker = {FULL: "*", REDUCED: "v", RATIO: "X"}.get(label, "s" if is_coarse else "o")
        text = marked.get(label, label.replace(COARSE, "coarse mesh"))
        look: dict[str, Any] = {
            "color": colour,
            "marker": marker,
            "markersize": 10 if label == FULL else 7,
            "linestyle": "none",
            "clip_on": False,
        }
        axes.plot(seconds, errors[column], label=text, zorder=2, **look)


def _softening(label: str) -> int:
    _, _, factor = label.partition("softened ")
    return int(factor.partition(",")[0]) if factor else 1


def _shade(k: int, count: int) -> tuple[float, float, float, float]:
    return colormaps["turbo"](0.1 + 0.8 * k / max(1, count - 1))


def _begin_at_zero(panels: Panels) -> None:
    """Let vertical axes begin at 0, which fixes their upper end: panels of a row share one, and are drawn before."""
    for axes in panels[:, 0]:
        axes.set_ylim(bottom=0.0)


def _panels(columns: int, **shared: Any) -> tuple[Figure, Panels]:
    figure = Figure(figsize=(SIZE[0] * columns + 0.6, 2 * SIZE[1] + 0.8), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(2, columns, squeeze=False, sharex="col", **shared)
    return figure, panels


def _finish(figure: Figure, panels: Panels, picture: Path) -> None:
    entries: dict[str, Any] = {}
    for axes in panels.ravel():
        axes.grid(color="0.92")
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
        entries |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    place: Any = "outside lower center"
    figure.legend(list(entries.values()), list(entries), loc=place, ncols=3, frameon=False)
    save_figure(figure, picture)
