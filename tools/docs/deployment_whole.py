"""One run of the whole deployment of each model, from the roll to the flat sail, with all that a run writes.

Its folder is kept. Balances, crossings, curves and contact sheets of the page are read from it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from deployment_reel import pull_at_tips, whole
from kept import kept, slug
from marked import copy_small
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from membrane_rs import Simulation
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from membrane_rs.errors import MissingFileError
from membrane_rs.plotting.figure import save_figure
from membrane_rs.plotting.sheets import stage_prefix
from membrane_rs.plotting.stage_marks import mark_stages, stage_starts
from membrane_rs.results import CrossingCounts, read_crossings, read_history, read_summary
from membrane_rs.simulation.motion import Motion

TIPS = "tips.npz"
SHEET = 0.75
"""Width of a contact sheet over its own."""
BEGIN = 0.05
"""Up to where the first crossing is looked for at each sample [s]."""
MEAN = 21
"""Samples over which the torque on the hub is averaged."""


class Tips:
    """An observer of the mean tension at the four tips [N], at each sample."""

    def __init__(self) -> None:
        self.rows: list[tuple[float, float]] = []

    def start(self, sim: Motion) -> None:
        """Nothing to do before the first sample."""

    def sample(self, sim: Motion) -> None:
        """Read the tension."""
        self.rows.append((sim.time, float(pull_at_tips(sim).mean())))

    def frame(self, sim: Motion) -> None:
        """Samples are enough."""

    def finish(self, sim: Motion, error: BaseException | None) -> None:
        """Nothing is left to do."""


def whole_run(folder: Path, model: str) -> Path:
    """The folder of a finished run; made where it is missing."""
    out = folder / slug("whole", model)
    try:
        is_there = read_summary(out)["outcome"] == "finished" and (out / TIPS).is_file()
    except MissingFileError:
        is_there = False
    if not is_there:
        print(f"whole {model}", flush=True)
        tips = Tips()
        Simulation(whole(model)).run(out=out, overwrite=True, crossings=True, observers=[tips])
        time, tension = np.array(tips.rows).T
        np.savez(out / TIPS, time=time, tension=tension)
    return out


def stages_of(folder: Path) -> Sequence[Mapping[str, Any]]:
    """What a summary says of each stage."""
    found: Sequence[Mapping[str, Any]] = read_summary(folder)["stages"]
    return found


def first_crossing(model: str) -> dict[str, Floats]:
    """Time at which the first triangles cross [s], to a sample of 1 ms; NaN after the first frames."""
    counts = CrossingCounts(samples=True)
    Simulation(whole(model)).run(until=BEGIN, frames=2, samples=51, observers=[counts])
    found = counts.table()
    begun = found["time"][found["crossing"] > 0]
    return {"time": begun[:1] if len(begun) else np.array([np.nan])}


def crossings_table(folders: Mapping[str, Path]) -> str:
    """Pairs of triangles that cross in each stage, by model."""
    body, begins = [], []
    for model, folder in folders.items():
        counts = read_crossings(folder)
        begin = float(kept(folder / "first_crossing.npz", partial(first_crossing, model))["time"][0])
        for stage in stages_of(folder):
            inside = (counts["time"] >= stage["start"] - 1e-9) & (counts["time"] <= stage["end"] + 1e-9)
            time, own = counts["time"][inside], counts["crossing"][inside]
            after = time - stage["start"]
            none = after[own == 0]
            body.append((
                model, stage["name"], f"{own[0]:,.0f}", f"{own.max():,.0f}", f"{after[own.argmax()]:.2f}",
                f"{own[-1]:,.0f}", f"{none[0]:.2f}" if len(none) and own[0] else "-",
            ))  # fmt: skip
        begins.append(f"{model} after {1e3 * begin:.0f} ms")
    heads = ("sail", "stage", "at its start", "most", "after [s]", "at its end", "none after [s]")
    return f"{table(heads, body, words=(0, 1))}\nThe first are seen in {' and in '.join(begins)}."


def draw_crossings(folders: Mapping[str, Path], picture: Path) -> None:
    """Crossings against time, of both models."""
    figure = Figure(figsize=(7.0, 3.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for k, (model, folder) in enumerate(folders.items()):
        counts = read_crossings(folder)
        axes.plot(counts["time"], counts["crossing"], color=f"C{k}", linewidth=1.2, label=model)
    axes.set_yscale("symlog", linthresh=10.0)
    axes.set_ylim(0.0, 2e7)
    axes.set_ylabel("Pairs of triangles that cross")
    axes.yaxis.set_major_formatter("{x:,.0f}")
    _finish(figure, [axes], next(iter(folders.values())))
    save_figure(figure, picture)


def draw_curves(folders: Mapping[str, Path], picture: Path) -> None:
    """Rate, phase, tension at the tips, and torque on the hub against time, of both models."""
    figure = Figure(figsize=(7.0, 9.0), layout="constrained")
    FigureCanvasAgg(figure)
    panels = list(figure.subplots(4, 1, sharex=True))
    for k, (model, folder) in enumerate(folders.items()):
        history, colour = read_history(folder), f"C{k}"
        with np.load(folder / TIPS) as tips:
            tension = 1e3 * tips["tension"]
            panels[2].plot(tips["time"], _mean(tension), color=colour, linewidth=1.2)
        time, torque = history["time"], -1e3 * history["hub_torque"]
        panels[0].plot(time, history["deployment_rate"], color=colour, linewidth=1.2, label=model)
        panels[1].plot(time, history["phase_difference_deg"], color=colour, linewidth=1.2)
        panels[3].plot(time, _mean(torque), color=colour, linewidth=1.2)
    labels = (
        "Deployment rate", "Phase difference [deg]", "Tension at the tips [mN]", "Torque on the sail [mN m]"
    )  # fmt: skip
    for axes, label in zip(panels, labels, strict=True):
        axes.set_ylabel(label)
    panels[0].set_ylim(0.0, 1.7)
    _finish(figure, panels, next(iter(folders.values())))
    save_figure(figure, picture)


def copy_sheets(folder: Path, model: str) -> None:
    """The contact sheet of each stage, and the balance of all stages, into docs/."""
    for index, stage in enumerate(stages_of(folder)):
        prefix = stage_prefix(index, stage["name"])
        name = f"deployment-{slug(model)}-{prefix}sheet.png"
        copy_small(folder / "snapshots" / f"{prefix}turning.png", name, share=SHEET)
    copy_small(folder / "energy.png", f"deployment-{slug(model)}-energy.png")


def _mean(values: Floats) -> Floats:
    """The moving mean, over fewer samples at both ends."""
    ones = np.ones(MEAN)
    sums: Floats = np.convolve(values, ones, "same") / np.convolve(np.ones(len(values)), ones, "same")
    return sums


def _finish(figure: Figure, panels: Sequence[Any], folder: Path) -> None:
    """Stages, grid, axes and the legend."""
    mark_stages(panels, stage_starts(read_history(folder)), [stage["name"] for stage in stages_of(folder)])
    for axes in panels:
        axes.grid(color="0.9")
        axes.margins(x=0.0)
        axes.spines[["top", "right"]].set_visible(False)
    panels[0].legend(frameon=False, loc="lower center")
    panels[-1].set_xlabel("Time [s]")
