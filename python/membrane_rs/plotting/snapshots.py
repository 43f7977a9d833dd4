"""Pictures at chosen times, in the turning frame and as a fixed camera sees them, and their contact sheets.

The times are those that the scene names. Of a run that ends before most of them, or goes on long after them, frames are
drawn that are spread over the run. The sheets are laid out like Figs. 10 and 12 of Okuizumi et al. 2012: rows of five,
"(a) 0.0 s" under each.
Each stage of a scene with stages has times, a camera and sheets of its own, and the sheet of the run shows all.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import astuple, replace

from membrane_rs.analysis.attitude import turn_at
from membrane_rs.plotting.camera import Camera
from membrane_rs.plotting.drawing import Drawing, spread
from membrane_rs.plotting.painter import painter
from membrane_rs.plotting.picture import Subject
from membrane_rs.plotting.scenery import BodiesInTime, reach_of
from membrane_rs.plotting.shape_files import SHAPES, read_shapes, write_shape
from membrane_rs.plotting.sheets import OF_STAGE, VIEWS, Part, Sheets, Snapshot, stage_prefix
from membrane_rs.results.record import Record
from membrane_rs.results.vtk import read_frame
from membrane_rs.scene.solid import Solid
from membrane_rs.simulation.motion import Motion
from membrane_rs.simulation.stepper import Stepper

SIZE = 700
FEWEST, SPREAD = 4, 6
LEAST_SHARE = 0.5
"""With fewer snapshots than the first number, or of less than half the run, so many frames are drawn instead."""


class Snapshots(Drawing):
    """Keeps the shapes at the times that the scene names, and draws them."""

    own_files = (
        *(f"snapshots/{stage}{view}{end}.png" for stage in ("", OF_STAGE) for view in VIEWS for end in ("", "-*s")),
        SHAPES,
    )

    def start(self, sim: Stepper, record: Record) -> None:
        """Wait for the times that are still to come."""
        self._begin(sim, record, sim.time)

    def resume(self, sim: Stepper, record: Record) -> None:
        """Take over the shapes up to now."""
        self._begin(sim, record, record.summary["start_time"])
        for shape in (Snapshot(*content) for content in read_shapes(record.path, sim.time)):
            record.shapes.append(self._taker.take(shape).positions)

    def sample(self, sim: Stepper) -> None:
        """Keep the state if a snapshot is due, in the folder too: a run that is resumed draws it."""
        shape = self._taker.offer(sim)
        if shape is not None:
            self.record.shapes.append(shape.positions)
            folder, number = self.record.path, len(self._taker.taken) - 1
            self.record.background.add(lambda: write_shape(folder, number, astuple(shape)))

    def count(self) -> int:
        """One for each view and time."""
        return len(self._views) * self._drawn

    def draw(self, sim: Stepper) -> None:
        """Draw each, and the sheets."""
        parts = [self._stage(sim, index) for index in range(len(sim.stages))] or [self._whole(sim)]
        self._drawn = sum(len(part.shots) for part in parts)
        if self._drawn:
            subject, bodies = self.subject(sim), BodiesInTime(sim, self.first_shape(sim))
            with painter(subject, SIZE) as artist:
                sheets = Sheets(self.record.path / "snapshots", artist, self.record.tick, self._views)
                for part in parts:
                    solids = [bodies.at(shot.time, part.stage) for shot in part.shots]
                    sheets.write(part, solids, self._camera(part, subject, solids))
                if sim.stages:
                    sheets.write_all(sim.scene.name)

    def _begin(self, sim: Stepper, record: Record, since: float) -> None:
        super().start(sim, record)
        self._views = VIEWS if any(law.turns_hub for law in sim.scene.laws) else VIEWS[1:]
        self._drawn = 0
        self._taker = SnapshotTaker(sim.scene.run.snapshots, since)

    def _whole(self, sim: Stepper) -> Part:
        """The pictures of a run without stages: frames spread over it where it came to few of its snapshots."""
        shots = list(self._taker.taken)
        named = len(sim.scene.run.snapshots)
        if named and _are_few(shots, self.record.frames, min(named, FEWEST)):
            shots = self._spread(self.record.frames) or shots
        return Part(shots, sim.scene.name)

    def _stage(self, sim: Stepper, index: int) -> Part:
        """The pictures of a stage, its start and its end among them where a frame or a snapshot shows them."""
        stage = sim.stages[index]
        frames = [frame for frame in self.record.frames if stage.start <= frame[0] <= stage.end]
        shots = [shot for shot in self._taker.taken if stage.start <= shot.time <= stage.end]
        if _are_few(shots, frames, FEWEST):
            shots = self._spread(frames) or shots
        return Part(
            shots, f"{sim.scene.name}: {stage.name}", stage_prefix(index, stage.name), stage.name, index, frames
        )

    def _camera(self, part: Part, subject: Subject, solids: Sequence[Sequence[Solid]]) -> Camera | None:
        """That of a stage, from the same side as of the whole run; None where the whole run has one."""
        if part.stage is None or not part.shots:
            return None
        shapes = [*(shot.positions for shot in part.shots), *self.some_shapes(part.frames)]
        if not subject.has_hub:
            return Camera.of(shapes, subject.triangles, about_axis=False)
        shown = [solid for some in solids for solid in some]
        return replace(subject.camera, reach=max(reach_of(shape, shown) for shape in shapes))

    def _spread(self, frames: Sequence[tuple[float, str]]) -> list[Snapshot]:
        """Of a few frames, the first and the last among them."""
        if not frames:
            return []
        return [self._snapshot(*frames[k]) for k in spread([time for time, _ in frames], SPREAD)]

    def _snapshot(self, time: float, file: str) -> Snapshot:
        table = self.record.table
        return Snapshot(time, turn_at(table, time), read_frame(self.record.path / file))


def _are_few(shots: Sequence[Snapshot], frames: Sequence[tuple[float, str]], fewest: int) -> bool:
    """Whether frames show a run, or a stage, better than its snapshots: these are few, or of a small part of it."""
    if len(shots) < fewest:
        return True
    span = frames[-1][0] - frames[0][0] if frames else 0.0
    return shots[-1].time - shots[0].time < LEAST_SHARE * span


class SnapshotTaker:
    """Keeps the first state at or after each of the wanted times.

    Times before the first state that is offered, as in a run that was restored, are dropped.
    """

    def __init__(self, times: Iterable[float], start: float) -> None:
        self.wanted = sorted(time for time in times if time >= start - 1e-9)
        self.taken: list[Snapshot] = []

    def offer(self, sim: Motion) -> Snapshot | None:
        """Keep the state of `sim` and give it if a wanted time has come."""
        if not self.wanted or sim.time < self.wanted[0] - 1e-9:
            return None
        return self.take(Snapshot(sim.time, sim.hub_turn, sim.positions.copy()))

    def take(self, shape: Snapshot) -> Snapshot:
        """Keep a shape: times up to its own are no longer wanted."""
        self.wanted = [time for time in self.wanted if time > shape.time + 1e-9]
        self.taken.append(shape)
        return shape
