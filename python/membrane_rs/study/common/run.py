"""The runs that studies compare: one scene from one start by one method and step, sampled at fixed instants."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from threading import Event

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._validation import check_kind, count_of, number_of
from membrane_rs.analysis.deployment import Corners
from membrane_rs.errors import UnstableError
from membrane_rs.results.body_contacts import BodyContacts
from membrane_rs.results.measures import peak_stress
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.scene.run_settings import check_duration
from membrane_rs.simulation.observer import Observer
from membrane_rs.simulation.output_times import is_same_time
from membrane_rs.study.common.executor import Tell, run_parallel
from membrane_rs.study.common.perturbation import SHIFT, perturbation
from membrane_rs.study.common.stages import refuse_stages

MOST_SAMPLES = 10**5
"""More samples of a run are taken as an input error: each may hold the positions of all nodes."""
MOST_MEMBERS, MOST_REPEATS = 1000, 1000
"""Perturbed starts of an ensemble, and repeated runs for a median of times, at most."""
REPORTED = 10
"""Parts of a run after each of which it may say how far it has come."""
BUDGET_CHECK = 0.02
"""Share of a run after which its cost is extrapolated and compared with the budget."""


@dataclass(frozen=True)
class StudyCase:
    """What all runs of a study have in common: scene, start, duration and sampling.

    Attributes
    ----------
    scene : Scene
        Without relaxation and snapshots in its run settings.
    start : (N, 3) float64
        Positions at time 0 [m], relaxed where the scene asks for it.
    until : float
        Time at the end [s].
    instants : int
        Number of samples, evenly spaced, the start not counted. Each step divides the interval between two.
    relaxation : float
        Duration of the relaxation of the start [s]; a scene with another mesh is relaxed for as long.
    """

    scene: Scene
    start: Floats
    until: float
    instants: int
    relaxation: float = 0.0

    @property
    def interval(self) -> float:
        """Time between two samples [s]."""
        return self.until / self.instants

    @cached_property
    def times(self) -> list[float]:
        """Of the samples [s]."""
        return [k * self.interval for k in range(1, self.instants + 1)]

    def step_near(self, dt: float) -> float:
        """The step nearest to `dt` that divides the interval between two samples [s]."""
        return self.interval / max(1, round(self.interval / dt))

    def of(self, scene: Scene) -> StudyCase:
        """The same case for another scene: from the same start on the same mesh, else from the scene's own start.

        Cords with another number of segments keep the start that the scene gives them.
        """
        if scene.mesh is not self.scene.mesh:
            relaxing = replace(scene, run=replace(scene.run, relax=self.relaxation))
            return study_case(relaxing, self.until, self.instants)
        start = scene.assemble().positions.copy()
        same = len(start) if start.shape == self.start.shape else 0 if scene.mesh is None else len(scene.mesh.reference)
        start[:same] = self.start[:same]
        return replace(self, scene=_bare(scene), start=start)

    def shortened(self, until: float | None) -> StudyCase:
        """The same case up to its last sample not after `until` [s], and at least to its first sample."""
        if until is None or until >= self.until:
            return self
        count = max(1, int(until / self.interval * (1.0 + 1e-9)))
        return replace(self, until=count * self.interval, instants=count)

    def perturbed(self, seed: int, shift: float = SHIFT) -> StudyCase:
        """The same case with a random displacement of standard deviation `shift` [m] at every free node of the
        start.
        """
        return replace(self, start=self.start + perturbation(self.scene, seed, shift))


@dataclass(frozen=True)
class StudyRun:
    """The result of one run.

    Attributes
    ----------
    integrator : str
        The method.
    dt : float
        Step [s]; the mean step where steps were chosen by their error.
    times, rate, phase, strain, stress : (k,) float64
        At the instants reached: time [s], deployment rate, phase difference [deg], the largest strain of any spring,
        and the largest stress in the film [Pa] (NaN without film).
    shapes : (k, N, 3) float64
        Positions [m] at the same instants; (0, N, 3) where they were not requested.
    steps, rejected, evaluations : int
        Accepted steps, rejected steps, and evaluations of the forces in both.
    seconds : float
        Processor time of the stepping [s].
    failure : UnstableError or None
        The error that stopped the run before its end.
    expected : float or None
        Extrapolated processor time [s] of a run that was abandoned because of its cost.
    """

    integrator: str
    dt: float
    times: Floats
    rate: Floats
    phase: Floats
    strain: Floats
    stress: Floats
    shapes: Floats
    steps: int
    rejected: int
    evaluations: int
    seconds: float
    failure: UnstableError | None = None
    expected: float | None = None

    def completed(self) -> StudyRun:
        """The run itself if it reached its end. Raises UnstableError if it did not."""
        if self.failure is not None:
            raise self.failure
        return self


def study_case(scene: Scene, until: float | None, instants: int) -> StudyCase:
    """The case of a scene from its own start, relaxed where the scene asks for it.

    Raises
    ------
    InputError
        An end outside the range of runs, fewer than one instant, or a scene that a simulation refuses.
    InputTypeError
        No scene, or no number.
    """
    check_kind(scene, Scene, "scene", "a Scene")
    refuse_stages(scene)
    end = scene.run.until if until is None else number_of("until", until)
    check_duration(end, "until")
    instants = count_of("instants", instants, 1, MOST_SAMPLES, "samples of a run")
    sim = Simulation(scene)
    if scene.run.relax > 0:
        sim.relax()
    return StudyCase(_bare(scene), sim.positions, end, instants, scene.run.relax)


def run_case(
    case: StudyCase,
    integrator: str,
    dt: float | None,
    *,
    tolerance: float | None = None,
    shapes: bool = False,
    budget: float | None = None,
    stop: Event | None = None,
    tell: Tell | None = None,
) -> StudyRun:
    """Run a case by one method, with the step nearest to `dt` that meets the instants, or with a tolerance.

    A run that the monitor stops is a result, not an error; its samples up to then are kept. At each instant the monitor
    judges the energy balance too. A run that would take more processor time than `budget` [s] is a result as well.
    Setting `stop` ends the run at its next instant. `tell` is called with a line of text at each `REPORTED` of its
    instants but the last.
    """
    scene, step = case.scene, None if dt is None else case.step_near(dt)
    if tolerance is not None:
        scene = replace(scene, run=replace(scene.run, tolerance=tolerance, dt=None))
    sim = Simulation(scene, integrator, step)
    sim.positions = case.start
    samples = _Samples(case, shapes=shapes, budget=budget, stop=stop, tell=tell)
    failure = None
    observers: list[Observer[Simulation]] = [samples]
    if scene.bodies:
        observers.append(BodyContacts())  # for its warnings
    try:
        sim.march(case.times[-1], frames=2, samples=case.times, observers=observers)
    except _Ended:
        pass
    except UnstableError as error:
        failure = error
    times, rates, phases, strain, stress = np.array(samples.rows, dtype=np.float64).reshape(-1, 5).T
    return StudyRun(
        integrator=sim.integrator,
        dt=sim.dt if step is not None else sim.time / max(sim.step_count, 1),
        times=times,
        rate=rates,
        phase=phases,
        strain=strain,
        stress=stress,
        shapes=np.array(samples.shapes, dtype=np.float64).reshape(-1, sim.node_count, 3),
        steps=sim.step_count,
        rejected=sim.rejected_count,
        evaluations=sim.evaluation_count,
        seconds=samples.seconds,
        failure=failure,
        expected=samples.expected,
    )


class _Ended(Exception):  # noqa: N818 - no error
    """A run that is stopped, or beyond its budget."""


class _Samples:
    """Observer that keeps the samples of a run, and the processor time of the stepping between them [s]."""

    def __init__(
        self, case: StudyCase, *, shapes: bool, budget: float | None, stop: Event | None, tell: Tell | None
    ) -> None:
        self._case, self._has_shapes, self._budget, self._stop, self._tell = case, shapes, budget, stop, tell
        self.rows: list[tuple[float, ...]] = []
        self.shapes: list[Floats] = []
        self.seconds = 0.0
        self.expected: float | None = None

    def start(self, sim: Simulation) -> None:
        self._corners = Corners(sim.assembly)
        self._began = time.thread_time()

    def sample(self, sim: Simulation) -> None:
        self.seconds += time.thread_time() - self._began
        # Neither the start nor the last state without a fault is an instant.
        if is_same_time(self._case.times[len(self.rows)], sim.time):
            sim._core.check(True)  # otherwise a long interval would hide what the balance shows
            self._keep(sim)
        if self._stop is not None and self._stop.is_set() and len(self.rows) < self._case.instants:
            raise _Ended
        self._began = time.thread_time()

    def frame(self, sim: Simulation) -> None:
        """Has nothing of its own."""

    def finish(self, sim: Simulation, error: BaseException | None) -> None:
        """Has nothing to close."""

    def _keep(self, sim: Simulation) -> None:
        positions, strains = sim.positions, sim.spring_strains()
        rate, phase = self._corners.deployment_rate(positions), self._corners.phase_difference(positions)
        largest = float(strains.max()) if len(strains) else 0.0
        self.rows.append((sim.time, rate, phase, largest, peak_stress(sim)))
        if self._has_shapes:
            self.shapes.append(positions)
        k, count = len(self.rows), self._case.instants
        if self._tell is not None and k < count and REPORTED * k // count > REPORTED * (k - 1) // count:
            self._tell(f"{100 * k // count} %, t = {sim.time:.4g} s")
        expected = self.seconds / k * count
        if self._budget is not None and k >= BUDGET_CHECK * count and expected > self._budget:
            self.expected = expected
            raise _Ended


def ensemble(
    case: StudyCase,
    integrator: str,
    dt: float,
    count: int,
    *,
    shift: float = SHIFT,
    shapes: bool = False,
    jobs: int | None = None,
    tell: Tell | None = None,
) -> list[StudyRun]:
    """The run from the unperturbed start, then `count` from perturbed starts with the seeds 0, 1, 2 ..."""
    cases = [case, *(case.perturbed(seed, shift) for seed in range(count))]
    names = ["unperturbed start", *(f"perturbed start, seed {seed}" for seed in range(count))]

    def member(one: StudyCase) -> StudyRun:
        return run_case(one, integrator, dt, shapes=shapes, stop=stop)

    stop = Event()
    return run_parallel([lambda one=one: member(one) for one in cases], names, stop, workers=jobs, tell=tell)  # type: ignore[misc]


def stopped_starts(starts: Sequence[StudyRun], shift: float) -> str:
    """A warning of those of some perturbed starts that the monitor stopped; empty where it stopped none."""
    failures = [start.failure for start in starts if start.failure is not None]
    if not failures:
        return ""
    reason = str(failures[0]).partition(". ")[0]  # without the remedies, which are for a scene's own start
    text = (
        f"{len(failures)} of {len(starts)} starts perturbed by {shift:g} m did not reach the end, the first: {reason}"
    )
    if len(failures) < len(starts):
        return f"{text}; they are not counted"
    return f"{text}; the spread is unknown, take a smaller shift"


def _bare(scene: Scene) -> Scene:
    """The scene without relaxation and snapshots: the case holds the relaxed start."""
    return replace(scene, run=replace(scene.run, relax=0.0, snapshots=()))
