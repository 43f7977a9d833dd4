"""Friction on all motion."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar

from membrane_rs._validation import NonNegative, Unit, validated
from membrane_rs.scene.law import Law, StiffThrough, Surroundings
from membrane_rs.scene.plausible import FILM, Doubt, implausible
from membrane_rs.scene.scales import first_frequency

STRONGEST = 10.0
"""Rate over the frequency of the longest wave of tension: the friction that brings a scene to rest is far below it."""


@validated
class MassDamping(Law):
    """Friction against the turning frame, F = -rate m v: for bringing a scene to rest. Its reaction acts on a free hub.

    Parameters
    ----------
    rate : float
        [1/s], 0 or above.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import MassDamping
    >>> MassDamping(rate=100.0).rate
    100.0
    """

    kind: ClassVar[str] = "mass_damping"
    stiff_through: ClassVar[StiffThrough] = "law"
    acts_while_relaxing: ClassVar[bool] = False
    rate: Annotated[NonNegative, Unit("1/s")]

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """From twice the lowest frequency of tension on all of its vibrations creep, and far beyond nothing moves."""
        most = STRONGEST * first_frequency(scene)
        reason = f"velocities decay within {1.0 / self.rate if self.rate else 0.0:.2g} s, and nothing moves; the "
        reason += f"slowest wave of tension has {most / STRONGEST:.3g} rad/s"
        yield from implausible(f"{where}.rate", self.rate, "1/s", reason, most=most, derived_from=(*FILM, "parts"))

    def why_idle(self, scene: Surroundings) -> str | None:
        """Friction of no strength."""
        return "its rate is 0" if self.rate == 0 else None

    def step_advice(self, gain: float) -> str:
        """A smaller rate."""
        return f"a rate of {self.rate / gain:.3g} 1/s or less would take it out of the limit"
