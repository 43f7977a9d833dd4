"""Observers of a run."""

from __future__ import annotations

from typing import Protocol, TypeVar

from membrane_rs.simulation.motion import Motion

Seen_contra = TypeVar("Seen_contra", bound=Motion, contravariant=True)
"""What an observer reads: a `Motion`, or a class that derives from it."""


class Observer(Protocol[Seen_contra]):
    """Reads a motion at chosen instants of a run."""

    def start(self, sim: Seen_contra, /) -> None:
        """Called before the first step."""

    def sample(self, sim: Seen_contra, /) -> None:
        """Called at each instant of the history."""

    def frame(self, sim: Seen_contra, /) -> None:
        """Called at each instant at which a shape is kept; each is also a sample."""

    def finish(self, sim: Seen_contra, error: BaseException | None, /) -> None:
        """Called at the end, whatever ended the run."""
