"""Files that are whole or absent: written beside their place, then moved into it. Bounds on those that are read."""

from __future__ import annotations

import errno
import mimetypes
import os
import stat
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

from membrane_rs.errors import InputError, InputTypeError, MembraneError, OutputError

PART = ".part"
MOST_BYTES = 2**32
"""A larger file is not read."""
_PART_BYTES = 2**20


_SPECIAL = "it is a pipe, a socket or a device, no regular file"


def path_of(value: object, name: str = "path") -> Path:
    """A path from a text or a path.

    Raises InputTypeError for anything else, an empty text and a NUL, by `name`; InputError for a character that the
    file system's encoding lacks, and for a name that is too long for it.
    """
    if not isinstance(value, str | os.PathLike) or not isinstance(found := os.fspath(value), str):
        raise InputTypeError(f"{name} = {value!r:.60}: must be a path, as a text or a pathlib.Path")
    if not found or "\0" in found:
        raise InputTypeError(f"{name} = {found!r:.60}: must be the name of a file or a folder, without a NUL")
    try:
        os.fsencode(found)
    except UnicodeEncodeError as error:
        raise InputError(
            f"{name} = {found!a:.60}: the file system's encoding, {error.encoding}, has no character "
            f"{found[error.start]!a}; give another name, or set PYTHONUTF8=1 in the environment"
        ) from None
    path = Path(found)
    try:
        path.lstat()
    except OSError as error:
        if error.errno == errno.ENAMETOOLONG:
            raise InputError(f"{name} = {found!r:.60}...: is too long for a name of a file; shorten it") from None
    return path


def made_folder(folder: object, name: str = "folder") -> Path:
    """A folder, which is made with those above it where there is none. Raises as `path_of`, and OutputError."""
    path = path_of(folder, name)
    with output_errors(path):
        path.mkdir(parents=True, exist_ok=True)
    return path


def check_folder(path: Path) -> None:
    """Refuse a folder that cannot be made or written, before there is anything to write. Raises OutputError."""
    whole = path.absolute()
    there = next((place for place in (whole, *whole.parents) if os.path.lexists(place)), whole)
    with output_errors(path):
        if not there.is_dir():
            raise NotADirectoryError(errno.ENOTDIR, f"{there} is no folder")
        if not os.access(there, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, f"{there} cannot be written")


def check_regular(path: Path, most: int = MOST_BYTES) -> None:
    """Refuse what is no regular file, or one of more than `most` bytes, before it is opened.

    A pipe or a device may never end. Raises OSError, whose `strerror` is the reason; FileNotFoundError without a file.
    """
    found = path.stat()
    if stat.S_ISDIR(found.st_mode):
        raise IsADirectoryError(errno.EISDIR, "it is a folder, no file", str(path))
    if not stat.S_ISREG(found.st_mode):
        raise OSError(errno.EINVAL, _SPECIAL, str(path))
    if found.st_size > most:
        raise OSError(errno.EFBIG, f"it has {found.st_size} bytes, and at most {most} are read", str(path))


def check_writable(path: Path) -> None:
    """Refuse to write where there is a pipe, a socket or a device: it would be replaced, or never take what is written.

    A file that is not there, and a folder, are left to the system. Raises OutputError.
    """
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise OutputError(f"cannot write {path}: {_SPECIAL}; choose another name, or remove it")


def check_unlinked(folder: Path, files: Iterable[Path]) -> None:
    """Refuse to remove files that a link in `folder` leads to: what it leads to is not of this folder alone.

    The folder itself may be a link. Raises OutputError, which names the link.
    """
    for inner in dict.fromkeys(file.parent for file in files):
        for place in (inner, *inner.parents):
            if place == folder:
                break
            if place.is_symlink():
                raise OutputError(
                    f"cannot overwrite {folder}: {place} is a link to {place.readlink()}, and files behind a link are "
                    "not removed; remove the link, or choose another folder"
                )


def check_kind_of_file(path: Path, kind: str, words: str, ending: str) -> None:
    """Refuse a file whose name says that it is of another kind, such as "image/png". Raises InputError."""
    said = mimetypes.guess_type(path.name)[0]
    if said not in (None, kind):
        raise InputError(f"{path}: {words}, and this name says {said}; give a name that ends in {ending}")


def read_text(path: Path, most: int = MOST_BYTES) -> str:
    """The UTF-8 text of a regular file, without a byte order mark.

    Raises OSError as `check_regular`, and UnicodeDecodeError.
    """
    check_regular(path, most)
    content = bytearray()
    with path.open("rb") as file:
        # By parts: memory is taken for what is there, not for the bound, and a file that grows ends at it.
        while len(content) <= most and (part := file.read(_PART_BYTES)):
            content += part
    return content[:most].decode("utf-8-sig")


@contextmanager
def reading_errors(path: Path, what: str) -> Iterator[None]:
    """Turn whatever goes wrong while a result at `path` is read into an OutputError: path, reason and remedy.

    What reads XML, CSV or VTU meets a damaged file with errors of every kind.
    """
    try:
        yield
    except MembraneError:
        raise
    except Exception as error:
        nameless = "it does not fit into memory" if isinstance(error, MemoryError) else "its content cannot be read"
        reason = (error.strerror if isinstance(error, OSError) else None) or str(error) or nameless
        text = f"{path} is no {what}, or damaged: {' '.join(reason.split())}; run the scene again, or name another file"
        raise OutputError(text) from error


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
    if the power fails. Raises OutputError where the system refuses, and for what is no regular file.
    """
    with output_errors(path):
        part = path.with_name(path.name + PART)
        check_writable(path)
        check_writable(part)
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
