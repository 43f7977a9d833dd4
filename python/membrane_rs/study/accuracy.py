"""Accuracy against work: every method over a ladder of steps or tolerances, against a reference far finer than all.

Where the motion is smooth the error is pointwise; where it is chaotic it is that of the curves, and an
ensemble of perturbed starts tells how near any two runs can be expected to come.

Steps are shares of each method's own stability limit at the start. Those beyond it show whether the watch
catches what goes wrong there. A method that chooses its steps climbs a ladder of tolerances, one without limit
takes multiples of the reference method's.
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

from membrane_rs._files import output_errors, replacing
from membrane_rs._validation import nearest, show
from membrane_rs.errors import InputError
from membrane_rs.plotting.work_precision import COSTS, Line, Row, plot_work_precision
from membrane_rs.results.summary import versions, write_summary
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.simulation import integrators
from membrane_rs.study.common.density import denser
from membrane_rs.study.common.differences import CURVES, POINTWISE
from membrane_rs.study.common.executor import Tell, together
from membrane_rs.study.common.run import SHIFT, Course, Trial, course, ensemble, run
from membrane_rs.study.ladder import COARSEST, Best, Point, Rung, cheapest, ladder, line_name, measured_order

REFERENCE = "rk4"
"""The method of the reference."""
REFERENCE_SHARE = {False: 0.25, True: 0.5}
"""Its step over that of its own finest rung: pointwise, and for curves, where chaos makes more in vain."""
REFERENCE_MOST = 0.125 * COARSEST
"""It is no larger than this share of the limit, however few the rungs."""
ENSEMBLE, ENSEMBLE_SHARE = "leapfrog", 0.25
"""The method of the perturbed starts and its step over its limit: their spread is the motion's, not the method's."""
CLEAR = 10.0
"""An error counts for a measured order where it is this many times what bounds it from below."""


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
    reference_dt, reference_density : float
        Step of the reference [s], and the density of its mesh over the scene's.
    reference_errors : dict
        The reference against itself at twice its step.
    floors : dict
        Largest error between perturbed starts; NaN without ensemble.
    wanted : float
        The wanted error, of the first kind.
    orders : dict
        Measured order, by line (a method, or a method on another mesh) and kind of error; NaN where too few points
        stand clear.
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
    reference_density: float
    reference_errors: dict[str, float]
    floors: dict[str, float]
    wanted: float
    orders: dict[str, dict[str, float]]
    best: dict[str, Best | None]

    def rungs(self, line: str) -> list[Point]:
        """The points of one line, coarsest first."""
        return [point for point in self.points if point.line == line]

    def summary(self) -> str:
        """The result in words."""
        lines = [f"{self.scene}, {self.until:g} s, read at {self.instants} instants"]
        for name, label in self.labels.items():
            lines.append(f"{label}:")
            lines.append(
                f"  reference: {line_name(REFERENCE, self.reference_density)} at {self.reference_dt:.3g} s, "
                f"{self.reference_errors[name]:.1e} from itself at twice that step"
            )
            if self.members:
                spread = f"  spread of {self.members} starts shifted by {SHIFT:g} m: {self.floors[name]:.1e}"
                lines.append(spread + ("; no method can be said to be nearer" if name in CURVES else ""))
            lines += [f"  {line}: {self._told(line, orders[name])}" for line, orders in self.orders.items()]
        first = next(iter(self.labels))
        for cost, best in self.best.items():
            what = f"{COSTS[cost].lower()} for an error of {self.wanted:g} ({first})"
            lines.append(
                f"Least {what}: {best.words()}, {best.cost:.3g}"
                if best
                else f"Least {what}: no method of the ladder reaches it below its limit"
            )
        bound = _bounds(self.reference_errors, self.floors, curves=first in CURVES)[first]
        if self.wanted < bound:
            lines.append(f"But an error of {self.wanted:g} cannot be told apart here: the bound is {bound:.1e}.")
            by_line = {line: self.rungs(line) for line in self.orders}
            for cost, words in COSTS.items():
                found = cheapest(by_line, first, bound, cost)
                lines += [f"Least {words.lower()} within the bound: {found.words()}, {found.cost:.3g}"] if found else []
        return "\n".join(lines)

    def _told(self, line: str, order: float) -> str:
        """A line in words: its order, and what became of its runs."""
        points = self.rungs(line)
        stopped = [p for p in points if p.failed_at is not None]
        dear = [p for p in points if p.failure is not None and p.failed_at is None]
        why = "no order, too few errors are set by the step and clear of the bounds"
        words = [f"measured order {order:.2f}" if math.isfinite(order) else why]
        words += [f"{len(stopped)} of {len(points)} runs stopped by the watch"] if stopped else []
        words += [f"{len(dear)} of {len(points)} runs left out as too costly"] if dear else []
        return ", ".join(words)

    def save(self, folder: Path | str) -> None:
        """Write chart.csv, chart.json and chart.png into a folder. Raises OutputError."""
        folder = Path(folder)
        with output_errors(folder):
            folder.mkdir(parents=True, exist_ok=True)
        with replacing(folder / "chart.csv") as part, part.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            names = ["integrator", "density", "dt", "share_of_limit", "tolerance", "steps", "rejected", "evaluations"]
            names.append("seconds")
            writer.writerow([*names, *(f"{name}_error" for name in self.labels), "failed_at", "failure"])
            for p in self.points:
                row = [p.integrator, p.density, p.dt, p.share, p.tolerance, p.steps, p.rejected, p.evaluations]
                row.append(p.seconds)
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
                [self._line(line, name) for line in self.orders],
                self.reference_errors[name],
                self.floors[name],
                self.wanted if name == next(iter(self.labels)) else math.nan,
            )
            for name, label in self.labels.items()
        ]

    def _line(self, line: str, name: str) -> Line:
        """A line's rungs; a run that was stopped is drawn at the cost that it would have had."""
        points = self.rungs(line)
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


