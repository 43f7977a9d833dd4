"""Runs in memory for tests of the viewer, with frames of one's own."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
from membrane_rs import Run


class CountedFrames:
    """Frames that count how often each is read."""

    def __init__(self, frames: Sequence[Any], times: Any) -> None:
        self.all, self.times, self.reads = list(frames), np.asarray(times, dtype=float), Counter[int]()

    def __len__(self) -> int:
        return len(self.all)

    def __getitem__(self, index: int) -> Any:
        self.reads[index] += 1
        return self.all[index]


def with_frames(run: Run, frames: Any) -> Any:
    """The same run with other frames, given with their times or as a list."""
    if isinstance(frames, list):
        frames = CountedFrames(frames, run.frames.times[: len(frames)])
    return SimpleNamespace(scene=run.scene, history=run.history, frames=frames)
