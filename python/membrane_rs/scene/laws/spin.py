"""The turning frame."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, ClassVar

from membrane_rs._validation import Finite, Unit, validated
from membrane_rs.scene.law import Law, StiffThrough, Surroundings
from membrane_rs.scene.plausible import FILM, RATES, Doubt, implausible
from membrane_rs.scene.scales import outermost

FASTEST = 300.0
"""Speed of the rim [m/s]: about that at which rotors of strong plastics burst."""
STRETCHED = 0.1
"""Strain by spinning at which films are torn; rho v^2/E is that of a ring of speed v."""
TURNS = (1e-4, 1000.0)
"""In a run: below, the frame hardly moves; a sail is deployed after some tens of turns."""


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

    @property
    def hub_frequency(self) -> float:
        """That at the start."""
        return self.frequency

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """The rim of the flat shape moves more slowly than `FASTEST`, and a film is stretched by less than `STRETCHED`
        as a ring of this speed would be; a run has a number of turns within `TURNS`.
        """
        radius = outermost(scene, with_cords=False)
        end = self.frequency + self.acceleration * scene.run.until
        highest, fastest = max(abs(self.frequency), abs(end)), FASTEST
        if scene.material is not None and scene.mesh is not None:
            tearing = math.sqrt(STRETCHED * scene.material.youngs_modulus / scene.material.density)
            fastest = min(FASTEST, tearing)
        speed = 2.0 * math.pi * highest * radius
        if speed > fastest:
            reason = f"the rim, {radius:.4g} m from the axis, would move at {speed:.4g} m/s; beyond {fastest:.4g} m/s "
            reason += "it is torn" if fastest < FASTEST else "rotors burst"
            most = fastest / (2.0 * math.pi * radius)
            at_start = abs(self.frequency) >= highest
            place, unit = (f"{where}.frequency", "Hz") if at_start else (f"{where}.acceleration (at the end)", "Hz")
            derived = FILM if fastest < FASTEST else ("mesh", "parts")
            yield from implausible(place, highest, unit, reason, most=most, units=RATES, derived_from=derived)
        turns = 0.5 * (abs(self.frequency) + abs(end)) * scene.run.until
        if turns > 0.0:
            reason = f"the hub turns by {turns:.3g} turns in this run"
            least, most = (bound * scene.run.until / turns for bound in TURNS)
            yield from implausible(
                "run.until",
                scene.run.until,
                "s",
                reason,
                least=least,
                most=most,
                units={"ms": 1e-3},
                derived_from=(where,),
            )

    def why_idle(self, scene: Surroundings) -> str | None:
        """A hub at rest."""
        return "the hub does not turn" if self.frequency == 0 and self.acceleration == 0 else None

    def step_advice(self, gain: float) -> str:
        """A slower frame or a shorter step."""
        return "the frame turns too fast for the step"
