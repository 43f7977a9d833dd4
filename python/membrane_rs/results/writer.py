"""What an output of a run is: the files that are its own, and what it does when."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from membrane_rs.results.record import Record
from membrane_rs.simulation.stepper import Stepper


class Writer:
    """An output of a run, for one run. It overrides the calls at which it has something to do.

    Each call raises OutputError where a file cannot be written; `finish` is called for all, whatever failed.
    """

    own_files: ClassVar[Sequence[str]] = ()
    """Glob patterns, relative to the run's folder, of all that it may write, and so of what `overwrite` may remove."""
    draws: ClassVar[bool] = False
    """Whether it is left out where no pictures are wanted."""
    option: ClassVar[str | None] = None
    """The field of the run's `Request` that asks for it; None where it needs none."""
    is_vital: ClassVar[bool] = False
    """Whether its failure is raised even where the run had ended by an interruption or another error."""

    def start(self, sim: Stepper, record: Record) -> None:
        """Before the first step, in a folder that holds nothing of an earlier run."""

    def resume(self, sim: Stepper, record: Record) -> None:
        """In place of `start`, where a run goes on from a checkpoint: the folder holds what was written before and, if
        the run was killed, after that. What this output wrote after `sim.time` is to be removed, since it is written
        again. By default as `start`.
        """
        self.start(sim, record)

    def sync(self) -> None:
        """Bring what is written so far onto the disk; in the background before each checkpoint, and at the end."""

    def sample(self, sim: Stepper) -> None:
        """At each instant of the history; after an error once more, at the last good state, which may be an old one."""

    def frame(self, sim: Stepper) -> None:
        """At each instant at which a shape is kept; each is also a sample."""

    def finish(self, sim: Stepper, error: BaseException | None) -> None:
        """At the end, with what ended the run or made an output before this one fail."""
