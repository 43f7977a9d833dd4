"""Choice of the painter: pyvista where that works, in a process of its own, else matplotlib."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from threading import Lock
from typing import Protocol

from membrane_rs._arrays import Floats
from membrane_rs.analysis.attitude import Turn
from membrane_rs.plotting.matplotlib import MatplotlibPainter
from membrane_rs.plotting.picture import Image, Subject
from membrane_rs.plotting.process import PaintingError, PaintingProcess
from membrane_rs.plotting.scenery import NONE, Scenery

PROBE_SECONDS = 120.0
"""Time for the first picture, the import of pyvista included."""
TRIES = 2
"""Processes that may fail at one picture, before matplotlib draws it and all others."""


class Painter(Protocol):
    """Draws one subject, the same camera each time."""

    def paint(self, positions: Floats, turn: Turn = 0.0, around: Scenery = NONE) -> Image:
        """Picture (size, size, 3) of positions (N, 3) [m] and what is around, turned as the hub is."""
        ...

    def close(self) -> None:
        """Free what the painter holds."""
        ...


class _Pyvista:
    """Whether pyvista works here, as far as is known, and the process that draws."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._process: PaintingProcess | None = None
        self.works: bool | None = None

    def begin(self) -> None:
        """Start the process, without waiting."""
        if self._process is None and self.works is not False:
            with suppress(OSError):
                self._process = PaintingProcess()
                return
            self.works = False

    def process(self) -> PaintingProcess | None:
        """The process; None where pyvista does not work."""
        with self._lock:
            is_known = self._process is not None and self.works
            self.begin()
            if self._process is not None and not is_known:
                try:
                    self._process.wait(PROBE_SECONDS)
                    self.works = True
                except PaintingError:
                    self._end()
                    self.works = False
            return self._process

    def fail(self, failed: PaintingProcess) -> None:
        """Start another process in place of one that failed."""
        with self._lock:
            if failed is self._process:
                self._end()

    def give_up(self) -> None:
        """Draw no more by pyvista in this program."""
        with self._lock:
            self._end()
            self.works = False

    def forget(self) -> None:
        """Try anew whether it works."""
        with self._lock:
            self._end()
            self.works = None

    def _end(self) -> None:
        if self._process is not None:
            self._process.end()
            self._process = None


_pyvista = _Pyvista()


class ProcessPainter:
    """Draws by pyvista in a process of its own, and by matplotlib once that has failed again and again."""

    def __init__(self, subject: Subject, size: int) -> None:
        self._subject, self._size = subject, size
        self._other: MatplotlibPainter | None = None

    def paint(self, positions: Floats, turn: Turn = 0.0, around: Scenery = NONE) -> Image:
        """Picture (size, size, 3) of positions (N, 3) [m] and what is around, turned as the hub is."""
        for _ in range(TRIES):
            process = None if self._other else _pyvista.process()
            if process is None:
                break
            try:
                return process.paint(self._subject, self._size, (positions, turn, around))
            except PaintingError:
                _pyvista.fail(process)
        if self._other is None:
            _pyvista.give_up()
            self._other = MatplotlibPainter(self._subject, self._size)
        return self._other.paint(positions, turn, around)

    def close(self) -> None:
        """Nothing is held: the process serves the next painter, or ends by itself."""


@contextmanager
def painter(subject: Subject, size: int) -> Iterator[Painter]:
    """The better of the two painters that works here, for square pictures of `size` pixels."""
    artist = ProcessPainter(subject, size)
    try:
        yield artist
    finally:
        artist.close()


def begin_probe() -> None:
    """Start the process that draws, so that it is known whether it works when it is needed."""
    if _pyvista.works is None:
        _pyvista.begin()


def pyvista_works() -> bool:
    """Whether pictures are drawn by pyvista: tried once, in a process of its own, and until that fails repeatedly."""
    if _pyvista.works is None:
        _pyvista.process()
    return bool(_pyvista.works)


def forget_probe() -> None:
    """Try anew whether pyvista works."""
    _pyvista.forget()
