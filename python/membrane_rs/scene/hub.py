"""How the hub of a scene turns, as the law says that turns it."""

from __future__ import annotations

from typing import Protocol

from membrane_rs.scene.schedule import Schedule


class Hub(Protocol):
    """A hub that is driven, or that turns freely."""

    @property
    def inertia(self) -> float | None:
        """Moment of inertia of a free hub about z [kg m2]; None: it is driven."""

    @property
    def schedule(self) -> Schedule | None:
        """Turns per second of a driven hub [Hz], where a schedule gives them."""

    @property
    def turning_in_words(self) -> str:
        """How it turns, for messages."""

    def planned_turning(self, time: float) -> float:
        """Turns per second at a time [s], as far as they are known before a run [Hz]: of a free hub those at its start.

        Parameters
        ----------
        time : float
            [s]

        Returns
        -------
        float
            [Hz]
        """

    def torque_impulse(self, start: float, end: float) -> float:
        """Impulse of the torque on a free hub.

        Parameters
        ----------
        start, end : float
            From when to when [s].

        Returns
        -------
        float
            [N m s]
        """
