"""What a viewer reads of a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from membrane_rs._arrays import Floats
from membrane_rs.analysis.attitude import Turn
from membrane_rs.plotting.fields import FieldFrame
from membrane_rs.plotting.stage_marks import stage_starts
from membrane_rs.scene import Scene


class ViewedFrame(FieldFrame, Protocol):
    """A frame of a run."""

    @property
    def time(self) -> float:
        """[s]"""

    @property
    def turn(self) -> Turn:
        """How the hub has turned: the angle about z [rad], or a quaternion."""

    @property
    def positions(self) -> Floats:
        """(N, 3) [m], in the frame that turns with the hub."""


class ViewedFrames(Protocol):
    """The frames of a run, in the order of their times, which may be read from disk one at a time."""

    def __len__(self) -> int:
        """How many."""

    def __getitem__(self, index: int, /) -> ViewedFrame:
        """One of them."""

    @property
    def times(self) -> Floats:
        """(k,) [s]"""


class ViewedRun(Protocol):
    """A run, in memory or in a folder."""

    @property
    def scene(self) -> Scene:
        """The scene."""

    @property
    def frames(self) -> ViewedFrames:
        """Its shapes."""

    @property
    def history(self) -> Mapping[str, Floats]:
        """Its columns, among them "time" [s], and "stage" where it has stages."""


@dataclass(frozen=True)
class ViewedStage:
    """A stage of a run that has begun."""

    name: str
    start: float
    """Time [s]."""


def stages_of(run: ViewedRun) -> list[ViewedStage]:
    """The stages that a run has reached; none for a scene without."""
    names = [stage.name for stage in run.scene.stages]
    return [ViewedStage(names[index], start) for index, start in stage_starts(run.history) if index < len(names)]
