"""What looks on while a scene runs."""

from __future__ import annotations

from typing import Protocol, TypeVar

from membrane_rs.simulation.motion import Motion

Seen_contra = TypeVar("Seen_contra", bound=Motion, contravariant=True)
"""What an observer asks to be shown: a `Motion`, or more."""


class Observer(Protocol[Seen_contra]):
    """Looks on while a scene runs."""

    def start(self, sim: Seen_contra, /) -> None:
        """Called before the first step."""

    def sample(self, sim: Seen_contra, /) -> None:
        """Called at each instant of the history."""

    def frame(self, sim: Seen_contra, /) -> None:
        """Called at each instant at which a shape is kept; each is also a sample."""

    def finish(self, sim: Seen_contra, error: BaseException | None, /) -> None:
        """Called at the end, whatever ended the run."""
