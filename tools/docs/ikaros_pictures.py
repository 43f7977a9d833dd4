"""Pictures of docs/ikaros.md: spin of the whole deployment, and curves of the second stage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ikaros_momentum import BEFORE, CROSS, FLAT, State, predicted_curve
from ikaros_runs import PHASE, RATE
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from membrane_rs._arrays import Floats
from membrane_rs.plotting.figure import save_figure
from membrane_rs.plotting.stage_marks import mark_stages


def draw_spin(
    runs: Mapping[float, Mapping[str, Floats]], states: Sequence[State], names: Sequence[str], picture: Path
) -> None:
    """Spin against time, by inertia of the hub [kg m2]: the runs, the balance of momentum and the reported points."""
    figure = Figure(figsize=(7.0, 7.0), layout="constrained")
    FigureCanvasAgg(figure)
    panels = list(figure.subplots(2, 1))
    for axes, begin in zip(panels, (0.0, None), strict=True):
        for k, (inertia, run) in enumerate(runs.items()):
            start = run["end"][-2] - 2.0 if begin is None else begin
            inside = run["time"] >= start
            time = run["time"][inside]
            axes.plot(time, run["rpm"][inside], color=f"C{k}", linewidth=1.3, label=f"{inertia:g} kg m2")
            balance = predicted_curve(run, inertia)[inside]
            axes.plot(time, balance, color=f"C{k}", linewidth=0.8, linestyle="--")
    run = next(iter(runs.values()))
    middle = run["time"][[state.at.start for state in states if state.reported == CROSS]]
    panels[0].plot([0.0], [BEFORE], "ko", clip_on=False, label="reported", zorder=5)
    panels[0].hlines([CROSS], middle.min(), middle.max(), color="k", linewidth=2.5, zorder=5)
    for axes in panels:
        axes.hlines([FLAT], run["end"][-2], run["end"][-1], color="k", linewidth=2.5, zorder=5)
    mark_stages(panels[:1], list(enumerate([0.0, *run["end"][:-1].tolist()])), names)
    _finish(panels, ("Spin [rpm]", "Spin [rpm]"))
    panels[0].legend(frameon=False)
    save_figure(figure, picture)


def draw_second_stage(runs: Mapping[str, Mapping[str, Floats]], picture: Path) -> None:
    """Spin, deployment rate and phase of the second stage, by run."""
    figure = Figure(figsize=(7.0, 8.0), layout="constrained")
    FigureCanvasAgg(figure)
    panels = list(figure.subplots(3, 1, sharex=True))
    for k, (label, run) in enumerate(runs.items()):
        for axes, column in zip(panels, ("rpm", RATE, PHASE), strict=True):
            axes.plot(run["time"], run[column], color=f"C{k}", linewidth=1.2, label=label)
    panels[0].axhline(FLAT, color="k", linewidth=1.0, linestyle=":", label="reported, flat")
    _finish(panels, ("Spin [rpm]", "Deployment rate", "Phase difference [deg]"))
    figure.legend(*panels[0].get_legend_handles_labels(), frameon=False, loc="outside upper center", ncols=2)
    save_figure(figure, picture)


def _finish(panels: Sequence[Any], labels: Sequence[str]) -> None:
    for axes, label in zip(panels, labels, strict=True):
        axes.set_ylabel(label)
        axes.grid(color="0.9")
        axes.margins(x=0.0)
        axes.spines[["top", "right"]].set_visible(False)
    panels[-1].set_xlabel("Time [s]")
