"""The turning frame."""

from __future__ import annotations

from typing import Annotated, ClassVar

from membrane_rs._validation import Finite, Unit, validated
from membrane_rs.scene.law import Law, StiffThrough, Surroundings


@validated
class Spin(Law):
    """The hub turns about z, and the scene is computed in the frame that turns with it.

    Omega(t) = 2 pi (frequency + acceleration t).

    Parameters
    ----------
    frequency : float
        Turns per second at the start [Hz]; the sign gives the sense.
    acceleration : float
        Its rate of change [Hz/s].
    """

    kind: ClassVar[str] = "spin"
    stiff_through: ClassVar[StiffThrough] = "law"
    turns_hub: ClassVar[bool] = True
    frequency: Annotated[Finite, Unit("Hz")] = 3.0
    acceleration: Annotated[Finite, Unit("Hz/s")] = 0.0

    def why_idle(self, scene: Surroundings) -> str | None:
        """A hub at rest."""
        return "the hub does not turn" if self.frequency == 0 and self.acceleration == 0 else None

    def step_advice(self, gain: float) -> str:
        """A slower frame or a shorter step."""
        return "the frame turns too fast for the step"
