"""Frames of a run: frames/frame-<k>.vtu, and frames.pvd, which lists them, after each."""

from __future__ import annotations

from membrane_rs.results.record import Record
from membrane_rs.results.vtk import Frame, FrameWriter, write_pvd
from membrane_rs.results.writer import Writer
from membrane_rs.simulation.stepper import Stepper


class Frames(Writer):
    """Writes frames in the background, from copies."""

    own_files = ("frames.pvd", "frames/frame-*.vtu")

    def start(self, sim: Stepper, record: Record) -> None:
        """Work out what is the same in all frames."""
        self._record = record
        self._writer = FrameWriter(sim)
        self._times: list[float] = []

    def frame(self, sim: Stepper) -> None:
        """Copy what a frame shows; a state that is not later than the last one is skipped.

        Waits only while earlier frames wait to be written. Raises OutputError where one of those cannot be.
        """
        if self._times and sim.time <= self._times[-1]:
            return
        frame, file = Frame.of(sim), f"frames/frame-{len(self._times):04d}.vtu"
        self._record.background.add(lambda: self._write(frame, file))
        self._times.append(frame.time)

    def _write(self, frame: Frame, file: str) -> None:
        self._writer.write(self._record.path / file, frame)
        self._record.frames.append((frame.time, file))
        write_pvd(self._record.path / "frames.pvd", self._record.frames)
