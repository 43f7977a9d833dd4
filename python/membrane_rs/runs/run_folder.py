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
from contextlib import nullcontext, suppress
from pathlib import Path, PurePath

from membrane_rs._files import PART, output_errors, path_of
from membrane_rs.errors import InputError, OutputError
from membrane_rs.plotting.animation import Animation
from membrane_rs.plotting.deployment import DeploymentPicture
from membrane_rs.plotting.snapshots import Snapshots
from membrane_rs.results.frames import Frames
from membrane_rs.results.history import History
from membrane_rs.results.record import Progress, Record
from membrane_rs.results.scene_file import SceneFile
from membrane_rs.results.state import State
from membrane_rs.results.summary import SUMMARY, Summary
from membrane_rs.results.writer import Writer
from membrane_rs.simulation.stepper import Stepper

WRITERS: list[type[Writer]] = [SceneFile, Frames, History, Summary, State, DeploymentPicture, Snapshots, Animation]
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
        self.path = path_of(path, "out")
        self._overwrite = overwrite
        self._record = Record(self.path, progress)
        self._summary = Summary()
        kinds = [kind for kind in WRITERS if pictures or not kind.draws]
        self._writers = [self._summary if kind is Summary else kind() for kind in kinds]
        self._check()

    def start(self, sim: Stepper) -> None:
        """Make the folder, clear it of an earlier run, write a first summary, and start all outputs.

        Raises OutputError, and then leaves no folder behind that was not there before.
        """
        self._check()
        made: list[Path] = []
        is_cleared = False
        try:
            self._make_folders(made)
            self._remove_own_files()
            is_cleared = True
            for writer in sorted(self._writers, key=lambda writer: writer is not self._summary):
                writer.start(sim, self._record)
        except BaseException:
            if is_cleared:
                self._remove_own_files()
            for folder in reversed(made):
                if not any(folder.iterdir()):
                    folder.rmdir()
            raise

    def sample(self, sim: Stepper) -> None:
        """Show a sample to all outputs. Raises OutputError, also where the background could not write."""
        self._record.background.look()
        for writer in self._writers:
            writer.sample(sim)

    def frame(self, sim: Stepper) -> None:
        """Show a frame to all outputs. Raises OutputError."""
        for writer in self._writers:
            writer.frame(sim)

    def finish(self, sim: Stepper, error: BaseException | None) -> None:
        """Wait for the background, finish all outputs, and write the summary once more. Raises OutputError.

        The error that ended the run is the one raised: a file that cannot be written after that is ignored, but for
        a vital one. Each output is given the first error so far, the summary among them. An output that fails, in
        whatever way, keeps no other from its end.
        """
        unwritten = self._record.background.close()
        first = error or unwritten
        for writer in self._writers:
            try:
                writer.finish(sim, first)
            except Exception as failure:  # noqa: BLE001 - an output of a user may fail in any way
                first = failure if writer.is_vital else first or failure
        try:
            self._summary.write()
        except OutputError as failure:
            first = first or failure
        if first is not None and first is not error:
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
            elif folders := [path for path in self._own_files() if path.is_dir()]:
                reason = f"{folders[0]} is a folder, where a run writes a file; move it, or choose another folder"
            elif not os.access(nearest, os.W_OK | os.X_OK):
                reason = f"no permission in {nearest}; choose another folder"
            else:
                return
        raise OutputError(f"cannot write into {self.path}: {reason}")

    def _make_folders(self, made: list[Path]) -> None:
        """Make the folders that are missing, and add them to `made`, outermost first."""
        above = (*reversed(self.path.parents), self.path)
        inner = {folder for name in own_files() for folder in (self.path / name).parents} - set(above)
        for folder in (*above, *sorted(inner)):
            # Another run may make the same parent at the same moment; then it is there, but not ours to remove.
            with output_errors(folder), suppress(FileExistsError) if folder in self.path.parents else nullcontext():
                if not folder.is_dir():
                    folder.mkdir()
                    made.append(folder)

    def _own_files(self) -> list[Path]:
        """The files in the folder that a run writes, complete or partial."""
        names = (name for pattern in own_files() for name in (pattern, pattern + PART))
        return [file for name in names for file in self.path.glob(name)]

    def _remove_own_files(self) -> None:
        for file in self._own_files():
            with output_errors(file):
                file.unlink()
