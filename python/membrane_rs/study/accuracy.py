"""Accuracy against work: every method over a ladder of steps, against a reference far finer than all.

Where the motion is smooth the error is pointwise; where it is chaotic it is that of the curves, and an
ensemble of perturbed starts tells how near any two runs can be expected to come.

The steps are shares of each method's own stability limit at the start. Those beyond it show whether the watch
catches what goes wrong there.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from membrane_rs._files import output_errors, replacing
from membrane_rs._validation import nearest
from membrane_rs.errors import InputError
from membrane_rs.observe import Floats
from membrane_rs.output.report import versions, write_summary
from membrane_rs.output.work_precision import COSTS, Line, Row, plot_work_precision
from membrane_rs.scene import Scene
from membrane_rs.simulation import Simulation, integrators
from membrane_rs.study.ladder import Best, Point, cheapest, measured_order
from membrane_rs.study.trial import SHIFT, Course, Trial, course, ensemble, run

BEYOND = (1.3, 1.05)
"""The coarsest rungs, as shares of the stability limit: beyond it."""
COARSEST = 0.9
"""The rung below the limit; each further one is half as large."""
REFERENCE = "rk4"
"""The method of the reference; it takes a quarter of its own finest rung."""
UNLIMITED_SHARE = 4.0
"""The ladder of a method without a limit is that of the reference, so much coarser."""
LADDER_SHARE = 0.25
ENSEMBLE_SHARE = 0.225
"""The step of the ensemble, as a share of the reference method's limit: any that resolves the motion does."""
CLEAR = 10.0
"""An error counts for a measured order where it is this many times what bounds it from below."""


def position_error(trial: Trial, reference: Trial, start: Floats) -> float:
    """RMS over nodes and instants of the difference in position, over the RMS displacement from the start."""
    scale = float(np.sqrt(np.mean((reference.shapes - start) ** 2)))
    if scale == 0.0:
        raise InputError("nothing moves in this scene up to the end; give a later one, or another scene")
    return float(np.sqrt(np.mean((trial.shapes - reference.shapes) ** 2))) / scale


def rate_error(trial: Trial, reference: Trial, _: Floats) -> float:
    """Largest difference in the deployment rate."""
    return float(np.abs(trial.rate - reference.rate).max())


def phase_error(trial: Trial, reference: Trial, _: Floats) -> float:
    """Largest difference in the phase [deg]."""
    return float(np.abs(trial.phase - reference.phase).max())


Error = Callable[[Trial, Trial, Floats], float]
POINTWISE: dict[str, tuple[str, Error]] = {"position": ("Error of positions, relative (RMS)", position_error)}
CURVES: dict[str, tuple[str, Error]] = {
    "rate": ("Error of the deployment rate (largest)", rate_error),
    "phase": ("Error of the phase [deg] (largest)", phase_error),
}


