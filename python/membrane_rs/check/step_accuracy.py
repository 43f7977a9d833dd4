"""The error of the step: a scene run twice, with its step and with half of it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.errors import MembraneError, UnstableError
from membrane_rs.mesh.findings import Finding
from membrane_rs.scene import Scene
from membrane_rs.simulation.methods import integrators
from membrane_rs.simulation.stepper import Stepper

ALLOWED = 0.01
"""Share of the motion by which a step may be wrong."""
INSTANTS = 200
"""Times at which two runs are compared, evenly spaced, but no more than steps; before the first of these after 1, 2,
4 ... steps."""
FINER = {False: 2.0, True: 32.0}
"""Divisor of the step, or of the tolerance where steps are chosen by their error."""
AT_REST = 1e-9
"""Extent of a motion below which nothing moves, as a share of the size of the scene."""
WORK = 1e8
"""Evaluations of the forces times nodes, of both runs together: some two seconds on one core."""
IMPLICIT_SHARE = 0.02
"""Share of that for a method without a limit of its step, which solves equations in each step."""
PART = 50
"""Steps between two looks at the work."""
SAFETY = 0.8
"""Share of the step that would just be right, for the advice."""


@dataclass(frozen=True)
class StepAccuracy:
    """The estimated error of the step.

    Attributes
    ----------
    error : float
        Largest distance of any node from where it should be, as a share of `extent`.
    extent : float
        Extent of the motion: the largest distance of any node from its start [m].
    reached, until : float
        Time up to which the error is known, and the end of the run [s].
    dt : float
        Step [s], the first one where steps are chosen by their error.
    order : int
        Order of the method.
    is_adaptive : bool
        Whether steps are chosen by their error.
    failure : str
        Why a run was stopped; empty otherwise.
    """

    error: float
    extent: float
    reached: float
    until: float
    dt: float
    order: int
    is_adaptive: bool
    failure: str = ""

    def warning(self) -> str | None:
        """Why the step may not be right to 1 % of the motion, and what to do; None where it is right."""
        found = self.finding()
        return None if found is None else f"Warning: {found.message}: {found.remedy}"

    def finding(self) -> Finding | None:
        """The same as a finding."""
        found = self._in_words()
        return None if found is None else Finding("warning", "step_accuracy", 1, *found)

    def _in_words(self) -> tuple[str, str] | None:
        """What is wrong, and what to do."""
        if self.failure:
            return f"the run stops by itself: {self.failure}", "do as that says, or compare steps and methods"
        share = f"{100.0 * self.error:.2g} % of the motion, whose extent is {self.extent:.3g} m"
        if self.error > ALLOWED:
            factor = (ALLOWED / self.error) ** (1.0 / self.order) * SAFETY
            remedy = "use a smaller tolerance" if self.is_adaptive else f"use dt = {factor * self.dt:.2g} s"
            return (
                f"by t = {self.reached:.4g} s the step is wrong by {share}",
                f"{remedy}; where that does not help, the motion is chaotic, and only its curves mean something "
                "(membrane-rs work-precision --curves)",
            )
        if self.reached < self.until:
            known = f"wrong by {share}" if self.reached > 0.0 else "not known"
            return (
                f"the error of the step up to {self.until:g} s would take too long to estimate. Up to "
                f"{self.reached:.3g} s it is {known}",
                "compare steps by membrane-rs work-precision",
            )
        return None


def accuracy_of_step(scene: Scene) -> Iterator[Finding]:
    """The error of the step as a finding: nothing where it is known to the end and right."""
    try:
        found = step_accuracy(scene).finding()
    except MembraneError:  # `Simulation` says why
        return
    if found is not None:
        yield found


def step_accuracy(scene: Scene, integrator: str | None = None, work: float = WORK) -> StepAccuracy:
    """Run a scene with its step and with half of it (of its tolerance a 32nd), and compare the positions.

    With order p, the error is the difference over 1 - 2^-p. Both start as the scene is given, without relaxation. They
    end at the end of the run, or where `work` is done, evaluations of the forces times nodes, but not before the first
    step is compared: so it is the same on every machine. There the energy balance is judged as at the end of a run.

    Raises
    ------
    InputError
        More steps to the end than a run takes.
    """
    coarse = Stepper(scene, integrator)
    coarse._check_end(scene.run.until)
    facts = integrators()[coarse.integrator]
    divisor = FINER[coarse.is_adaptive]
    finer = replace(scene.run, tolerance=scene.run.tolerance / divisor) if coarse.is_adaptive else scene.run
    fine = Stepper(replace(scene, run=finer), coarse.integrator, None if coarse.is_adaptive else coarse.dt / divisor)
    dt, until = coarse.dt, scene.run.until
    start, limit = coarse.positions, math.inf
    work *= IMPLICIT_SHARE if math.isinf(facts.imaginary_limit) else 1.0
    largest = extent = reached = 0.0
    failure = ""
    try:
        for instant in _instants(dt, until):
            if not _reach((coarse, fine), instant, limit):
                break
            largest = max(largest, _distance(coarse.positions, fine.positions))
            extent, reached, limit = max(extent, _distance(fine.positions, start)), instant, work
        coarse._core.check(True)
    except UnstableError as error:
        failure = str(error)
    rate = 1.0 if coarse.is_adaptive else 1.0 / (1.0 - divisor**-facts.order)
    size = float(np.ptp(start, axis=0).max(initial=0.0))
    share = rate * largest / extent if extent > AT_REST * size else 0.0
    return StepAccuracy(share, extent, reached, until, dt, facts.order, coarse.is_adaptive, failure)


def _instants(dt: float, until: float) -> list[float]:
    """Times [s] at which two runs are compared."""
    even = np.linspace(0.0, until, min(INSTANTS, math.ceil(until / dt)) + 1)[1:].tolist()
    earlier = max(0, math.ceil(math.log2(even[0] / dt)))
    return [*(dt * 2**k for k in range(earlier)), *even]


def _reach(sims: Sequence[Stepper], instant: float, limit: float) -> bool:
    """Whether all have reached an instant [s] before the work of all is at its limit."""
    for sim in sims:
        while sim.time < instant:
            if sum(each.evaluation_count * each.node_count for each in sims) >= limit:
                return False
            sim.reach(min(instant, sim.time + PART * sim.dt))
    return True


def _distance(one: Floats, other: Floats) -> float:
    """The largest distance of any node."""
    return float(np.sqrt(np.square(one - other).sum(axis=1)).max(initial=0.0))
