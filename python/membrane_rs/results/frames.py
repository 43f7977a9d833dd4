"""Frames of a run: frames/frame-<k>.vtu, and frames.pvd, which lists them, after each."""

from __future__ import annotations

from pathlib import Path

from membrane_rs._files import output_errors, sync_all
from membrane_rs.results.frame_fields import Frame
from membrane_rs.results.pvd import PVD, PvdWriter, read_pvd
from membrane_rs.results.record import Record
from membrane_rs.results.vtk import FrameWriter
from membrane_rs.results.writer import Writer
from membrane_rs.simulation.stepper import Stepper

FRAMES = "frames"
FILES = f"{FRAMES}/frame-*.vtu"


class Frames(Writer):
    """Writes frames in the background, from copies."""

    own_files = (PVD, FILES)

    def start(self, sim: Stepper, record: Record) -> None:
        """Work out what is the same in all frames."""
        self._record = record
        self._writer = FrameWriter(sim)
        self._list = PvdWriter(record.path / PVD)
        self._unsynced: list[Path] = []
        record.frames = self._list.frames
        self._times = [time for time, _ in record.frames]

    def resume(self, sim: Stepper, record: Record) -> None:
        """Keep the frames up to now, and remove later ones."""
        self.start(sim, record)
        if self._list.path.is_file():
            listed = [(time, file.relative_to(record.path).as_posix()) for time, file in read_pvd(self._list.path)]
            self._list.frames += [(time, file) for time, file in listed if time <= sim.time]
            self._times = [time for time, _ in record.frames]
        kept = {record.path / file for _, file in record.frames}
        for file in record.path.glob(FILES):
            if file not in kept:
                with output_errors(file):
                    file.unlink()
        if kept or self._list.path.is_file():
            self._list.write()

    def frame(self, sim: Stepper) -> None:
        """Copy what a frame shows; a state that is not later than the last one is skipped.

        Waits only while earlier frames wait to be written. Raises OutputError where one of those cannot be.
        """
        if self._times and sim.time <= self._times[-1]:
            return
        frame, file = Frame.of(sim), f"{FRAMES}/frame-{len(self._times):04d}.vtu"
        self._record.background.add(lambda: self._write(frame, file))
        self._times.append(frame.time)

    def sync(self) -> None:
        """Frames since the last time, and their list."""
        if self._unsynced:
            sync_all([*self._unsynced, self._unsynced[-1].parent, self._list.path])
            self._unsynced.clear()

    def _write(self, frame: Frame, file: str) -> None:
        path = self._record.path / file
        self._writer.write(path, frame)
        self._unsynced.append(path)
        self._list.append(frame.time, file)
