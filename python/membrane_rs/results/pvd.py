"""frames.pvd: frames and their times, for ParaView. A line for each, before the lines that close the list."""

from __future__ import annotations

import os
from collections.abc import Sequence
from itertools import takewhile
from pathlib import Path
from xml.etree import ElementTree

from membrane_rs._files import check_regular, check_writable, output_errors, path_of, reading_errors, replacing
from membrane_rs._validation import check_text, is_list, number_of, show
from membrane_rs.errors import InputTypeError, MissingFileError, OutputError

PVD = "frames.pvd"
MOST_PVD = 2**26
"""Bytes of a longer list, which is not read: half a million frames have fewer."""

_BEGIN = """<?xml version='1.0' encoding='utf-8'?>
<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">
  <Collection>
"""
_LINE = '    <DataSet timestep="{time!r}" group="" part="0" file={file} />\n'
_END = """  </Collection>
</VTKFile>
"""


class PvdWriter:
    """A list that grows in place: the cost of a frame does not depend on the number of those before it.

    A frame is one write, which replaces the closing lines by its own line and the closing lines. A process that is
    killed, even by SIGKILL, ends before or after such a write, but for one that crosses into another page of the
    system's memory; `read_pvd` then reads all lines that are whole.

    Parameters
    ----------
    path :
        The file.
    frames :
        What the list holds at first: time [s], and file relative to `path`. It is written, whole or not at all, with
        the first call of `append` or `write`.
    """

    def __init__(self, path: Path, frames: Sequence[tuple[float, str]] = ()) -> None:
        self.path = path
        self.frames = list(frames)
        self._end: int | None = None

    def write(self) -> None:
        """Write all, whole or not at all. Raises OutputError."""
        lines = _BEGIN + "".join(_line(*frame) for frame in self.frames)
        content = lines.encode()
        with replacing(self.path) as part:
            part.write_bytes(content + _END.encode())
        self._end = len(content)

    def append(self, time: float, file: str) -> None:
        """Add a frame at `time` [s]. Raises OutputError."""
        self.frames.append((time, file))
        if self._end is None:
            self.write()
            return
        line = _line(time, file).encode()
        with output_errors(self.path):
            check_writable(self.path)
            with self.path.open("r+b", buffering=0) as stream:
                stream.seek(self._end)
                stream.write(line + _END.encode())
        self._end += len(line)


def write_pvd(path: str | Path, frames: Sequence[tuple[float, str]]) -> None:
    """List frames as (time [s], file relative to `path`), whole or not at all.

    Parameters
    ----------
    path : path
        Of the .pvd file.
    frames : sequence of (float, str)
        Times [s] and files, relative to that folder.

    Raises
    ------
    OutputError
        It cannot be written.
    InputError, InputTypeError
        No path, or no list of times and files.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from membrane_rs.results import read_pvd, write_pvd
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_pvd(Path(folder) / "frames.pvd", [(0.0, "a.vtu"), (0.1, "b.vtu")])
    ...     [(time, file.name) for time, file in read_pvd(Path(folder) / "frames.pvd")]
    [(0.0, 'a.vtu'), (0.1, 'b.vtu')]
    """
    if not is_list(frames):
        raise InputTypeError(f"frames = {show(frames)}: must be a list of pairs: a time (s) and the name of a file")
    for k, frame in enumerate(frames):
        if not isinstance(frame, Sequence) or len(frame) != 2 or not isinstance(frame[1], str | os.PathLike):
            raise InputTypeError(f"frames[{k}] = {show(frame)}: must be a time (s) and the name of a file")
        check_text(str(frame[1]), f"frames[{k}]:")
    listed = [(number_of(f"frames[{k}]", time), str(file)) for k, (time, file) in enumerate(frames)]
    PvdWriter(path_of(path), listed).write()


def read_pvd(path: str | Path) -> list[tuple[float, Path]]:
    """Times [s] and paths of the frames that a PVD file lists.

    Where a killed process left the end unfinished, or a run writes there meanwhile, the lines that are whole.

    Parameters
    ----------
    path : path
        Of a .pvd file.

    Returns
    -------
    list of (float, path)
        Times [s] and files.

    Raises
    ------
    MissingFileError
        No such file.
    OutputError
        What is no PVD file.
    InputError, InputTypeError
        No path.

    Examples
    --------
    See `write_pvd`.

    >>> from membrane_rs.results import read_pvd
    >>> read_pvd("nowhere.pvd")
    Traceback (most recent call last):
    membrane_rs.errors.MissingFileError: ...
    """
    path = path_of(path)
    with reading_errors(path, "PVD file"):
        if path.is_dir():
            path /= PVD
        if not path.is_file():
            raise MissingFileError(f"no frames.pvd at {path}; name a run's folder that holds frames")
        check_regular(path, MOST_PVD)
        content = path.read_bytes()[:MOST_PVD]
        try:
            root = ElementTree.fromstring(content)
        except ElementTree.ParseError:
            if not content.startswith(_BEGIN.encode()):
                raise
            # A line that comes in replaces the end, and may be read in part, or with a part of the old end.
            lines = content[len(_BEGIN) :].split(b"\n")
            whole = list(takewhile(lambda line: line.startswith(b"    <DataSet ") and line.endswith(b" />"), lines))
            root = ElementTree.fromstring(b"\n".join([_BEGIN.encode(), *whole, _END.encode()]))
        if root.tag != "VTKFile":
            raise OutputError(f"{path} is no PVD file: it begins with {root.tag!r}, not 'VTKFile'; run the scene again")
        entries = root.iter("DataSet")
        return [(float(entry.attrib["timestep"]), path.parent / entry.attrib["file"]) for entry in entries]


def _line(time: float, file: str) -> str:
    from xml.sax.saxutils import quoteattr  # slow to import

    return _LINE.format(time=float(time), file=quoteattr(file))
