"""Steps of a scene in motion: single ones, a run with outputs for observers, saved states."""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np
from typing_extensions import Self

from membrane_rs._files import path_of
from membrane_rs._validation import number_of, show
from membrane_rs.errors import InputError, InputTypeError, UnstableError
from membrane_rs.scene.run_settings import MOST_INSTANTS
from membrane_rs.simulation.checkpoint import read_state, write_state
from membrane_rs.simulation.motion import Motion
from membrane_rs.simulation.observer import Observer

MOST_STEPS = 10**15
"""More steps than this are taken as an input error: they would take centuries."""
PROGRESS_CALLS = 500
"""Calls of `progress` in a run, beside those at its samples."""


class Stepper(Motion):
    """A scene in motion that steps; writes nothing but its own state. Its parameters and errors are those of
    `Simulation`, which adds what a run needs before and beside its steps.
    """

    def step(self, n: int = 1) -> None:
        """Take `n` steps; where `is_adaptive`, `n` accepted ones from the end of the last.

        Raises
        ------
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
        self._core.step(count)

    def march(
        self,
        end: float,
        frames: int | Sequence[float],
        samples: int | Sequence[float],
        observers: Sequence[Observer[Self]],
        progress: Callable[[Self], None] | None = None,
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
            Called with this stepper at each output, and at 500 times spread evenly.

        Raises
        ------
        UnstableError
            The motion became unstable; observers have seen the last state without a fault.
        """
        frame_times = self._targets_of(frames, end, "frames")
        snapshot_times = [time for time in self.scene.run.snapshots if time <= end]
        output_times = frame_times | self._targets_of(snapshot_times, end, "snapshots")
        output_times |= self._targets_of(samples, end, "samples")
        progress_times = np.linspace(min(output_times), max(output_times), PROGRESS_CALLS if progress else 0)
        whole = float if self.is_adaptive else int
        started: list[Observer[Self]] = []
        error: BaseException | None = None
        try:
            for observer in observers:
                observer.start(self)
                started.append(observer)
            for target in sorted(output_times.union(map(whole, progress_times))):
                self.reach(target)
                if target in output_times:
                    self._core.check()
                    self._show(observers, is_frame=target in frame_times)
                if progress is not None:
                    progress(self)
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

    def _show(self, observers: Sequence[Observer[Self]], *, is_frame: bool) -> None:
        for observer in observers:
            observer.sample(self)
            if is_frame:
                observer.frame(self)

    def reach(self, target: float) -> None:
        """Go to a time [s] if `is_adaptive`, else to a step count."""
        if self.is_adaptive:
            self._core.reach(target)
        else:
            self._core.step(int(target) - self.step_count)

    def _targets_of(self, wanted: int | Sequence[float], end: float, name: str) -> set[float]:
        """Targets of `reach`: the wanted times not in the past if `is_adaptive`, else the nearest step counts.

        Now and the end are among them.
        """
        ahead = (end - self.time) / self.dt
        if ahead > MOST_STEPS and not self.is_adaptive:
            raise InputError(
                f"until = {end} s: that is {ahead:.1e} steps of dt = {self.dt:.3g} s; give an earlier time"
            )
        if isinstance(wanted, Sequence | np.ndarray) and not isinstance(wanted, str | bytes):
            times = np.asarray([number_of(name, t) for t in wanted], dtype=np.float64)
        else:
            try:
                count = operator.index(wanted)  # type: ignore[arg-type]
            except TypeError:
                raise InputTypeError(
                    f"{name} = {show(wanted)}: must be a whole number or a list of times (s)"
                ) from None
            if not 2 <= count <= MOST_INSTANTS:
                raise InputError(f"{name} = {show(count)}: must be from 2 to {MOST_INSTANTS}, or a list of times (s)")
            times = np.linspace(0.0, end, count)
        if self.is_adaptive:
            # Twelve digits, so that a frame and a sample of the same time are one target.
            later = [float(f"{time:.12g}") for time in times[(times > self.time) & (times < end)]]
            return {self.time, end, *later}
        last = round(ahead)
        steps = np.round(np.clip((times - self.time) / self.dt, -1.0, last + 1.0)).astype(np.int64)
        steps = np.array([0, last, *steps[(steps > 0) & (steps <= last)]]) + self.step_count
        return set(steps.tolist())

    def save(self, path: str | Path) -> None:
        """Write scene and state into one file (.npz), from which `restore` continues with the same bits.

        Raises
        ------
        OutputError
            It cannot be written.
        """
        state = {
            "integrator": self.integrator,
            "dt": self.dt,
            "is_adaptive": self.is_adaptive,
            "is_relaxed": self.is_relaxed,
            **self.state(),
        }
        write_state(path_of(path), self.scene, state)

    @classmethod
    def restore(cls, path: str | Path) -> Self:
        """The simulation that `save` wrote.

        Raises
        ------
        MissingFileError
            No such file.
        InputError
            Not a saved state, or damaged.
        """
        path = path_of(path)
        scene, state = read_state(path)
        try:
            dt, is_adaptive = state.pop("dt"), state.pop("is_adaptive")
            if not isinstance(is_adaptive, bool):
                raise ValueError("is_adaptive is not true or false")
            sim = cls(scene, str(state.pop("integrator")), None if is_adaptive else dt)
            if is_adaptive:
                sim._core.set_dt(number_of("dt", dt))
            sim.is_relaxed = bool(state.pop("is_relaxed"))
            sim.set_state(state)
        except ValueError as error:
            raise InputError(
                f"{path}: is a damaged saved state ({error}); give one that Simulation.save wrote"
            ) from None
        return sim
