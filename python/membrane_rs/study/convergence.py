"""What a mesh study's runs say together: how far the curves of one mesh are from those of the next, and at what rate.

With d(h) the distance of the curves on cells of height h from those on cells of h/r, an error that goes with h^p makes
d(h)/d(h/r) = r^p. So three meshes give one order p, and with p the limit that a number is on its way to (Richardson).
Where starts that differ by nothing to speak of make curves that differ, the mean over starts stands for a mesh,
and a distance counts where it is clear of what is left of that spread.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from membrane_rs.observe import Floats
from membrane_rs.output.report import curve_features
from membrane_rs.study.mesh import COLUMNS, MeshRun

POINTS = 2001
"""Instants at which curves are compared."""
CURVES = COLUMNS[1:]
_SHOWN = (
    ("first peak of the rate", "first_peak_rate", ".3f"),
    ("at [s]", "first_peak_time", ".3f"),
    ("trough of the phase [deg]", "phase_trough_deg", ".1f"),
    ("at [s]", "phase_trough_time", ".3f"),
    ("phase back at zero [s]", "zero_crossing_time", ".3f"),
    ("rate there", "zero_crossing_rate", ".3f"),
)


@dataclass(frozen=True)
class Density:
    """All runs of one form on one mesh."""

    form: str
    rows: int
    cell: float
    """Height of a cell [m]."""
    runs: tuple[MeshRun, ...]

    @property
    def until(self) -> float:
        """Time that all runs came to [s]."""
        return min(float(run.table["time"][-1]) for run in self.runs)

    def mean(self, column: str, times: Floats) -> Floats:
        """(n,) mean over the starts of a curve at the given times."""
        return np.asarray(self._curves(column, times).mean(axis=0))

    def spread(self, column: str, until: float) -> float:
        """Standard deviation over the starts, root mean square over the time; NaN from one start."""
        if len(self.runs) < 2:
            return math.nan
        curves = self._curves(column, np.linspace(0.0, until, POINTS))
        return float(np.sqrt(np.mean(curves.var(axis=0, ddof=1))))

    def feature(self, key: str) -> tuple[float, float]:
        """Mean over the starts of what a curve shows, and its standard deviation; NaN where there is none."""
        found = [run_features(run)[key] for run in self.runs]
        known = [value for value in found if value is not None]
        if len(known) < len(found):
            return math.nan, math.nan
        return float(np.mean(known)), float(np.std(known, ddof=1)) if len(known) > 1 else math.nan

    def _curves(self, column: str, times: Floats) -> Floats:
        return np.array([np.interp(times, run.table["time"], run.table[column]) for run in self.runs])


@dataclass(frozen=True)
class Step:
    """From one mesh to the next finer one, over the time that all meshes of the form cover."""

    coarse: Density
    fine: Density
    until: float
    distance: dict[str, float]
    """Root mean square distance of the mean curves, by column."""
    noise: dict[str, float]
    """What the spread of starts leaves in that distance, by column; NaN where no mesh has two starts."""

    @property
    def ratio(self) -> float:
        """By how much the cells are smaller."""
        return self.coarse.cell / self.fine.cell


def run_features(run: MeshRun) -> dict[str, float | None]:
    """Peak, trough and zero of a run's curves, None where it has not come that far."""
    return curve_features(run.table)


def densities(runs: Sequence[MeshRun]) -> dict[str, list[Density]]:
    """By form, from coarse to fine."""
    groups: dict[tuple[str, int], list[MeshRun]] = {}
    for run in runs:
        groups.setdefault((run.form, run.rows), []).append(run)
    found: dict[str, list[Density]] = {}
    for form, rows in sorted(groups, key=lambda key: key[1]):
        members = groups[form, rows]
        found.setdefault(form, []).append(Density(form, rows, members[0].cell, tuple(members)))
    return {form: found[form] for form in dict.fromkeys(run.form for run in runs)}


def steps(meshes: Sequence[Density], until: float | None = None) -> list[Step]:
    """Mesh to mesh, coarse to fine, over the time that all of them cover, or up to `until` [s]."""
    end = min([mesh.until for mesh in meshes] + ([until] if until is not None else []))
    times = np.linspace(0.0, end, POINTS)
    spreads = {c: [mesh.spread(c, end) for mesh in meshes] for c in CURVES}
    found = []
    for k, (a, b) in enumerate(pairwise(meshes)):
        distance, noise = {}, {}
        for c in CURVES:
            distance[c] = float(np.sqrt(np.mean((a.mean(c, times) - b.mean(c, times)) ** 2)))
            noise[c] = math.hypot(*(_known(spreads[c], k + j) / math.sqrt(len(m.runs)) for j, m in enumerate((a, b))))
        found.append(Step(a, b, end, distance, noise))
    return found


def _known(spreads: Sequence[float], k: int) -> float:
    """The spread of a mesh, or of the next coarser one that has several starts."""
    return next((spread for spread in reversed(spreads[: k + 1]) if math.isfinite(spread)), math.nan)


