"""Largest stable steps, errors over refined steps, and times of a step.

Times are processor times, so that other programs on the machine have little effect, and are taken alternately, so
that a slow moment affects all alike; of repeated runs at one level the shortest counts, of repeated times of a step
the median.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np

from peers.problem import Floats, Problem
from peers.program import BlownError, Program

GROWTH = 2.0
"""A run whose kinetic energy passes this many times that of the start is unstable: all of it is there at the start."""
TRIAL_STEPS = 400
PRECISION = 0.005
"""Of a largest stable step."""
LEAST_TIME = 0.2
"""A level is repeated until its runs have taken this long in total [s]."""
MOST_RUNS = 5


@dataclass(frozen=True)
class RefinementLevel:
    """One run. `error` is NaN if it blew up; `seconds` of processor time; `steps` in total."""

    dt: float
    steps: int
    seconds: float
    error: float


@dataclass(frozen=True)
class Refinement:
    """One program on one problem over refined steps. `limit` [s] is None if none was found below the longest step."""

    program: Program
    limit: float | None
    levels: list[RefinementLevel]


def is_stable(program: Program, problem: Problem, dt: float, steps: int = TRIAL_STEPS) -> bool:
    """Whether the kinetic energy stays where it was over some steps of size `dt` [s]."""
    most = GROWTH * problem.kinetic_energy(problem.velocities)
    try:
        program.start(dt)
        for _ in range(4):
            program.step(steps // 4)
            _, velocities = program.motion()
            if not problem.kinetic_energy(velocities) < most:
                return False
    except BlownError:
        return False
    return True


def largest_step(program: Program, problem: Problem) -> float | None:
    """Largest stable step [s], by bisection from the program's guess; None without a guess."""
    if program.limit_guess is None:
        return None
    with np.errstate(over="ignore", invalid="ignore"):
        low, high = 0.97 * program.limit_guess, 1.03 * program.limit_guess
        while not is_stable(program, problem, low):
            low, high = 0.7 * low, low
        while is_stable(program, problem, high):
            low, high = high, 1.4 * high
        while high / low > 1.0 + PRECISION:
            middle = math.sqrt(low * high)
            low, high = (middle, high) if is_stable(program, problem, middle) else (low, middle)
    return low


def shapes_of(program: Program, problem: Problem, per_interval: int) -> tuple[Floats, float]:
    """(instants, n, 3) positions [m] with so many steps between two instants, and the processor time [s]."""
    program.start(problem.interval / per_interval)
    shapes, seconds = [], 0.0
    for _ in range(problem.instants):
        began = time.process_time()
        program.step(per_interval)
        seconds += time.process_time() - began
        shapes.append(program.motion()[0])
    return np.stack(shapes), seconds


def run(program: Program, problem: Problem, per_interval: int, reference: Floats) -> RefinementLevel:
    """The run at one level."""
    dt, steps = problem.interval / per_interval, per_interval * problem.instants
    best, spent, error = math.inf, 0.0, math.nan
    for _ in range(MOST_RUNS):
        try:
            shapes, seconds = shapes_of(program, problem, per_interval)
        except BlownError:
            return RefinementLevel(dt, steps, math.nan, math.nan)
        error = problem.error(shapes, reference)
        best, spent = min(best, seconds), spent + seconds
        if spent > LEAST_TIME:
            break
    return RefinementLevel(dt, steps, best, error)


def coarsest(problem: Problem, limit: float | None) -> int:
    """Fewest steps between two instants below the limit; one where there is none."""
    return 1 if limit is None else math.ceil(problem.interval / limit)


def nearest(levels: Iterable[RefinementLevel]) -> RefinementLevel:
    """The one with the least error."""
    return min(levels, key=lambda level: level.error if math.isfinite(level.error) else math.inf)


def step_times(
    tasks: Sequence[tuple[str, Callable[[], None], Callable[[int], None]]], repeats: int, slice_seconds: float
) -> dict[str, float]:
    """Median processor time of a step [s] by name; a task is a name, how to start it and how to take n steps."""
    counts = {}
    for name, start, step in tasks:
        start()
        step(2)
        began = time.process_time()
        step(10)
        counts[name] = max(4, int(slice_seconds / max((time.process_time() - began) / 10, 1e-7)))
    found: dict[str, list[float]] = {name: [] for name, _, _ in tasks}
    for _ in range(repeats):
        for name, _, step in tasks:
            began = time.process_time()
            step(counts[name])
            found[name].append((time.process_time() - began) / counts[name])
    return {name: median(times) for name, times in found.items()}
