"""The folder of a run: what is in it, and when each file is written.

scene.toml      at the start, all values resolved (mesh.npz beside it where the mesh has no pattern)
summary.json    first of all ("running"), and again at the end
history.csv     a line per sample
frames.pvd      after each frame, with frames/frame-<k>.vtu; both by a thread, from copies, while the core steps
state.npz       at the end of a run that finished or was interrupted, to go on from
deployment.png, snapshots/*.png, animation.gif      at the end, unless the run was interrupted
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import Any

from membrane_rs._files import PART, output_errors
from membrane_rs.errors import OutputError, UnstableError
from membrane_rs.plotting.animation import SIZE as ANIMATION_SIZE
from membrane_rs.plotting.animation import chosen, write_animation
from membrane_rs.plotting.deployment import plot_deployment
from membrane_rs.plotting.painter import begin_probe, painter, pyvista_works
from membrane_rs.plotting.picture import Subject
from membrane_rs.plotting.snapshots import SIZE as SNAPSHOT_SIZE
from membrane_rs.plotting.snapshots import VIEWS, SnapshotTaker, write_snapshots
from membrane_rs.results.background import Background
from membrane_rs.results.history import History
from membrane_rs.results.summary import curve_features, energy_balance, versions, write_summary
from membrane_rs.results.vtk import Frame, FrameWriter, write_pvd
from membrane_rs.simulation.stepper import Stepper

SUMMARY = "summary.json"
"""Written first and removed last: files of these names in a folder without it are not a run's, but somebody's own."""
# What a run writes, and so all that `overwrite` may remove.
OWN_FILES = (
    "scene.toml",
    "mesh.npz",
    "history.csv",
    "frames.pvd",
    "state.npz",
    "deployment.png",
    "animation.gif",
    "frames/frame-*.vtu",
    *(f"snapshots/{view}{end}.png" for view in VIEWS for end in ("", "-*s")),
    SUMMARY,
)
OWN_FOLDERS = ("frames", "snapshots")

Progress = Callable[[str, int, int], None]


class RunFolder:
    """An observer that writes a run's results into a folder. For one run.

    The folder is valid after every frame: each file is whole or absent, and history.csv grows by whole lines.

    Parameters
    ----------
    path :
        The folder; made where it is missing, with its parents.
    overwrite :
        Remove the files of an earlier run in this folder, which its summary.json shows to be one. Other files stay.
    pictures :
        Draw deployment.png, snapshots and animation when the run ends.
    progress :
        Called with (what is drawn, pictures done, pictures in all) while the pictures are drawn.

    Raises
    ------
    OutputError
        If the folder is not empty and `overwrite` is false, or it holds files of a run's names that no run wrote, or
        it cannot be written.
    """

    def __init__(
        self,
        path: Path | str,
        overwrite: bool = False,
        *,
        pictures: bool = True,
        progress: Progress | None = None,
    ) -> None:
        self.path = Path(path)
        self._overwrite = overwrite
        self._pictures = pictures
        self._progress = progress
        self._check()

    def start(self, sim: Stepper) -> None:
        """Make the folder, clear it of an earlier run, write scene.toml and a first summary.

        Raises OutputError, and then leaves no folder behind that was not there before.
        """
        self._check()
        made: list[Path] = []
        is_cleared = False
        try:
            self._make_folders(made)
            self._remove_own_files()
            is_cleared = True
            self._began = time.perf_counter()
            self._summary = self._first_summary(sim)
            self._write_summary()
            sim.scene.save(self.path)
            self._history = History(self.path / "history.csv", sim)
            self._frames: list[tuple[float, str]] = []
            self._frame_times: list[float] = []
            self._frame_writer = FrameWriter(sim)
            self._background = Background()
            self._snapshots = SnapshotTaker(sim.scene.run.snapshots, sim.time)
            if self._pictures:
                begin_probe()
        except BaseException:
            if is_cleared:
                self._remove_own_files()
            for folder in reversed(made):
                if not any(folder.iterdir()):
                    folder.rmdir()
            raise

    def sample(self, sim: Stepper) -> None:
        """Add a line to history.csv, and keep the state if a snapshot is due. Raises OutputError.

        A state that is not later than the last one is passed over: a run that went wrong steps back to its
        last good state, which may have been written already. The same holds for frames.
        """
        self._background.look()
        if not self._history.rows or sim.time > self._history.rows[-1][0]:
            self._history.add(sim)
            self._snapshots.offer(sim)

    def frame(self, sim: Stepper) -> None:
        """Copy what a frame shows, to be written in the background: a VTU file, then the index that lists it.

        Waits only while earlier frames wait to be written. Raises OutputError where one of those cannot be.
        """
        if self._frame_times and sim.time <= self._frame_times[-1]:
            return
        frame, file = Frame.of(sim), f"frames/frame-{len(self._frame_times):04d}.vtu"
        self._background.add(lambda: self._write_frame(frame, file))
        self._frame_times.append(frame.time)

    def _write_frame(self, frame: Frame, file: str) -> None:
        self._frame_writer.write(self.path / file, frame)
        self._frames.append((frame.time, file))
        write_pvd(self.path / "frames.pvd", self._frames)

    def finish(self, sim: Stepper, error: BaseException | None) -> None:
        """Write the frames that wait, close the history, write the summary, then the pictures. Raises OutputError.

        The summary is written even where the history cannot be closed. What ended the run stays the error that is
        told: a file that cannot be written after that is passed over, but for the state of an interrupted run.

        A run that went unstable is drawn as far as it came. After an interruption, or any other error,
        nothing is drawn, so that the program stops at once.
        """
        unwritten = self._background.close()
        first = error or unwritten
        try:
            self._history.close()
        except OutputError as failure:
            first = first or failure
        try:
            self._close_summary(sim, first)
        except OutputError as failure:
            first = first or failure
        if first is None or isinstance(first, KeyboardInterrupt):
            with output_errors(self.path / "state.npz"):
                sim.save(self.path / "state.npz")
        if self._pictures and (first is None or isinstance(first, UnstableError)):
            try:
                self._summary["pictures"] = self._draw(sim)
                self._write_summary()
            except OutputError as failure:
                first = first or failure
        if first is not None and error is None:
            raise first

    def _check(self) -> None:
        """Refuse a folder that cannot be used, before anything is written."""
        with output_errors(self.path):
            nearest = next(folder for folder in (self.path, *self.path.absolute().parents) if folder.exists())
            if not nearest.is_dir():
                reason = f"{nearest} is a file; choose another folder"
            elif nearest == self.path and not self._overwrite and any(self.path.iterdir()):
                reason = "it is not empty; choose another folder, or overwrite (overwrite=True, --overwrite)"
            elif nearest == self.path and not (nearest / SUMMARY).exists() and (own := self._own_files()):
                reason = f"{own[0]} is there, but no {SUMMARY}, so no run wrote it; choose another folder"
            elif not os.access(nearest, os.W_OK | os.X_OK):
                reason = f"no permission in {nearest}; choose another folder"
            else:
                return
        raise OutputError(f"cannot write into {self.path}: {reason}")

    def _make_folders(self, made: list[Path]) -> None:
        """Make the folders that are missing, and add them to `made`, outermost first."""
        for folder in (*reversed(self.path.parents), self.path, *(self.path / name for name in OWN_FOLDERS)):
            # Another run may make the same parent at the same moment; then it is there, but not ours to remove.
            with output_errors(folder), suppress(FileExistsError) if folder in self.path.parents else nullcontext():
                if not folder.is_dir():
                    folder.mkdir()
                    made.append(folder)

    def _own_files(self) -> list[Path]:
        """What is there of the files that a run writes, whole or half-written."""
        names = (name for pattern in OWN_FILES for name in (pattern, pattern + PART))
        return [file for name in names for file in self.path.glob(name)]

    def _remove_own_files(self) -> None:
        for file in self._own_files():
            with output_errors(file):
                file.unlink()

    def _first_summary(self, sim: Stepper) -> dict[str, Any]:
        """What is known before the first step."""
        return {
            "scene": sim.scene.name,
            "outcome": "running",
            "counts": sim.scene.counts(),
            "integrator": sim.integrator,
            "dt": sim.dt,
            "stable_dt": sim.stable_dt(),
            "limiting_part": sim.limiting_part,
            "start_time": sim.time,
            "versions": versions(),
        }

    def _close_summary(self, sim: Stepper, error: BaseException | None) -> None:
        """Add what the run has shown, and write the summary."""
        table = self._history.table()
        self._summary |= {
            "outcome": outcome(error),
            "time": sim.time,
            "steps": sim.step_count,
            "rejected_steps": sim.rejected_count,
            "evaluations": sim.evaluation_count,
            **({key: count for key, count in sim.effort.items() if any(sim.effort.values())}),
            "wall_time": time.perf_counter() - self._began,
            "frames": len(self._frames),
            "samples": len(self._history.rows),
            "energy_balance": energy_balance(table),
            "curves": curve_features(table),
            "pictures": "none",
        }
        self._write_summary()

    def _write_summary(self) -> None:
        write_summary(self.path / SUMMARY, self._summary)

    def _draw(self, sim: Stepper) -> str:
        """Draw what the run has left; return who drew it."""
        table, name = self._history.table(), self._summary["scene"]
        if len(self._history.rows) > 1:
            plot_deployment(table, self.path / "deployment.png", name)
        shots = self._snapshots.taken
        frames = chosen([(when, self.path / file) for when, file in self._frames])
        total = len(VIEWS) * len(shots) + len(frames)
        done = 0

        def tick() -> None:
            nonlocal done
            done += 1
            if self._progress is not None:
                self._progress("pictures", done, total)

        subject = Subject.of(sim, [shot.positions for shot in shots] or [sim.positions])
        if shots:
            with painter(subject, SNAPSHOT_SIZE) as artist:
                write_snapshots(self.path / "snapshots", shots, artist, name, tick)
        if len(frames) > 1:
            with painter(subject, ANIMATION_SIZE) as artist:
                write_animation(self.path / "animation.gif", frames, artist, tick)
        return "pyvista" if pyvista_works() else "matplotlib"


def outcome(error: BaseException | None) -> str:
    """How a run ended, in a word, and the reason where it went wrong."""
    if error is None:
        return "finished"
    if isinstance(error, KeyboardInterrupt):
        return "interrupted"
    if isinstance(error, UnstableError):
        return f"unstable: {error}"
    return f"failed: {type(error).__name__}: {error}"
