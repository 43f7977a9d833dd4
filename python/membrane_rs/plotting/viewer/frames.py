"""Frames of a run, kept while they are shown again and again, and read where they are not."""

from __future__ import annotations

from collections import OrderedDict

import numpy as np

from membrane_rs.plotting.viewer.source import ViewedFrame, ViewedFrames

MOST_BYTES = 256e6
"""Of the frames that are kept."""


class KeptFrames:
    """The frames that were read last, so many as fit into `MOST_BYTES`, and two at least."""

    def __init__(self, frames: ViewedFrames) -> None:
        self._frames = frames
        self._kept: OrderedDict[int, ViewedFrame] = OrderedDict()
        self._most = 2

    def __len__(self) -> int:
        return len(self._frames)

    def __getitem__(self, index: int) -> ViewedFrame:
        if index not in self._kept:
            frame = self._frames[index]
            self._most = max(2, int(MOST_BYTES // max(1, _bytes(frame))))
            self._kept[index] = frame
            while len(self._kept) > self._most:
                self._kept.popitem(last=False)
        self._kept.move_to_end(index)
        return self._kept[index]

    def spread(self, count: int) -> list[int]:
        """Indices of so many frames evenly spread over the run, the first and the last among them."""
        picks = np.linspace(0, len(self) - 1, min(count, len(self)))
        return [int(k) for k in np.unique(picks.round().astype(int))]


def _bytes(frame: ViewedFrame) -> int:
    """What a frame with all its values takes, about."""
    numbers = 9 * len(frame.positions) + 12 * len(frame.triangles) + 6 * len(frame.lines)
    return 8 * numbers
