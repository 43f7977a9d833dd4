"""Observers of a run."""

from __future__ import annotations

from typing import Protocol, TypeVar

from membrane_rs.simulation.motion import Motion

Seen_contra = TypeVar("Seen_contra", bound=Motion, contravariant=True)
"""What an observer reads: a `Motion`, or a class that derives from it."""


class Observer(Protocol[Seen_contra]):
    """Reads a motion at chosen instants of a run.

    Examples
    --------
    >>> from membrane_rs import Simulation, scenes
    >>> class Lowest:
    ...     def start(self, sim): self.z = []
    ...     def sample(self, sim): self.z.append(float(sim.positions[:, 2].min()))
    ...     def frame(self, sim): pass
    ...     def finish(self, sim, error): pass
    >>> lowest = Lowest()
    >>> Simulation(scenes.load("hanging-strip")).run(0.02, 2, samples=[0.0, 0.01, 0.02], observers=[lowest])
    >>> len(lowest.z)
    3
    """

    def start(self, sim: Seen_contra, /) -> None:
        """Called before the first step.

        Parameters
        ----------
        sim : Stepper
            That which runs.
        """

    def sample(self, sim: Seen_contra, /) -> None:
        """Called at each instant of the history.

        Parameters
        ----------
        sim : Stepper
            At the time of a sample.
        """

    def frame(self, sim: Seen_contra, /) -> None:
        """Called at each instant at which a shape is kept; each is also a sample.

        Parameters
        ----------
        sim : Stepper
            At the time of a frame.
        """

    def finish(self, sim: Seen_contra, error: BaseException | None, /) -> None:
        """Called at the end, whatever ended the run.

        Parameters
        ----------
        sim : Stepper
            At the end.
        error : exception or None
            What ended the run early.
        """
