"""The run of a scene: relaxed first where it asks for it, stepped to its end, its results written into a folder."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from membrane_rs._renamed import Renamed
from membrane_rs._validation import flags_of, number_of, show
from membrane_rs.check import Audit, audit_of_motion
from membrane_rs.check.bodies import inside_at_stage_start
from membrane_rs.check.scene_audit import warn_of
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.results.body_contacts import BodyContacts
from membrane_rs.results.history_table import HistoryTable
from membrane_rs.results.recorded import Measures, Recorded
from membrane_rs.runs import signals
from membrane_rs.runs.recorder import Recorder
from membrane_rs.runs.request import CHECKPOINT, Request
from membrane_rs.scene import Scene
from membrane_rs.scene.run_settings import check_duration
from membrane_rs.simulation.motion import Motion
from membrane_rs.simulation.observer import Observer
from membrane_rs.simulation.relaxation import relaxed
from membrane_rs.simulation.stepper import Stepper
from membrane_rs.simulation.stopping import Stop, StopWhen

if TYPE_CHECKING:
    from membrane_rs.runs.run_folder import RunFolder


class Simulation(Stepper):
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
        other methods take 0.4 of the stability limit; less where the spin, the loads or the response to them would be
        wrong (docs/model.md). All take a little less so that a whole number of steps makes a power of ten of a second.
        The step depends neither on the end of a run nor on its outputs.
    start : Simulation or path, optional
        Go on from the motion of another simulation, or of a saved state, in a file or in the folder of a run: its
        positions, velocities, time and the angle of its hub, which turns on from there at this scene's rate. The scene
        may have other laws, parameters and parts, but must have the same nodes, triangles and segments of cords. Steps
        are counted from there, and the energy ledger is opened anew. Default: the scene's own start, at time 0.

    Raises
    ------
    MeshError
        A triangle without area, negative spring constants, a crease that is no hinge.
    InputError
        dt not above zero or far beyond the limit, an integrator that does not exist, a node without mass, a start with
        other nodes.
    InputTypeError
        No scene, no number, no start.
    MissingFileError
        No saved state to start from.

    Warns
    -----
    AuditWarning
        Each error and each warning that `audit` finds in the scene; later, of what begins a stage inside a body.

    Examples
    --------
    Steps, times and energies:

    >>> from membrane_rs import Simulation, scenes
    >>> sim = Simulation(scenes.load("spinning-tether"))
    >>> sim.step(10)
    >>> sim.reach(0.05)
    >>> sim.step_count > 10, sim.time, sim.dt < sim.stable_dt()
    (True, 0.05, True)
    >>> energies, ledger = sim.energies(), sim.ledger()
    >>> sorted(energies)
    ['kinetic', 'spin', 'tethers']
    >>> abs(ledger["error"]) < 1e-3
    True

    Readings: forces, tensions, stresses, loads:

    >>> sim.forces().shape, sim.forces("spin").shape == sim.positions.shape
    ((11, 3), True)
    >>> sim.cord_tensions().shape, sim.spring_strains().shape, bool(sim.buckled().any())
    ((10,), (10,), False)
    >>> bool(sim.hub_load().force[0] > 0.0), sim.hub_force().shape, sim.hub_torque().shape, sim.body_loads()
    (True, (3,), (3,), {})
    >>> round(sim.hub_rate, 2), sim.hub_motor().power == 0.0, sim.angular_momentum().hub
    (18.85, False, 0.0)
    >>> strip = Simulation(scenes.load("hanging-strip"))
    >>> strip.film_stress().principal.shape, int(strip.film_states().max()), strip.crease_angles().shape
    ((84, 2), -1, (2,))
    >>> strip.largest_film_stress() < 1.0, bool(strip.contact_forces().any()), strip.crossings().count
    (True, False, 0)

    A run, and the same state once more:

    >>> sim.run(until=0.06, samples=3, frames=2)
    >>> again = Simulation(sim.scene, start=sim)
    >>> again.time, sim.audit().ok, sim.reach_within(0.061, seconds=60.0)
    (0.06, True, True)
    >>> state = sim.state()
    >>> sim.step(5)
    >>> sim.set_state(state)
    >>> sim.time, sim.saved_state().keys() > state.keys()
    (0.061, True)
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     sim.save(f"{folder}/state.npz")
    ...     Simulation.restore(f"{folder}/state.npz").time
    0.061

    Rest, before the first step:

    >>> strip.relax(duration=0.05) < 1.0
    True
    """

    def __init__(
        self,
        scene: Scene,
        integrator: str | None = None,
        dt: float | None = None,
        *,
        start: Motion | str | Path | None = None,
    ) -> None:
        super().__init__(scene, integrator, dt, start=start)
        warn_of(self.audit())

    def audit(self) -> Audit:
        """Faults, risks and facts of the scene, and of the method and step that this simulation has.

        Costly checks are left out; `membrane_rs.check.audit` makes all.

        Returns
        -------
        Audit
            The findings, errors first.
        """
        return audit_of_motion(self)

    def _end_stage(self, ended_by: str) -> None:
        """As `StagedMotion`, and warn of what begins the next stage inside a body."""
        super()._end_stage(ended_by)
        if not self.is_over:
            warn_of(Audit.of(inside_at_stage_start(self)))

    def relax(self, duration: float | None = None, rate: float | None = None) -> float:
        """Damp the scene to rest where its guide bars hold it, and start from there, at the same time.

        Nodes of the set "guide_bars" (none without that set) are held, and friction F = -rate m v is added, for
        `duration` of damped motion. Meanwhile no time passes: all that depends on time, such as the rate of the hub,
        its acceleration and the direction of gravity, is that of the start. A scene that is not at rest then goes on
        without that friction by kinetic damping: it is stopped at each maximum of its kinetic energy, until the net
        force on each free node is far below 1 % of the largest force of a law on a node. It takes at most 20 times
        `duration`, or 20,000 steps if that is longer, then warns (`UserWarning`) and takes the state nearest to rest.
        Then the nodes are released, at rest; a net force is left on those that were held alone. Returns the largest
        speed before the nodes were stopped the last time [m/s].

        Parameters
        ----------
        duration : float, optional
            Of damped motion [s]. Default: that of the scene.
        rate : float, optional
            Of the friction [1/s]. Default: that of the scene.

        Returns
        -------
        float
            The largest speed [m/s].

        Raises
        ------
        InputError
            After the first step, or with a duration or rate that is not above zero.
        InputTypeError
            A duration or rate that is no number.
        UnstableError
            The motion with friction became unstable.
        KeyboardInterrupt
            Ctrl-C; the simulation is then as it was.
        """
        if self.step_count or self.time:
            raise InputError(
                f"relax at t = {self.time:.6g} s: it must come before the first step; build a new Simulation"
            )
        duration = None if duration is None else number_of("relax: duration", duration)
        rate = None if rate is None else number_of("relax: rate", rate, "1/s")
        positions, speed = relaxed(self, duration, rate)
        self._set_motion(positions, np.zeros_like(positions))
        self.is_relaxed = True
        return speed

    settle = Renamed("relax")

    def run(
        self,
        until: float | None = None,
        frames: int | Sequence[float] | None = None,
        out: str | Path | None = None,
        *,
        samples: int | Sequence[float] | None = None,
        observers: Sequence[Observer[Simulation]] = (),
        progress: Callable[[Simulation], None] | None = None,
        overwrite: bool = False,
        pictures: bool = True,
        crossings: bool = False,
        checkpoint: float = CHECKPOINT,
        record: Recorded | None = None,
        every: float | None = None,
        stop_when: StopWhen | Stop | None = None,
    ) -> RunFolder | None:
        """Step to `until`, and call the observers at frames and samples.

        Parameters
        ----------
        until : float, optional
            Time at the end [s]. Default: the scene's; with stages the end of the last one, at the latest. A run ends
            earlier where a measure ends the last stage.
        frames : int or sequence of float, optional
            How many shapes to keep, evenly spaced from time 0 to the end, or their times [s]. Default: the scene's.
            Given times before now or after the end are left out, with a warning.
        out : path, optional
            Folder of the results; see `membrane_rs.runs.RunFolder`. Default: nothing is written.
        samples : int or sequence of float, optional
            Rows of the history, evenly spaced, or their times [s]; each frame is one too. Default: the scene's.
        observers : sequence of observers, optional
            Further observers.
        progress : callable, optional
            Called with this simulation at each output, and about every 0.1 s of wall time.
        overwrite, pictures : bool
            For the folder: replace an earlier run; draw pictures at the end.
        crossings : bool
            For the folder: count the triangles that pass through each other at each frame, into crossings.csv. Without
            a folder, `membrane_rs.results.CrossingCounts` is an observer that does so.
        checkpoint : float, optional
            For the folder: wall time between two checkpoints (state.npz) [s], from which `membrane_rs.runs.resume` goes
            on should the process be killed. Default: 10.
        record, every, stop_when
            As for `membrane_rs.run`; `record` needs something that keeps a history. What has ended
            a run before its time is `stopped_by`.

        Returns
        -------
        RunFolder or None
            The folder, where `out` was given.

        Raises
        ------
        UnstableError
            The run stopped itself. What was written stays, with the last good frame.
        Interrupted
            Ctrl-C, SIGTERM or another signal of `runs.signals`, in the main thread; a KeyboardInterrupt. What was
            written stays, the state among it; the simulation can go on.
        OutputError
            Results cannot be written.
        InputError, InputTypeError
            An end before now or after the last stage, times or a measure that are none, an option without effect.
        """
        from membrane_rs.runs.run_folder import RunFolder  # slow to import, with all outputs

        overwrite, pictures, crossings = flags_of(overwrite=overwrite, pictures=pictures, crossings=crossings)
        settings = self.scene.run
        end = number_of("until", self.planned_end if until is None else until)
        if end < self.time:
            raise InputError(f"until = {end} s: the simulation is at {self.time:.6g} s already; give a later time")
        _check_callers(observers, progress)
        _check_every(every, samples)
        stop = stop_when if stop_when is None or isinstance(stop_when, Stop) else Stop(stop_when)
        measures = _measures(self, record)
        request = Request(
            end,
            settings.frames if frames is None else frames,
            settings.samples if samples is None else samples,
            checkpoint=checkpoint,
            every=every,
            record=measures.units,
            known=measures.known,
            stop=None if stop is None else stop.table,
        )
        # Refused before anything is written.
        has_folder = out is not None or any(isinstance(observer, RunFolder) for observer in observers)
        has_history = out is not None or any(isinstance(observer, Recorder) for observer in observers)
        _refuse_unused(
            ("overwrite", overwrite, overwrite and out is None),
            ("pictures", pictures, not pictures and not has_folder),
            ("crossings", crossings, crossings and out is None),
            ("checkpoint", checkpoint, checkpoint != CHECKPOINT and not has_folder),
            ("record", list(measures.units), bool(measures.units) and not has_history),
        )
        if measures.units:
            HistoryTable(self, measures).add(self)
        self._check_end(end)
        self._check_stages_last(end)
        if not end <= 0.0:
            check_duration(end, "until")
        request.output_times(self.time, self.scene)
        if not any(observer.is_resumed for observer in observers if isinstance(observer, Recorder)):
            request.warn_of_unshown(self.time)
            request.warn_of_fewer(frames)
        folder = None if out is None else RunFolder(out, overwrite, pictures=pictures, crossings=crossings)
        all_observers: list[Observer[Simulation]] = [*observers, *([folder] if folder is not None else [])]
        recorders = [observer for observer in all_observers if isinstance(observer, Recorder)]
        if self.scene.bodies and not recorders:  # a summary has one of its own
            all_observers.append(BodyContacts())

        def between(_: Simulation) -> None:
            signals.look()
            for each in recorders:
                each.between(self)

        self.until = end
        with signals.interruptible():
            try:
                self._begin_stop(stop)
                for each in recorders:
                    each.prepare(self, each.asked(request), measures)
                if settings.relax > 0 and not self.is_relaxed and self.time == 0.0:
                    self.relax()
                with signals.held():
                    shown = request.instants(self.scene)
                    self.march(end, observers=all_observers, progress=progress, between=between, **shown)
            except BaseException as error:
                for each in recorders:
                    each.finish(self, error)
                raise
            finally:
                self._end_stop()
        return folder


def _measures(sim: Simulation, record: Recorded | None) -> Measures:
    """What is recorded beside the columns that each history has. Raises InputError and InputTypeError."""
    measures = Measures(record)
    return HistoryTable(sim, measures).measures if measures.units else measures


def _check_callers(observers: object, progress: object) -> None:
    """Refuse what is no list of observers, or cannot be called. Raises InputTypeError."""
    if not isinstance(observers, Sequence) or not all(hasattr(item, "sample") for item in observers):
        raise InputTypeError(f"observers = {show(observers)}: must be a list of observers")
    if progress is not None and not callable(progress):
        raise InputTypeError(f"progress = {show(progress)}: must be a function that takes this simulation")


def _check_every(every: float | None, samples: object) -> None:
    """Refuse an interval between samples beside their number or times. Raises InputError."""
    if every is not None and samples is not None:
        raise InputError(f"every = {show(every)}: samples are given too; leave one of them out")


def _refuse_unused(*options: tuple[str, object, bool]) -> None:
    """Refuse options that have no effect, each with its name, its value, and whether it has none. Raises InputError."""
    for name, value, is_unused in options:
        if is_unused:
            raise InputError(f"{name} = {value}: without out nothing is written; give out a folder, or leave this out")