def orders(found: Sequence[Step], column: str) -> list[float]:
    """p from each three meshes in a row; NaN where the cells do not shrink by one ratio."""
    return [
        math.log(a.distance[column] / b.distance[column]) / math.log(a.ratio)
        if math.isclose(a.ratio, b.ratio, rel_tol=1e-6) and min(a.distance[column], b.distance[column]) > 0.0
        else math.nan
        for a, b in pairwise(found)
    ]


def overall_order(found: Sequence[Step], column: str) -> float:
    """p from all meshes: slope of log distance against log cell by least squares; NaN from less than three."""
    values = [(step.coarse.cell, step.distance[column]) for step in found if step.distance[column] > 0.0]
    if len(values) < 2:
        return math.nan
    x, y = np.log(np.array(values)).T
    return float(np.polyfit(x, y, 1)[0])


def limit(meshes: Sequence[Density], key: str, order: float) -> float:
    """What a feature tends to, from the two finest meshes and the order; NaN where that is not above a half."""
    if len(meshes) < 2 or not order > 0.5:
        return math.nan
    coarse, fine = (mesh.feature(key)[0] for mesh in meshes[-2:])
    return fine + (fine - coarse) / ((meshes[-2].cell / meshes[-1].cell) ** order - 1.0)


def report(runs: Sequence[MeshRun]) -> str:
    """Tables in Markdown: what the curves show, how far each mesh is from the next, at what order; then the verdict."""
    forms = densities(runs)
    return "\n".join([_shown(forms), _stepped(forms), verdict(forms)])


def _shown(forms: dict[str, list[Density]]) -> str:
    head = ["form", "cells [mm]", "nodes", "starts", "step [us]", *(name for name, _, _ in _SHOWN), "energy error [%]"]
    body = []
    for meshes in forms.values():
        for mesh in meshes:
            first = mesh.runs[0]
            cells = [_with_spread(*mesh.feature(key), form) for _, key, form in _SHOWN]
            stopped = next((run.stopped for run in mesh.runs if run.stopped), None)
            worst = max((run.energy_error for run in mesh.runs), key=abs)
            energy = f"{100 * worst:+.2f}" if stopped is None else f"stopped: {stopped}"
            sizes = [f"{1e3 * mesh.cell:.4g}", f"{first.node_count:,}", str(len(mesh.runs)), f"{1e6 * first.dt:.3g}"]
            body.append([mesh.form, *sizes, *cells, energy])
    return _markdown(head, body)


def _stepped(forms: dict[str, list[Density]]) -> str:
    head = ["form", "cells [mm]", "until [s]", "distance of the rates", "of the phases [deg]", "order, rate", "phase"]
    body = []
    for form, meshes in forms.items():
        found = steps(meshes)
        ps = {c: [math.nan, *orders(found, c)] for c in CURVES}
        for k, step in enumerate(found):
            cells = f"{1e3 * step.coarse.cell:.4g} to {1e3 * step.fine.cell:.4g}"
            values = [
                _with_spread(step.distance[c], step.noise[c], digits)
                for c, digits in zip(CURVES, (".4f", ".1f"), strict=True)
            ]
            body.append([form, cells, f"{step.until:.3g}", *values, *(_number(ps[c][k], ".1f") for c in CURVES)])
    return _markdown(head, body) if body else ""


def verdict(forms: dict[str, list[Density]]) -> str:
    """For each form with three meshes and more, in words: whether its curves approach a limit, and which."""
    lines = []
    for form, meshes in forms.items():
        found = steps(meshes)
        if len(found) < 2:
            continue
        p = {c: overall_order(found, c) for c in CURVES}
        shrinking = {c: all(b.distance[c] < a.distance[c] for a, b in pairwise(found)) for c in CURVES}
        over = f"over {len(meshes)} meshes, order {p[CURVES[0]]:.1f} in the rate and {p[CURVES[1]]:.1f} in the phase"
        if all(shrinking.values()) and min(p.values()) > 0.5:
            trough = limit(meshes, "phase_trough_deg", p[CURVES[1]])
            to = f"; the trough of the phase tends to {trough:.0f} degrees" if math.isfinite(trough) else ""
            last = [f"{found[-1].distance[c]:{d}}" for c, d in zip(CURVES, (".4f", ".1f"), strict=True)]
            text = f"approaches a limit: {over}; the last step is {last[0]} and {last[1]} degrees{to}"
        elif max(p.values()) < 0.5 and not any(shrinking.values()):
            text = f"no limit in sight: {over}"
        else:
            text = f"undecided: {over}"
        lines.append(f"- {form}: {text}.\n")
    return "".join(lines)


def _number(value: float, form: str) -> str:
    return f"{value:{form}}" if math.isfinite(value) else "-"


def _with_spread(value: float, spread: float, form: str) -> str:
    return _number(value, form) + (f" +- {spread:{form}}" if math.isfinite(spread) else "")


def _markdown(head: Sequence[str], body: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *body]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)
