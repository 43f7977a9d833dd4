"""Files that are whole or absent: written beside their place, then moved into it."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Iterator
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
def replacing(path: Path) -> Iterator[Path]:
    """Give a temporary path to write to; move it to `path` on success, delete it on any error.

    A reader sees the old file or the new one, never half of one, even if the process is killed.
    Raises OutputError where the system refuses.
    """
    part = path.with_name(path.name + PART)
    with output_errors(path):
        try:
            yield part
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write `text` as UTF-8, whole or not at all. Raises OutputError."""
    with replacing(path) as part:
        part.write_text(text, encoding="utf-8")
