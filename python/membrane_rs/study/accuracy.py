"""Work-precision diagram: the error of every method against its cost, over steps or tolerances.

The reference is a far finer run, of the film as it is where softened ones are compared. For a smooth motion the error
is that of the positions. For a chaotic motion it is that of the curves, and the spread of an ensemble of perturbed
starts bounds it from below.

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

import numpy as np

from membrane_rs._validation import check_kind, count_of, is_list, nearest, number_of, show, texts_of
from membrane_rs.check.stepping import is_explicit
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.plotting.work_precision import COSTS
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.scene.softened import softening_of, with_softening
from membrane_rs.simulation import integrators
from membrane_rs.study.common.density import denser
from membrane_rs.study.common.differences import CURVES, POINTWISE
from membrane_rs.study.common.executor import Tell, run_parallel, teller, workers_of
from membrane_rs.study.common.methods import methods_of
from membrane_rs.study.common.perturbation import MODEL_SHIFT, SHIFT, check_shift, shift_of
from membrane_rs.study.common.run import (
    MOST_MEMBERS,
    MOST_REPEATS,
    StudyCase,
    StudyRun,
    ensemble,
    run_case,
    stopped_starts,
    study_case,
)
from membrane_rs.study.refinement import (
    COARSEST,
    Point,
    RefinementLevel,
    cheapest,
    finest_errors,
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
    softenings: Sequence[float] = (),
    shift: float | None = None,
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
        Integrators. Default: all. Those that cannot move a free hub are left out of a scene with one.
    until : float, optional
        Time at the end [s]. Default: the scene's.
    steps : int
        Levels below the stability limit, from 0.9 of it, each half as large; two more lie beyond it. As many
        tolerances, from 1e-3, each a 32nd; as many steps of a method without limit, from 64 limits of rk4.
    curves : bool
        Measure the error of deployment rate and phase, not of the positions.
    members : int, optional
        Runs from perturbed starts, whose spread is the lower bound; 0: none. Default: 4 with `curves`, else none. A
        run that the monitor stops is not counted, but reported.
    densities : sequence of float
        Other meshes, as multiples of the scene's density [-]; needs `curves`. Each is a line of its own, run by the
        method of the fewest evaluations a step, and all errors are then against the finest mesh.
    softenings : sequence of float
        Softenings of the film [-], from 1 to 1e6. Each is a line of its own, run by the explicit method of the fewest
        evaluations a step from the same start; all errors are against the film that is not softened, even if that of
        the scene is. They have a floor that no step lessens: what softening changes.
    shift : float, optional
        Standard deviation of the perturbation of each coordinate of a start [m]; needs `members` or `curves`. Default:
        1e-12; 1e-6 with `softenings`, since starts that differ by rounding alone show less than what any change of the
        model does.
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
        An unknown method, a number outside its range, a shift not below the shortest edge, a density that the mesh
        cannot represent, a softening of no film or by implicit methods alone, a scene without motion, no method that
        can run the scene.
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
    check_kind(scene, Scene, "scene", "a Scene")
    names, left_out = methods_of(scene, _methods(methods))
    members = (4 if curves else 0) if members is None else members
    repeats = (1 if curves else 3) if repeats is None else repeats
    steps = count_of("steps", steps, 1, MOST_LEVELS, "each is half the last, and so costs as much as all before it")
    members = count_of("members", members, 0, MOST_MEMBERS, "perturbed starts, --ensemble")
    repeats = count_of("repeats", repeats, 1, MOST_REPEATS, "runs for a median of times")
    wanted = _above_zero("wanted", wanted, "the target error, --error")
    budget = None if budget is None else _above_zero("budget", budget, "s")
    densities = _factors("densities", densities, "multiples of the scene's density, --density")
    softenings = _factors("softenings", softenings, "by which the film is softer in stretch, --softening")
    shift = _shift(shift, members, softenings)
    explicit = _explicit(names, softenings)
    if densities and not curves:
        raise InputError(
            f"densities = {show(densities)}: meshes have different nodes, so only curves can be compared; add --curves"
        )
    tell, jobs = teller(progress), workers_of(jobs)
    kinds = CURVES if curves else POINTWISE
    count = (100 if curves else 10) if instants is None else instants
    cases = _cases(scene, until, count, densities, softenings)
    (_, film), case = next(iter(cases.items()))
    if members:
        check_shift(shift, case.scene)
    true = max(density for density, _ in cases), film
    levels = []
    for model, each in cases.items():
        levels += _levels(each, names if model[1] == film else explicit, model, steps, is_own=each is case)
    finest = min(REFERENCE_SHARE[curves] * COARSEST / 2.0 ** (steps - 1), REFERENCE_MOST)
    finest *= Simulation(cases[true].scene, REFERENCE).stable_dt()
    stop = Event()

    reference, check = _references(cases[true], finest, stop, shapes=not curves, jobs=jobs, tell=tell)

    def errors(run: StudyRun, other: StudyRun = reference) -> dict[str, float]:
        failed = run.failure is not None or run.expected is not None
        return {name: math.nan if failed else error(run, other, case.start) for name, (_, error) in kinds.items()}

    starts = _starts(case, members, shift, shapes=not curves, jobs=jobs, tell=tell)
    ended = [run for run in starts if run.failure is None]
    members = max(len(ended) - 1, 0)
    floors = {name: max((errors(other, ended[0])[name] for other in ended[1:]), default=math.nan) for name in kinds}

    def at_level(level: RefinementLevel) -> Point:
        def once(*, keep: bool) -> StudyRun:
            model, tolerance = cases[level.model], level.tolerance
            return run_case(
                model, level.integrator, level.dt, tolerance=tolerance, shapes=keep, budget=budget, stop=stop
            )

        is_check = (level.integrator, level.model, level.dt) == (REFERENCE, true, check.dt)
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
        reference_density=true[0],
        reference_errors=errors(check),
        floors=floors,
        wanted=wanted,
        orders={
            line: {name: measured_order(found, name, CLEAR * _bound(found, name, bounds, film)) for name in kinds}
            for line, found in lines.items()
        },
        best={cost: cheapest(lines, next(iter(kinds)), wanted, cost) for cost in COSTS},
        shift=shift,
        reference_softening=film,
        stopped_starts=stopped_starts(starts[1:], shift),
        left_out=left_out,
    )


def _starts(
    case: StudyCase, members: int, shift: float, *, shapes: bool, jobs: int | None, tell: Tell
) -> list[StudyRun]:
    """The run from the unperturbed start and those from perturbed ones; none at all for no `members`."""
    if not members:
        return []
    dt = ENSEMBLE_SHARE * Simulation(case.scene, ENSEMBLE).stable_dt()
    return ensemble(case, ENSEMBLE, dt, members, shift=shift, shapes=shapes, jobs=jobs, tell=tell)


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


def _cases(
    scene: Scene, until: float | None, instants: int, densities: Sequence[float], softenings: Sequence[float]
) -> dict[tuple[float, float | None], StudyCase]:
    """What is run, by density of the mesh and softening of the film: first the scene itself, with the film as it is
    where others are compared.
    """
    scene = with_softening(scene, None) if softenings else scene
    case, film = study_case(scene, until, instants), softening_of(scene)
    found = {(1.0, film): case}
    found |= {(d, film): study_case(denser(scene, d), until, instants) for d in sorted(set(densities)) if d != 1.0}
    for factor in sorted(set(softenings)):  # by the key of scene files, whose errors say what is wrong
        try:
            found[1.0, factor] = case.of(case.scene.with_values({"material.softening": factor}))
        except InputError as error:
            raise type(error)(f"softenings (--softening): {error}") from None
    return found


def _above_zero(name: str, value: float, unit: str) -> float:
    number = number_of(name, value, unit)
    if not number > 0.0:
        raise InputError(f"{name} = {number}: must be greater than 0 ({unit})")
    return number


def _factors(name: str, given: object, what: str) -> tuple[float, ...]:
    """A list of numbers. Raises InputTypeError and InputError."""
    if not is_list(given):
        raise InputTypeError(f"{name} = {show(given)}: must be a list of numbers, {what}")
    return tuple(number_of(name, factor, what) for factor in given)


def _methods(wanted: Sequence[str] | None) -> list[str]:
    known = list(integrators())
    wanted = None if wanted is None else texts_of("methods", wanted, "a list of names of methods, such as ['rk4']")
    for name in wanted or ():
        if name not in known:
            raise InputError(f"integrators: there is no {name!r}; {nearest(name, known)}")
    return list(dict.fromkeys(wanted or known))


def _shift(shift: float | None, members: int, softenings: Sequence[float]) -> float:
    """The perturbation of starts [m]. Raises InputError where one is given and there are none, InputTypeError."""
    if shift is None:
        return MODEL_SHIFT if softenings else SHIFT
    shift = shift_of(shift)
    if not members:
        raise InputError(
            f"shift = {show(shift)} (--shift): has no effect without perturbed starts; leave it out, or add --ensemble "
            "or --curves"
        )
    return shift


def _explicit(methods: Sequence[str], softenings: Sequence[float]) -> list[str]:
    """The explicit ones. Raises InputError for softened films without any."""
    found = list(filter(is_explicit, methods))
    if softenings and not found:
        raise InputError(
            f"softenings = {show(softenings)}: make no step longer by {', '.join(methods)}, which is implicit; add an "
            "explicit method, such as leapfrog"
        )
    return found


def _bound(points: Sequence[Point], name: str, bounds: dict[str, float], film: float | None) -> float:
    """What bounds the errors of a line from below; of another film than the reference's its finest error does as well,
    which the step does not set.
    """
    finest, _ = finest_errors(points, name)
    return bounds[name] if points[0].softening == film else float(np.fmax(bounds[name], finest))


def _levels(
    case: StudyCase, methods: Sequence[str], model: tuple[float, float | None], steps: int, *, is_own: bool
) -> list[RefinementLevel]:
    """The levels of all methods; of another model than the scene's own only of the method with the cheapest step."""
    facts, (density, softening) = integrators(), model
    limits = {name: Simulation(case.scene, name, case.interval * 1e-9).stable_dt() for name in (*methods, REFERENCE)}
    if not is_own:
        limited = [name for name in methods if math.isfinite(limits[name]) and not facts[name].is_adaptive]
        methods = [min(limited or methods, key=lambda name: facts[name].evaluations)]
    found: dict[RefinementLevel, None] = {}
    for name in methods:
        adaptive = facts[name].is_adaptive
        for level in refinement_levels(
            name, density, steps, limit=limits[name], unit=limits[REFERENCE], is_adaptive=adaptive
        ):
            dt = None if level.dt is None else case.step_near(level.dt)
            found[replace(level, dt=dt, softening=softening)] = None
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
        softening=level.softening,
    )
