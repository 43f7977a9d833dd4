"""Runs a scene: the core steps, observers look on."""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np

from membrane_rs import _core
from membrane_rs._validation import number_of, show
from membrane_rs.errors import InputError, InputTypeError, UnstableError
from membrane_rs.motion import Motion
from membrane_rs.run_settings import MOST_INSTANTS
from membrane_rs.saved_state import read_state, write_state

if TYPE_CHECKING:
    from membrane_rs.output import RunFolder

MOST_STEPS = 10**15
"""More steps than this are a slip of the pen: they would take centuries."""
PROGRESS_LOOKS = 500
"""How often a run that is followed tells its progress, beside every sample."""


@dataclass(frozen=True)
class IntegratorFacts:
    """What is known of a method of time integration.

    order : of the error after a given time. evaluations : of the forces per step. evaluations_at_start : before the
    first step. keeps_energy : whether the energy of an undamped motion stays bounded, however long it lasts.
    is_adaptive : whether it chooses its own step where none is given. imaginary_limit : largest stable
    omega dt of an undamped oscillation. real_limit : largest stable rate times dt of a pure decay.
    """

    order: int
    evaluations: int
    evaluations_at_start: int
    keeps_energy: bool
    is_adaptive: bool
    imaginary_limit: float
    real_limit: float


def integrators() -> dict[str, IntegratorFacts]:
    """What is known of each method, by name."""
    return {facts[0]: IntegratorFacts(*facts[1:]) for facts in _core.integrators()}


class Observer(Protocol):
    """Looks on while a scene runs."""

    def start(self, sim: Simulation) -> None:
        """Called before the first step."""

    def sample(self, sim: Simulation) -> None:
        """Called at each instant of the history."""

    def frame(self, sim: Simulation) -> None:
        """Called at each instant at which a shape is kept; each is also a sample."""

    def finish(self, sim: Simulation, error: BaseException | None) -> None:
        """Called at the end, whatever ended the run."""


