"""Friction on all motion."""

from __future__ import annotations

from typing import Annotated, ClassVar

from membrane_rs._validation import NonNegative, Unit, validated
from membrane_rs.scene.law import Law, StiffThrough, Surroundings


@validated
class MassDamping(Law):
    """Friction against the turning frame, F = -rate m v: for bringing a scene to rest.

    Parameters
    ----------
    rate : float
        [1/s], 0 or above.
    """

    kind: ClassVar[str] = "mass_damping"
    stiff_through: ClassVar[StiffThrough] = "law"
    acts_while_relaxing: ClassVar[bool] = False
    rate: Annotated[NonNegative, Unit("1/s")]

    def why_idle(self, scene: Surroundings) -> str | None:
        """Friction of no strength."""
        return "its rate is 0" if self.rate == 0 else None

    def step_advice(self, gain: float) -> str:
        """A smaller rate."""
        return f"a rate of {self.rate / gain:.3g} 1/s or less would take it out of the limit"
