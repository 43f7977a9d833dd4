"""The end of a stage, or of a run, by a measure.

The measure is evaluated after each step of the stage, or every so many steps where these are far shorter than what it
shows, see `steps_between`; a value that it has in between alone is not seen. Before anything is shown at a time, the
run has looked ahead to the first check after it; where the measure has passed its value there, the time at which it
does is found between the two checks by Brent's method, each trial being stepped from the state at the earlier one. So
neither that time nor the motion depends on outputs, and a saved state is that at the last check.

R. P. Brent, Algorithms for Minimization without Derivatives (1973), chapter 4.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
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


@dataclass(frozen=True)
class Watch:
    """A measure that may end a stage or the run, at its last evaluation.

    Attributes
    ----------
    follower : Follower
        Evaluates it.
    sides : (-1,), (1,) or (-1, 1)
        Sides of its value from which it may pass: below, above, or either.
    ends_run : bool
        Whether it ends the run, and not the stage.
    side : int
        The one of those on which it was last; 0 where it has been on none of them.
    """

    follower: Follower
    sides: tuple[int, ...]
    ends_run: bool = False
    side: int = 0

    @classmethod
    def of_stage(cls, stage: Stage, follower: Follower) -> Watch:
        """That of a stage."""
        return cls(follower, (-1,) if stage.below is None else (1,))

    def passes(self, excess: float) -> bool:
        """Whether it has passed its value where it is this much beyond it."""
        return self.side != 0 and _sign(excess) != self.side

    def after(self, excess: float) -> Watch:
        """The same once it was so much beyond its value."""
        side = _sign(excess)
        return replace(self, side=side) if side in self.sides else self


class StageEnd:
    """The measures that may end a stage, or the run: their last evaluation, and the first one after it.

    Parameters
    ----------
    sim : Motion
        At the last evaluation.
    end : float
        Time at which the stage ends at the latest [s].
    watches : sequence of Watch
        The measures, at least one. Of those that pass their values at one time the first counts.
    """

    def __init__(self, sim: Motion, end: float, watches: Sequence[Watch]) -> None:
        self._sim, self._end, self.watches = sim, end, list(watches)
        self._steps = steps_between(sim)
        self.event: float | None = None
        """Time at which one passes its value [s]; None: not before the next evaluation, as far as known."""
        self.passed: Watch | None = None
        """The one that does."""
        self._keep()

    @property
    def ahead(self) -> float:
        """Time of the first evaluation after the last one that was looked ahead to [s]."""
        return self._ahead

    def open(self) -> None:
        """Evaluate the measures now, at the start of a stage or of a run."""
        self._next = self._evaluated()
        self.watches, is_past = [watch for watch, _ in self._next], [is_past for _, is_past in self._next]
        if any(is_past):
            self.event, self.passed = self.time, self.watches[is_past.index(True)]

    def without_run(self) -> StageEnd | None:
        """The same for the stage alone, from the last evaluation on; None where no measure ends it."""
        watches = [watch for watch in self.watches if not watch.ends_run]
        if not watches:
            return None
        made = copy(self)
        made.watches, made.event, made.passed, made._ahead = watches, None, None, self.time
        return made

    def _keep(self) -> None:
        """Keep the state now as that of the last evaluation."""
        core = self._sim._core
        self.state: dict[str, Any] = core.progress()
        self.time = self._ahead = core.time

    def _evaluated(self) -> list[tuple[Watch, bool]]:
        """Each measure after its value now, and whether it has passed."""
        values = [(watch, watch.follower.excess(self._sim)) for watch in self.watches]
        return [(watch.after(excess), watch.passes(excess)) for watch, excess in values]

    def look_ahead(self, goal: float, seconds: float | None) -> bool:
        """Evaluate the measures up to the first time of an evaluation not before `goal` [s], for about `seconds` of
        wall time. Whether that is done; the state is then that at a time not after `goal`, or after `event`.
        """
        began, core = monotonic(), self._sim._core
        while self.event is None and self._ahead < goal:
            if self._ahead > self.time:
                core.reach(self._ahead)
                at_check = ((watch, watch.follower.at_check(self._sim)) for watch, _ in self._next)
                self.watches = [replace(watch, follower=follower) for watch, follower in at_check]
                self._keep()
            core.resume(self.state)
            try:
                ahead = self._next_time()
                core.reach(ahead)
                after = self._evaluated()
                is_jump = any(is_past for _, is_past in after) and core.progress()["origin"] == ahead
                found = [
                    (self._found(watch, ahead, is_jump=is_jump), k)
                    for k, (watch, (_, is_past)) in enumerate(zip(self.watches, after, strict=True))
                    if is_past
                ]
                event, first = min(found, default=(None, 0))
                if ahead > goal or event is not None:
                    core.resume(self.state)
                self._next, self._ahead = after, ahead
                self.event, self.passed = event, None if event is None else self.watches[first]
            except BaseException:
                core.resume(self.state)
                raise
            if event is None and ahead < goal and seconds is not None and monotonic() - began > seconds:
                return False
        return True

    def next_time(self) -> float:
        """Time of the first evaluation after the last one [s]; the state is then that at the last one."""
        core = self._sim._core
        core.resume(self.state)
        ahead = self._next_time()
        core.resume(self.state)
        return ahead

    def _next_time(self) -> float:
        """Time of the first evaluation after the last one [s]: at the end of a step, or of the stage."""
        core = self._sim._core
        if core.is_adaptive:
            return next_adaptive(core, self._end)
        number = (core.step_count // self._steps + 1) * self._steps
        return min(self._end, core.time_of_step(number))

    def _found(self, watch: Watch, ahead: float, *, is_jump: bool) -> float:
        """Time between the last evaluation and the next one, at which a measure passes its value [s]: that of a jump of
        schedules, there, where it does so by the jump.
        """
        from scipy.optimize import brentq  # slow to import

        rounding, core = float(np.finfo(float).eps), self._sim._core
        near_jump = max(SAME_STEP * (0.0 if core.is_adaptive else core.dt), SAME_TIME * abs(ahead))
        apart = 2.0 * rounding * abs(ahead)

        def excess(time: float) -> float:
            core.resume(self.state)
            core.reach(time)
            return watch.follower.excess(self._sim)

        try:
            found: float = brentq(excess, self.time, ahead, xtol=apart, rtol=4.0 * rounding)
        except ValueError:  # no change of sign
            raise InputError(
                f"{watch.follower.where}: is not the same again at t = {self.time:.6g} s or {ahead:.6g} s, between "
                "which it passes its value; a measure must follow from the state of the simulation alone"
            ) from None
        if is_jump and ahead - found <= near_jump:
            return ahead
        while watch.ends_run and found < ahead and not watch.passes(excess(found)):
            found = min(ahead, found + apart)  # the root is known to rounding: the run ends behind it
        return found


def _sign(value: float) -> int:
    return (value > 0.0) - (value < 0.0)


def next_adaptive(core: _core.Simulation, end: float) -> float:
    """Take the next step of a method that chooses its steps; the time at its end [s], or `end` where that is before."""
    core.reach(min(end, math.nextafter(step_end(core), math.inf)))
    return min(end, step_end(core))


def step_end(core: _core.Simulation) -> float:
    """Time at the end of the last step of a method that chooses its steps [s]."""
    return float(core.progress()["adaptive_numbers"][0])
