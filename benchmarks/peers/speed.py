"""The flat sail of model 1: the time of a step in every program, and model 1 itself beside it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from membrane_rs import Simulation, scenes

from peers.deployment import UNTIL, Deployment, FastDeployment, deploy, deploy_fast
from peers.measure import largest_step, step_times
from peers.problem import Problem
from peers.program import Program

DT = 2e-6
"""Step of the timed runs [s]: stable for all."""
OTHER = ("MuJoCo RK4", "triangles")
"""Name and law of the program that deployments are compared with."""
METHODS = ("rk4", "leapfrog")
"""By which model 1 itself is timed."""


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
        return self.whole_by(self.step)

    def whole_by(self, step: float) -> float:
        """The same by another time of a step [s]."""
        return UNTIL / self.limit * step if self.limit else float("nan")


@dataclass(frozen=True)
class Steps:
    """Steps of all programs and of model 1 with all laws, by method [s], timed in turn.

    `width`: the vector instructions that membrane_rs runs with.
    """

    problem: Problem
    paces: list[Pace]
    model: dict[str, float]
    width: str

    def pace(self, name: str, law: str) -> Pace:
        """That of a program."""
        return next(found for found in self.paces if found.name == name and found.law == law)


@dataclass(frozen=True)
class Speed(Steps):
    """All that the tables of speed show."""

    deployment: Deployment
    fast: FastDeployment

    @property
    def other(self) -> Pace:
        """The program that deployments are compared with."""
        return self.pace(*OTHER)


def steps(problem: Problem, programs: Sequence[Program], *, repeats: int, slice_seconds: float) -> Steps:
    """The time of a step in every program, and of model 1; largest steps are not looked for."""
    models = {method: Simulation(scenes.load("okuizumi-model-1"), integrator=method) for method in METHODS}
    tasks: list[tuple[str, Callable[[], None], Callable[[int], None]]] = [
        (str(k), (lambda program=program: program.start(DT)), program.step)  # type: ignore[misc]
        for k, program in enumerate(programs)
    ]
    tasks += [(method, lambda: None, sim.step) for method, sim in models.items()]
    times = step_times(tasks, repeats, slice_seconds)
    paces = [Pace(one.name, one.law, one.bits, times[str(k)], None) for k, one in enumerate(programs)]
    return Steps(problem, paces, {method: times[method] for method in models}, models[METHODS[0]]._core.instructions)


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
    limits = [*(largest_step(program, problem) for program in programs), *(None for _ in only_timed)]
    found = steps(problem, [*programs, *only_timed], repeats=repeats, slice_seconds=slice_seconds)
    paces = [replace(pace, limit=limit) for pace, limit in zip(found.paces, limits, strict=True)]
    other = next(program for program in programs if (program.name, program.law) == OTHER)
    other.start(DT)
    deployment = deploy(scenes.load("okuizumi-model-1"), other, deploy_until)
    return Speed(problem, paces, found.model, found.width, deployment, deploy_fast(other, deploy_until))
