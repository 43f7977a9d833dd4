"""How the hub of a scene turns, as the law says that turns it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from membrane_rs.scene.schedule import Schedule


class Hub(Protocol):
    """A hub that is driven, or that turns freely."""

    @property
    def inertia(self) -> float | None:
        """Moment of inertia of a free hub about z [kg m2]; None: it is driven."""

    @property
    def mass(self) -> float | None:
        """Mass of a hub that is free in six degrees of freedom [kg]; None: it turns about its axis."""

    @property
    def tumble(self) -> float | None:
        """Turns per second of that hub about x at the start [Hz]; None: none."""

    @property
    def schedule(self) -> Schedule | None:
        """Turns per second of a driven hub [Hz], where a schedule gives them."""

    @property
    def torque(self) -> Schedule | None:
        """Torque on a free hub [N m]; None: none."""

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


class HasHub(Protocol):
    """A law."""

    @property
    def hub(self) -> Hub | None:
        """The hub, where the law turns it."""


class Turning(Protocol):
    """What of a scene says how its hub turns."""

    @property
    def laws(self) -> Sequence[HasHub]:
        """All laws."""


class Staged(Turning, Protocol):
    """The same of a scene with stages."""

    @property
    def stages(self) -> Sequence[Any]:
        """The stages."""

    def staged(self, index: int) -> Turning:
        """The scene of one of them."""


def hub_of(scene: Turning) -> Hub | None:
    """The hub of a scene without stages; None where no law turns it."""
    return next((law.hub for law in scene.laws if law.hub is not None), None)


def has_free_hub(scene: Staged) -> bool:
    """Whether the hub of a scene turns freely, in any of its stages."""
    return any(hub.inertia is not None for hub in _hubs_of(scene))


def has_free_body(scene: Staged) -> bool:
    """Whether the hub of a scene moves in six degrees of freedom, in any of its stages."""
    return any(hub.mass is not None for hub in _hubs_of(scene))


def _hubs_of(scene: Staged) -> list[Hub]:
    hubs = map(hub_of, [scene.staged(k) for k in range(len(scene.stages))] or [scene])
    return [hub for hub in hubs if hub is not None]
