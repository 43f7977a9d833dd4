"""The square: the same problem in every program, then error against work for each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from peers.measure import Refinement, RefinementLevel, coarsest, largest_step, nearest, run, shapes_of
from peers.neo_hookean import NeoHookean
from peers.problem import Floats, Problem
from peers.program import Program

WANTED = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6)
"""Errors whose cost is reported."""
LEVELS = 6
"""Number of steps of each program, each half as long as the one before."""
LEVEL_BUDGET = 4.0
"""A level that is expected to take longer than this is left out [s]."""
REFERENCE_STEPS = 640
"""Of membrane_rs's rk4 between two instants, for its reference."""
NUMPY_STEPS = 40
"""The same for the neo-Hookean film."""


@dataclass(frozen=True)
class Sameness:
    """A converged motion: its program and law, and its distance from membrane_rs's on triangles.

    `mass` [kg] and `energy` [J], kinetic at the start, as the program itself holds them; `peak` [-] and `peak_time`
    [s] of the corners' first stretch; `apart` is a distance as `Problem.error` measures it, and `nearest` that of the
    nearest of the program's runs from this motion.
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
class WorkPrecision:
    """The data of the diagram. `own_error`: of membrane_rs's reference on triangles, against twice the step."""

    problem: Problem
    sameness: list[Sameness]
    refinements: list[Refinement]
    own_error: float


def measure(problem: Problem, programs: Sequence[Program], levels: int = LEVELS) -> WorkPrecision:
    """References, largest steps, and runs at all levels; the programs take turns at each level."""
    limits = {id(program): largest_step(program, problem) for program in programs}
    references, own_error = _references(problem, programs)
    found: dict[int, list[RefinementLevel]] = {id(program): [] for program in programs}
    for k in range(levels + 1):
        for program in programs:
            done, limit = found[id(program)], limits[id(program)]
            is_over = k == levels and limit is not None  # methods without a limit begin at longer steps
            if is_over or (done and not 2.0 * done[-1].seconds < LEVEL_BUDGET):
                continue
            per_interval = coarsest(problem, limit) * 2**k
            done.append(run(program, problem, per_interval, references[_reference_of(program)]))
    refinements = [Refinement(program, limits[id(program)], found[id(program)]) for program in programs]
    return WorkPrecision(problem, _sameness(problem, refinements, references), refinements, own_error)


def seconds_at(levels: Sequence[RefinementLevel], wanted: float) -> float:
    """Processor time for an error [s], between two levels on logarithms; NaN if no level reaches it."""
    k = next((k for k, level in enumerate(levels) if level.error <= wanted), None)
    if k is None:
        return math.nan
    fine = levels[k]
    if k == 0 or not levels[k - 1].error > wanted or fine.error == 0.0:
        return fine.seconds
    rough = levels[k - 1]
    part = math.log(wanted / fine.error) / math.log(rough.error / fine.error)
    return float(fine.seconds * (rough.seconds / fine.seconds) ** part)


def measured_order(levels: Sequence[RefinementLevel]) -> float:
    """Slope of error against step over all levels but the coarsest whose error still halves; NaN without two."""
    falling = [fine for rough, fine in pairwise(levels) if 1e-9 < fine.error < 0.6 * rough.error]
    if len(falling) < 2:
        return math.nan
    return float(np.polyfit(np.log([level.dt for level in falling]), np.log([level.error for level in falling]), 1)[0])


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
            found[key] = shapes_of(program, problem, coarsest(problem, program.limit_guess) * 2 ** (LEVELS - 1))[0]
        elif program.law == "neo-Hookean" and key not in found:
            found[key] = NeoHookean(problem).shapes(NUMPY_STEPS)
    return found, own_error


def _sameness(
    problem: Problem, refinements: Sequence[Refinement], references: dict[tuple[str, str], Floats]
) -> list[Sameness]:
    ours = references["double precision", "triangles"]
    rows, seen = [], set()
    for refinement in refinements:
        program, key = refinement.program, _reference_of(refinement.program)
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
            level
            for other in refinements
            for level in other.levels
            if (other.program.name.split()[0], other.program.law) == family
        ]
        rows.append(Sameness(*family, float(masses.sum()), energy, peak, peak_time, apart, nearest(runs).error))
    return rows
