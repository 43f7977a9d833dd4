"""Choice of the painter: pyvista where that works, else matplotlib."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from typing import Protocol

from membrane_rs._arrays import Floats
from membrane_rs.plotting.matplotlib import MatplotlibPainter
from membrane_rs.plotting.picture import Image, Subject
from membrane_rs.plotting.pyvista import PyvistaPainter

PROBE_SECONDS = 120.0


class Painter(Protocol):
    """Draws one subject, the same camera each time."""

    def paint(self, positions: Floats, hub_angle: float = 0.0) -> Image:
        """Picture (size, size, 3) of positions (N, 3) [m], turned about z by `hub_angle` [rad]."""
        ...

    def close(self) -> None:
        """Free what the painter holds."""
        ...


@contextmanager
def painter(subject: Subject, size: int) -> Iterator[Painter]:
    """The better of the two painters that works here, for square pictures of `size` pixels."""
    artist = PyvistaPainter(subject, size) if pyvista_works() else MatplotlibPainter(subject, size)
    try:
        yield artist
    finally:
        artist.close()


def begin_probe() -> None:
    """Start to find out what `pyvista_works` will ask, so that the answer is there when it is needed."""
    if _begun or pyvista_works.cache_info().currsize:
        return
    code = (
        "import pyvista as p; q = p.Plotter(off_screen=True, window_size=(16, 16)); q.add_mesh(p.Sphere());"
        "raise SystemExit(0 if q.screenshot(return_img=True).std() > 1 else 1)"
    )
    nowhere = subprocess.DEVNULL
    with suppress(OSError):
        # In a session of its own, so that Ctrl-C is not taken for graphics that do not work.
        _begun.append(
            subprocess.Popen(
                [sys.executable, "-c", code], stdin=nowhere, stdout=nowhere, stderr=nowhere, start_new_session=True
            )
        )


@cache
def pyvista_works() -> bool:
    """Whether a picture can be rendered off-screen.

    Tried once, in a process of its own: VTK without working graphics libraries may end the process that asks.
    """
    begin_probe()
    if not _begun:
        return False
    probe = _begun.pop()
    try:
        return probe.wait(PROBE_SECONDS) == 0
    except subprocess.TimeoutExpired:
        probe.kill()
        probe.wait()
        return False


_begun: list[subprocess.Popen[bytes]] = []
"""The probe under way, if there is one."""
