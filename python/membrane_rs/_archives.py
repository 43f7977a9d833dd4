"""Numpy archives that others may have written: read array by array, each within bounds that its header states first.

Nothing in them is unpickled. An array that declares more than its member of the archive holds, or than memory may, is
refused before memory is taken for it.
"""

from __future__ import annotations

import math
import zipfile
import zlib
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from membrane_rs._bounds import MOST_NODES
from membrane_rs._files import MOST_BYTES, check_regular

Arrays = dict[str, NDArray[Any]]

MOST_NUMBERS = 6 * MOST_NODES
"""An array of more numbers is not read: a mesh of so many nodes has twice as many triangles, of three corners each."""
MOST_DIMENSIONS = 8
"""An array of more dimensions is not read: neither meshes nor states have them, and numpy has a bound of its own."""
KINDS = "biufcU"
"""Kinds of dtype that are read; a reader refuses those that mean nothing to it by its own words."""
DEFLATE_RATIO = 1100
"""No member that is deflated holds more bytes than so many times its own."""
MOST_HEADER = 4096
"""Bytes of a header of an array: more describe no plain array."""
_SUFFIX = ".npy"


class ArchiveError(ValueError):
    """A numpy archive that cannot be read, and why."""


def read_arrays(path: Path) -> Arrays:
    """All arrays of a numpy archive by name, in this machine's byte order.

    Raises
    ------
    FileNotFoundError
        No such file.
    ArchiveError
        No archive, a damaged one, or one with an array that is larger than it may be; the message names the array.
    """
    try:
        check_regular(path)
        with zipfile.ZipFile(path) as archive:
            members = archive.infolist()
            names = [member.filename for member in members]
            if len(set(names)) < len(names):
                raise ArchiveError("it holds two arrays of one name")
            if sum(member.file_size for member in members) > MOST_BYTES:
                raise ArchiveError(f"its arrays have more than {MOST_BYTES} bytes; a mesh or a state has fewer")
            return {member.filename.removesuffix(_SUFFIX): _array(archive, member) for member in members}
    except (FileNotFoundError, ArchiveError):
        raise
    except OSError as error:
        raise ArchiveError(error.strerror or str(error)) from None
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, ValueError, MemoryError) as error:
        raise ArchiveError(f"{error}" or type(error).__name__) from None


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> NDArray[Any]:
    """One array, whose header is checked first."""
    name = member.filename.removesuffix(_SUFFIX)
    if not member.filename.endswith(_SUFFIX):
        raise ArchiveError(f"{name!r} is no array of numpy")
    if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ArchiveError(f"{name!r} is compressed by another method than numpy's; write it with numpy.savez")
    if member.file_size > DEFLATE_RATIO * member.compress_size + MOST_HEADER:
        raise ArchiveError(f"{name!r} claims {member.file_size} bytes in {member.compress_size}")
    with archive.open(member) as file:
        shape, is_fortran, dtype = _header(file, name)
        if len(shape) > MOST_DIMENSIONS:
            raise ArchiveError(f"{name!r} has the shape {_short(shape)}, {len(shape)} dimensions; give rows of numbers")
        count = math.prod(shape)
        if count > MOST_NUMBERS or any(rows > MOST_NUMBERS for rows in shape):
            raise ArchiveError(
                f"{name!r} has the shape {_short(shape)}; an array of more than {MOST_NUMBERS} numbers is not read"
            )
        size = count * dtype.itemsize
        if file.tell() + size != member.file_size:
            raise ArchiveError(
                f"{name!r} declares the shape {_short(shape)}, {size} bytes, and holds {member.file_size - file.tell()}"
            )
        data = file.read()  # to the end, where the archive's checksum is compared
    array = np.frombuffer(data, dtype).reshape(shape, order="F" if is_fortran else "C")
    return np.array(array, dtype.newbyteorder("="), order="C")


def _header(file: IO[bytes], name: str) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Shape, whether the first index runs fastest, and dtype."""
    try:
        version = np.lib.format.read_magic(file)
        read = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}[version]
        shape, is_fortran, dtype = read(file, max_header_size=MOST_HEADER)
    except (ValueError, KeyError, TypeError, EOFError, RecursionError):
        raise ArchiveError(f"{name!r} has no header of an array; write it with numpy.savez") from None
    if dtype.hasobject or dtype.kind not in KINDS or dtype.shape or not dtype.itemsize:
        raise ArchiveError(f"{name!r} holds {dtype.name}, neither numbers nor text; give numbers")
    if any(rows < 0 for rows in shape):
        raise ArchiveError(f"{name!r} has the shape {_short(shape)}; no number of rows is below 0")
    return shape, is_fortran, dtype


def _short(shape: tuple[int, ...]) -> str:
    """A shape as messages show it."""
    rows = [f"10^{len(str(count)) - 1} ..." if count >= 10**15 else str(count) for count in shape[:4]]
    return f"({', '.join(rows)}{', ...' if len(shape) > 4 else ',' if len(shape) == 1 else ''})"
