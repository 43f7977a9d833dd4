"""One run of a study: a scene from a given start, by a given method and step, read at given instants."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from threading import Event

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.analysis.deployment import Corners
from membrane_rs.errors import InputError, UnstableError
from membrane_rs.results.measures import peak_stress
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.study.common.executor import Tell, together

SHIFT = 1e-12
"""By how much the starts of an ensemble differ: the standard deviation of each coordinate [m]."""
LEAST_READ = 0.02
"""Share of a run after which its cost is judged."""


@dataclass(frozen=True)
class Course:
    """What all runs of a study share.

    Attributes
    ----------
    scene : Scene
        Settled already, if it wants to be.
    start : (N, 3) float64
        Positions at time 0 [m].
    until : float
        Time at the end [s].
    instants : int
        Readings, evenly spaced, the start not counted; each step divides the time between two.
    settle : float
        For how long the start was settled [s]; a scene of another mesh is settled for as long.
    """

    scene: Scene
    start: Floats
    until: float
    instants: int
    settle: float = 0.0

    @property
    def interval(self) -> float:
        """Time between two readings [s]."""
        return self.until / self.instants

    def step_near(self, dt: float) -> float:
        """The step nearest to `dt` of which a whole number fit between two readings [s]."""
        return self.interval / max(1, round(self.interval / dt))

    def of(self, scene: Scene) -> Course:
        """The same course for another scene: with the same mesh from the same start, with another from its own.

        Cords of other segments take their own start.
        """
        if scene.mesh is not self.scene.mesh:
            return course(replace(scene, run=replace(scene.run, relax=self.settle)), self.until, self.instants)
        start = scene.assemble().positions.copy()
        same = len(start) if start.shape == self.start.shape else 0 if scene.mesh is None else len(scene.mesh.reference)
        start[:same] = self.start[:same]
        return replace(self, scene=_plain(scene), start=start)

    def shortened(self, until: float | None) -> Course:
        """The same course to the last reading that is not after `until` [s], and at least to the first."""
        if until is None or until >= self.until:
            return self
        count = max(1, int(until / self.interval * (1.0 + 1e-9)))
        return replace(self, until=count * self.interval, instants=count)

    def shifted(self, seed: int) -> Course:
        """The same course from a start in which every node that is free is shifted at random by `SHIFT`."""
        shift = SHIFT * np.random.default_rng(seed).standard_normal(self.start.shape)
        shift[self.scene.assemble().fixed] = 0.0
        return replace(self, start=self.start + shift)


@dataclass(frozen=True)
class Trial:
    """What one run showed.

    Attributes
    ----------
    integrator : str
        The method.
    dt : float
        Step [s]; the mean one where steps were chosen by their error.
    times, rate, phase, strain, stress : (k,) float64
        At the instants that the run came to: time [s], deployment rate, phase difference [deg], the largest strain
        of any spring, and the largest stress in the film [Pa] (NaN without film).
    shapes : (k, N, 3) float64
        Positions [m] at the same instants; (0, N, 3) where they were not wanted.
    steps, rejected, evaluations : int
        Steps, tries in vain, and evaluations of the forces, those of tries in vain among them.
    seconds : float
        Processor time of the stepping [s].
    failure : UnstableError or None
        Why it stopped before its end.
    expected : float or None
        Where it was given up because of its cost: the processor time that it would have taken [s], about.
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

    def whole(self) -> Trial:
        """The trial itself, where it came to its end. Raises UnstableError where it did not."""
        if self.failure is not None:
            raise self.failure
        return self


def course(scene: Scene, until: float | None, instants: int) -> Course:
    """A course from the scene's own start, settled if the scene wants to be.

    Raises
    ------
    InputError
        An end that is not above 0, less than one instant, or whatever a simulation of the scene refuses.
    """
    end = scene.run.until if until is None else float(until)
    if not 0.0 < end < float("inf"):
        raise InputError(f"until = {end}: must be greater than 0 and finite (s)")
    if instants < 1:
        raise InputError(f"instants = {instants}: must be 1 or above")
    sim = Simulation(scene)
    if scene.run.relax > 0:
        sim.relax()
    return Course(_plain(scene), sim.positions, end, instants, scene.run.relax)


def run(
    where: Course,
    integrator: str,
    dt: float | None,
    *,
    tolerance: float | None = None,
    shapes: bool = False,
    budget: float | None = None,
    stop: Event | None = None,
) -> Trial:
    """Run a course by one method: with the step nearest to `dt` that meets the instants, or by a tolerance.

    A run that the watch stops is a result, not an error: what was read before stays. So is one that would take
    more processor time than `budget` [s]. `stop`, once set, ends the run at its next instant.
    """
    scene, step = where.scene, None if dt is None else where.step_near(dt)
    if tolerance is not None:
        scene = replace(scene, run=replace(scene.run, tolerance=tolerance, dt=None))
    sim = Simulation(scene, integrator, step)
    sim.positions = where.start
    corners = Corners(sim.assembly)
    rows: list[tuple[float, ...]] = []
    kept: list[Floats] = []
    seconds, failure, expected = 0.0, None, None
    for k in range(1, where.instants + 1):
        if stop is not None and stop.is_set():
            break
        began = time.thread_time()
        try:
            sim.run(until=k * where.interval, frames=2, samples=2)
        except UnstableError as error:
            failure = error
        seconds += time.thread_time() - began
        if failure is not None:
            break
        positions, strains = sim.positions, sim.spring_strains()
        rate, phase = corners.deployment_rate(positions), corners.phase_difference(positions)
        rows.append((sim.time, rate, phase, float(strains.max()) if len(strains) else 0.0, peak_stress(sim)))
        if shapes:
            kept.append(positions)
        if budget is not None and k >= LEAST_READ * where.instants and seconds / k * where.instants > budget:
            expected = seconds / k * where.instants
            break
    times, rates, phases, strain, stress = np.array(rows, dtype=np.float64).reshape(-1, 5).T
    return Trial(
        integrator=sim.integrator,
        dt=sim.dt if step is not None else sim.time / max(sim.step_count, 1),
        times=times,
        rate=rates,
        phase=phases,
        strain=strain,
        stress=stress,
        shapes=np.array(kept, dtype=np.float64).reshape(-1, sim.node_count, 3),
        steps=sim.step_count,
        rejected=sim.rejected_count,
        evaluations=sim.evaluation_count,
        seconds=seconds,
        failure=failure,
        expected=expected,
    )


def ensemble(
    where: Course,
    integrator: str,
    dt: float,
    count: int,
    *,
    shapes: bool = False,
    jobs: int | None = None,
    tell: Tell | None = None,
) -> list[Trial]:
    """The run from the true start, then `count` from shifted ones, with the seeds 0, 1, 2 ..."""
    courses = [where, *(where.shifted(seed) for seed in range(count))]
    names = ["from the true start", *(f"from a shifted start, seed {seed}" for seed in range(count))]

    def of(one: Course) -> Trial:
        return run(one, integrator, dt, shapes=shapes, stop=stop)

    stop = Event()
    return together([lambda one=one: of(one) for one in courses], names, stop, workers=jobs, tell=tell)  # type: ignore[misc]


def _plain(scene: Scene) -> Scene:
    """The scene without settling and snapshots, which a course sees to itself."""
    return replace(scene, run=replace(scene.run, relax=0.0, snapshots=()))
