"""The folder of a run: what is in it, and when each file is written.

.membrane_rs.lock   there and locked for as long as the run goes on
state.npz       before the start is relaxed, after that, every few seconds of wall time, and at the end
summary.json    before all other outputs ("running"), at each checkpoint, and at the end
scene.toml      at the start, all values resolved (mesh.npz beside it where the mesh has no pattern)
history.csv     a line per sample
frames.pvd      after each frame, with frames/frame-<k>.vtu; both by a thread, from copies, while the core steps
crossings.csv   a line per frame, where it is asked for; by that thread too
shapes/*.npz    at the times of the snapshots, for a run that is resumed
deployment.png, energy.png, momentum.png (of a free hub), crossings.png, snapshots/*.png, animation.gif    at the end,
                unless the run was interrupted
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path, PurePath
from time import monotonic

from membrane_rs._extras import need
from membrane_rs._files import path_of
from membrane_rs._known_attributes import KnownAttributes
from membrane_rs._validation import flags_of
from membrane_rs.check import audit_of_motion
from membrane_rs.check.bodies import inside_at_stage_start
from membrane_rs.errors import InputError, OutputError
from membrane_rs.plotting.animation import Animation
from membrane_rs.plotting.crossings import CrossingsPicture
from membrane_rs.plotting.deployment import DeploymentPicture
from membrane_rs.plotting.energy import EnergyPicture
from membrane_rs.plotting.momentum import MomentumPicture
from membrane_rs.plotting.snapshots import Snapshots
from membrane_rs.results.background import Background
from membrane_rs.results.crossing_counts import CrossingsFile
from membrane_rs.results.frames import Frames
from membrane_rs.results.history import HISTORY, History
from membrane_rs.results.pvd import PVD
from membrane_rs.results.record import Progress, Record
from membrane_rs.results.recorded import Measures
from membrane_rs.results.run_summary import add_findings
from membrane_rs.results.scene_file import SceneFile
from membrane_rs.results.state import State
from membrane_rs.results.summary import Summary
from membrane_rs.results.writer import Writer
from membrane_rs.runs import signals
from membrane_rs.runs.place import Place
from membrane_rs.runs.recorder import Recorder
from membrane_rs.runs.request import Request
from membrane_rs.simulation.stepper import Stepper

WRITERS: list[type[Writer]] = [
    SceneFile,
    Frames,
    History,
    CrossingsFile,
    Summary,
    State,
    DeploymentPicture,
    EnergyPicture,
    MomentumPicture,
    CrossingsPicture,
    Snapshots,
    Animation,
]
"""The one list of outputs, in the order in which they start and finish; but the summary starts before all others."""


def own_files() -> list[str]:
    """What a run writes, and so all that `overwrite` may remove: glob patterns, in the order of removal.

    The summary is removed last: files of these names in a folder without it are not a run's, but somebody's own.
    Raises InputError for a pattern that leads out of the folder.
    """
    names: list[str] = []
    for kind in sorted(WRITERS, key=lambda kind: kind is Summary):
        paths = [PurePath(name) for name in kind.own_files]
        if isinstance(kind.own_files, str) or any(not p.name or p.is_absolute() or ".." in p.parts for p in paths):
            raise InputError(
                f"{kind.__name__}.own_files = {kind.own_files!r}: must be a tuple of names or patterns in the folder "
                "of the run, none absolute and none with '..'"
            )
        names += kind.own_files
    return names


class RunFolder(KnownAttributes, Recorder):
    """An observer that writes a run's results into a folder. For one run.

    The folder is valid after every frame: each file is whole or absent, and history.csv and frames.pvd grow by whole
    lines. A run that was killed is resumed from its last checkpoint (`membrane_rs.runs.resume`).

    Parameters
    ----------
    path : path
        The folder; made where it is missing, with its parents.
    overwrite : bool
        Remove the files of an earlier run in this folder, which its summary.json shows to be one. Other files stay.
    pictures : bool
        Draw the pictures of the run when it ends.
    crossings : bool
        Count the triangles that pass through each other at each frame, into crossings.csv.
    progress : callable, optional
        Called with (what is drawn, pictures done, pictures in all) while the pictures are drawn.

    Raises
    ------
    MissingExtraError
        Pictures are wanted, and the extra "plot" is not installed.
    OutputError
        The folder is not empty and `overwrite` is false, or it holds files of a run's names that no run wrote, or
        another run goes on there, or it cannot be written.
    InputError, InputTypeError
        No path.

    Examples
    --------
    >>> from membrane_rs import Simulation, scenes
    >>> from membrane_rs.runs import RunFolder
    >>> folder = RunFolder("runs/tether", pictures=False)
    >>> Simulation(scenes.load("spinning-tether")).run(0.01, frames=2, samples=3, observers=[folder])
    >>> sorted(file.name for file in folder.path.iterdir() if file.is_file() and file.name[0] != ".")
    ['frames.pvd', 'history.csv', 'scene.toml', 'state.npz', 'summary.json']
    >>> again = RunFolder(folder.path, overwrite=True, pictures=False)
    >>> with again.reopened():
    ...     again.is_resumed
    True
    """

    ONCE = ("path", "pictures", "crossings")

    def __init__(
        self,
        path: Path | str,
        overwrite: bool = False,
        *,
        pictures: bool = True,
        crossings: bool = False,
        progress: Progress | None = None,
    ) -> None:
        self.path = path_of(path, "out")
        overwrite, pictures, crossings = flags_of(overwrite=overwrite, pictures=pictures, crossings=crossings)
        if pictures:
            need("matplotlib", "PIL", use="the pictures of a run, which --no-pictures (pictures=False) leaves out")
        self.pictures, self.crossings = pictures, crossings
        self._place = Place(self.path, own_files(), overwrite=overwrite)
        self._record = Record(self.path, progress, Background(self._place.check_held))
        self._summary, self._state = Summary(), State()
        own: dict[type[Writer], Writer] = {Summary: self._summary, State: self._state}
        kinds = [kind for kind in WRITERS if (pictures or not kind.draws) and self._is_asked_for(kind)]
        self._writers = [own.get(kind) or kind() for kind in kinds]
        self._is_prepared = self._is_started = self._is_ended = self._is_resumed = False
        self._interval, self._last_checkpoint = float("inf"), 0.0
        self._shown: dict[float, bool] = {}
        self._first_shown: tuple[bool, bool] | None = None
        self._is_frame_due = True
        self._place.check()

    def asked(self, request: Request) -> Request:
        """A request with what this folder is to hold."""
        return replace(request, pictures=self.pictures, crossings=self.crossings)

    def _is_asked_for(self, kind: type[Writer]) -> bool:
        return kind.option is None or bool(getattr(self, kind.option))

    @property
    def is_resumed(self) -> bool:
        """Whether an earlier run goes on here."""
        return self._is_resumed

    @property
    def has_begun(self) -> bool:
        """Whether what is in the folder is of this run."""
        return self._is_prepared or self._is_started

    @contextmanager
    def reopened(self) -> Iterator[None]:
        """Hold the folder of an earlier run to go on there inside, in place of an `overwrite`.

        Yields
        ------
        None
            Nothing: it is for a `with`.

        Raises
        ------
        OutputError
            Another run goes on there, or the folder holds none.
        """
        self._place.reopen()
        self._is_resumed = True
        try:
            yield
        finally:
            self._place.release()

    def prepare(self, sim: Stepper, request: Request, measures: Measures | None = None) -> None:
        """Make the folder, take its lock, clear it of an earlier run, and write a first checkpoint and summary.

        A run that is prepared can be resumed, even if it is killed before `start`, which does what is left. Raises
        OutputError, and then leaves no folder behind that was not there before, but for a summary where all that
        cannot be written is the checkpoint.
        """
        unwritten: OutputError | None = None
        with self._claimed():
            self._record.request, self._interval = request.as_table(), request.checkpoint
            self._record.measures = measures or Measures()
            self._state.start(sim, self._record)
            if self._is_resumed:
                self._summary.resume(sim, self._record)
                starts = [stage.start for stage in sim.stages]
                self._shown = request.output_times(self._record.summary["start_time"], sim.scene, starts)
                self._first_shown = sim.time in self._shown, self._shown.get(sim.time, False)
            else:
                # Before the summary: where that is, a run can be resumed.
                try:
                    self._state.writing(sim)()
                except OutputError as error:
                    unwritten = error
                self._start_summary(sim)
            self._is_prepared = True
        if unwritten is not None:
            raise unwritten

    def start(self, sim: Stepper) -> None:
        """Prepare the folder where that is not done, and start all outputs. Raises OutputError as `prepare` does."""
        with self._claimed():
            if self._is_prepared:
                self._summary.relaxed(sim)
            else:
                self._start_summary(sim)
            for writer in self._writers:
                if writer is not self._summary:
                    (writer.resume if self._is_resumed else writer.start)(sim, self._record)
            self._check_complete(sim.time)
            self._is_started = True
            if self._is_prepared:
                self._checkpoint(sim)

    def _start_summary(self, sim: Stepper) -> None:
        found = audit_of_motion(sim)
        self._record.summary["audit"] = [finding.as_dict() for finding in found.findings]
        self._summary.start(sim, self._record)

    def sample(self, sim: Stepper) -> None:
        """Show a sample to all outputs. Raises OutputError, also where the background could not write."""
        with signals.held():
            self._place.check_held()
            self._record.background.look()
            # A run that is resumed shows its checkpoint, which is an instant of its history by chance alone.
            is_due, self._is_frame_due = self._first_shown or (True, True)
            self._first_shown = None
            self._audit_stage(sim)
            if is_due:
                self._show(lambda writer: writer.sample(sim))

    def _audit_stage(self, sim: Stepper) -> None:
        """Add what begins a stage inside a body to the audit in the summary."""
        if sim.boundaries[-1:] != [sim.time]:
            return
        add_findings(self._record.summary, inside_at_stage_start(sim))

    def frame(self, sim: Stepper) -> None:
        """Show a frame to all outputs. Raises OutputError."""
        with signals.held():
            if self._is_frame_due:
                self._show(lambda writer: writer.frame(sim))

    def between(self, sim: Stepper) -> None:
        """Write a checkpoint where it is time for one. Raises OutputError."""
        is_due = monotonic() - self._last_checkpoint >= self._interval
        if is_due and self._is_started and self._record.background.is_idle:
            with signals.held():
                self._place.check_held()
                self._checkpoint(sim)

    def finish(self, sim: Stepper, error: BaseException | None) -> None:
        """Wait for the background, finish all outputs, and write the summary once more. Raises OutputError.

        The error that ended the run is the one raised: a file that cannot be written after that is ignored, but for
        a vital one. Each output is given the first error so far, the summary among them. An output that fails, in
        whatever way, keeps no other from its end. Where the folder is no longer this run's, nothing is written.
        """
        if self._is_ended or not (self._is_prepared or self._is_started):
            return
        self._is_ended = True
        with signals.held():
            unwritten = self._record.background.close()
            first = error or unwritten
            try:
                self._place.check_held()
                first = self._finish(sim, first)
            except OutputError as failure:
                first = first or failure
            finally:
                self._place.release()
        if first is not None and first is not error:
            raise first

    @contextmanager
    def _claimed(self) -> Iterator[None]:
        """The place is this run's inside, and after an error inside as it was."""
        with signals.held():
            try:
                with self._place.claimed():
                    yield
            except BaseException:
                self._is_ended = True
                raise

    def _finish(self, sim: Stepper, first: BaseException | None) -> BaseException | None:
        """Finish all outputs. Returns the first error. Raises OutputError where the summary cannot be written."""
        for writer in self._writers if self._is_started else ():
            try:
                with signals.released() if writer.draws else signals.held():
                    writer.finish(sim, first)
                    writer.sync()
            except (Exception, KeyboardInterrupt) as failure:  # noqa: BLE001 - a user's output may fail in any way
                first = failure if writer.is_vital else first or failure
        self._summary.close(first)
        return first

    def _check_complete(self, now: float) -> None:
        """Where the run is resumed, raise OutputError for an instant before `now` [s] that its files lack."""
        frames, samples = {time for time, _ in self._record.frames}, self._record.table.get("time", ())
        for file, known, wanted in (
            (PVD, frames, {time for time, is_frame in self._shown.items() if is_frame}),
            (HISTORY, set(samples), self._shown.keys()),
        ):
            lacking = sorted(time for time in wanted if time < now and time not in known)
            if lacking:
                raise OutputError(
                    f"{self.path / file}: lacks the time {lacking[0]:.6g} s, which is before the checkpoint; continue "
                    "state.npz into a folder of its own, or run the scene again"
                )

    def _show(self, call: Callable[[Writer], None]) -> None:
        for writer in self._writers:
            call(writer)

    def _checkpoint(self, sim: Stepper) -> None:
        """Copy the state, and have it written behind all that was written so far."""
        self._last_checkpoint = monotonic()
        tasks = [*(writer.sync for writer in self._writers), self._state.writing(sim), self._summary.at_checkpoint(sim)]

        def write() -> None:
            if not self._record.background.has_failed:
                for task in tasks:
                    task()

        self._record.background.add(write)
