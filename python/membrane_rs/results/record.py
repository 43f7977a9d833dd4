"""What the outputs of one run share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from membrane_rs._arrays import Floats
from membrane_rs.results.background import Background
from membrane_rs.results.recorded import Measures

Progress = Callable[[str, int, int], None]
"""Called with what is drawn, pictures done, and pictures in all."""


@dataclass(kw_only=True)
class RunData:
    """What of a run is data, in memory or in a folder."""

    request: dict[str, Any] = field(default_factory=dict)
    """What the run was asked for, as summary.json says it."""
    measures: Measures = field(default_factory=Measures)
    """What the history records beside its own columns."""
    summary: dict[str, Any] = field(default_factory=dict)
    """What summary.json says; written again when all outputs have finished."""
    table: dict[str, Floats] = field(default_factory=dict)
    """(samples,) columns of the history, once that is closed."""
    frames: list[tuple[float, str]] = field(default_factory=list)
    """Time [s] of each frame so far and, of one that is written, its file, relative to the folder."""


@dataclass
class Record(RunData):
    """What an output of a run may read, and adds for those after it."""

    path: Path
    """The folder of the run."""
    progress: Progress | None = None
    """Reports pictures as they are drawn."""
    background: Background = field(default_factory=Background)
    """Does what takes longer than a copy, while the core steps."""
    shapes: list[Floats] = field(default_factory=list)
    """(N, 3) positions [m] that must fit into each picture."""
    picture_counts: list[Callable[[], int]] = field(default_factory=list)
    """How many pictures each output will draw, asked before the first is drawn."""
    drawn: int = 0
    """Pictures so far."""

    def tick(self) -> None:
        """Count a picture that is drawn, and report it."""
        self.drawn += 1
        if self.progress is not None:
            self.progress("pictures", self.drawn, sum(count() for count in self.picture_counts))
