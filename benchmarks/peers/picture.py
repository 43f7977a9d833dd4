"""The diagram as a picture: a row of panels for each film, a column for each kind of work."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from peers.measure import Refinement
from peers.work_precision import WorkPrecision

FILMS = {"Film of triangles": ("triangles", "neo-Hookean"), "Net of springs": ("springs",)}
STYLE = {
    "membrane_rs rk4": ("C0", "o"),
    "membrane_rs leapfrog": ("C1", "s"),
    "membrane_rs dopri5": ("C2", "D"),
    "MuJoCo Euler": ("C3", "^"),
    "MuJoCo RK4": ("C4", "v"),
    "MuJoCo discrete": ("C5", "P"),
    "Newton semi-implicit": ("C6", "X"),
    "Newton VBD": ("C7", "<"),
    "Newton XPBD": ("C8", ">"),
}
COSTS = {"seconds": "Processor time [s]", "steps": "Steps"}
LARGEST = 10.0
"""Larger errors are left out: such runs blew up."""


def draw(diagram: WorkPrecision, path: Path) -> None:
    """Write a PNG."""
    figure = Figure(figsize=(11.5, 8.0), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(len(FILMS), len(COSTS), sharex="col", sharey="row")
    for (film, laws), row in zip(FILMS.items(), panels, strict=True):
        refinements = [refinement for refinement in diagram.refinements if refinement.program.law in laws]
        for axes, cost in zip(row, COSTS, strict=True):
            axes.set(xscale="log", yscale="log")
            for refinement in refinements:
                _line(axes, refinement, cost)
            axes.xaxis.set_minor_formatter(NullFormatter())
            axes.grid(color="0.92")
            axes.set_axisbelow(True)
            axes.spines[["top", "right"]].set_visible(False)
        row[0].set_ylabel(f"{film}\nError of positions, relative (RMS)")
        row[-1].legend(frameon=False, fontsize=9, loc="center left", bbox_to_anchor=(1.01, 0.5))
    for axes, label in zip(panels[-1], COSTS.values(), strict=True):
        axes.set_xlabel(label)
    until = diagram.problem.until
    figure.suptitle(f"Spinning {diagram.problem.name}, {until:g} s: each program against its own converged motion")
    figure.savefig(path, format="png", dpi=120)


def _line(axes: Axes, refinement: Refinement, cost: str) -> None:
    name = refinement.program.name
    colour, marker = STYLE[name]
    errors = np.array([level.error for level in refinement.levels])
    costs = np.array([float(getattr(level, cost)) for level in refinement.levels])
    shown = np.isfinite(errors) & (errors > 0.0) & (errors < LARGEST)
    label = name + (" (f32)" if refinement.program.bits == 32 else "")
    is_ours = name.startswith("membrane_rs")
    axes.plot(
        costs[shown],
        errors[shown],
        marker + ("-" if is_ours else "--"),
        color=colour,
        linewidth=1.6 if is_ours else 1.1,
        label=label,
    )
