"""Work-precision diagram: the error of every method against its cost, over steps or tolerances.

The reference is a far finer run. For a smooth motion the error is that of the positions. For a chaotic motion it is
that of the curves, and the spread of an ensemble of perturbed starts bounds it from below.

Steps are multiples of each method's own stability limit at the start. Those beyond the limit show whether the monitor
detects the instability. An adaptive method takes tolerances; a method without limit takes multiples of the limit of
the reference method.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from threading import Event
from typing import Any

import numpy as np

from membrane_rs._files import made_folder, replacing
from membrane_rs._validation import nearest, show
from membrane_rs.errors import InputError
from membrane_rs.plotting.work_precision import COSTS, Line, Row, plot_work_precision
from membrane_rs.results.run_summary import versions
from membrane_rs.results.summary import write_summary
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.simulation import integrators
from membrane_rs.study.common.density import denser
from membrane_rs.study.common.differences import CURVES, POINTWISE
from membrane_rs.study.common.executor import Tell, run_parallel
from membrane_rs.study.common.perturbation import SHIFT
from membrane_rs.study.common.run import StudyCase, StudyRun, ensemble, run_case, study_case
from membrane_rs.study.refinement import (
    COARSEST,
    Best,
    Point,
    RefinementLevel,
    cheapest,
    line_name,
    measured_order,
    refinement_levels,
)

REFERENCE = "rk4"
"""The method of the reference."""
REFERENCE_SHARE = {False: 0.25, True: 0.5}
"""Ratio of its step to that of its own finest level; for curves a finer one is useless because of chaos."""
REFERENCE_MOST = 0.125 * COARSEST
"""Upper bound of its step as a share of the limit, for any number of levels."""
ENSEMBLE, ENSEMBLE_SHARE = "leapfrog", 0.25
"""Method of the perturbed starts, and its step over its limit; their spread belongs to the motion, not the method."""
CLEAR = 10.0
"""Ratio to the lower bound from which an error counts for a measured order."""


@dataclass(frozen=True)
class WorkPrecision:
    """The data of a work-precision diagram.

    Attributes
    ----------
    scene, until, instants :
        Scene, time at the end [s], and number of samples.
    points : tuple of Point
        By method, coarsest level first.
    labels : dict
        Label of each kind of error.
    reference_dt, reference_density : float
        Step of the reference [s], and ratio of the density of its mesh to the scene's.
    reference_errors : dict
        Difference of the reference from itself at twice its step.
    floors : dict
        Largest error between perturbed starts; NaN without ensemble.
    wanted : float
        The target error, of the first kind.
    orders : dict
        Measured order, by line (a method, or a method on another mesh) and kind of error; NaN if too few errors
        exceed the lower bound clearly.
    best : dict
        By kind of cost; None if no method reaches the target error.
    """

    scene: str
    until: float
    instants: int
    members: int
    points: tuple[Point, ...]
    labels: dict[str, str]
    reference_dt: float
    reference_density: float
    reference_errors: dict[str, float]
    floors: dict[str, float]
    wanted: float
    orders: dict[str, dict[str, float]]
    best: dict[str, Best | None]

    def points_of(self, line: str) -> list[Point]:
        """The points of one line, coarsest first."""
        return [point for point in self.points if point.line == line]

    def summary(self) -> str:
        """The result as text."""
        lines = [f"{self.scene}, {self.until:g} s, {self.instants} samples"]
        for name, label in self.labels.items():
            lines.append(f"{label}:")
            lines.append(
                f"  reference: {line_name(REFERENCE, self.reference_density)} at {self.reference_dt:.3g} s, "
                f"{self.reference_errors[name]:.1e} from itself at twice that step"
            )
            if self.members:
                spread = f"  spread of {self.members} starts perturbed by {SHIFT:g} m: {self.floors[name]:.1e}"
                lines.append(spread + ("; smaller errors are indistinguishable" if name in CURVES else ""))
            lines += [f"  {line}: {self._described(line, orders[name])}" for line, orders in self.orders.items()]
        first = next(iter(self.labels))
        for cost, best in self.best.items():
            what = f"{COSTS[cost].lower()} for an error of {self.wanted:g} ({first})"
            lines.append(
                f"Least {what}: {best.words()}, {best.cost:.3g}"
                if best
                else f"Least {what}: no method reaches it below its limit"
            )
        bound = _bounds(self.reference_errors, self.floors, curves=first in CURVES)[first]
        if self.wanted < bound:
            lines.append(f"An error of {self.wanted:g} is below the lower bound of {bound:.1e}.")
            by_line = {line: self.points_of(line) for line in self.orders}
            for cost, words in COSTS.items():
                found = cheapest(by_line, first, bound, cost)
                lines += [f"Least {words.lower()} within the bound: {found.words()}, {found.cost:.3g}"] if found else []
        return "\n".join(lines)

    def _described(self, line: str, order: float) -> str:
        """A line as text: its order, and the number of runs stopped or left out."""
        points = self.points_of(line)
        stopped = [p for p in points if p.failed_at is not None]
        dear = [p for p in points if p.failure is not None and p.failed_at is None]
        why = "no order, too few errors depend on the step and exceed the bounds"
        words = [f"measured order {order:.2f}" if math.isfinite(order) else why]
        words += [f"{len(stopped)} of {len(points)} runs stopped by the monitor"] if stopped else []
        words += [f"{len(dear)} of {len(points)} runs left out as too costly"] if dear else []
        return ", ".join(words)

    def save(self, folder: Path | str) -> None:
        """Write chart.csv, chart.json and chart.png into a folder. Raises OutputError."""
        folder = made_folder(folder)
        with replacing(folder / "chart.csv") as part, part.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            names = ["integrator", "density", "dt", "share_of_limit", "tolerance", "steps", "rejected", "evaluations"]
            names.append("seconds")
            writer.writerow([*names, *(f"{name}_error" for name in self.labels), "failed_at", "failure"])
            for p in self.points:
                row = [p.integrator, p.density, p.dt, p.share, p.tolerance, p.steps, p.rejected, p.evaluations]
                row.append(p.seconds)
                writer.writerow([*row, *p.errors.values(), p.failed_at, p.failure])
        write_summary(folder / "chart.json", self.as_dict())
        plot_work_precision(self._rows(), folder / "chart.png", f"{self.scene}, first {1e3 * self.until:g} ms")

    def as_dict(self) -> dict[str, Any]:
        """All data as plain numbers and texts, as chart.json holds them."""
        plain = {name: value for name, value in vars(self).items() if name not in ("points", "best")}
        best = {cost: vars(found) if found else None for cost, found in self.best.items()}
        reference = {"reference": REFERENCE, "points": [vars(point) for point in self.points]}
        return {**plain, "best": best, **reference, "versions": versions()}

    def _rows(self) -> list[Row]:
        return [
            Row(
                label,
                [self._line(line, name) for line in self.orders],
                self.reference_errors[name],
                self.floors[name],
                self.wanted if name == next(iter(self.labels)) else math.nan,
            )
            for name, label in self.labels.items()
        ]

    def _line(self, line: str, name: str) -> Line:
        """A line's points; a stopped run is drawn at its extrapolated cost."""
        points = self.points_of(line)
        done = [p for p in points if p.failure is None]
        costs = {cost: np.array([float(getattr(p, cost)) for p in points]) for cost in COSTS}
        for k, p in enumerate(points):
            for cost in COSTS:
                per_step = median(getattr(q, cost) / q.steps for q in done) if done else math.nan
                if p.failure is not None:
                    costs[cost][k] = per_step * self.until / p.dt if p.failed_at is not None else math.nan
        order = self.orders[line][name]
        label = f"{line}: order {order:.1f}" if math.isfinite(order) else line
        errors = np.array([p.errors[name] for p in points])
        return Line(label, costs, errors, np.array([not p.is_stable for p in points]))


