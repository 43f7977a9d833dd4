"""Refinement levels, steps or tolerances: the results of a method at each, its order, and the cheapest to an error."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

BEYOND = (1.3, 1.05)
"""The two coarsest levels of a method with a stability limit, in multiples of it."""
COARSEST = 0.9
"""The coarsest level below the limit, in multiples of it; each further step is half as large."""
COARSEST_TOLERANCE = 1e-3
"""The coarsest tolerance of an adaptive method."""
TOLERANCE_RATIO = 10.0**1.5
"""Ratio of one tolerance to the next: 32, which halves the steps of a pair of orders 5 and 4."""
COARSEST_MULTIPLE = 64.0
"""The coarsest level of a method without limit, in multiples of the reference method's; each further one is half."""


@dataclass(frozen=True)
class RefinementLevel:
    """A run to be made: a method with a step [s] or a tolerance, and the method's stability limit [s]."""

    integrator: str
    density: float
    dt: float | None
    tolerance: float | None
    limit: float
    softening: float | None = None

    @property
    def model(self) -> tuple[float, float | None]:
        """What is run: the density of its mesh and the softening of its film."""
        return self.density, self.softening

    def __str__(self) -> str:
        line = line_name(self.integrator, self.density, self.softening)
        if self.dt is None:
            return f"{line}, tolerance {self.tolerance:.2g}"
        share = self.dt / self.limit
        return f"{line}, dt = {self.dt:.3g} s" + (f" ({share:.2f} of its limit)" if share else "")


@dataclass(frozen=True)
class Point:
    """The result of one method at one step or tolerance.

    If the monitor stopped the run, or its cost exceeded the budget, `errors` are NaN, `failure` is the reason, and
    `evaluations` and `seconds` count the part that was run.

    Attributes
    ----------
    integrator : str
        The method.
    dt : float
        Step [s]; the mean step of an adaptive method.
    share : float
        `dt` over the method's stability limit at the start [-]; 0 without limit.
    steps, evaluations : int
        Steps, and evaluations of the forces.
    seconds : float
        Processor time of the stepping [s].
    errors : dict of str to float
        By name, in the unit that the label of `WorkPrecision.labels` says.
    failure : str or None
        Why the run has no errors.
    failed_at : float or None
        When the monitor stopped it [s].
    tolerance : float or None
        Of a method that chooses its steps [-].
    rejected : int
        Rejected steps of such a method.
    density : float
        Of the mesh, as a multiple of the scene's [-].
    softening : float or None
        Of the film [-]; None: as it is.

    Examples
    --------
    >>> from membrane_rs.study import Point
    >>> point = Point("rk4", 1e-5, 0.5, 100, 400, 0.02, {"position": 1e-6}, None, None)
    >>> point.line, point.is_stable, point.words()
    ('rk4', True, '400 evaluations, 0.02 s, error 1.00e-06')
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
    softening: float | None = None

    @property
    def line(self) -> str:
        """The line of the diagram that it lies on: its method, its mesh where that is not the scene's own, and the
        softening of its film.
        """
        return line_name(self.integrator, self.density, self.softening)

    @property
    def resolves(self) -> bool:
        """Whether a measured order may include it: its step is set by accuracy, not by stability."""
        return self.share <= 0.5

    @property
    def is_stable(self) -> bool:
        """Whether the step is within the limit, or chosen by the error."""
        return self.tolerance is not None or self.share <= 1.0

    def words(self) -> str:
        """The result as text.

        Returns
        -------
        str
            In one line.
        """
        if self.failed_at is not None:
            return f"stopped at {self.failed_at:.3g} s"
        error = self.failure or f"error {next(iter(self.errors.values())):.2e}"
        return f"{self.evaluations:,} evaluations, {self.seconds:.3g} s, {error}"


@dataclass(frozen=True)
class Best:
    """The method that reaches the target error at least cost, with its interpolated step or tolerance.

    Attributes
    ----------
    integrator : str
        The method.
    dt : float
        Its step [s]; the mean one of an adaptive method.
    cost : float
        Evaluations of the forces [-], or processor time [s], as the key of `WorkPrecision.best` says.
    tolerance : float or None
        Of a method that chooses its steps [-].
    density : float
        Of the mesh, as a multiple of the scene's [-].
    softening : float or None
        Of the film [-]; None: as it is.

    Examples
    --------
    >>> from membrane_rs.study import Best
    >>> Best("rk4", 1e-5, 400.0).words()
    'rk4 with dt = 1e-05 s'
    """

    integrator: str
    dt: float
    cost: float
    tolerance: float | None = None
    density: float = 1.0
    softening: float | None = None

    def words(self) -> str:
        """The method with its step or tolerance as text.

        Returns
        -------
        str
            In one line.
        """
        name = line_name(self.integrator, self.density, self.softening)
        if self.tolerance is not None:
            return f"{name} with tolerance = {self.tolerance:.2g}"
        return f"{name} with dt = {self.dt:.3g} s"


def line_name(integrator: str, density: float, softening: float | None = None) -> str:
    """The method, with the density of the mesh where that is not the scene's own, and the softening of the film."""
    name = integrator if density == 1.0 else f"{integrator} on {density:g} x the mesh"
    return name if softening is None else f"{name} (softened {softening:g})"


