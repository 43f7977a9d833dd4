"""Cost of a step of one scene relative to another.

Both are timed alternately and in processor time, so that other load on the machine affects them equally.
"""

from __future__ import annotations

import math
import time
from statistics import median

from membrane_rs.errors import UnstableError
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene

ROUNDS = 9
BATCH = 0.02
"""Approximate duration of the complete scene's steps in each round [s]."""


def cost_against(whole: Simulation, scene: Scene) -> tuple[float, float]:
    """Ratios of time per step and of stability limit, the scene over the complete one; 1 for two infinite limits.

    The time is the median over rounds in which both take the same number of steps of the same size. It is NaN where
    the monitor stops the scene within them.
    """
    dt = min(whole.dt, Simulation(scene, whole.integrator).dt)
    mine = Simulation(whole.scene, whole.integrator, dt)
    other = Simulation(scene, whole.integrator, dt)
    before, after = mine.stable_dt(), other.stable_dt()
    limits = 1.0 if math.isinf(before) and math.isinf(after) else after / before
    try:
        count = max(1, round(10 * BATCH / max(_seconds(mine, 10), 1e-9)))
        _seconds(other, 10)
        ratios = [_seconds(other, count) / _seconds(mine, count) for _ in range(ROUNDS)]
    except UnstableError:
        return math.nan, limits
    return median(ratios), limits


def _seconds(sim: Simulation, steps: int) -> float:
    began = time.process_time()
    sim.step(steps)
    return time.process_time() - began
