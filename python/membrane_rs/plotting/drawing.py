"""Pictures of a run, drawn when it has ended."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.errors import UnstableError
from membrane_rs.plotting.painter import begin_probe, pyvista_works
from membrane_rs.plotting.picture import Subject
from membrane_rs.results.record import Record
from membrane_rs.results.vtk import read_frame
from membrane_rs.results.writer import Writer
from membrane_rs.simulation.stepper import Stepper

SHAPES = 24
"""So many frames of a run, and one more, must fit into its pictures."""


class Drawing(Writer):
    """An output that draws, if anything, at the end.

    A run that went unstable is drawn as far as it came. After an interruption, or any other error, nothing is drawn, so
    that the program stops at once.
    """

    draws = True

    def start(self, sim: Stepper, record: Record) -> None:
        """Keep what the outputs share."""
        self.record = record
        record.picture_counts.append(self.count)
        begin_probe()

    def finish(self, sim: Stepper, error: BaseException | None) -> None:
        """Draw."""
        if error is None or isinstance(error, UnstableError):
            self.draw(sim)
            self.record.summary["pictures"] = "pyvista" if pyvista_works() else "matplotlib"

    def count(self) -> int:
        """How many pictures of a membrane it will draw; each calls `record.tick`."""
        return 0

    def draw(self, sim: Stepper) -> None:
        """Draw all. Raises OutputError."""

    def subject(self, sim: Stepper) -> Subject:
        """What all pictures of the run show, with one camera."""
        return Subject.of(sim, [*self.record.shapes, *self.some_shapes(self.record.frames), sim.positions])

    def some_shapes(self, frames: Sequence[tuple[float, str]]) -> list[Floats]:
        """Those of about `SHAPES` of some frames, (N, 3) [m] each."""
        some = frames[:: max(1, len(frames) // SHAPES)]
        return [read_frame(self.record.path / file) for _, file in some]

    def first_shape(self, sim: Stepper) -> Floats:
        """(N, 3) positions of the first shape that is known [m]."""
        frames = self.record.frames
        return read_frame(self.record.path / frames[0][1]) if frames else sim.positions


def spread(times: Sequence[float] | Floats, count: int) -> list[int]:
    """Indices of so many instants [s], or fewer, evenly spread from the first to the last one, both among them."""
    known = np.asarray(times, dtype=np.float64)
    wanted = np.linspace(known[0], known[-1], count) if count > 1 else known[-1:]
    return sorted({int(np.abs(known - time).argmin()) for time in wanted})


RIGHT = 0.05
"""Share of the least step between times by which a time in a caption may be off."""


def decimals(times: Sequence[float], least: int, off: float = np.inf) -> int:
    """Decimals by which all times differ [s], `least` or more; none is off by more than a share `off` of their step."""
    step = float(np.diff(np.unique(times)).min(initial=np.inf))
    for n in range(least, 12):
        shown = [float(f"{time:.{n}f}") for time in times]
        error = max((abs(one - other) for one, other in zip(shown, times, strict=True)), default=0.0)
        if len(set(shown)) == len(times) and (off == np.inf or error <= off * step):
            return n
    return 12
