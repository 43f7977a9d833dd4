"""The place of a run's results: a folder that is made, locked, cleared of an earlier run, and left as it was found
where the run cannot begin.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path

from membrane_rs._files import PART, check_unlinked, output_errors, sync
from membrane_rs.errors import MembraneError, OutputError
from membrane_rs.results.lock import LOCK, FolderLock, is_locked
from membrane_rs.results.summary import SUMMARY, read_summary


class Place:
    """A folder, and the files in it that are a run's own.

    Parameters
    ----------
    path :
        The folder.
    patterns :
        Glob patterns, relative to it, of all that a run writes, in the order of removal.
    overwrite :
        Whether the files of an earlier run are removed.
    """

    def __init__(self, path: Path, patterns: Sequence[str], *, overwrite: bool) -> None:
        self.path = path
        self._patterns, self._overwrite = patterns, overwrite
        self._lock = FolderLock(path)
        self._made: list[Path] = []
        self._is_cleared = False

    def check(self) -> list[Path]:
        """The files of an earlier run. Raises OutputError for a folder that cannot be used; nothing is written."""
        with output_errors(self.path):
            nearest = next(folder for folder in (self.path, *self.path.absolute().parents) if folder.exists())
            if not nearest.is_dir():
                raise self._refusal(f"{nearest} is a file; choose another folder")
            if not os.access(nearest, os.W_OK | os.X_OK):
                raise self._refusal(f"no permission in {nearest}; choose another folder")
            if nearest != self.path:
                return []
            names = {file.name for file in self.path.iterdir()}
            own = self._own_files()
        if names - {LOCK} and not self._overwrite:
            if is_locked(self.path):
                raise self._occupied()
            raise self._refusal("it is not empty; choose another folder, or overwrite (overwrite=True, --overwrite)")
        if own and not names & {LOCK, SUMMARY}:
            raise self._refusal(f"{own[0]} is there, but no {SUMMARY}, so no run wrote it; choose another folder")
        self._check_files(own)
        check_unlinked(self.path, own)
        return own

    def _check_files(self, own: Sequence[Path]) -> None:
        """Raise OutputError for a folder, a pipe, a socket or a device where a run writes a file."""
        for path in own:
            if path.exists() and not path.is_file():
                kind = "a folder" if path.is_dir() else "a pipe, a socket or a device"
                raise self._refusal(f"{path} is {kind}, where a run writes a file; move it, or choose another folder")

    @contextmanager
    def claimed(self) -> Iterator[None]:
        """Make the folder, lock it and clear it, where it is not locked yet.

        After an error inside nothing is left behind that was not there before.
        """
        try:
            if not self._lock.is_held:
                self._claim()
            yield
        except BaseException:
            self._abandon()
            raise

    def reopen(self) -> None:
        """Lock the folder of an earlier run, which is kept but for files that are half written. Raises OutputError."""
        self._acquire()
        try:
            self._make_folders([])
            self._check_files(self._own_files())
            for file in self._own_files():
                if file.suffix == PART:
                    with output_errors(file):
                        file.unlink()
        except BaseException:
            self._lock.release()
            raise

    def check_held(self) -> None:
        """Raise OutputError where the folder was removed, replaced or taken by another run."""
        self._lock.check()

    def release(self) -> None:
        """Give the folder back."""
        self._lock.release()

    def _claim(self) -> None:
        self.check()
        self._make_folders(self._made, with_inner=False)
        self._acquire()
        own = self.check()  # once more: another run may have come and gone
        self._make_folders(self._made)
        _remove(own)
        self._is_cleared = True

    def _acquire(self) -> None:
        if not self._lock.acquire():
            raise self._occupied()

    def _abandon(self) -> None:
        try:
            if self._is_cleared:
                _remove(self._own_files())
        finally:
            self._lock.release()
        for folder in reversed(self._made):
            if not any(folder.iterdir()):
                folder.rmdir()

    def _occupied(self) -> OutputError:
        """The refusal of a folder that another run holds."""
        try:
            process = read_summary(self.path).get("process") or {}
        except MembraneError:
            process = {}
        known = ("pid", "host", "start")
        who = "process {pid} on {host}, since {start}".format(**process) if process.keys() >= set(known) else ""
        return self._refusal(
            f"another run goes on there{who and f' ({who})'}; wait for its end, or choose another folder"
        )

    def _refusal(self, reason: str) -> OutputError:
        return OutputError(f"cannot write into {self.path}: {reason}")

    def _make_folders(self, made: list[Path], *, with_inner: bool = True) -> None:
        """Make the folders that are missing, and add them to `made`, outermost first."""
        above = (*reversed(self.path.parents), self.path)
        inner = {folder for name in self._patterns for folder in (self.path / name).parents} - set(above)
        for folder in (*above, *(sorted(inner) if with_inner else ())):
            # Another run may make the same folder at the same moment; then it is there, but not ours to remove.
            with output_errors(folder), suppress(FileExistsError) if folder in above else nullcontext():
                if not folder.is_dir():
                    folder.mkdir()
                    made.append(folder)
                    sync(folder.parent)

    def _own_files(self) -> list[Path]:
        """The files in the folder that a run writes, complete or partial."""
        names = (name for pattern in self._patterns for name in (pattern, pattern + PART))
        return [file for name in names for file in self.path.glob(name)]


def _remove(files: Sequence[Path]) -> None:
    for file in files:
        with output_errors(file):
            file.unlink(missing_ok=True)
