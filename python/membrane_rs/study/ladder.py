"""A ladder of steps: the points that a method leaves on it, its measured order, and the cheapest way to an error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Point:
    """One method at one step.

    `share` is the step over the method's stability limit at the start; `errors` are NaN and `failure` says why
    where the watch stopped the run. `evaluations` and `seconds` are then what it had spent.
    """

    integrator: str
    dt: float
    share: float
    steps: int
    evaluations: int
    seconds: float
    errors: dict[str, float]
    failure: str | None
    failed_at: float | None


@dataclass(frozen=True)
class Best:
    """The method that reaches the wanted error at least cost, and its step, between two rungs."""

    integrator: str
    dt: float
    cost: float


def measured_order(points: Sequence[Point], name: str, clear: float) -> float:
    """Slope of error against step by least squares on logarithms, over steps of at most half the limit whose
    error is above `clear`; NaN with fewer than two of them.
    """
    used = [(p.dt, p.errors[name]) for p in points if p.share <= 0.5 and p.errors[name] > clear]
    if len(used) < 2:
        return math.nan
    dt, error = np.log(np.array(used)).T
    return float(np.polyfit(dt, error, 1)[0])


def cheapest(rungs: dict[str, list[Point]], name: str, wanted: float, cost: str) -> Best | None:
    """The method that reaches an error at least cost, steps beyond the limit left aside.

    Between the last rung above the wanted error and the first from which all finer ones are below it, step and
    cost are interpolated on logarithms.
    """
    found = []
    for method, points in rungs.items():
        below = [p for p in points if p.share <= 1.0]
        fits = [p.errors[name] <= wanted for p in below]  # False where the run was stopped
        k = next((i for i in range(len(below)) if all(fits[i:])), None)
        if k is None:
            continue
        dt, spent = below[k].dt, float(getattr(below[k], cost))
        above = below[k - 1].errors[name] if k else math.nan
        if math.isfinite(above) and below[k].errors[name] > 0.0:
            part = math.log(wanted / below[k].errors[name]) / math.log(above / below[k].errors[name])
            dt *= (below[k - 1].dt / dt) ** part
            spent *= (getattr(below[k - 1], cost) / spent) ** part
        found.append(Best(method, dt, spent))
    return min(found, key=lambda best: best.cost, default=None)