def chart(
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
) -> Chart:
    """Run a scene by each method over a ladder of steps or tolerances, and measure errors and costs.

    Parameters
    ----------
    scene : Scene
        What is run. It should be smooth up to the end, or `curves` be set.
    methods : sequence of str, optional
        Integrators. Default: all.
    until : float, optional
        Time at the end [s]. Default: the scene's.
    steps : int
        Rungs below the stability limit, from 0.9 of it, each half as large; two more lie beyond it. As many
        tolerances, from 1e-3, each a 32nd; as many steps of a method without limit, from 64 limits of rk4.
    curves : bool
        The error is that of deployment rate and phase, not that of the positions.
    members : int, optional
        Runs from perturbed starts, which set the floor; 0: none. Default: 4 with `curves`, else none. One that the
        watch stops is not counted.
    densities : sequence of float
        Other meshes, as multiples of the scene's density; needs `curves`. Each is a line of its own, run by the
        method of the fewest evaluations a step, and all errors are then against the finest mesh.
    wanted : float
        The error for which the cheapest method is named (of the rate, with `curves`).
    repeats : int, optional
        Runs of which the time is the median. Default: 1 with `curves`, else 3.
    instants : int, optional
        How often positions (default 10) or curves (default 100) are compared.
    budget : float, optional
        Processor time that a rung may take [s]; one that would take more is left out, and said to be.
    jobs : int, optional
        Runs at once, of an ensemble and with `curves`. Default: one on each core. No result but the time depends on it.
    progress : callable, optional
        Told in words what was just done.

    Raises
    ------
    InputError
        An unknown method, a number out of its range, a density that the mesh cannot have, a scene in which nothing
        moves.
    UnstableError
        The reference itself stopped.
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
            f"densities = {show(tuple(densities))}: other meshes have other nodes, so only curves can be compared; "
            "give --curves too"
        )
    tell = progress or (lambda _: None)
    kinds = CURVES if curves else POINTWISE
    count = (100 if curves else 10) if instants is None else instants
    meshes = {1.0: course(scene, until, count)}
    meshes |= {float(d): course(denser(scene, d), until, count) for d in sorted(set(densities)) if d != 1.0}
    where, finest_mesh = meshes[1.0], max(meshes)

    rungs = [rung for density, mesh in meshes.items() for rung in _rungs(mesh, names, density, steps)]
    finest = min(REFERENCE_SHARE[curves] * COARSEST / 2.0 ** (steps - 1), REFERENCE_MOST)
    finest *= Simulation(meshes[finest_mesh].scene, REFERENCE).stable_dt()
    stop = Event()

    def reference_at(dt: float) -> Trial:
        return run(meshes[finest_mesh], REFERENCE, dt, shapes=not curves, stop=stop).whole()

    said = [f"reference: {REFERENCE}, dt = {dt:.3g} s" for dt in (finest, 2.0 * finest)]
    makes = [lambda dt=dt: reference_at(dt) for dt in (finest, 2.0 * finest)]
    reference, check = together(makes, said, stop, workers=jobs, tell=tell)

    def errors(trial: Trial, true: Trial = reference) -> dict[str, float]:
        failed = trial.failure is not None or trial.expected is not None
        return {name: math.nan if failed else error(trial, true, where.start) for name, (_, error) in kinds.items()}

    floors = dict.fromkeys(kinds, math.nan)
    if members:
        dt = ENSEMBLE_SHARE * Simulation(where.scene, ENSEMBLE).stable_dt()
        starts = ensemble(where, ENSEMBLE, dt, members, shapes=not curves, jobs=jobs, tell=tell)
        peer, *others = [trial for trial in starts if trial.failure is None] or starts
        members = len(others) if peer.failure is None else 0
        floors = {name: max((errors(other, peer)[name] for other in others), default=math.nan) for name in kinds}

    def climb(rung: Rung) -> Point:
        def once(*, keep: bool) -> Trial:
            mesh, tolerance = meshes[rung.density], rung.tolerance
            return run(mesh, rung.integrator, rung.dt, tolerance=tolerance, shapes=keep, budget=budget, stop=stop)

        is_check = (rung.integrator, rung.density, rung.dt) == (REFERENCE, finest_mesh, check.dt)
        trials = [check if is_check and repeats == 1 else once(keep=not curves)]
        if trials[0].failure is None and trials[0].expected is None:
            trials += [once(keep=False) for _ in range(repeats - 1)]
        return _point(rung, trials, errors(trials[0]), budget)

    climbs = [lambda rung=rung: climb(rung) for rung in rungs]
    at_once = jobs if curves else 1
    points = together(climbs, list(map(str, rungs)), stop, workers=at_once, tell=tell, outcome=Point.words)
    bounds = _bounds(errors(check), floors, curves=curves)
    lines: dict[str, list[Point]] = {}
    for p in points:
        lines.setdefault(p.line, []).append(p)
    return Chart(
        scene=where.scene.name,
        until=where.until,
        instants=where.instants,
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


def _rungs(where: Course, methods: Sequence[str], density: float, steps: int) -> list[Rung]:
    """The ladders of all methods; on another mesh than the scene's only of the one whose steps are cheapest."""
    facts = integrators()
    limits = {name: Simulation(where.scene, name, where.interval * 1e-9).stable_dt() for name in (*methods, REFERENCE)}
    if density != 1.0:
        limited = [name for name in methods if math.isfinite(limits[name]) and not facts[name].is_adaptive]
        methods = [min(limited or methods, key=lambda name: facts[name].evaluations)]
    found: dict[Rung, None] = {}
    for name in methods:
        adaptive = facts[name].is_adaptive
        for rung in ladder(name, density, steps, limit=limits[name], unit=limits[REFERENCE], is_adaptive=adaptive):
            found[rung if rung.dt is None else replace(rung, dt=where.step_near(rung.dt))] = None
    return list(found)


def _point(rung: Rung, trials: Sequence[Trial], errors: dict[str, float], budget: float | None) -> Point:
    trial, failed = trials[0], trials[0].failure
    failure = None if failed is None else str(failed)
    if trial.expected is not None:
        failure = f"left out: it would have taken about {trial.expected:.3g} s, more than the budget of {budget:g} s"
    return Point(
        integrator=rung.integrator,
        dt=trial.dt,
        share=trial.dt / rung.limit,
        steps=trial.steps,
        evaluations=trial.evaluations,
        seconds=median(t.seconds for t in trials),
        errors=errors,
        failure=failure,
        failed_at=None if failed is None else failed.time,
        tolerance=rung.tolerance,
        rejected=trial.rejected,
        density=rung.density,
    )