def refinement_levels(
    integrator: str, density: float, steps: int, *, limit: float, unit: float, is_adaptive: bool
) -> list[RefinementLevel]:
    """The levels of a method, coarsest first.

    `limit` is its stability limit [s], infinite without one; `unit` that of the reference method.
    """
    if is_adaptive:
        return [
            RefinementLevel(integrator, density, None, COARSEST_TOLERANCE / TOLERANCE_RATIO**k, limit)
            for k in range(steps)
        ]
    if math.isinf(limit):
        sizes = [COARSEST_MULTIPLE * unit / 2.0**k for k in range(steps)]
        return [RefinementLevel(integrator, density, dt, None, limit) for dt in sizes]
    shares = [*BEYOND, *(COARSEST / 2.0**k for k in range(steps))]
    return [RefinementLevel(integrator, density, share * limit, None, limit) for share in shares]


def measured_order(points: Sequence[Point], name: str, clear: float) -> float:
    """Slope of error against step by least squares on logarithms, over the points that resolve the motion and
    whose error is above `clear`; NaN for fewer than two such points.
    """
    used = [(p.dt, p.errors[name]) for p in points if p.resolves and p.errors[name] > clear]
    if len({dt for dt, _ in used}) < 2:
        return math.nan
    dt, error = np.log(np.array(used)).T
    return float(np.polyfit(dt, error, 1)[0])


def finest_errors(points: Sequence[Point], name: str) -> tuple[float, bool]:
    """The error at the finest level that came to its end, NaN without any, and whether it has levelled out there: it is
    more than half of that at the level before. Steps beyond the limit are left out.
    """
    errors = [p.errors[name] for p in points if p.is_stable and math.isfinite(p.errors[name])]
    return (errors or [math.nan])[-1], len(errors) > 1 and errors[-1] > 0.5 * errors[-2]


def cheapest(lines: Mapping[str, Sequence[Point]], name: str, wanted: float, cost: str) -> Best | None:
    """The line that reaches an error at least cost, steps beyond the limit excluded.

    Step, tolerance and cost are interpolated on logarithms between the last level above the target error and the first
    from which all finer levels are below it.
    """
    found = []
    for points in lines.values():
        below = [p for p in points if p.is_stable]
        fits = [p.errors[name] <= wanted for p in below]  # False for a stopped run
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
        found.append(Best(here.integrator, between(here.dt, above.dt), spent, tolerance, here.density, here.softening))
    return min(found, key=lambda best: best.cost, default=None)
