"""Work-precision diagram: the error of every method against its cost, over steps or tolerances.

The reference is a far finer run. For a smooth motion the error is that of the positions. For a chaotic motion it is
that of the curves, and the spread of an ensemble of perturbed starts bounds it from below.

Steps are multiples of each method's own stability limit at the start. Those beyond the limit show whether the monitor
detects the instability. An adaptive method takes tolerances; a method without limit takes multiples of the limit of
the reference method.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from statistics import median
from threading import Event

from membrane_rs._validation import count_of, is_list, nearest, number_of, show, texts_of
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.plotting.work_precision import COSTS
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.simulation import integrators
from membrane_rs.study.common.density import denser
from membrane_rs.study.common.differences import CURVES, POINTWISE
from membrane_rs.study.common.executor import Tell, run_parallel, teller
from membrane_rs.study.common.run import (
    MOST_MEMBERS,
    MOST_REPEATS,
    StudyCase,
    StudyRun,
    ensemble,
    run_case,
    study_case,
)
from membrane_rs.study.refinement import (
    COARSEST,
    Point,
    RefinementLevel,
    cheapest,
    measured_order,
    refinement_levels,
)
from membrane_rs.study.work_precision_result import REFERENCE, WorkPrecision, error_bounds

REFERENCE_SHARE = {False: 0.25, True: 0.5}
"""Ratio of its step to that of its own finest level; for curves a finer one is useless because of chaos."""
REFERENCE_MOST = 0.125 * COARSEST
"""Upper bound of its step as a share of the limit, for any number of levels."""
ENSEMBLE, ENSEMBLE_SHARE = "leapfrog", 0.25
"""Method of the perturbed starts, and its step over its limit; their spread belongs to the motion, not the method."""
MOST_LEVELS = 24
"""Levels below the limit, at most: the finest step is then ten million times smaller than the coarsest."""
CLEAR = 10.0
"""Ratio to the lower bound from which an error counts for a measured order."""


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
        Other meshes, as multiples of the scene's density [-]; needs `curves`. Each is a line of its own, run by the
        method of the fewest evaluations a step, and all errors are then against the finest mesh.
    wanted : float
        The target error [-], for which the cheapest method is given (of the rate, with `curves`).
    repeats : int, optional
        Runs of which the time is the median. Default: 1 with `curves`, else 3.
    instants : int, optional
        Number of samples at which positions (default 10) or curves (default 100) are compared.
    budget : float, optional
        Processor time that a run may take [s]; one that would take more is left out and reported.
    jobs : int, optional
        Number of parallel runs of an ensemble and with `curves`. Default: one on each core. Only times depend on it.
    progress : callable, optional
        Called with a line of text after each run, and at each tenth of the reference run, the longest.

    Returns
    -------
    WorkPrecision
        Points, reference and best of each method.

    Raises
    ------
    InputError
        An unknown method, a number outside its range, a density that the mesh cannot represent, a scene without
        motion.
    InputTypeError
        No scene, or no number.
    UnstableError
        The reference run stopped.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> from membrane_rs.study import work_precision
    >>> scene = scenes.load("spinning-tether")
    >>> found = work_precision(scene, ["rk4"], until=0.005, steps=2, instants=2, repeats=1)
    >>> len(found.points), found.reference_errors["position"] < 1e-6
    (4, True)
    """
    names = _methods(methods)
    members = (4 if curves else 0) if members is None else members
    repeats = (1 if curves else 3) if repeats is None else repeats
    steps = count_of("steps", steps, 1, MOST_LEVELS, "each is half the last, and so costs as much as all before it")
    members = count_of("members", members, 0, MOST_MEMBERS, "perturbed starts, --ensemble")
    repeats = count_of("repeats", repeats, 1, MOST_REPEATS, "runs for a median of times")
    wanted = _above_zero("wanted", wanted, "the target error, --error")
    budget = None if budget is None else _above_zero("budget", budget, "s")
    densities = _densities(densities)
    if densities and not curves:
        raise InputError(
            f"densities = {show(densities)}: meshes have different nodes, so only curves can be compared; add --curves"
        )
    tell = teller(progress)
    kinds = CURVES if curves else POINTWISE
    count = (100 if curves else 10) if instants is None else instants
    meshes = {1.0: study_case(scene, until, count)}
    meshes |= {float(d): study_case(denser(scene, d), until, count) for d in sorted(set(densities)) if d != 1.0}
    case, finest_mesh = meshes[1.0], max(meshes)

    levels = [level for density, mesh in meshes.items() for level in _levels(mesh, names, density, steps)]
    finest = min(REFERENCE_SHARE[curves] * COARSEST / 2.0 ** (steps - 1), REFERENCE_MOST)
    finest *= Simulation(meshes[finest_mesh].scene, REFERENCE).stable_dt()
    stop = Event()

    reference, check = _references(meshes[finest_mesh], finest, stop, shapes=not curves, jobs=jobs, tell=tell)

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
            mesh, tolerance = meshes[level.density], level.tolerance
            return run_case(
                mesh, level.integrator, level.dt, tolerance=tolerance, shapes=keep, budget=budget, stop=stop
            )

        is_check = (level.integrator, level.density, level.dt) == (REFERENCE, finest_mesh, check.dt)
        runs = [check if is_check and repeats == 1 else once(keep=not curves)]
        if runs[0].failure is None and runs[0].expected is None:
            runs += [once(keep=False) for _ in range(repeats - 1)]
        return _point(level, runs, errors(runs[0]), budget)

    work = [lambda level=level: at_level(level) for level in levels]
    at_once = jobs if curves else 1
    points = run_parallel(work, list(map(str, levels)), stop, workers=at_once, tell=tell, outcome=Point.words)
    bounds = error_bounds(errors(check), floors, curves=curves)
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


def _references(
    case: StudyCase, finest: float, stop: Event, *, shapes: bool, jobs: int | None, tell: Tell
) -> tuple[StudyRun, StudyRun]:
    """The reference run by the finest step [s], which is the longest of all, and that by a step of twice its size."""
    names = {dt: f"reference: {REFERENCE}, dt = {dt:.3g} s" for dt in (finest, 2.0 * finest)}
    tell(f"{names[finest]}: {case.until / finest:,.0f} steps, the longest run of all")

    def made(dt: float) -> StudyRun:
        share = (lambda words: tell(f"{names[dt]}: {words}")) if dt == finest else None
        return run_case(case, REFERENCE, dt, shapes=shapes, stop=stop, tell=share).completed()

    work = [lambda dt=dt: made(dt) for dt in names]
    reference, check = run_parallel(work, list(names.values()), stop, workers=jobs, tell=tell)
    return reference, check


def _above_zero(name: str, value: float, unit: str) -> float:
    number = number_of(name, value, unit)
    if not number > 0.0:
        raise InputError(f"{name} = {number}: must be greater than 0 ({unit})")
    return number


def _densities(given: object) -> tuple[float, ...]:
    """Relative densities of meshes. Raises InputTypeError and InputError."""
    if not is_list(given):
        raise InputTypeError(f"densities = {show(given)}: must be a list of numbers, multiples of the scene's density")
    return tuple(number_of("densities", density, "multiples of the scene's density") for density in given)


def _methods(wanted: Sequence[str] | None) -> list[str]:
    known = list(integrators())
    wanted = None if wanted is None else texts_of("methods", wanted, "a list of names of methods, such as ['rk4']")
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
