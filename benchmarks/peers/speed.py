"""The flat sail of model 1: the time of a step in every program, and model 1 itself beside it."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from membrane_rs import Simulation, scenes

from peers.measure import largest_step, step_times
from peers.problem import Problem
from peers.program import Program

UNTIL = 0.8
"""Of the deployment [s]."""
DT = 2e-6
"""Step of the timed runs [s]: stable for all."""


@dataclass(frozen=True)
class Pace:
    """One program: processor time of a step [s], and the largest stable step [s], None without one."""

    name: str
    law: str
    bits: int
    step: float
    limit: float | None

    @property
    def whole(self) -> float:
        """Processor time for 0.8 s at the largest stable step [s], extrapolated; NaN without one."""
        return UNTIL / self.limit * self.step if self.limit else float("nan")


@dataclass(frozen=True)
class Model:
    """Model 1 with everything on. `limit`: predicted [s]; `deployment`: leapfrog, 0.8 s at its default step [s]."""

    steps: dict[str, float]
    limits: dict[str, float]
    dt: float
    deployment: float


@dataclass(frozen=True)
class Speed:
    """All that the tables of speed show. `width`: the vector instructions that membrane_rs runs with."""

    problem: Problem
    paces: list[Pace]
    model: Model
    width: str


def measure(
    problem: Problem,
    programs: Sequence[Program],
    only_timed: Sequence[Program],
    *,
    repeats: int,
    slice_seconds: float,
    deploy_until: float,
) -> Speed:
    """Steps of all programs in turn; then the deployment, scaled to 0.8 s where a shorter one is asked for.

    `only_timed`: programs whose largest step is not looked for.
    """
    limits = [largest_step(program, problem) for program in programs] + [None] * len(only_timed)
    programs = [*programs, *only_timed]
    scene = scenes.load("okuizumi-model-1")
    models = {method: Simulation(scene, integrator=method) for method in ("rk4", "leapfrog")}
    tasks: list[tuple[str, Callable[[], None], Callable[[int], None]]] = [
        (str(k), (lambda program=program: program.start(DT)), program.step)  # type: ignore[misc]
        for k, program in enumerate(programs)
    ]
    tasks += [(method, lambda: None, sim.step) for method, sim in models.items()]
    times = step_times(tasks, repeats, slice_seconds)
    paces = [
        Pace(program.name, program.law, program.bits, times[str(k)], limit)
        for k, (program, limit) in enumerate(zip(programs, limits, strict=True))
    ]
    sim = Simulation(scene, integrator="leapfrog")
    began = time.process_time()
    sim.run(deploy_until)
    deployment = (time.process_time() - began) * UNTIL / deploy_until
    model = Model(
        {method: times[method] for method in models},
        {method: Simulation(scene, integrator=method).stable_dt() for method in models},
        sim.dt,
        deployment,
    )
    return Speed(problem, paces, model, sim._core.width)
