"""The end of a stage by a measure.

The measure is evaluated after each step of the stage, or every so many steps where these are far shorter than what it
shows, see `steps_between`; a value that it has in between alone is not seen. Before anything is shown at a time, the
run has looked ahead to the first check after it; where the measure has passed its value there, the time at which it
does is found between the two checks by Brent's method, each trial being stepped from the state at the earlier one. So
neither that time nor the motion depends on outputs, and a saved state is that at the last check.

R. P. Brent, Algorithms for Minimization without Derivatives (1973), chapter 4.
"""

from __future__ import annotations

import math
from time import monotonic
from typing import Any

import numpy as np

from membrane_rs import _core
from membrane_rs.errors import InputError
from membrane_rs.scene.stage import Stage
from membrane_rs.simulation.measures import Follower
from membrane_rs.simulation.methods import integrators
from membrane_rs.simulation.motion import Motion

CHECK_STEPS = 20
"""Steps of an explicit method between two evaluations in a scene of more than ..."""
FEW_NODES = 100
"""... so many nodes: there the shortest vibrations set the step. In a small one the whole motion may."""
SAME_STEP, SAME_TIME = 2e-9, 1e-14
"""A time this near a jump is that of the jump for the core: a share of the step, and a share of the time."""


def steps_between(sim: Motion) -> int:
    """Steps between two evaluations of the measure that ends a stage."""
    facts = integrators()[sim.integrator]
    is_fine = not sim.is_adaptive and math.isfinite(facts.imaginary_limit) and sim.node_count > FEW_NODES
    return max(1, CHECK_STEPS // sim.stage_scene.run.substeps) if is_fine else 1


class StageEnd:
    """The measure that may end a stage: its last evaluation, and the first one after it.

    Parameters
    ----------
    sim : Motion
        At the last evaluation.
    stage : Stage
        With a measure.
    end : float
        Time at which the stage ends at the latest [s].
    follower : Follower
        Of its measure.
    is_armed : bool
        Whether the measure has been on this side of its value in this stage.
    """

    def __init__(self, sim: Motion, stage: Stage, end: float, follower: Follower, *, is_armed: bool = False) -> None:
        self._sim, self._stage, self._end, self.follower = sim, stage, end, follower
        self._steps = steps_between(sim)
        self.is_armed = is_armed
        self.event: float | None = None
        """Time at which the measure passes its value [s]; None: not before the next evaluation, as far as known."""
        self._keep()

    @property
    def ahead(self) -> float:
        """Time of the first evaluation after the last one that was looked ahead to [s]."""
        return self._ahead

    def open(self) -> None:
        """Evaluate the measure at the start of the stage."""
        self.is_armed = self._next_armed = not self._is_past()

    def _keep(self) -> None:
        """Keep the state now as that of the last evaluation."""
        core = self._sim._core
        self.state: dict[str, Any] = core.progress()
        self.time = self._ahead = core.time
        self._next_armed = self.is_armed

    def look_ahead(self, goal: float, seconds: float | None) -> bool:
        """Evaluate the measure up to the first time of an evaluation not before `goal` [s], for about `seconds` of wall
        time. Whether that is done; the state is then that at a time not after `goal`, or after `event`.
        """
        began, core = monotonic(), self._sim._core
        while self.event is None and self._ahead < goal:
            if self._ahead > self.time:
                core.reach(self._ahead)
                self.follower, self.is_armed = self.follower.at_check(self._sim), self._next_armed
                self._keep()
            core.resume(self.state)
            try:
                ahead = self._next_time()
                core.reach(ahead)
                is_past = self._is_past()
                event = self._found(ahead) if self.is_armed and is_past else None
                if ahead > goal or event is not None:
                    core.resume(self.state)
                self._next_armed, self._ahead, self.event = self.is_armed or not is_past, ahead, event
            except BaseException:
                core.resume(self.state)
                raise
            if event is None and ahead < goal and seconds is not None and monotonic() - began > seconds:
                return False
        return True

    def _next_time(self) -> float:
        """Time of the first evaluation after the last one [s]: at the end of a step, or of the stage."""
        core = self._sim._core
        if core.is_adaptive:
            return next_adaptive(core, self._end)
        number = (core.step_count // self._steps + 1) * self._steps
        return min(self._end, core.time_of_step(number))

    def _found(self, ahead: float) -> float:
        """Time between the last evaluation and the next one, where the core is, at which the measure passes its value
        [s]: that of a jump of schedules where it does so by the jump.
        """
        from scipy.optimize import brentq  # slow to import

        level, rounding = self._stage.level or 0.0, float(np.finfo(float).eps)
        core = self._sim._core
        is_jump = core.progress()["origin"] == ahead
        near_jump = max(SAME_STEP * (0.0 if core.is_adaptive else core.dt), SAME_TIME * abs(ahead))

        def excess(time: float) -> float:
            core.resume(self.state)
            core.reach(time)
            return self.follower.value(self._sim) - level

        try:
            found: float = brentq(excess, self.time, ahead, xtol=2.0 * rounding * abs(ahead), rtol=4.0 * rounding)
        except ValueError:  # no change of sign
            raise InputError(
                f"{self.follower.where}: is not the same again at t = {self.time:.6g} s or {ahead:.6g} s, between "
                "which it passes its value; a measure must follow from the state of the simulation alone"
            ) from None
        return ahead if is_jump and ahead - found <= near_jump else found

    def _is_past(self) -> bool:
        return self._stage.is_past(self.follower.value(self._sim))


def next_adaptive(core: _core.Simulation, end: float) -> float:
    """Take the next step of a method that chooses its steps; the time at its end [s], or `end` where that is before."""
    core.reach(min(end, math.nextafter(step_end(core), math.inf)))
    return min(end, step_end(core))


def step_end(core: _core.Simulation) -> float:
    """Time at the end of the last step of a method that chooses its steps [s]."""
    return float(core.progress()["adaptive_numbers"][0])