@dataclass(frozen=True)
class Chart:
    """What a chart shows.

    Attributes
    ----------
    scene, until, instants :
        What was run, to which time [s], and read how often.
    points : tuple of Point
        Coarsest first, method by method.
    labels : dict
        What each kind of error is.
    reference_dt : float
        Step of the reference [s].
    reference_errors : dict
        The reference against itself at twice its step.
    floors : dict
        Largest error between perturbed starts; NaN without ensemble.
    wanted : float
        The wanted error, of the first kind.
    orders : dict
        Measured order, by method and kind of error; NaN where too few points stand clear.
    best : dict
        By kind of cost; None where no method reaches the wanted error.
    """

    scene: str
    until: float
    instants: int
    members: int
    points: tuple[Point, ...]
    labels: dict[str, str]
    reference_dt: float
    reference_errors: dict[str, float]
    floors: dict[str, float]
    wanted: float
    orders: dict[str, dict[str, float]]
    best: dict[str, Best | None]

    def rungs(self, integrator: str) -> list[Point]:
        """The points of one method, coarsest first."""
        return [point for point in self.points if point.integrator == integrator]

    def summary(self) -> str:
        """The result in words."""
        lines = [f"{self.scene}, {self.until:g} s, read at {self.instants} instants"]
        for name, label in self.labels.items():
            lines.append(f"{label}:")
            lines.append(
                f"  reference: {REFERENCE} at {self.reference_dt:.3g} s, "
                f"{self.reference_errors[name]:.1e} from itself at twice that step"
            )
            if self.members:
                spread = f"  spread of {self.members} starts shifted by {SHIFT:g} m: {self.floors[name]:.1e}"
                lines.append(spread + ("; no method can be said to be nearer" if name in CURVES else ""))
            for method, orders in self.orders.items():
                order = f"{orders[name]:.2f}" if math.isfinite(orders[name]) else "not clear of the bounds"
                lines.append(f"  {method}: measured order {order}")
        first = next(iter(self.labels))
        for cost, best in self.best.items():
            what = f"{COSTS[cost].lower()} for an error of {self.wanted:g} ({first})"
            lines.append(
                f"Least {what}: {best.integrator} with dt = {best.dt:.3g} s, {best.cost:.3g}"
                if best
                else f"Least {what}: no method of the ladder reaches it below its limit"
            )
        bound = _bounds(self.reference_errors, self.floors, curves=first in CURVES)[first]
        if self.wanted < bound:
            lines.append(f"But an error of {self.wanted:g} cannot be told apart here: the bound is {bound:.1e}.")
        return "\n".join(lines)

    def save(self, folder: Path | str) -> None:
        """Write chart.csv, chart.json and chart.png into a folder. Raises OutputError."""
        folder = Path(folder)
        with output_errors(folder):
            folder.mkdir(parents=True, exist_ok=True)
        with replacing(folder / "chart.csv") as part, part.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            names = ["integrator", "dt", "share_of_limit", "steps", "evaluations", "seconds"]
            writer.writerow([*names, *(f"{name}_error" for name in self.labels), "failed_at", "failure"])
            for p in self.points:
                row = [p.integrator, p.dt, p.share, p.steps, p.evaluations, p.seconds]
                writer.writerow([*row, *p.errors.values(), p.failed_at, p.failure])
        write_summary(folder / "chart.json", self._as_dict())
        plot_work_precision(self._rows(), folder / "chart.png", f"{self.scene}, first {1e3 * self.until:g} ms")

    def _as_dict(self) -> dict[str, Any]:
        plain = {name: value for name, value in vars(self).items() if name not in ("points", "best")}
        best = {cost: vars(found) if found else None for cost, found in self.best.items()}
        reference = {"reference": REFERENCE, "points": [vars(point) for point in self.points]}
        return {**plain, "best": best, **reference, "versions": versions()}

    def _rows(self) -> list[Row]:
        return [
            Row(
                label,
                [self._line(method, name) for method in self.orders],
                self.reference_errors[name],
                self.floors[name],
                self.wanted if name == next(iter(self.labels)) else math.nan,
            )
            for name, label in self.labels.items()
        ]

    def _line(self, method: str, name: str) -> Line:
        """A method's rungs; one that failed is drawn at the cost that it would have had."""
        points = self.rungs(method)
        done = [p for p in points if p.failure is None]
        costs = {cost: np.array([float(getattr(p, cost)) for p in points]) for cost in COSTS}
        for k, p in enumerate(points):
            for cost in COSTS:
                per_step = median(getattr(q, cost) / q.steps for q in done) if done else math.nan
                if p.failure is not None:
                    costs[cost][k] = per_step * self.until / p.dt
        order = self.orders[method][name]
        label = f"{method}: order {order:.1f}" if math.isfinite(order) else method
        errors = np.array([p.errors[name] for p in points])
        return Line(label, costs, errors, np.array([p.share > 1.0 for p in points]))


