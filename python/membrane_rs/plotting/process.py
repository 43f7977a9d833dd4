"""Painting by pyvista in a process of its own: a crash of VTK ends that process, and nothing of a run.

The process tries a picture first, since VTK without working graphics libraries may end the process that asks. Requests
and answers are pickled, one after the other, through its standard input and output. It ends by itself when its input
is closed, or when nothing was asked of it for a while.
"""

from __future__ import annotations

import atexit
import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import IO, Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.analysis.attitude import Turn
from membrane_rs.plotting.picture import Image, Subject
from membrane_rs.plotting.scenery import Scenery

IDLE_SECONDS = 60.0
"""The process ends when nothing was asked of it for so long."""
ANSWER_SECONDS = 120.0
"""A process that takes longer for an answer is ended."""
COMMAND = [sys.executable, "-c", "from membrane_rs.plotting.process import serve; serve()"]


class PaintingError(Exception):
    """The process ended, or pyvista failed in it."""


class PaintingProcess:
    """A process that paints by pyvista; the constructor does not wait for it. Raises OSError where none can start."""

    def __init__(self) -> None:
        paths = os.pathsep.join(path for path in sys.path if path)
        self._lock = threading.Lock()
        self._shown: tuple[Subject, int] | None = None
        # In a session of its own, so that Ctrl-C is not taken for graphics that do not work.
        self._process = subprocess.Popen(
            COMMAND,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": paths},
            start_new_session=True,
        )
        atexit.register(self.end)

    def wait(self, seconds: float) -> None:
        """Wait until its first picture is drawn. Raises PaintingError where it fails."""
        self._answer(seconds)

    def paint(self, subject: Subject, size: int, shown: tuple[Floats, Turn, Scenery]) -> Image:
        """A picture of a subject, one at a time: of what `Painter.paint` takes. Raises PaintingError."""
        with self._lock:
            if self._shown is None or self._shown[0] is not subject or self._shown[1] != size:
                self._ask(("begin", subject, size))
                self._shown = (subject, size)
            picture: Image = self._ask(("paint", *shown))
            return picture

    def end(self) -> None:
        """End the process."""
        atexit.unregister(self.end)
        with suppress(OSError):
            self._process.kill()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            with suppress(OSError):
                pipe.close()
        self._process.wait()

    def _ask(self, request: tuple[Any, ...]) -> Any:
        assert self._process.stdin is not None
        try:
            pickle.dump(request, self._process.stdin)
            self._process.stdin.flush()
        except OSError as error:
            raise PaintingError(f"the process that draws has ended: {error}") from None
        return self._answer(ANSWER_SECONDS)

    def _answer(self, seconds: float) -> Any:
        assert self._process.stdout is not None
        with _killed_after(self._process, seconds):
            try:
                is_fine, value = pickle.load(self._process.stdout)
            except (EOFError, OSError, ValueError, pickle.UnpicklingError):
                raise PaintingError("the process that draws has ended") from None
        if not is_fine:
            raise PaintingError(value)
        return value


@contextmanager
def _killed_after(process: subprocess.Popen[bytes], seconds: float) -> Iterator[None]:
    timer = threading.Timer(seconds, process.kill)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def serve() -> None:
    """Answer requests from standard input, in the process that draws."""
    source, sink = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print is no answer
    painter: Any = None

    def first() -> None:
        import pyvista

        plotter: Any = pyvista.Plotter(off_screen=True, window_size=[16, 16])
        plotter.add_mesh(pyvista.Sphere())
        if plotter.screenshot(return_img=True).std() <= 1:
            raise RuntimeError("the first picture is blank")
        plotter.close()

    def answer(request: tuple[Any, ...]) -> Any:
        nonlocal painter
        from membrane_rs.plotting.pyvista import PyvistaPainter

        kind, *values = request
        if kind == "begin":
            if painter is not None:
                painter.close()
            painter = PyvistaPainter(*values)
            return None
        return np.ascontiguousarray(painter.paint(*values))

    _reply(sink, first)
    while True:
        idle = threading.Timer(IDLE_SECONDS, os._exit, (0,))
        idle.daemon = True
        idle.start()
        try:
            request = pickle.load(source)
        except (EOFError, OSError, pickle.UnpicklingError):
            # Without the end of the interpreter, in which VTK may crash as well.
            os._exit(0)
        idle.cancel()
        _reply(sink, lambda request=request: answer(request))


def _reply(sink: IO[bytes], work: Any) -> None:
    """Send what `work` returns, or the error that it raises, as (is_fine, value)."""
    try:
        reply = (True, work())
    except Exception as error:  # noqa: BLE001 - the caller draws by other means, whatever it was
        reply = (False, f"{type(error).__name__}: {error}")
    try:
        pickle.dump(reply, sink)
        sink.flush()
    except OSError:
        os._exit(0)
