"""One run of a study: a scene from a given start, by a given method and step, read at given instants."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from threading import Event

import numpy as np

from membrane_rs.errors import InputError, UnstableError
from membrane_rs.observe import Corners, Floats
from membrane_rs.scene import Scene
from membrane_rs.simulation import Simulation

SHIFT = 1e-12
"""By how much the starts of an ensemble differ: the standard deviation of each coordinate [m]."""


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
    """

    scene: Scene
    start: Floats
    until: float
    instants: int

    @property
    def interval(self) -> float:
        """Time between two readings [s]."""
        return self.until / self.instants

    def step_near(self, dt: float) -> float:
        """The step nearest to `dt` of which a whole number fit between two readings [s]."""
        return self.interval / max(1, round(self.interval / dt))

    def of(self, scene: Scene) -> Course:
        """The same course for another scene of the same mesh; cords of other segments take their own start."""
        start = scene.assemble().positions.copy()
        same = len(start) if start.shape == self.start.shape else 0 if scene.mesh is None else len(scene.mesh.reference)
        start[:same] = self.start[:same]
        return replace(self, scene=_plain(scene), start=start)

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
        Step [s].
    times, rate, phase, strain : (k,) float64
        At the instants that the run came to: time [s], deployment rate, phase difference [deg], and the
        largest strain of any spring.
    shapes : (k, N, 3) float64
        Positions [m] at the same instants; (0, N, 3) where they were not wanted.
    steps, evaluations : int
        Steps, and evaluations of the forces.
    seconds : float
        Wall time of the stepping [s].
    failure : UnstableError or None
        Why it stopped before its end.
    """

    integrator: str
    dt: float
    times: Floats
    rate: Floats
    phase: Floats
    strain: Floats
    shapes: Floats
    steps: int
    evaluations: int
    seconds: float
    failure: UnstableError | None = None


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
    if scene.run.settle > 0:
        sim.settle()
    return Course(_plain(scene), sim.positions, end, instants)


def run(where: Course, integrator: str, dt: float, *, shapes: bool = False, stop: Event | None = None) -> Trial:
    """Run a course by one method with the step nearest to `dt` that meets the instants.

    A run that the watch stops is a result, not an error: what was read before stays. `stop`, once set, ends
    the run at its next instant.
    """
    sim = Simulation(where.scene, integrator, where.step_near(dt))
    sim.positions = where.start
    corners = Corners(sim.assembly)
    rows: list[tuple[float, float, float, float]] = []
    kept: list[Floats] = []
    seconds, failure = 0.0, None
    for k in range(1, where.instants + 1):
        if stop is not None and stop.is_set():
            break
        began = time.perf_counter()
        try:
            sim.run(until=k * where.interval, frames=2, samples=2)
        except UnstableError as error:
            failure = error
        seconds += time.perf_counter() - began
        if failure is not None:
            break
        positions, strains = sim.positions, sim.spring_strains()
        peak = float(strains.max()) if len(strains) else 0.0
        rows.append((sim.time, corners.deployment_rate(positions), corners.phase_difference(positions), peak))
        if shapes:
            kept.append(positions)
    times, rate, phase, strain = np.array(rows, dtype=np.float64).reshape(-1, 4).T
    return Trial(
        integrator=sim.integrator,
        dt=sim.dt,
        times=times,
        rate=rate,
        phase=phase,
        strain=strain,
        shapes=np.array(kept, dtype=np.float64).reshape(-1, sim.node_count, 3),
        steps=sim.step_count,
        evaluations=sim.evaluation_count,
        seconds=seconds,
        failure=failure,
    )


def together(jobs: Sequence[Callable[[Event], Trial]]) -> list[Trial]:
    """Run jobs at once, one on each core; the core lets go of the interpreter while it steps.

    Each gets the event that ends it where the user interrupts.
    """
    stop = Event()
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        waiting = [pool.submit(job, stop) for job in jobs]
        try:
            return [future.result() for future in waiting]
        except BaseException:
            stop.set()
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def ensemble(where: Course, integrator: str, dt: float, count: int, *, shapes: bool = False) -> list[Trial]:
    """The run from the true start, then `count` from shifted ones, with the seeds 0, 1, 2 ..."""
    courses = [where, *(where.shifted(seed) for seed in range(count))]
    return together([lambda stop, c=c: run(c, integrator, dt, shapes=shapes, stop=stop) for c in courses])  # type: ignore[misc]


def _plain(scene: Scene) -> Scene:
    """The scene without settling and snapshots, which a course sees to itself."""
    return replace(scene, run=replace(scene.run, settle=0.0, snapshots=()))