def work_precision(
    scene: Scene,
    methods: Sequence[str] | None = None,
    until: float | None = None,
    *,
    steps: int = 6,
    curves: bool = False,
    members: int | None = None,
    densities: Sequence[float] = (),
    wanted: float = 1e-3,
    repeats: int | None = None,
    instants: int | None = None,
    budget: float | None = None,
    jobs: int | None = None,
    progress: Tell | None = None,
) -> WorkPrecision:
    """Run a scene by each method over a series of steps or tolerances, and measure errors and costs.

    Parameters
    ----------
    scene : Scene
        The scene. Its motion should be smooth up to the end, or `curves` be set.
    methods : sequence of str, optional
        Integrators. Default: all.
    until : float, optional
        Time at the end [s]. Default: the scene's.
    steps : int
        Levels below the stability limit, from 0.9 of it, each half as large; two more lie beyond it. As many
        tolerances, from 1e-3, each a 32nd; as many steps of a method without limit, from 64 limits of rk4.
    curves : bool
        Measure the error of deployment rate and phase, not of the positions.
    members : int, optional
        Runs from perturbed starts, whose spread is the lower bound; 0: none. Default: 4 with `curves`, else none. A
        run that the monitor stops is not counted.
    densities : sequence of float
        Other meshes, as multiples of the scene's density; needs `curves`. Each is a line of its own, run by the
        method of the fewest evaluations a step, and all errors are then against the finest mesh.
    wanted : float
        The target error, for which the cheapest method is given (of the rate, with `curves`).
    repeats : int, optional
        Runs of which the time is the median. Default: 1 with `curves`, else 3.
    instants : int, optional
        Number of samples at which positions (default 10) or curves (default 100) are compared.
    budget : float, optional
        Processor time that a run may take [s]; one that would take more is left out and reported.
    jobs : int, optional
        Number of parallel runs of an ensemble and with `curves`. Default: one on each core. Only times depend on it.
    progress : callable, optional
        Called with a line of text after each run.

    Returns
    -------
    WorkPrecision
        Points, reference and best of each method.

    Raises
    ------
    InputError
        An unknown method, a number outside its range, a density that the mesh cannot represent, a scene without
        motion.
    UnstableError
        The reference run stopped.
    """
    names = _methods(methods)
    members = (4 if curves else 0) if members is None else members
    repeats = (1 if curves else 3) if repeats is None else repeats
    for what, value, least in (("steps", steps, 1), ("ensemble", members, 0), ("repeats", repeats, 1)):
        if value < least:
            raise InputError(f"{what} = {value}: must be {least} or above")
    for what, number in (("error", wanted), ("budget", budget)):
        if number is not None and not 0.0 < number < math.inf:
            raise InputError(f"{what} = {number}: must be greater than 0 and finite")
    if densities and not curves:
        raise InputError(
            f"densities = {show(tuple(densities))}: meshes have different nodes, so only curves can be compared; "
            "add --curves"
        )
    tell = progress or (lambda _: None)
    kinds = CURVES if curves else POINTWISE
    count = (100 if curves else 10) if instants is None else instants
    meshes = {1.0: study_case(scene, until, count)}
    meshes |= {float(d): study_case(denser(scene, d), until, count) for d in sorted(set(densities)) if d != 1.0}
    case, finest_mesh = meshes[1.0], max(meshes)

    levels = [level for density, mesh in meshes.items() for level in _levels(mesh, names, density, steps)]
    finest = min(REFERENCE_SHARE[curves] * COARSEST / 2.0 ** (steps - 1), REFERENCE_MOST)
    finest *= Simulation(meshes[finest_mesh].scene, REFERENCE).stable_dt()
    stop = Event()

    def reference_at(dt: float) -> StudyRun:
        return run_case(meshes[finest_mesh], REFERENCE, dt, shapes=not curves, stop=stop).completed()

    labels = [f"reference: {REFERENCE}, dt = {dt:.3g} s" for dt in (finest, 2.0 * finest)]
    makes = [lambda dt=dt: reference_at(dt) for dt in (finest, 2.0 * finest)]
    reference, check = run_parallel(makes, labels, stop, workers=jobs, tell=tell)

    def errors(run: StudyRun, true: StudyRun = reference) -> dict[str, float]:
        failed = run.failure is not None or run.expected is not None
        return {name: math.nan if failed else error(run, true, case.start) for name, (_, error) in kinds.items()}

    floors = dict.fromkeys(kinds, math.nan)
    if members:
        dt = ENSEMBLE_SHARE * Simulation(case.scene, ENSEMBLE).stable_dt()
        starts = ensemble(case, ENSEMBLE, dt, members, shapes=not curves, jobs=jobs, tell=tell)
        peer, *others = [run for run in starts if run.failure is None] or starts
        members = len(others) if peer.failure is None else 0
        floors = {name: max((errors(other, peer)[name] for other in others), default=math.nan) for name in kinds}

    def at_level(level: RefinementLevel) -> Point:
        def once(*, keep: bool) -> StudyRun:
            ways = {"tolerance": level.tolerance, "budget": budget}
            return run_case(meshes[level.density], level.integrator, level.dt, shapes=keep, stop=stop, **ways)

        is_check = (level.integrator, level.density, level.dt) == (REFERENCE, finest_mesh, check.dt)
        runs = [check if is_check and repeats == 1 else once(keep=not curves)]
        if runs[0].failure is None and runs[0].expected is None:
            runs += [once(keep=False) for _ in range(repeats - 1)]
        return _point(level, runs, errors(runs[0]), budget)

    work = [lambda level=level: at_level(level) for level in levels]
    at_once = jobs if curves else 1
    points = run_parallel(work, list(map(str, levels)), stop, workers=at_once, tell=tell, outcome=Point.words)
    bounds = _bounds(errors(check), floors, curves=curves)
    lines: dict[str, list[Point]] = {}
    for p in points:
        lines.setdefault(p.line, []).append(p)
    return WorkPrecision(
        scene=case.scene.name,
        until=case.until,
        instants=case.instants,
        members=members,
        points=tuple(points),
        labels={name: label for name, (label, _) in kinds.items()},
        reference_dt=reference.dt,
        reference_density=finest_mesh,
        reference_errors=errors(check),
        floors=floors,
        wanted=wanted,
        orders={
            line: {name: measured_order(found, name, CLEAR * bounds[name]) for name in kinds}
            for line, found in lines.items()
        },
        best={cost: cheapest(lines, next(iter(kinds)), wanted, cost) for cost in COSTS},
    )