def chart(
    scene: Scene,
    methods: Sequence[str] | None = None,
    until: float | None = None,
    *,
    steps: int = 6,
    curves: bool = False,
    members: int | None = None,
    wanted: float = 1e-3,
    repeats: int = 3,
    instants: int | None = None,
    progress: Callable[[str], None] | None = None,
) -> Chart:
    """Run a scene by each method over a ladder of steps, and measure errors and costs.

    Parameters
    ----------
    scene : Scene
        What is run. It should be smooth up to the end, or `curves` be set.
    methods : sequence of str, optional
        Integrators. Default: all.
    until : float, optional
        Time at the end [s]. Default: the scene's.
    steps : int
        Rungs below the stability limit, from 0.9 of it, each half as large; two more lie beyond it.
    curves : bool
        The error is that of deployment rate and phase, not that of the positions.
    members : int, optional
        Runs from perturbed starts, which set the floor; 0: none. Default: 4 with `curves`, else none.
    wanted : float
        The error for which the cheapest method is named (of the rate, with `curves`).
    repeats : int
        Runs of which the wall time is the median.
    instants : int, optional
        How often positions (default 10) or curves (default 100) are compared.
    progress : callable, optional
        Told in words what was just done.

    Raises
    ------
    InputError
        An unknown method, a number out of its range, a scene in which nothing moves.
    UnstableError
        The reference itself stopped.
    """
    names = _methods(methods)
    members = (4 if curves else 0) if members is None else members
    for what, value, least in (("steps", steps, 1), ("ensemble", members, 0), ("repeats", repeats, 1)):
        if value < least:
            raise InputError(f"{what} = {value}: must be {least} or above")
    if not 0.0 < wanted < math.inf:
        raise InputError(f"error = {wanted}: must be greater than 0 and finite")
    tell = progress or (lambda _: None)
    kinds = CURVES if curves else POINTWISE
    where = course(scene, until, instants or (100 if curves else 10))
    keep = not curves

    limit = Simulation(where.scene, REFERENCE).stable_dt()
    shares = [*BEYOND, *(COARSEST / 2.0**k for k in range(steps))]
    finest = LADDER_SHARE * shares[-1] * limit
    reference = _whole(run(where, REFERENCE, finest, shapes=keep))
    tell(f"reference: {REFERENCE}, dt = {reference.dt:.3g} s, {reference.seconds:.1f} s")
    check = _whole(run(where, REFERENCE, 2.0 * finest, shapes=keep))

    def errors(trial: Trial, true: Trial = reference) -> dict[str, float]:
        failed = trial.failure is not None
        return {name: math.nan if failed else error(trial, true, where.start) for name, (_, error) in kinds.items()}

    floors = dict.fromkeys(kinds, math.nan)
    if members:
        peer, *others = map(_whole, ensemble(where, REFERENCE, ENSEMBLE_SHARE * limit, members, shapes=keep))
        floors = {name: max(errors(other, peer)[name] for other in others) for name in kinds}
        tell(f"ensemble of {members} perturbed starts")
    points = []
    for method in names:
        for share in shares:
            points.append(_point(where, method, share, repeats, errors, shapes=keep))
            tell(f"{method}: {_told(points[-1])}")
    clear = {name: CLEAR * value for name, value in _bounds(errors(check), floors, curves=curves).items()}
    rungs = {method: [p for p in points if p.integrator == method] for method in names}
    return Chart(
        scene=where.scene.name,
        until=where.until,
        instants=where.instants,
        members=members,
        points=tuple(points),
        labels={name: label for name, (label, _) in kinds.items()},
        reference_dt=reference.dt,
        reference_errors=errors(check),
        floors=floors,
        wanted=wanted,
        orders={m: {name: measured_order(rungs[m], name, clear[name]) for name in kinds} for m in names},
        best={cost: cheapest(rungs, next(iter(kinds)), wanted, cost) for cost in COSTS},
    )


def _bounds(reference: dict[str, float], floors: dict[str, float], *, curves: bool) -> dict[str, float]:
    """Below what errors say nothing: the reference's own, and for curves the spread of perturbed starts.

    Pointwise all runs have the same start to the last bit, so a spread does not keep them apart.
    """
    return {name: float(np.fmax(value, floors[name] if curves else 0.0)) for name, value in reference.items()}


def _methods(wanted: Sequence[str] | None) -> list[str]:
    known = list(integrators())
    for name in wanted or ():
        if name not in known:
            raise InputError(f"integrators: there is no {name!r}; {nearest(name, known)}")
    return list(dict.fromkeys(wanted or known))


def _whole(trial: Trial) -> Trial:
    """The trial, where it came to its end."""
    if trial.failure is not None:
        raise trial.failure
    return trial


def _point(
    where: Course, method: str, share: float, repeats: int, errors: Callable[[Trial], dict[str, float]], *, shapes: bool
) -> Point:
    limit = Simulation(where.scene, method).stable_dt()
    if not math.isfinite(limit):
        limit = UNLIMITED_SHARE * Simulation(where.scene, REFERENCE).stable_dt()
    trials = [run(where, method, share * limit, shapes=shapes)]
    trial = trials[0]
    if trial.failure is None:
        trials += [run(where, method, share * limit) for _ in range(repeats - 1)]
    failed = trial.failure
    return Point(
        integrator=method,
        dt=trial.dt,
        share=trial.dt / limit,
        steps=trial.steps,
        evaluations=trial.evaluations,
        seconds=median(t.seconds for t in trials),
        errors=errors(trial),
        failure=None if failed is None else str(failed),
        failed_at=None if failed is None else failed.time,
    )


def _told(point: Point) -> str:
    result = f"stopped at {point.failed_at:.3g} s" if point.failure else f"{next(iter(point.errors.values())):.2e}"
    return f"dt = {point.dt:.3g} s ({point.share:.2f} of its limit), {point.evaluations} evaluations, error {result}"
