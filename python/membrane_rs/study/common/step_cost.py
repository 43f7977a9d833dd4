"""What a step costs, one scene against another.

Timed in turns, and in processor time, so that a machine that is busy with other things slows both alike.
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
"""Time of the whole scene's steps in each round [s], about."""


def cost_against(whole: Simulation, scene: Scene) -> tuple[float, float]:
    """Time per step and stability limit of a scene, over those of the whole one; two without limit are alike.

    The time is the median over rounds in which both take the same number of steps of the same size; NaN
    where the scene goes wrong within them.
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