def _bounds(reference: dict[str, float], floors: dict[str, float], *, curves: bool) -> dict[str, float]:
    """Lower bounds of meaningful errors: the reference's own error, and for curves the spread of perturbed starts.

    Pointwise all runs have the same start to the last bit, so the spread is no bound.
    """
    return {name: float(np.fmax(value, floors[name] if curves else 0.0)) for name, value in reference.items()}


def _methods(wanted: Sequence[str] | None) -> list[str]:
    known = list(integrators())
    for name in wanted or ():
        if name not in known:
            raise InputError(f"integrators: there is no {name!r}; {nearest(name, known)}")
    return list(dict.fromkeys(wanted or known))


def _levels(case: StudyCase, methods: Sequence[str], density: float, steps: int) -> list[RefinementLevel]:
    """The levels of all methods; on another mesh than the scene's only of the method with the cheapest step."""
    facts = integrators()
    limits = {name: Simulation(case.scene, name, case.interval * 1e-9).stable_dt() for name in (*methods, REFERENCE)}
    if density != 1.0:
        limited = [name for name in methods if math.isfinite(limits[name]) and not facts[name].is_adaptive]
        methods = [min(limited or methods, key=lambda name: facts[name].evaluations)]
    found: dict[RefinementLevel, None] = {}
    for name in methods:
        adaptive = facts[name].is_adaptive
        for level in refinement_levels(
            name, density, steps, limit=limits[name], unit=limits[REFERENCE], is_adaptive=adaptive
        ):
            found[level if level.dt is None else replace(level, dt=case.step_near(level.dt))] = None
    return list(found)


def _point(level: RefinementLevel, runs: Sequence[StudyRun], errors: dict[str, float], budget: float | None) -> Point:
    run, failed = runs[0], runs[0].failure
    failure = None if failed is None else str(failed)
    if run.expected is not None:
        failure = f"left out: it would have taken about {run.expected:.3g} s, more than the budget of {budget:g} s"
    return Point(
        integrator=level.integrator,
        dt=run.dt,
        share=run.dt / level.limit,
        steps=run.steps,
        evaluations=run.evaluations,
        seconds=median(t.seconds for t in runs),
        errors=errors,
        failure=failure,
        failed_at=None if failed is None else failed.time,
        tolerance=level.tolerance,
        rejected=run.rejected,
        density=level.density,
    )
