"""Tables of docs/contact.md: crossings and energy, cost, and what contact changes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from statistics import median

import numpy as np
from contact_runs import COUNTED, OWN, PHASE, RATE, SPENT, WITH
from deployment_release import FEATURES
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from membrane_rs.results.features import curve_features

INSTANTS = (5, 10, 20, 30, 50, 100, 200, 400, 600, 800)
"""At which crossings are listed [ms]."""
EDGES = (*range(0, 100, 5), *range(100, 801, 50))
"""Of the windows in which times of steps are drawn [ms]."""
SHOWN = (0, 5, 10, 20, 30, 50, 100, 200, 400, 800)
"""Edges of the windows in which they are listed [ms]."""
PARTS = {
    "look_time": "looks at pairs",
    "list_time": "lists of pairs",
    "impulse_time": "impulses",
    "check_time": "exact checks",
}
"""Of the time of a step with contact, beside that of the film, by their names in `Motion.contact_statistics`."""
Runs = Sequence[Mapping[str, Floats]]


def crossings_table(found: Mapping[str, Mapping[str, Mapping[str, Floats]]]) -> str:
    """Pairs of triangles that cross at some instants of single runs, by scene and contact."""
    rows = [0, *(1 + COUNTED.index(instant) for instant in INSTANTS)]
    body = []
    for name, runs in found.items():
        for label, run in runs.items():
            counts = run["crossings"]
            listed = [f"{counts[k]:,.0f}" if k < len(counts) else "stopped" for k in rows]
            body.append((name, label, *listed, f"{counts.max():,.0f}"))
    return table(("scene", "ms", "0", *map(str, INSTANTS), "most"), body, words=(0, 1))


def energy_table(found: Mapping[str, Mapping[str, Mapping[str, Floats]]]) -> str:
    """Residual of the energy balance and work of contact, by scene and contact."""
    body = []
    for name, runs in found.items():
        for label, run in runs.items():
            k = np.abs(run["energy"]).argmax()
            body.append((
                name, label, f"{100.0 * run['energy'][k]:+.2f}", f"{1e3 * run['counted'][k]:.0f}",
                f"{100.0 * run['energy'][-1]:+.2f}", f"{1e6 * run['work'][-1]:.1f}" if label == WITH else "-",
                f"{1e6 * run['reference'][-1]:.0f}",
            ))  # fmt: skip
    heads = (
        "scene", "", "largest energy residual [%]", "at [ms]", "at the end [%]", "work of contact [uJ]",
        "reference energy [uJ]",
    )  # fmt: skip
    return table(heads, body, words=(0, 1))


def ratios(kinds: Mapping[str, Runs], edges: Sequence[int]) -> list[float]:
    """Median over the starts of the time with contact over that without, in each window [ms]."""
    found = []
    for first, last in pairwise(edges):
        times = [[run["seconds"][last] - run["seconds"][first] for run in kinds[kind]] for kind in (OWN, WITH)]
        found.append(median(with_contact / own for own, with_contact in zip(*times, strict=True)))
    return found


def cost_table(found: Mapping[str, Mapping[str, Runs]]) -> str:
    """Ratios in some windows and in the whole run, by model."""
    windows = [f"{first} to {last}" for first, last in pairwise(SHOWN)]
    body = []
    for model, kinds in found.items():
        every = [*ratios(kinds, SHOWN), *ratios(kinds, (0, SHOWN[-1]))]
        body.append((model, *(f"{ratio:.3g}" for ratio in every)))
    return table(("ms of the run", *windows, "all"), body, words=(0,))


def per_step(runs: Runs, name: str, edges: Sequence[int]) -> list[float]:
    """Median over the starts of what is spent in a step, in each window [ms]."""
    return [
        median((run[name][last] - run[name][first]) / (run["steps"][last] - run["steps"][first]) for run in runs)
        for first, last in pairwise(edges)
    ]


def times_of_step(kinds: Mapping[str, Runs], edges: Sequence[int]) -> dict[str, list[float]]:
    """Of the film and of each part of contact in each window [ms]: medians over the starts [us]."""
    film = {"film": per_step(kinds[OWN], "seconds", edges)}
    parts = {label: per_step(kinds[WITH], name, edges) for name, label in PARTS.items()}
    return {label: [1e6 * value for value in values] for label, values in (film | parts).items()}


def spent_table(kinds: Mapping[str, Runs]) -> str:
    """Time of a step by its parts, and pairs of a step, in some windows."""
    windows = [f"{first} to {last}" for first, last in pairwise(SHOWN)]
    times = times_of_step(kinds, SHOWN)
    times["all, with contact"] = [1e6 * value for value in per_step(kinds[WITH], "seconds", SHOWN)]
    body = [(f"{label} [us]", *(f"{value:,.0f}" for value in row)) for label, row in times.items()]
    for name in SPENT:
        if name not in PARTS:
            label = name.replace("_", " ")
            body.append((f"pairs {label}", *(f"{value:,.0f}" for value in per_step(kinds[WITH], name, SHOWN))))
    return table(("ms of the run", *windows), body, words=(0,))


def change_table(found: Mapping[str, Mapping[str, Runs]]) -> str:
    """Features of the curves, mean and standard deviation over the starts, by model and contact."""
    body = []
    for model, kinds in found.items():
        for kind, runs in kinds.items():
            each = [curve_features(run) for run in runs]
            cells = []
            for _, key, form in FEATURES:
                values = np.array([math.nan if one[key] is None else one[key] for one in each], dtype=np.float64)
                known = values[np.isfinite(values)]
                text = f"{known.mean():{form}} +- {known.std(ddof=1):{form}}" if len(known) > 1 else "-"
                cells.append(text if len(known) == len(values) else f"{text} ({len(known)} of {len(values)})")
            residuals = np.concatenate([run["energy"] for run in runs])
            residual = f"{100.0 * residuals[np.nanargmax(np.abs(residuals))]:+.2f}"
            body.append((model, kind, f"{len(runs)}", *cells, residual))
    heads = ("sail", "", "starts", *(label for label, _, _ in FEATURES), "energy residual [%]")
    return table(heads, body, words=(0, 1))


def distance_table(found: Mapping[str, Mapping[str, Runs]]) -> str:
    """Root mean square distance of the mean curves with contact from those without, and spread of the starts."""
    body = []
    for model, kinds in found.items():
        cells = []
        for key, form in ((RATE, ".4f"), (PHASE, ".1f")):
            curves = {kind: np.array([run[key] for run in runs]) for kind, runs in kinds.items()}
            apart = curves[WITH].mean(axis=0) - curves[OWN].mean(axis=0)
            spreads = [curves[kind].std(axis=0, ddof=1) for kind in (OWN, WITH)]
            cells += [f"{np.sqrt(np.mean(np.square(values))):{form}}" for values in (apart, *spreads)]
        body.append((model, *cells))
    heads = (
        "sail", "rate: change by contact", "spread of starts without", "with contact", "phase [deg]: change by contact",
        "spread without", "with contact",
    )  # fmt: skip
    return table(heads, body, words=(0,))
