"""The square: the same problem in every program, then error against work for each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from peers.measure import Ladder, Rung, coarsest, largest_step, nearest, run, shapes_of
from peers.neo_hookean import NeoHookean
from peers.problem import Floats, Problem
from peers.program import Program

WANTED = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6)
"""Errors of which the cost is told."""
RUNGS = 6
"""Steps of each program, the next one half as long."""
RUNG_BUDGET = 4.0
"""A rung that is expected to take longer than this is left out [s]."""
REFERENCE_STEPS = 640
"""Of membrane_rs's rk4 between two instants, for its reference."""
NUMPY_STEPS = 40
"""The same for the neo-Hookean film."""


@dataclass(frozen=True)
class Sameness:
    """A converged motion: what it is of, and how far from membrane_rs's on triangles.

    `mass` [kg] and `energy` [J], kinetic at the start, as the program itself holds them; `peak` [-] and `peak_time`
    [s] of the corners' first stretch; `apart` is a distance as `Problem.error` measures it, and `nearest` that of the
    nearest run of the program's ladders from this motion.
    """

    name: str
    law: str
    mass: float
    energy: float
    peak: float
    peak_time: float
    apart: float
    nearest: float


@dataclass(frozen=True)
class Chart:
    """All that the chart shows. `own_error`: of membrane_rs's reference on triangles, against twice the step."""

    problem: Problem
    sameness: list[Sameness]
    ladders: list[Ladder]
    own_error: float


def measure(problem: Problem, programs: Sequence[Program], rungs: int = RUNGS) -> Chart:
    """References, largest steps, and ladders; of the programs the rungs are run in turn."""
    limits = {id(program): largest_step(program, problem) for program in programs}
    references, own_error = _references(problem, programs)
    found: dict[int, list[Rung]] = {id(program): [] for program in programs}
    for k in range(rungs + 1):
        for program in programs:
            done, limit = found[id(program)], limits[id(program)]
            is_over = k == rungs and limit is not None  # methods without a limit begin at longer steps
            if is_over or (done and not 2.0 * done[-1].seconds < RUNG_BUDGET):
                continue
            per_interval = coarsest(problem, limit) * 2**k
            done.append(run(program, problem, per_interval, references[_reference_of(program)]))
    ladders = [Ladder(program, limits[id(program)], found[id(program)]) for program in programs]
    return Chart(problem, _sameness(problem, ladders, references), ladders, own_error)


def seconds_at(rungs: Sequence[Rung], wanted: float) -> float:
    """Processor time for an error [s], between two rungs on logarithms; NaN if no rung reaches it."""
    k = next((k for k, rung in enumerate(rungs) if rung.error <= wanted), None)
    if k is None:
        return math.nan
    fine = rungs[k]
    if k == 0 or not rungs[k - 1].error > wanted or fine.error == 0.0:
        return fine.seconds
    rough = rungs[k - 1]
    part = math.log(wanted / fine.error) / math.log(rough.error / fine.error)
    return float(fine.seconds * (rough.seconds / fine.seconds) ** part)


def measured_order(rungs: Sequence[Rung]) -> float:
    """Slope of error against step over all rungs but the coarsest whose error still halves; NaN without two."""
    falling = [fine for rough, fine in pairwise(rungs) if 1e-9 < fine.error < 0.6 * rough.error]
    if len(falling) < 2:
        return math.nan
    return float(np.polyfit(np.log([rung.dt for rung in falling]), np.log([rung.error for rung in falling]), 1)[0])


def _reference_of(program: Program) -> tuple[str, str]:
    """Whose converged motion a program is measured against: its own; in single precision that of its law."""
    whose = "MuJoCo" if program.name.startswith("MuJoCo") else "double precision"
    return whose, program.law


def _references(problem: Problem, programs: Sequence[Program]) -> tuple[dict[tuple[str, str], Floats], float]:
    found: dict[tuple[str, str], Floats] = {}
    own_error = math.nan
    for program in programs:
        key = _reference_of(program)
        if program.name == "membrane_rs rk4":
            found[key] = shapes_of(program, problem, REFERENCE_STEPS)[0]
            if program.law == "triangles":
                own_error = problem.error(shapes_of(program, problem, REFERENCE_STEPS // 2)[0], found[key])
        elif program.name == "MuJoCo RK4":
            found[key] = shapes_of(program, problem, coarsest(problem, program.limit_guess) * 2 ** (RUNGS - 1))[0]
        elif program.law == "neo-Hookean" and key not in found:
            found[key] = NeoHookean(problem).shapes(NUMPY_STEPS)
    return found, own_error


def _sameness(problem: Problem, ladders: Sequence[Ladder], references: dict[tuple[str, str], Floats]) -> list[Sameness]:
    ours = references["double precision", "triangles"]
    rows, seen = [], set()
    for ladder in ladders:
        program, key = ladder.program, _reference_of(ladder.program)
        family = (program.name.split()[0], program.law)
        if family in seen:
            continue
        seen.add(family)
        program.start(problem.interval)
        masses, velocities = program.masses(), program.motion()[1]
        energy = 0.5 * float(masses @ (velocities**2).sum(axis=1))
        peak, peak_time = problem.corner_peak(references[key])
        apart = problem.error(references[key], ours)
        runs = [
            rung
            for other in ladders
            for rung in other.rungs
            if (other.program.name.split()[0], other.program.law) == family
        ]
        rows.append(Sameness(*family, float(masses.sum()), energy, peak, peak_time, apart, nearest(runs).error))
    return rows
