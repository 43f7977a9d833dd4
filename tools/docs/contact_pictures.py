"""Pictures of docs/contact.md: crossings, cost, curves of all starts, and a folded arm."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from contact_runs import MODELS, scene_of
from membrane_rs import Simulation
from membrane_rs._arrays import Floats, Ints
from membrane_rs.mesh.crossings import crossings
from membrane_rs.plotting.camera import Camera
from membrane_rs.plotting.deployment import PANELS
from membrane_rs.plotting.figure import new_figure, save_figure
from membrane_rs.plotting.painter import painter
from membrane_rs.plotting.panels import add_legend, line_look
from membrane_rs.plotting.picture import Subject
from membrane_rs.plotting.style import INCH, SCREEN

WIDE = replace(SCREEN, width=9.0 * INCH)
MARKS = (0, 20, 40, 60, 80, 100, 200, 400, 800)
"""Of the axis of times of the picture of costs [ms]."""
FACTORS = (1, 2, 5, 10, 20, 50, 100)
"""Of its axis of times of a step."""
SEEN = 0.036
"""What the picture of an arm reaches around its section [m]."""
RAISED = np.array([0.0, 0.0, 0.012])
"""What the picture looks at, over the lower edge of the arm [m]."""
PIXELS = 900
CUT = 0.15
"""Distance of the section from the tip, along the arm [m]."""
WIDENED = 3.0
"""Scale of a section across the arm, over that along the axis."""
SHARED = 1e-9
"""Share of a line at its ends that may meet the next one."""
MARKED, FILM = 2, 1
"""Tones of triangles that cross, and of all others: numbers of petals."""


def draw_crossings(found: Mapping[str, Mapping[str, Mapping[str, Floats]]], picture: Path) -> None:
    """Pairs of triangles that cross, and the residual of the energy balance, of single runs by scene and contact."""
    with WIDE.context():
        figure = new_figure(WIDE, WIDE.size(2))
        panels = list(figure.subplots(2, 1, sharex=True))
        looks = 0
        for name, runs in found.items():
            for label, run in runs.items():
                time = 1e3 * run["counted"]
                panels[0].plot(time, run["crossings"], label=f"{name}, {label}", **line_look(looks))
                panels[1].plot(time, 100.0 * run["energy"], **line_look(looks))
                looks += 1
        panels[0].set_yscale("symlog", linthresh=10.0)
        panels[0].set_ylim(-1.0, 5e4)
        panels[0].yaxis.set_major_formatter("{x:,.0f}")
        panels[0].set_ylabel("Pairs that cross")
        panels[1].set_ylabel("Energy residual [%]")
        panels[1].set_xlabel("Time [ms]")
        for axes in panels:
            axes.margins(x=0.0)
        add_legend(figure, panels, WIDE)
        save_figure(figure, picture)


def draw_cost(
    edges: Sequence[float], ratios: Mapping[str, Sequence[float]], parts: Mapping[str, Sequence[float]], picture: Path
) -> None:
    """Time of a step with contact over that without in windows between `edges` [ms], by scene; shares of its parts."""
    with WIDE.context():
        figure = new_figure(WIDE, WIDE.size(2))
        axes, shares = figure.subplots(2, 1, sharex=True)
        for k, (name, values) in enumerate(ratios.items()):
            axes.stairs(values, edges, baseline=None, label=name, linewidth=WIDE.line_width, **line_look(k))
        axes.set_xscale("symlog", linthresh=100.0, linscale=2.0)
        axes.set_xticks(MARKS, labels=[f"{mark}" for mark in MARKS])
        axes.set_xlim(0.0, edges[-1])
        axes.set_yscale("log")
        axes.set_yticks(FACTORS, labels=[f"{factor}" for factor in FACTORS])
        axes.yaxis.minorticks_off()
        axes.set_ylabel("Time of a step,\nover that without contact")
        sums = np.cumsum([np.zeros(len(edges) - 1), *parts.values()], axis=0)
        for k, label in enumerate(parts):
            lower, upper = 100.0 * sums[k : k + 2] / sums[-1]
            look = line_look(len(ratios) + k)
            shares.stairs(upper, edges, baseline=lower, fill=True, label=label, color=look["color"])
        shares.set_ylim(0.0, 100.0)
        shares.set_ylabel(f"Shares of a step\nof {next(iter(ratios))} [%]")
        shares.set_xlabel("Time of the run [ms]")
        add_legend(figure, [axes, shares], WIDE)
        save_figure(figure, picture)


def draw_curves(found: Mapping[str, Mapping[str, Sequence[Mapping[str, Floats]]]], picture: Path) -> None:
    """Rate and phase of all starts, their mean and the band of one standard deviation: a column for each sail."""
    with WIDE.context():
        figure = new_figure(WIDE, WIDE.size(2))
        panels = figure.subplots(2, len(MODELS), sharex=True, sharey="row", squeeze=False)
        for row, (column, label, level) in enumerate(PANELS):
            panels[row, 0].set_ylabel(label)
            for axes, (model, kinds) in zip(panels[row], found.items(), strict=True):
                for k, (kind, runs) in enumerate(kinds.items()):
                    curves, look = np.array([run[column] for run in runs]), line_look(k)
                    time, mean, spread = runs[0]["time"], curves.mean(axis=0), curves.std(axis=0)
                    axes.fill_between(time, mean - spread, mean + spread, color=look["color"], alpha=0.25, linewidth=0)
                    axes.plot(time, mean, label=kind, **look)
                axes.axhline(level, color="0.5", linewidth=0.8)
                axes.margins(x=0.0)
                if row == 0:
                    axes.set_title(model)
        for axes in panels[-1]:
            axes.set_xlabel("Time [s]")
        add_legend(figure, list(panels.flat), WIDE)
        save_figure(figure, picture)


def draw_arm(shapes: Mapping[str, Floats], picture: Path) -> None:
    """An arm of model 1 at one instant, by contact: seen from above, and cut across the arm; triangles that cross, and
    points where the cut passes through itself, are marked.
    """
    sim = Simulation(scene_of(MODELS[0], with_contact=False))
    corner = int(sim.assembly.node_sets["corners"][0])
    with WIDE.context():
        figure = new_figure(WIDE, (WIDE.millimetres / INCH, 7.6))
        panels = figure.subplots(2, 2, height_ratios=(1.2, 1.0))
        for column, (label, shape) in zip(panels.T, shapes.items(), strict=True):
            pairs = crossings(sim.assembly.triangles, shape, limit=10**6).pairs
            marked = np.unique(pairs)
            column[0].imshow(_seen(sim, shape, corner, marked))
            column[0].set_title(f"{label}: {len(pairs):,} pairs of triangles cross")
            column[0].set_axis_off()
            _draw_section(column[1], sim.assembly.triangles, shape, shape[corner])
            column[1].set_xlabel(f"Across the arm [mm], {WIDENED:g} times as wide")
        panels[1, 0].set_ylabel("Along the axis [mm]")
        save_figure(figure, picture)


def _seen(sim: Simulation, shape: Floats, corner: int, marked: Ints) -> Any:
    """The picture of an arm, triangles that cross in a tone of their own."""
    outward = shape[corner] / np.linalg.norm(shape[corner])
    across = np.cross([0.0, 0.0, 1.0], outward)
    view = 0.7 * across + 0.3 * outward + np.array([0.0, 0.0, 0.65])
    view /= np.linalg.norm(view)
    up = np.array([0.0, 0.0, 1.0]) - view[2] * view
    centre = shape[corner] - CUT * outward + RAISED
    camera = Camera(centre, view, up / np.linalg.norm(up), SEEN)
    petals = np.full(len(sim.assembly.triangles), FILM, dtype=np.int8)
    petals[marked] = MARKED
    subject = replace(Subject.of(sim, [shape]), camera=camera, petals=petals, spool=None)
    with painter(subject, PIXELS) as artist:
        return artist.paint(shape)


def _draw_section(axes: Any, triangles: Ints, shape: Floats, tip: Floats) -> None:
    """The film in the plane across the arm, and points in which it passes through itself [mm]."""
    lines = section(triangles, shape, tip)
    axes.plot(*np.moveaxis(np.insert(1e3 * lines, 2, np.nan, axis=1).reshape(-1, 2), 1, 0), color="C0", linewidth=0.8)
    found = 1e3 * meetings(lines)
    axes.plot(*found.T, "o", color="C1", markersize=4.0, markerfacecolor="none", label="passes through itself")
    axes.set_aspect(1.0 / WIDENED)


def section(triangles: Ints, shape: Floats, tip: Floats) -> Floats:
    """(k, 2, 2) ends of the lines in which triangles meet a plane across the arm with this tip: across and along the
    axis [m].
    """
    outward = tip * [1.0, 1.0, 0.0]
    reach = float(np.linalg.norm(outward))
    outward /= reach
    height = shape @ outward - (reach - CUT)
    across = np.stack([shape @ np.cross([0.0, 0.0, 1.0], outward), shape[:, 2]], axis=1)
    found = []
    for corners in triangles[np.ptp(np.sign(height[triangles]), axis=1) > 0]:
        ends = []
        for a, b in ((0, 1), (1, 2), (2, 0)):
            low, high = height[corners[[a, b]]]
            if low * high < 0.0:
                ends.append(across[corners[a]] + low / (low - high) * (across[corners[b]] - across[corners[a]]))
        if len(ends) == 2:
            found.append(ends)
    return np.array(found).reshape(-1, 2, 2)


def meetings(lines: Floats) -> Floats:
    """(k, 2) points in which lines (n, 2, 2) pass through each other, inside of both."""
    start, along = lines[:, 0], lines[:, 1] - lines[:, 0]
    apart = start[None] - start[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        own = _cross(apart, along[None]) / _cross(along[:, None], along[None])
        other = _cross(apart, along[:, None]) / _cross(along[:, None], along[None])
    inside = (np.abs(own - 0.5) < 0.5 - SHARED) & (np.abs(other - 0.5) < 0.5 - SHARED)
    first, second = np.nonzero(np.triu(inside, 1))
    points: Floats = start[first] + own[first, second, None] * along[first]
    return points


def _cross(a: Floats, b: Floats) -> Floats:
    found: Floats = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return found