class Simulation(Motion):
    """A scene that moves. Arrays are in the order of the scene: the mesh's nodes, then those of the cords.

    Positions are [m] in the frame that turns with the hub, and velocities [m/s] are relative to it.

    Parameters
    ----------
    scene : Scene
        What is simulated.
    integrator : str, optional
        Name of the method. Default: the scene's own, which is "rk4" unless it says otherwise.
    dt : float, optional
        Step [s]. Default: the scene's own; without one, "dopri5" chooses each step so that its error stays below
        the scene's tolerance; "generalized_alpha", which has no limit, takes 50 times 2/omega of the highest frequency;
        other methods take 0.4 of the stability limit. All take a little less so that a whole number of steps, and
        at least one, lies between two samples of the scene's history.

    Raises
    ------
    MeshError
        A triangle without area, negative spring constants, a crease that is no hinge.
    InputError
        dt not above zero or far beyond the limit, an integrator that does not exist, a node without mass.
    """

    def step(self, n: int = 1) -> None:
        """Take `n` steps; where `is_adaptive`, `n` accepted ones from the end of the last.

        Raises
        ------
        UnstableError
            The run went wrong; the state is then that of the last check that found nothing.
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

    def settle(self, duration: float | None = None, rate: float | None = None) -> float:
        """Damp the scene to rest where its guide bars hold it, and start from there with the clock at zero.

        Nodes of the set "guide_bars" (none without that set) are held, and friction F = -rate m v is added, for
        `duration` of simulated time; then the nodes are let go, at rest. Returns the largest
        speed left before that [m/s].

        Raises
        ------
        InputError
            After the first step, or with a duration or rate that is not above zero.
        """
        from membrane_rs.settling import settled

        if self.step_count:
            raise InputError(
                f"settle at t = {self.time:.6g} s: it must come before the first step; build a new Simulation"
            )
        duration = None if duration is None else number_of("settle: duration", duration)
        rate = None if rate is None else number_of("settle: rate", rate, "1/s")
        positions, speed = settled(self.scene, self.integrator, self.positions, duration, rate)
        self._set_motion(positions, np.zeros_like(positions))
        self.is_settled = True
        return speed

    def run(
        self,
        until: float | None = None,
        frames: int | Sequence[float] | None = None,
        out: str | Path | None = None,
        *,
        samples: int | None = None,
        observers: Sequence[Observer] = (),
        progress: Callable[[Simulation], None] | None = None,
        overwrite: bool = False,
        pictures: bool = True,
    ) -> RunFolder | None:
        """Step to `until`, and let observers look on at frames and samples.

        Parameters
        ----------
        until : float, optional
            Time at the end [s]. Default: the scene's.
        frames : int or sequence of float, optional
            How many shapes to keep, evenly spaced from time 0 to the end, or their times [s]. Default: the scene's.
        out : path, optional
            Folder of the results; see `membrane_rs.output.RunFolder`. Default: nothing is written.
        samples : int, optional
            Rows of the history, evenly spaced. Default: the scene's.
        observers : sequence of observers, optional
            Others that look on.
        progress : callable, optional
            Called with this simulation now and then.
        overwrite, pictures : bool
            For the folder: replace an earlier run; draw pictures at the end.

        Returns
        -------
        RunFolder or None
            The folder, where `out` was given.

        Raises
        ------
        UnstableError
            The run stopped itself. What was written stays, with the last good frame.
        KeyboardInterrupt
            Ctrl-C. What was written stays; the simulation can go on.
        OutputError
            Results cannot be written.
        """
        end = number_of("until", self.scene.run.until if until is None else until)
        if end < self.time:
            raise InputError(f"until = {end} s: the simulation is at {self.time:.6g} s already; give a later time")
        folder = None
        if out is not None:
            # Output looks on from above; it is named here only because a run may ask for it.
            from membrane_rs.output import RunFolder

            folder = RunFolder(out, overwrite, pictures=pictures)
        watchers: list[Observer] = [*observers, *([folder] if folder is not None else [])]
        if self.scene.run.settle > 0 and not self.is_settled and self.step_count == 0:
            self.settle()
        frame_marks = self._marks_of(self.scene.run.frames if frames is None else frames, end, "frames")
        shots = [time for time in self.scene.run.snapshots if time <= end]
        marks = frame_marks | self._marks_of(shots, end, "snapshots")
        marks |= self._marks_of(self.scene.run.samples if samples is None else samples, end, "samples")
        looks = np.linspace(min(marks), max(marks), PROGRESS_LOOKS if progress else 0)
        whole = float if self.is_adaptive else int
        started: list[Observer] = []
        error: BaseException | None = None
        try:
            for watcher in watchers:
                watcher.start(self)
                started.append(watcher)
            for mark in sorted(marks.union(map(whole, looks))):
                self._reach(mark)
                if mark in marks:
                    self._core.check()
                    self._show(watchers, is_frame=mark in frame_marks)
                if progress is not None:
                    progress(self)
        except BaseException as caught:
            error = caught
            if isinstance(caught, UnstableError):
                self._show(watchers, is_frame=True)  # the last good state
            raise
        finally:
            # All finish, in their order, whatever one of them raises.
            with ExitStack() as ending:
                for watcher in reversed(started):
                    ending.callback(watcher.finish, self, error)
        return folder

    def _show(self, watchers: Sequence[Observer], *, is_frame: bool) -> None:
        for watcher in watchers:
            watcher.sample(self)
            if is_frame:
                watcher.frame(self)

    def _reach(self, mark: float) -> None:
        """Go to a time [s] where steps are chosen, and else to a step count."""
        if self.is_adaptive:
            self._core.reach(mark)
        else:
            self._core.step(int(mark) - self.step_count)

    def _marks_of(self, wanted: int | Sequence[float], end: float, name: str) -> set[float]:
        """Marks for `_reach`: the wanted instants that are not past, or the step counts nearest to them; now and the
        end are among them.
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
            # Twelve digits, so that a frame and a sample of the same instant are one mark.
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
            "is_settled": self.is_settled,
            **self.state(),
        }
        write_state(Path(path), self.scene, state)

    @classmethod
    def restore(cls, path: str | Path) -> Simulation:
        """The simulation that `save` wrote.

        Raises
        ------
        MissingFileError
            No such file.
        InputError
            Not a saved state, or damaged.
        """
        scene, state = read_state(Path(path))
        try:
            dt, is_adaptive = state.pop("dt"), state.pop("is_adaptive")
            if not isinstance(is_adaptive, bool):
                raise ValueError("is_adaptive is not true or false")
            sim = cls(scene, str(state.pop("integrator")), None if is_adaptive else dt)
            if is_adaptive:
                sim._core.set_dt(number_of("dt", dt))
            sim.is_settled = bool(state.pop("is_settled"))
            sim.set_state(state)
        except ValueError as error:
            raise InputError(
                f"{path}: is a damaged saved state ({error}); give one that Simulation.save wrote"
            ) from None
        return sim
