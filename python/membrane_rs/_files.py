"""Files that are whole or absent: written beside their place, then moved into it."""

from __future__ import annotations

import os
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

from membrane_rs.errors import OutputError

PART = ".part"
BAD_ARCHIVE = (
    OSError,
    ValueError,
    EOFError,
    AttributeError,
    TypeError,
    RuntimeError,
    zipfile.BadZipFile,
    zlib.error,
)
"""What numpy and zipfile raise on a damaged archive, or on a file that is none."""


@contextmanager
def output_errors(path: Path) -> Iterator[None]:
    """Turn the system's error while `path` is written into an OutputError: path, reason and remedy."""
    try:
        yield
    except OutputError:
        raise
    except OSError as error:
        reason = error.strerror or str(error)
        raise OutputError(
            f"cannot write {path}: {reason}; choose a folder that can be written, on a disk with free space"
        ) from error


@contextmanager
def replacing(path: Path, *, synced: bool = False) -> Iterator[Path]:
    """Give a temporary path to write to; move it to `path` on success, delete it on any error.

    A reader sees the old file or the new one, never half of one, even if the process is killed; with `synced`, even
    if the power fails. Raises OutputError where the system refuses.
    """
    part = path.with_name(path.name + PART)
    with output_errors(path):
        try:
            yield part
            if synced:
                sync(part)
            part.replace(path)
            if synced:
                sync(path.parent)
        finally:
            part.unlink(missing_ok=True)


def sync(path: Path) -> None:
    """Bring a file, or the list of files of a folder, from the system's memory onto the disk. Raises OutputError."""
    with output_errors(path):
        if path.is_dir() and os.name == "nt":
            return  # Windows opens no folder
        descriptor = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def sync_all(paths: Sequence[Path]) -> None:
    """Bring many files onto the disk, eight at a time, which disks do together. Raises OutputError."""
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(sync, paths))


def write_text(path: Path, text: str, *, synced: bool = False) -> None:
    """Write `text` as UTF-8, whole or not at all; with `synced`, onto the disk. Raises OutputError."""
    with replacing(path, synced=synced) as part:
        part.write_text(text, encoding="utf-8")
