"""One run in a folder at a time: a lock of the operating system, which ends with the process that holds it."""

from __future__ import annotations

import os
import socket
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from membrane_rs._files import check_writable, output_errors
from membrane_rs.errors import OutputError

if TYPE_CHECKING:
    from filelock import FileLock

LOCK = ".membrane_rs.lock"
"""The file that is locked, in the folder. A process that was killed leaves it behind, unlocked."""
SECONDS = 1.0
"""For so long a run waits for the lock: readers that ask whether it is held hold it for an instant."""


class FolderLock:
    """The lock of a run's folder.

    Parameters
    ----------
    folder :
        The folder, which is there when the lock is taken.
    """

    def __init__(self, folder: Path) -> None:
        self._folder, self._path = folder, folder / LOCK
        self._lock = _lock(self._path)
        self._identity: tuple[int, int] | None = None
        self._folder_identity: tuple[int, int] | None = None

    @property
    def is_held(self) -> bool:
        """Whether this object holds the lock."""
        return self._lock.is_locked

    def acquire(self) -> bool:
        """Take the lock; False where another run holds it.

        Raises OutputError where the folder's file system has no locks.
        """
        from filelock import Timeout

        with output_errors(self._path):
            check_writable(self._path)
            try:
                self._lock.acquire(timeout=SECONDS, poll_interval=0.02)
            except Timeout:
                return False
            self._identity, self._folder_identity = _identity(self._path), _identity(self._folder)
        return True

    def check(self) -> None:
        """Raise OutputError where the folder was removed, replaced or taken by another run."""
        if self._identity is None or _identity(self._path) == self._identity:
            return
        if not self._folder.is_dir():
            reason = "the folder was removed or renamed"
        elif self._path.exists() or _identity(self._folder) != self._folder_identity:
            reason = "the folder was replaced, or taken by another run,"
        else:
            reason = f"its file {LOCK}, which keeps other runs out, was removed"
        raise OutputError(
            f"cannot write into {self._folder}: {reason} while this run went on; choose a folder of its own for each "
            "run"
        )

    def release(self) -> None:
        """Give the lock back, and remove its file while it is held: one that another run has made since stays."""
        try:
            if self._identity is not None and _identity(self._path) == self._identity:
                with suppress(OSError):  # Windows removes no open file
                    self._path.unlink()
        finally:
            self._identity = None
            self._lock.release()


def is_locked(folder: Path) -> bool:
    """Whether a run holds the lock of `folder`, in this process or another, and so goes on.

    True where this user may not ask, since the file belongs to another one.
    """
    path = folder / LOCK
    if not path.is_file():
        return False
    from filelock import Timeout

    lock = _lock(path)
    try:
        lock.acquire(blocking=False)
    except (Timeout, PermissionError):
        return True
    except OSError:
        return False
    lock.release()
    return False


def this_process() -> dict[str, Any]:
    """What names this process in summary.json: pid, host, and the time now."""
    now = datetime.now().astimezone().isoformat(timespec="seconds")
    return {"pid": os.getpid(), "host": socket.gethostname(), "start": now}


def _lock(path: Path) -> FileLock:
    from filelock import FileLock  # slow to import

    # Not one for each thread: the thread that ends a run may be another than the one that began it.
    return FileLock(path, thread_local=False)


def _identity(path: Path) -> tuple[int, int] | None:
    """Device and number of a file, which no other has while it is open; None where there is none."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_dev, found.st_ino
