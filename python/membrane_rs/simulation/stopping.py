"""The end of a run by a measure of its own, beside those of its stages, and found as theirs are."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from membrane_rs._messages import function_words, in_one_line
from membrane_rs._validation import build, nearest, number_of, show
from membrane_rs._warning import warn
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.scene.run_settings import LONGEST
from membrane_rs.scene.stage import Stage
from membrane_rs.simulation.measures import Follower
from membrane_rs.simulation.motion import Motion
from membrane_rs.simulation.stage_end import StageEnd, Watch
from membrane_rs.simulation.stage_state import ResumableMotion

StopWhen = Callable[[Any], float] | Callable[[Any], bool] | Mapping[str, Any] | str
"""A function of the simulation; or a known measure and a value, as of a stage: "deployment_rate > 0.99", or the same as
a table, {"measure": "deployment_rate", "above": 0.99}, or with "below" in place of "above"."""
_KEYS = ("measure", "below", "above")
_SIGNS = {"<": "below", "<=": "below", "below": "below", ">": "above", ">=": "above", "above": "above"}
_CONDITION = re.compile(r"\s*(\w+)\s*(<=?|>=?|\bbelow\b|\babove\b)\s*(\S.*?)\s*")
_EXAMPLE = '"deployment_rate > 0.99"'


class Stop:
    """What may end a run before its time.

    Parameters
    ----------
    given : callable, str or Mapping
        A function of the simulation that gives a number, which ends the run as it passes zero in either direction, or a
        truth value, which ends it as it becomes true; or the measure of a stage, with the value that it passes.

    Raises
    ------
    InputError, InputTypeError
        Something else; a measure that is not there, without a value or with two.
    """

    def __init__(self, given: StopWhen) -> None:
        self._function: _Signed | None = None
        if isinstance(given, Mapping | str):
            self._stage = _stage(_condition(given) if isinstance(given, str) else given)
        elif callable(given):
            self._function = _Signed(given)
            self._stage = Stage("run", LONGEST, self._function, above=0.0)
        else:
            what = f"must be a function of the simulation, or a known measure and its value, such as {_EXAMPLE}"
            raise InputTypeError(f"stop_when = {show(given)}: {what}")

    @property
    def table(self) -> str | dict[str, Any]:
        """What a file says of it: of a function its name alone."""
        stage = self._stage
        if self._function is not None:
            return stage.measure_name
        known = {"measure": stage.measure_name, "below": stage.below, "above": stage.above}
        return {name: value for name, value in known.items() if value is not None}

    @property
    def is_number(self) -> bool:
        """Whether it is a function that has given a number, not a truth value."""
        return self._function is not None and self._function.is_truth is False

    @property
    def described(self) -> str:
        """It in words, such as "deployment_rate above 0.99"."""
        stage = self._stage
        if self._function is not None:
            return self._function.words
        return f"{stage.measure_name} {'above' if stage.below is None else 'below'} {stage.level:.6g}"

    def watch(self, sim: Motion, follower: Follower | None = None) -> Watch:
        """It as it is now, evaluated once."""
        where = f"stop_when = {self.described}"
        follower = follower or Follower(self._stage, where, sim, "it ends the run").at_check(sim)
        follower.excess(sim)
        if self._function is None:
            return replace(Watch.of_stage(self._stage, follower), ends_run=True)
        return Watch(follower, (-1,) if self._function.is_truth else (-1, 1), ends_run=True)


def _condition(text: str) -> dict[str, Any]:
    """The table of a text such as "kinetic_energy < 0.1 uJ". Raises InputError."""
    found = _CONDITION.fullmatch(text)
    if found is None:
        what = f"must be a measure, < or >, and the value that it passes, such as {_EXAMPLE}"
        raise InputError(f"stop_when = {show(text)}: {what}")
    measure, sign, value = found.groups()
    with suppress(ValueError):
        return {"measure": measure, _SIGNS[sign]: float(value)}
    return {"measure": measure, _SIGNS[sign]: value}


def _stage(given: Mapping[str, Any]) -> Stage:
    """A stage with the measure and the value of a table."""
    for key in given:
        if key not in _KEYS:
            raise InputError(f"stop_when: {show(key)}: no such key; {nearest(str(key), _KEYS)}")
    if "measure" not in given:
        raise InputError(f"stop_when: lacks the measure; give it with its value, such as {_EXAMPLE}")
    if not isinstance(given["measure"], str):
        raise InputTypeError(f"stop_when.measure = {show(given['measure'])}: must be a name; give a function by itself")
    try:
        return build(Stage, {"name": "run", "duration": LONGEST, **given}, "stop_when")
    except InputError as error:
        raise type(error)(str(error).replace("Stage.", "stop_when.")) from None


class _Signed:
    """A function of a user as a measure that passes zero: 1 for a truth value that holds, else -1."""

    def __init__(self, function: Callable[[Any], object]) -> None:
        self._function = function
        self.is_truth: bool | None = None
        self.__qualname__ = getattr(function, "__qualname__", type(function).__name__)
        self.words = function_words(function)

    def __call__(self, sim: Motion) -> object:
        where = f"stop_when = {self.words} at t = {sim.time:.6g} s"
        try:
            value = self._function(sim)
        except InputError as error:
            raise InputError(f"{where}: {error}") from error
        except Exception as error:
            raise InputError(f"{where}: raised {in_one_line(error)}; mend the function") from error
        if isinstance(value, np.ndarray) and not value.ndim and not isinstance(value, np.ma.MaskedArray):
            value = value[()]
        if value is None or isinstance(value, np.ndarray):
            raise InputTypeError(f"{where}: gave {show(value)}; must give one number, or true or false")
        is_truth = isinstance(value, bool | np.bool_)
        if self.is_truth is not None and is_truth != self.is_truth:
            kinds = ("a number", "a truth value")[:: 1 if is_truth else -1]
            raise InputTypeError(f"{where}: gave {kinds[1]}, and {kinds[0]} before; must give the same kind always")
        self.is_truth = is_truth
        return (1.0 if value else -1.0) if is_truth else value


class StoppableMotion(ResumableMotion):
    """A motion whose run a measure may end before its time."""

    _stop: Stop | None = None
    _stopped_by: str | None = None

    @property
    def stopped_by(self) -> str | None:
        """What ended the last run before its time, such as "deployment_rate above 0.99"; None where nothing did."""
        return self._stopped_by

    @property
    def is_stopped(self) -> bool:
        """Whether `stop_when` has ended the run that is going on."""
        return self._stop is not None and self._stopped_by is not None

    def _begin_stop(self, stop: Stop | None) -> None:
        """Look for what may end a run, from now on; where that was done already, go on with it."""
        self._stopped_by = None
        if stop is self._stop:
            return
        self._end_stop()
        self._stop = stop
        if stop is None or self.is_over:
            return
        check = self._stage_end
        kept = [] if check is None else [replace(w, follower=w.follower.at_check(self)) for w in check.watches]
        self._stage_end = StageEnd(self, self.stage_end, [*kept, stop.watch(self)])
        self._stage_end.open()
        if self._stage_end.watches[-1].side == 0:
            what = "is met already, and so ends the run only when it is met anew"
            if stop.is_number:
                what = "is 0 already, and so ends the run only as it passes 0 later; a condition gives true or false"
            warn(f"stop_when = {stop.described} at t = {self.time:.6g} s: {what}")

    def _end_stop(self) -> None:
        """Look for it no more."""
        if self._stop is not None and self._stage_end is not None:
            self._stage_end = self._stage_end.without_run()
        self._stop = None

    def _watches(self) -> list[Watch]:
        """What may end the present stage and what may end the run, which goes on from stage to stage."""
        found, stop, check = super()._watches(), self._stop, self._stage_end
        if stop is None or self.is_stopped or self.is_over:
            return found
        before = None if check is None else next((watch for watch in check.watches if watch.ends_run), None)
        if before is None:
            return [*found, stop.watch(self)]
        return [*found, replace(before, follower=before.follower.at_check(self))]

    def _reopen_check(self) -> None:
        self._stop = None  # the run has ended, and its function is not to raise in its place
        super()._reopen_check()

    def _pass(self, passed: Watch) -> None:
        if passed.ends_run:
            self._stopped_by = self._stop.described if self._stop is not None else None
        else:
            super()._pass(passed)

    def _end_stage(self, ended_by: str) -> None:
        super()._end_stage(ended_by)
        check = self._stage_end
        if check is not None and check.passed is not None and check.passed.ends_run and check.event == self.time:
            self._pass(check.passed)  # by what the change of stage has changed

    def _set_motion(self, positions: Any, velocities: Any) -> None:
        super()._set_motion(positions, velocities)
        if self._stop is not None:
            self._stage_end = None
            self._open_check()

    def state(self) -> dict[str, Any]:
        """All that changes while the scene moves, copied, by name: what `set_state` continues from with the same bits.

        Among it "positions" (N, 3) [m], "velocities" (N, 3) [m/s], and "history_vectors" (k N, 3), what the method
        keeps from step to step, if it keeps anything. They are those at the end of the last step; "output_time" [s] is
        there where the time now is another. "scene_digest" tells the scene from others; "integrator", "dt" [s] and
        "is_adaptive" say how it is stepped. With stages also how far the run has come in them ("stage_index", ...). In
        a stage, or in a run, that a measure may end, the motion is that at its last evaluation, from which `set_state`
        steps to "stage_now" [s] or "stop_now" [s].

        Returns
        -------
        dict of str to object
            Copies.
        """
        found, check = super().state(), self._stage_end
        watch = None if check is None else next((watch for watch in check.watches if watch.ends_run), None)
        if watch is not None:
            found |= {"stop_now": self.time, "stop_side": watch.side}
            if watch.follower.turned is not None:
                found["stop_turned"] = watch.follower.turned
        return found

    def _time_of_check(self, own: dict[str, Any]) -> float | None:
        now = super()._time_of_check(own)
        if now is not None or "stop_now" not in own:
            return now
        return number_of("saved state: stop_now", own["stop_now"])

    def _resumed_watches(self, own: dict[str, Any]) -> list[Watch]:
        found, stop, side = super()._resumed_watches(own), self._stop, own.get("stop_side", 0)
        if not isinstance(side, int) or side not in (-1, 0, 1):
            raise InputTypeError(f"saved state: stop_side = {show(side)}: must be -1, 0 or 1")
        if stop is None or "stop_now" not in own:
            return found
        watch = stop.watch(self)
        watch.follower.resume(self, own.get("stop_turned"))
        return [*found, replace(watch, side=side)]
