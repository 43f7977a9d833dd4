"""The state of a scene with stages: what is saved of it, and how a motion goes on from that."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from typing_extensions import override

from membrane_rs._validation import number_of, show
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.simulation.measures import is_measured
from membrane_rs.simulation.stage_end import StageEnd, Watch
from membrane_rs.simulation.stages import StagedMotion, named
from membrane_rs.simulation.timeline import ENTRIES, OF_STOP


class ResumableMotion(StagedMotion):
    """A motion through stages that goes on from a state with the same bits."""

    @override
    def state(self) -> dict[str, Any]:
        found = super().state()
        line, check = self._timeline, self._stage_end
        if check is not None:
            for name in self._core.progress():
                del found[name]
            found |= check.state
        if line is None:
            return found
        watch = next((watch for watch in check.watches if not watch.ends_run), None) if check is not None else None
        if watch is not None:
            found |= {"stage_now": self.time, "stage_is_armed": abs(watch.side)}
            if watch.follower.turned is not None:
                found["stage_turned"] = watch.follower.turned
        integrator, dt = self._given
        given = {"stage_method": integrator or "", "stage_given_dt": dt or 0.0}
        return {**found, **line.saved(), **given}

    @override
    def set_state(self, state: dict[str, Any]) -> None:
        if is_measured(self):
            raise InputError("a measure has set the motion; a measure only reads")
        entries = OF_STOP if self._timeline is None else (*ENTRIES, *OF_STOP)
        own = {name: value for name, value in state.items() if name in entries} if isinstance(state, dict) else {}
        if self._timeline is None and not own:
            super().set_state(state)
            self._stage_end = None
            return
        plain = {name: value for name, value in state.items() if name not in own}
        before = self._core.progress()
        try:
            self._wholly(lambda: self._set_state(own, plain))
        except BaseException:
            self._core.resume(before)
            raise

    def _set_state(self, own: dict[str, Any], plain: dict[str, Any]) -> None:
        if self._timeline is None:
            super().set_state(plain)
            self._stage_end = None
            self._resume_check(own)
            return
        index = own.get("stage_index")
        methods = [self._method(k)[0] or self.scene.staged(k).run.integrator for k in range(len(self.scene.stages))]
        is_older = "motor_numbers" not in plain
        line = self._timeline = self._present().loaded(own, methods, is_older=is_older)
        integrator, dt = self._method(line.index)
        scene = self.scene.staged(line.index, line.starts)
        saved = plain.get("dt")
        is_free = dt is None and scene.run.dt is None and plain.get("is_adaptive") is False and saved is not None
        with named(f"stages[{index}]"):
            self._simulate(scene, integrator, number_of("saved state: dt", saved) if is_free else dt)
            self._given_dt = None if is_free else self._given_dt
        self._stage_end = None
        super().set_state(plain)
        if not line.starts[-1] - 1e-12 * abs(self.time) <= self.time <= line.end:
            raise InputError(
                f"saved state: it is at {self.time:.6g} s, which is not in {line.stage.name!r}, from "
                f"{line.starts[-1]:.6g} to {line.end:.6g} s; it is damaged: give one that a simulation gave"
            )
        if line.ended_by is None:
            self._resume_check(own)

    def _resume_check(self, own: dict[str, Any]) -> None:
        """Follow the measures on from their last evaluation, at which the motion is; go to the time of the state."""
        now = self._time_of_check(own)
        if now is None:
            return
        if not self.time <= now <= self.stage_end:
            what = f"must be from {self.time:.6g} to {self.stage_end:.6g} s"
            raise InputError(f"saved state: {'stage_now' if 'stage_now' in own else 'stop_now'} = {now:.6g} s: {what}")
        watches = self._resumed_watches(own)
        check = StageEnd(self, self.stage_end, watches)
        if self._timeline is None and now > check.next_time():
            raise InputError(
                f"saved state: stop_now = {now:.6g} s: must be from {self.time:.6g} to {check.next_time():.6g} s"
            )
        self._stage_end = check if watches else None
        if now > self.time:
            self._reach(now)
            if self.time != now:
                raise InputError("saved state: its stage has ended before stage_now; it is damaged")

    def _time_of_check(self, own: dict[str, Any]) -> float | None:
        """The time of a state whose motion is that at the last evaluation of a measure [s]; None for any other."""
        line = self._timeline
        if line is None or (line.stage.measure is None and "stage_now" not in own):
            return None
        return number_of("saved state: stage_now", own.get("stage_now"))

    def _resumed_watches(self, own: dict[str, Any]) -> list[Watch]:
        """The measure that may end the present stage, as it was at its last evaluation, now."""
        line = self._timeline
        if line is None or "stage_now" not in own:
            return []
        is_armed = own.get("stage_is_armed")
        if not isinstance(is_armed, int) or is_armed not in (0, 1):
            raise InputTypeError(f"saved state: stage_is_armed = {show(is_armed)}: must be 0 or 1")
        if line.stage.measure is None:  # it was a function, and its file is read for the motion alone
            return []
        follower = self._follower()
        follower.resume(self, own.get("stage_turned"))
        watch = Watch.of_stage(line.stage, follower)
        return [replace(watch, side=watch.sides[0] * is_armed)]
