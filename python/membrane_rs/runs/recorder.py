"""What keeps a run: in a folder, or in memory."""

from __future__ import annotations

from membrane_rs.results.recorded import Measures
from membrane_rs.runs.request import Request
from membrane_rs.simulation.stepper import Stepper


class Recorder:
    """An observer that keeps a run as a whole, from before its start is relaxed to what ended it."""

    @property
    def is_resumed(self) -> bool:
        """Whether it goes on with an earlier run."""
        return False

    def asked(self, request: Request) -> Request:
        """A request with what is to be kept."""
        return request

    def prepare(self, sim: Stepper, request: Request, measures: Measures | None = None) -> None:
        """Before the start is relaxed; with the measures that the history is to record."""

    def start(self, sim: Stepper) -> None:
        """Before the first step."""

    def sample(self, sim: Stepper) -> None:
        """At each instant of the history."""

    def frame(self, sim: Stepper) -> None:
        """At each instant at which a shape is kept; each is also a sample."""

    def between(self, sim: Stepper) -> None:
        """At each output, and about every 0.1 s of wall time."""

    def finish(self, sim: Stepper, error: BaseException | None) -> None:
        """At the end, with what ended the run; also where that was before its first step."""
