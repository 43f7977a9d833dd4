"""A ladder of steps or tolerances: the points that a method leaves on it, its order, the cheapest way to an error."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

BEYOND = (1.3, 1.05)
"""The coarsest rungs of a method with a limit, as shares of it: beyond it."""
COARSEST = 0.9
"""The rung below the limit; each further one is half as large."""
COARSEST_TOLERANCE = 1e-3
"""The first tolerance of a method that chooses its steps."""
TOLERANCE_RATIO = 10.0**1.5
"""From one tolerance to the next: 32, which halves the steps of a pair of orders 5 and 4."""
COARSEST_MULTIPLE = 64.0
"""The first rung of a method without limit, in limits of the reference method; each further one is half as large."""


@dataclass(frozen=True)
class Rung:
    """One run to be made: a method with a step [s], or with a tolerance; and the method's stability limit [s]."""

    integrator: str
    density: float
    dt: float | None
    tolerance: float | None
    limit: float

    def __str__(self) -> str:
        line = line_name(self.integrator, self.density)
        if self.dt is None:
            return f"{line}, tolerance {self.tolerance:.2g}"
        share = self.dt / self.limit
        return f"{line}, dt = {self.dt:.3g} s" + (f" ({share:.2f} of its limit)" if share else "")


@dataclass(frozen=True)
class Point:
    """One method at one step, or at one tolerance.

    `dt` is the mean step where a tolerance chose it, and `rejected` counts tries in vain. `share` is `dt` over the
    method's stability limit at the start, 0 without limit. `errors` are NaN and `failure` says why where the watch
    stopped the run, or where it would have cost too much. `evaluations` and `seconds` are then what it had spent.
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
    tolerance: float | None = None
    rejected: int = 0
    density: float = 1.0

    @property
    def line(self) -> str:
        """The line of the chart that it lies on: its method, and its mesh where that is another."""
        return line_name(self.integrator, self.density)

    @property
    def resolves(self) -> bool:
        """Whether a measured order may count it: stability has no say in its step, chosen or given."""
        return self.share <= 0.5

    @property
    def is_stable(self) -> bool:
        """Whether the step does not lie beyond the limit; one chosen by the error takes care of that itself."""
        return self.tolerance is not None or self.share <= 1.0

    def words(self) -> str:
        """What it came to."""
        if self.failed_at is not None:
            return f"stopped at {self.failed_at:.3g} s"
        error = self.failure or f"error {next(iter(self.errors.values())):.2e}"
        return f"{self.evaluations:,} evaluations, {self.seconds:.3g} s, {error}"


@dataclass(frozen=True)
class Best:
    """The method that reaches the wanted error at least cost, and its step or tolerance, between two rungs."""

    integrator: str
    dt: float
    cost: float
    tolerance: float | None = None
    density: float = 1.0

    def words(self) -> str:
        """How to get there."""
        name = line_name(self.integrator, self.density)
        if self.tolerance is not None:
            return f"{name} with tolerance = {self.tolerance:.2g}"
        return f"{name} with dt = {self.dt:.3g} s"


def line_name(integrator: str, density: float) -> str:
    """A method, and the density of the mesh where it is not the scene's own."""
    return integrator if density == 1.0 else f"{integrator} on {density:g} x the mesh"


def ladder(integrator: str, density: float, steps: int, *, limit: float, unit: float, is_adaptive: bool) -> list[Rung]:
    """The ladder of a method, coarsest first.

    `limit` is its stability limit [s], infinite without one; `unit` that of the reference method.
    """
    if is_adaptive:
        return [Rung(integrator, density, None, COARSEST_TOLERANCE / TOLERANCE_RATIO**k, limit) for k in range(steps)]
    if math.isinf(limit):
        sizes = [COARSEST_MULTIPLE * unit / 2.0**k for k in range(steps)]
        return [Rung(integrator, density, dt, None, limit) for dt in sizes]
    shares = [*BEYOND, *(COARSEST / 2.0**k for k in range(steps))]
    return [Rung(integrator, density, share * limit, None, limit) for share in shares]


def measured_order(points: Sequence[Point], name: str, clear: float) -> float:
    """Slope of error against step by least squares on logarithms, over the points that resolve the motion and
    whose error is above `clear`; NaN with fewer than two of them.
    """
    used = [(p.dt, p.errors[name]) for p in points if p.resolves and p.errors[name] > clear]
    if len({dt for dt, _ in used}) < 2:
        return math.nan
    dt, error = np.log(np.array(used)).T
    return float(np.polyfit(dt, error, 1)[0])


def cheapest(lines: Mapping[str, Sequence[Point]], name: str, wanted: float, cost: str) -> Best | None:
    """The line that reaches an error at least cost, steps beyond the limit left aside.

    Between the last rung above the wanted error and the first from which all finer ones are below it, step,
    tolerance and cost are interpolated on logarithms.
    """
    found = []
    for points in lines.values():
        below = [p for p in points if p.is_stable]
        fits = [p.errors[name] <= wanted for p in below]  # False where the run was stopped
        k = next((i for i in range(len(below)) if all(fits[i:])), None)
        if k is None:
            continue
        here, part = below[k], 0.0
        above = below[k - 1] if k else here
        if k and math.isfinite(above.errors[name]) and here.errors[name] > 0.0:
            part = math.log(wanted / here.errors[name]) / math.log(above.errors[name] / here.errors[name])

        def between(at: float, before: float, part: float = part) -> float:
            return at * (before / at) ** part if at > 0.0 and before > 0.0 else at

        tolerance = None
        if here.tolerance is not None and above.tolerance is not None:
            tolerance = between(here.tolerance, above.tolerance)
        spent = between(float(getattr(here, cost)), float(getattr(above, cost)))
        found.append(Best(here.integrator, between(here.dt, above.dt), spent, tolerance, here.density))
    return min(found, key=lambda best: best.cost, default=None)
