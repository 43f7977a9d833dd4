"""The stages of a scene in motion: each by a core of its own, which goes on from the motion of the one before."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from membrane_rs._arrays import Floats
from membrane_rs._messages import function_words
from membrane_rs.errors import InputError, UnstableError
from membrane_rs.scene import Scene
from membrane_rs.simulation.measures import Follower, is_measured
from membrane_rs.simulation.motion import Motion
from membrane_rs.simulation.output_times import is_same_time
from membrane_rs.simulation.stage_end import StageEnd, Watch, next_adaptive, step_end
from membrane_rs.simulation.timeline import (
    BY_DURATION,
    BY_MEASURE,
    StageRecord,
    Timeline,
    summed,
    sums,
    without_energy,
)


class StagedMotion(Motion):
    """A motion that passes through the stages of its scene; of a scene without stages, a `Motion`."""

    _timeline: Timeline | None = None
    _stage_end: StageEnd | None = None

    def _build(self, scene: Scene, integrator: str | None, dt: float | None) -> None:
        self._timeline, self._stage_end = None, None
        super()._build(scene, integrator, dt)
        if not scene.stages:
            return
        self._given = (integrator, dt)
        laws, potentials = dict.fromkeys(self._core.law_names), dict.fromkeys(self._potentials())
        for k in range(1, len(scene.stages)):
            with named(f"stages[{k}]"):
                trial = Motion(scene.staged(k), *self._method(k))
            laws |= dict.fromkeys(trial._core.law_names)
            potentials |= dict.fromkeys(name for name in trial.energies() if name != "kinetic")
        self._timeline = Timeline(scene.stages, list(laws), list(potentials))
        self._open_check()

    def _method(self, index: int) -> tuple[str | None, float | None]:
        """Method and step of a stage by the caller, where the stage sets no other."""
        names = self.scene.stages[index].set
        integrator, dt = self._given
        return None if "run.integrator" in names else integrator, None if "run.dt" in names else dt

    def _built_with(self) -> tuple[str | None, float | None]:
        return super()._built_with() if self._timeline is None else self._given

    @property
    def stage(self) -> int:
        """Index of the present stage; 0 for a scene without stages. At a boundary it is the stage that begins."""
        return 0 if self._timeline is None else self._timeline.index

    @property
    def stage_name(self) -> str:
        """Name of the present stage; empty for a scene without stages."""
        return "" if self._timeline is None else self._timeline.stage.name

    @property
    def is_over(self) -> bool:
        """Whether the last stage has ended."""
        return self._timeline is not None and self._timeline.ended_by is not None

    @property
    def stages(self) -> list[StageRecord]:
        """A record of each stage up to the present one; empty for a scene without stages."""
        return [] if self._timeline is None else [*self._timeline.past, self._record()]

    @property
    def boundaries(self) -> list[float]:
        """Times at which stages after the first one began [s]."""
        return [] if self._timeline is None else self._timeline.starts[1:]

    @property
    def stage_end(self) -> float:
        """Time at which the present stage ends at the latest [s]; infinite for a scene without stages."""
        return math.inf if self._timeline is None else self._timeline.end

    @property
    def planned_end(self) -> float:
        """Time at the end of a run [s]: that of the scene, or of its last stage, where no measure ends one earlier."""
        return self.scene.run.until if self._timeline is None else self._timeline.last_end

    def _check_stages_last(self, end: float) -> None:
        """Refuse a time [s] after the end of the last stage. Raises InputError."""
        line = self._timeline
        if line is not None and end > line.latest_end and not is_same_time(end, line.latest_end):
            raise InputError(
                f"until = {end} s: the last stage ends at {line.latest_end:.15g} s; give an earlier time, or make a "
                "stage longer"
            )

    @property
    def law_names(self) -> tuple[str, ...]:
        """All laws that act in any stage, those of cords and bridges among them."""
        return tuple(self._core.law_names if self._timeline is None else self._timeline.laws)

    @property
    def potential_names(self) -> tuple[str, ...]:
        """Those that have a potential in any stage."""
        return tuple(self._potentials() if self._timeline is None else self._timeline.potentials)

    @property
    def step_count(self) -> int:
        """Steps taken, in all stages."""
        return self._core.step_count + sum(record.steps for record in self._past())

    @property
    def evaluation_count(self) -> int:
        """Evaluations of the forces while stepping, in all stages."""
        return self._core.evaluation_count + sum(record.evaluations for record in self._past())

    @property
    def rejected_count(self) -> int:
        """Steps that were tried and rejected because of their error; their evaluations count."""
        return self._core.rejected_count + sum(record.rejected_steps for record in self._past())

    def ledger(self) -> dict[str, Any]:
        """The energy balance since the start, or since positions or velocities were last set.

        Returns
        -------
        dict
            That of `Motion.ledger`. With stages "work", "work_by_law" and "motor_work" are sums over the stages,
            "reference_energy" is the largest of any stage, and "error" the sum of the residuals of all stages as a
            share of it. "changes" is what changes of stage and jumps of schedules have put in [J], as
            {"<stage>: <term>": J}, where a term is
            "kinetic" or a law.
        """
        found = super().ledger()
        if self._timeline is None:
            return found
        return found | summed(found, self._past(), self.stages)

    def _past(self) -> list[StageRecord]:
        return [] if self._timeline is None else self._timeline.past

    def _potentials(self) -> list[str]:
        return [name for name in self.energies() if name != "kinetic"]

    def _law_names(self) -> list[str]:
        return list(self.law_names)

    def _record(self) -> StageRecord:
        """Of the present stage."""
        line, core = self._present(), self._core
        balance = core.ledger()
        return StageRecord(
            name=line.stage.name,
            start=line.starts[-1],
            end=core.time,
            ended_by=line.ended_by,
            integrator=core.integrator,
            dt=core.dt,
            steps=core.step_count,
            evaluations=core.evaluation_count,
            rejected_steps=core.rejected_count,
            changes=sums(line.changes, balance.changes),
            work_by_law=dict(balance.work_by_law),
            reference_energy=balance.reference_energy,
            error=balance.error,
            motor_work=balance.motor_work,
        )

    def _present(self) -> Timeline:
        if self._timeline is None:
            raise InputError("the scene has no stages")
        return self._timeline

    def _reach(self, time: float, seconds: float | None = None) -> bool:
        """Step to a time [s], at most to the end of the present stage, where the next one begins, or stop after about
        `seconds` of wall time. Whether it came there.
        """
        line, core, check = self._timeline, self._core, self._stage_end
        if line is None and check is None:
            return core.reach(time, seconds)
        if is_measured(self):
            raise InputError("a measure has stepped the simulation; a measure only reads")
        if line is not None and line.ended_by is not None:
            raise self._over()
        goal = min(time, self.stage_end)
        try:
            if check is not None:
                if not check.look_ahead(goal, seconds):
                    return False
                goal = goal if check.event is None else min(goal, check.event)
            if not core.reach(goal, seconds):
                return False
        except UnstableError:
            self._reopen_check()
            raise
        passed = None if check is None or goal != check.event else check.passed
        if passed is not None:
            self._wholly(lambda: self._pass(passed))
        elif goal == self.stage_end:
            self._wholly(lambda: self._end_stage(BY_DURATION))
        return True

    def _pass(self, passed: Watch) -> None:
        """A measure has passed its value now: end the present stage."""
        self._end_stage(BY_MEASURE)

    def _step(self, count: int) -> None:
        """Take steps through the stages; the rest of a step up to the end of a stage is none of them."""
        while count > 0:
            line, core = self._present(), self._core
            index = line.index
            if line.ended_by is not None:
                raise self._over()
            before = core.step_count
            self._reach(self._next_step_end() if core.is_adaptive else core.time_of_step(before + count))
            line = self._present()
            count -= (core.step_count if line.index == index else line.past[-1].steps) - before

    def _next_step_end(self) -> float:
        """Time at the end of the next step of a method that chooses its steps, or of the stage before it [s]."""
        core, end, check = self._core, self.stage_end, self._stage_end
        if check is None:
            return next_adaptive(core, end)
        check.look_ahead(min(end, math.nextafter(step_end(core), math.inf)), None)
        return check.ahead

    def _over(self) -> InputError:
        return InputError(
            f"the last stage, {self.stage_name!r}, has ended at {self.time:.6g} s; to go on, make it longer, or "
            "continue under another scene: Simulation(other, start=this)"
        )

    def _wholly(self, change: Callable[[], None]) -> None:
        """Make a change, or none of it where it fails or is interrupted: then a run goes on as if nothing had been."""
        before = dict(self.__dict__)
        try:
            change()
        except BaseException:
            object.__setattr__(self, "__dict__", before)
            raise

    def _end_stage(self, ended_by: str) -> None:
        """End the present stage, and begin the next one. All that it changes is made anew: see `_wholly`."""
        line, core = self._present(), self._core
        if line.is_last:
            self._timeline, self._stage_end = replace(line, ended_by=ended_by), None
            return
        before = self.energies()
        record = replace(self._record(), ended_by=ended_by)
        time, hub, rate, positions = core.time, core.hub(), core.hub_rate, core.positions()
        velocities, past = core.velocities(), (core.crease_angles(), core.layer_shapes())
        starts = [*line.starts, core.time]
        index = line.index + 1
        with named(f"stages[{index}]"):
            self._simulate(self.scene.staged(index, starts), *self._method(index))
        self._core.start_from(time, hub, positions, velocities, past)
        if (jump := self._core.hub_rate - rate) != 0.0:  # the nodes keep their velocities in space, v + Omega x r
            velocities[:, :2] += jump * positions[:, 1::-1] * (1.0, -1.0)
            self._core.start_from(time, hub, positions, velocities, past)
        after = self.energies()
        changes = {name: after.get(name, 0.0) - before.get(name, 0.0) for name in before | after}
        changes = {name: joule for name, joule in changes.items() if joule != 0.0}
        self._timeline = replace(line, starts=starts, past=[*line.past, record], changes=changes)
        self._open_check()
        self._core.check(False)  # what a body has swallowed might come out on its other side by the next check

    def _start_from(self, other: Motion) -> None:
        super()._start_from(other)
        line = self._timeline
        if line is not None:
            line.starts = [other.time]
            if other.time != 0.0:
                self._simulate(self.scene.staged(0, line.starts), *self._method(0))
                super()._start_from(other)
            self._open_check()

    def _set_motion(self, positions: Floats, velocities: Floats) -> None:
        if is_measured(self):
            raise InputError("a measure has set the motion; a measure only reads")
        super()._set_motion(positions, velocities)
        if self._timeline is not None:
            line = self._timeline
            line.changes = {}
            line.past = [without_energy(record) for record in line.past]
            self._open_check()

    def _open_check(self) -> None:
        """Begin to follow the measures that may end something, from now on."""
        watches, self._stage_end = self._watches(), None
        if watches:
            self._stage_end = StageEnd(self, self.stage_end, watches)
            self._stage_end.open()

    def _reopen_check(self) -> None:
        """The same after the core was set back."""
        self._open_check()

    def _watches(self) -> list[Watch]:
        """The measure that may end the present stage, from now on."""
        line = self._timeline
        if line is None or line.stage.measure is None or line.ended_by is not None:
            return []
        return [Watch.of_stage(line.stage, self._follower().at_check(self))]

    def _follower(self) -> Follower:
        line = self._present()
        measure = line.stage.measure
        words = function_words(measure) if callable(measure) else repr(measure)
        return Follower(line.stage, f"stages[{line.index}].measure = {words}", self)


@contextmanager
def named(where: str) -> Iterator[None]:
    """Name the stage in an error of its scene."""
    try:
        yield
    except InputError as error:
        raise type(error)(f"{where}: {error}") from None
