"""Steps of a scene in motion: single ones, a run with outputs for observers, saved states."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from typing_extensions import Self

from membrane_rs._files import path_of
from membrane_rs._validation import number_of, show
from membrane_rs._warning import warn
from membrane_rs.errors import InputError, InputTypeError, UnstableError
from membrane_rs.scene import Scene
from membrane_rs.simulation.checkpoint import STATE, StateFile, read_state
from membrane_rs.simulation.continuation import unknown_entries
from membrane_rs.simulation.measures import is_measured
from membrane_rs.simulation.motion import Motion
from membrane_rs.simulation.observer import Observer
from membrane_rs.simulation.output_times import is_same_time, output_times
from membrane_rs.simulation.shown import ShownMotion
from membrane_rs.simulation.stopping import Stop
from membrane_rs.simulation.timeline import ENTRIES, OF_STOP

MOST_STEPS = 10**15
"""More steps than this are taken as an input error: they would take centuries."""
CHUNK = 0.1
"""Wall time after which a run on its way to the next output calls what watches it [s]."""


class Stepper(ShownMotion):
    """A scene in motion that steps; writes nothing but its own state. Its parameters and errors are those of
    `Simulation`, which adds what a run needs before and beside its steps.

    Parameters
    ----------
    scene : Scene
        What moves.
    integrator : str, optional
        Name of the method.
    dt : float, optional
        Step [s].
    start : Motion or path, optional
        Whose motion it goes on from.

    Raises
    ------
    InputError, InputTypeError, MeshError
        As `Simulation`.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> from membrane_rs.simulation import Stepper
    >>> Stepper(scenes.load("spinning-tether")).time
    0.0
    """

    def __init__(
        self,
        scene: Scene,
        integrator: str | None = None,
        dt: float | None = None,
        *,
        start: Motion | str | Path | None = None,
    ) -> None:
        other = Stepper._of_file(start, motion_alone=True) if isinstance(start, str | Path) else start
        super().__init__(scene, integrator, dt, start=other)

    until: float | None = None
    """Time at the end of the present or the last run [s]; None before one."""

    def step(self, n: int = 1) -> None:
        """Take `n` steps; where `is_adaptive`, `n` accepted ones from the end of the last. With stages, through their
        ends; the rest of a step up to one is not counted.

        Parameters
        ----------
        n : int
            Steps.

        Raises
        ------
        InputError
            The last stage ended before; a number below 0.
        InputTypeError
            No whole number.
        UnstableError
            The run became unstable; the state is then that of the last check without a fault.
        KeyboardInterrupt
            Ctrl-C, between two steps.
        """
        try:
            count = operator.index(n)
        except TypeError:
            raise InputTypeError(f"n = {show(n)}: must be a whole number of steps") from None
        if not 0 <= count <= MOST_STEPS:
            raise InputError(f"n = {show(count)}: must be a whole number of steps, from 0 to {MOST_STEPS:.0e}")
        if is_measured(self):
            raise InputError("a measure has stepped the simulation; a measure only reads")
        if self._timeline is None:
            self._core.step(count)
        else:
            self._step(count)

    def march(
        self,
        end: float,
        frames: int | Sequence[float],
        samples: int | Sequence[float],
        observers: Sequence[Observer[Self]],
        progress: Callable[[Self], None] | None = None,
        *,
        between: Callable[[Self], None] | None = None,
        snapshots: Sequence[float] | None = None,
    ) -> None:
        """Step to `end` [s]; call the observers at frames, samples and the scene's snapshots.

        Parameters
        ----------
        end : float
            Time at the end [s], not before now.
        frames, samples : int or sequence of float
            How many, evenly spaced from time 0 to the end, or their times [s].
        observers : sequence of observers
            All finish, in their order, whatever one of them raises.
        progress : callable, optional
            Called with this stepper at each output, and about every 0.1 s of wall time.
        between : callable, optional
            Called as `progress` is, but for the end: what it reads or saves has no effect on the motion.
        snapshots : sequence of float, optional
            Further times [s] that are samples. Default: those of the scene.

        Raises
        ------
        InputError
            More steps to the end than `MOST_STEPS`; an observer that steps.
        UnstableError
            The motion became unstable; observers have seen the last state without a fault.

        Examples
        --------
        >>> from membrane_rs import Simulation, scenes
        >>> from membrane_rs.results import CrossingCounts
        >>> counts, sim = CrossingCounts(), Simulation(scenes.load("hanging-strip"))
        >>> sim.march(0.01, frames=2, samples=[0.0, 0.005, 0.01], observers=[counts])
        >>> counts.table()["time"].tolist()
        [0.0, 0.01]
        """
        end = number_of("end", end)
        self._check_end(end)
        wanted = (end, frames, samples, self.scene.run.snapshots if snapshots is None else snapshots)
        self._outputs(*wanted)  # refused before an observer has started
        self.until = end
        watchers = [watcher for watcher in (progress, between) if watcher is not None]
        started: list[Observer[Self]] = []
        error: BaseException | None = None
        try:
            for observer in observers:
                observer.start(self)
                started.append(observer)
            for time, is_frame in self._outputs_by_stage(*wanted):
                if self._leads(time, end, watchers, progress, observers, is_frame=is_frame):
                    break
        except BaseException as caught:
            error = caught
            if isinstance(caught, UnstableError):
                self._show(observers, is_frame=True)  # the last good state
            raise
        finally:
            # All finish, in their order, whatever one of them raises.
            with ExitStack() as ending:
                for observer in reversed(started):
                    ending.callback(observer.finish, self, error)

    def _outputs(
        self, end: float, frames: int | Sequence[float], samples: int | Sequence[float], snapshots: Sequence[float]
    ) -> list[tuple[float, bool]]:
        """Times [s] from now to `end`, and whether each is that of a frame, as far as they are known now."""
        starts = [record.start for record in self.stages]
        stages = self.scene.stages
        times = output_times(self.time, end, frames, samples, snapshots, stages=stages, starts=starts)
        # Of times that are one, that of the boundary is shown, and was.
        return [(time, flag) for time, flag in times if time == self.time or not is_same_time(time, self.time)]

    def _outputs_by_stage(
        self, end: float, frames: int | Sequence[float], samples: int | Sequence[float], snapshots: Sequence[float]
    ) -> Iterator[tuple[float, bool]]:
        """The same one by one, with those of a stage once it has begun: when that is, a measure may say."""
        times = self._outputs(end, frames, samples, snapshots)
        while times:
            stage = self.stage
            for time in times:
                yield time
                if self.stage != stage:
                    break
            else:
                return
            times = [time for time in self._outputs(end, frames, samples, snapshots) if time[0] > self.time]

    def _leads(
        self,
        time: float,
        end: float,
        watchers: Sequence[Callable[[Self], None]],
        progress: Callable[[Self], None] | None,
        observers: Sequence[Observer[Self]],
        *,
        is_frame: bool,
    ) -> bool:
        """Step to the next output, or to a boundary of stages before it, and show that; whether it is the last."""
        if is_same_time(time, self.stage_end):
            time = self.stage_end
        self._refuse_past(time)
        is_boundary = self._advance(time, watchers)
        is_end = self.time >= end or self.is_over or self.is_stopped
        self._core.check(is_end)
        self._show(observers, is_frame=is_frame or is_boundary or self.is_stopped)
        for watcher in watchers if not is_end else watchers[: progress is not None]:
            watcher(self)
        return is_end

    def _show(self, observers: Sequence[Observer[Self]], *, is_frame: bool) -> None:
        for observer in observers:
            observer.sample(self)
            if is_frame:
                observer.frame(self)

    def reach(self, time: float) -> None:
        """Step to a time [s] not before now, and show the state there.

        A time between two steps is reached by a side step from the last one, or by interpolation where `is_adaptive`;
        the next step continues from the last one, so that such times have no effect on the motion.

        Parameters
        ----------
        time : float
            [s]

        Raises
        ------
        InputError, InputTypeError
            No number, a time before now, or more than `MOST_STEPS` steps ahead.
        UnstableError, KeyboardInterrupt
            As `step`.
        """
        target = number_of("time", time)
        self._check_end(target, "time")
        while self._advance(target, ()) and not self._is_at(target):
            pass

    def reach_within(self, time: float, seconds: float) -> bool:
        """As `reach`, for about `seconds` of wall time; whether the time was reached.

        Parameters
        ----------
        time : float
            [s]
        seconds : float
            Of wall time [s]; infinity for no limit.

        Returns
        -------
        bool
            Whether the time was reached.

        Raises
        ------
        InputError, InputTypeError
            No number.
        UnstableError, KeyboardInterrupt
            As `step`.
        """
        time = number_of("time", time)
        seconds = math.inf if seconds == math.inf else number_of("seconds", seconds)
        return seconds > 0.0 and self._reach(time, seconds) and self._is_at(time)

    def _is_at(self, time: float) -> bool:
        """Whether a time [s] is reached: at the end of the last stage, also one that is the same."""
        return self.time >= time or (self.is_over and is_same_time(time, self.time))

    def _advance(self, time: float, watchers: Sequence[Callable[[Self], None]]) -> bool:
        """Step to a time [s], or to the end of the present stage before it; whether a stage has ended."""
        before = self.stage, self.is_over
        while not self._reach(time, CHUNK):
            for watcher in watchers:
                watcher(self)
        return before != (self.stage, self.is_over)

    def _check_end(self, end: float, name: str = "until") -> None:
        ahead = (end - self.time) / self.dt
        if ahead > MOST_STEPS and not self.is_adaptive:
            raise InputError(
                f"{name} = {end} s: that is {ahead:.1e} steps of dt = {self.dt:.3g} s; give an earlier time"
            )

    def _refuse_past(self, time: float) -> None:
        if time < self.time:
            raise InputError(
                f"an observer has stepped to t = {self.time:.6g} s, past the next output at {time:.6g} s; an observer "
                "only reads: step after the run"
            )

    def save(self, path: str | Path) -> None:
        """Write scene and state into one file (.npz), from which `restore` continues with the same bits.

        Parameters
        ----------
        path : path
            Of the file, which ends in .npz.

        Raises
        ------
        InputError, InputTypeError
            No path of a file that ends in .npz.
        OutputError
            It cannot be written.
        """
        StateFile(self.scene).write(path_of(path), self.saved_state())

    def saved_state(self) -> dict[str, Any]:
        """All that `save` writes beside the scene, copied: the simulation may go on while it is written.

        Returns
        -------
        dict of str to object
            Copies, by the names of the file's entries.
        """
        return {"is_relaxed": self.is_relaxed, **self.state()}

    @classmethod
    def _with_method_of(cls, scene: Scene, state: dict[str, Any]) -> Self:
        """A simulation with the method and the step of a saved state; without stages they are then not in it."""
        if scene.stages:
            dt = number_of("stage_given_dt", state.get("stage_given_dt"))
            return cls(scene, str(state.get("stage_method")) or None, dt or None)
        dt, is_adaptive = state.pop("dt"), state.pop("is_adaptive")
        if not isinstance(is_adaptive, bool):
            raise ValueError("is_adaptive is not true or false")
        sim = cls(scene, str(state.pop("integrator")), None if is_adaptive else dt)
        sim._given_dt = scene.run.dt  # a file does not say whether its step was given otherwise
        if is_adaptive:
            sim._core.set_dt(number_of("dt", dt))
        return sim

    @classmethod
    def restore(cls, path: str | Path) -> Self:
        """The simulation that `save` wrote.

        Parameters
        ----------
        path : path
            Of the file, or the folder of a run, whose last checkpoint is taken.

        Returns
        -------
        Simulation
            Where it was.

        Raises
        ------
        MissingFileError
            No such file.
        InputError
            Not a saved state, or damaged.

        Warns
        -----
        UserWarning
            An entry that this version does not know, and ignores.
        """
        return cls._of_file(path)

    @classmethod
    def _of_file(cls, path: str | Path, *, motion_alone: bool = False, stop: Stop | None = None) -> Self:
        """The same; for its motion alone, without measures that were functions; with what may end its run."""
        path = path_of(path)
        with suppress(OSError):  # a name that is too long is refused where it is read
            path = path / STATE if path.is_dir() else path
        scene, state = read_state(path, motion_alone=motion_alone)
        try:
            sim = cls._with_method_of(scene, state)
            sim.is_relaxed = bool(state.pop("is_relaxed"))
            own = (*(ENTRIES if scene.stages else ()), *OF_STOP)
            for name, words in unknown_entries([name for name in state if name not in own], sim.law_names).items():
                warn(f"{path}: {name} is ignored: {words}")
                del state[str(name)]
            sim._stop = stop
            sim.set_state(state)
        except ValueError as error:
            raise InputError(
                f"{path}: is a damaged saved state ({error}); give one that Simulation.save wrote"
            ) from None
        return sim
