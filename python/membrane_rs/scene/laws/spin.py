"""The turning frame."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Any, ClassVar

from membrane_rs._validation import Finite, Unit, validated
from membrane_rs.errors import InputError
from membrane_rs.scene.law import Law, StiffThrough, Surroundings
from membrane_rs.scene.plausible import FILM, RATES, Doubt, implausible
from membrane_rs.scene.scales import outermost
from membrane_rs.scene.schedule import Schedule

FREQUENCY = 3.0
"""Of the deployment experiments of Okuizumi et al. [Hz]."""
FASTEST = 300.0
"""Speed of the rim [m/s]: about that at which rotors of strong plastics burst."""
STRETCHED = 0.1
"""Strain by spinning at which films are torn; rho v^2/E is that of a ring of speed v."""
PARTS_OF_RUN = 1000
"""Intervals by which the turns of a schedule are summed up."""
TURNS = (1e-4, 1000.0)
"""In a run: below, the frame hardly moves; a sail is deployed after some tens of turns."""


@validated
class Spin(Law):
    """The hub turns about z, and the scene is computed in the frame that turns with it.

    Omega(t) = 2 pi (frequency + acceleration t), or 2 pi schedule(t).

    Parameters
    ----------
    frequency : float or None
        Turns per second at t = 0 [Hz]; the sign gives the sense. Default: 3, or none with a schedule.
    acceleration : float
        Its rate of change [Hz/s], from t = 0, or from the start of the stage that sets it.
    schedule : Schedule or None
        Turns per second [Hz] as a function of time, for spin-up, hold and ramp, in place of the other two.

    Raises
    ------
    InputError
        A schedule beside a frequency or an acceleration, a number that is not finite.
    InputTypeError
        What is no number or no schedule.

    Examples
    --------
    >>> from membrane_rs import Schedule, Spin
    >>> Spin(frequency=4.0).frequency
    4.0
    >>> Spin(schedule=Schedule([0.0, 2.0], [4.0, 1.0])).schedule.at(1.0)
    2.5
    """

    kind: ClassVar[str] = "spin"
    stiff_through: ClassVar[StiffThrough] = "law"
    turns_hub: ClassVar[bool] = True
    frequency: Annotated[Finite | None, Unit("Hz")] = None
    acceleration: Annotated[Finite, Unit("Hz/s")] = 0.0
    schedule: Annotated[Schedule | None, Unit("Hz")] = None

    def __post_init__(self) -> None:
        """Check that the motion of the hub is given once."""
        if self.schedule is None:
            if self.frequency is None:
                object.__setattr__(self, "frequency", FREQUENCY)
            return
        if self.acceleration != 0.0:
            what = "is not used with a schedule; leave it out, or set a frequency in place of the schedule"
            raise InputError(f"Spin.acceleration = {self.acceleration!r}: {what}")
        if self.frequency is not None:
            raise InputError(f"Spin.frequency = {self.frequency!r}: is not used with a schedule; leave it out")

    def core_parameters(self) -> dict[str, Any]:
        """A number as frequency beside a schedule, too, with which the core does not use it."""
        return super().core_parameters() | {"frequency": self._at_start}

    def replaced_by(self, name: str) -> tuple[str, ...]:
        """A schedule by a frequency, and frequency and acceleration by a schedule."""
        return {"schedule": ("frequency", "acceleration"), "frequency": ("schedule",)}.get(name, ())

    def within(self, start: float, end: float) -> Spin:
        """An acceleration counts from the start of the stage that sets it, or the frequency beside it."""
        if self.acceleration == 0.0 or not start < end:
            return self
        change = self.acceleration * (end - start)
        return Spin(schedule=Schedule((start, end), (self._at_start, self._at_start + change)))

    @property
    def hub_frequency(self) -> float:
        """That at the start, or the largest of its schedule."""
        return self._at_start if self.schedule is None else max(self.schedule.values, key=abs)

    def fastest_turning(self, until: float) -> float:
        """That at the start, at the end, or the most of a schedule."""
        most = abs(self.hub_frequency)
        return most if self.schedule is not None else max(most, abs(self._at(until)))

    @property
    def _at_start(self) -> float:
        """The frequency, 0 beside a schedule."""
        return 0.0 if self.frequency is None else self.frequency

    def _at(self, time: float) -> float:
        """The frequency at a time [s]."""
        if self.schedule is not None:
            return self.schedule.at(time)
        return self._at_start + self.acceleration * time

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """The rim of the flat shape moves more slowly than `FASTEST`, and a film is stretched by less than `STRETCHED`
        as a ring of this speed would be; a run has a number of turns within `TURNS`.
        """
        radius = outermost(scene, with_cords=False)
        end = self._at(scene.run.until)
        highest, fastest = self.fastest_turning(scene.run.until), FASTEST
        if scene.material is not None and scene.mesh is not None:
            tearing = math.sqrt(STRETCHED * scene.material.youngs_modulus / scene.material.density)
            fastest = min(FASTEST, tearing)
        speed = 2.0 * math.pi * highest * radius
        if speed > fastest:
            reason = f"the rim, {radius:.4g} m from the axis, would move at {speed:.4g} m/s; beyond {fastest:.4g} m/s "
            reason += "it is torn" if fastest < FASTEST else "rotors burst"
            most = fastest / (2.0 * math.pi * radius)
            field = "frequency" if abs(self.hub_frequency) >= highest else "acceleration (at the end)"
            place, unit = f"{where}.{'schedule (at most)' if self.schedule else field}", "Hz"
            derived = FILM if fastest < FASTEST else ("mesh", "parts")
            yield from implausible(place, highest, unit, reason, most=most, units=RATES, derived_from=derived)
        between = (scene.run.until * share / PARTS_OF_RUN for share in range(1, PARTS_OF_RUN))
        ends = 0.5 * (abs(self._at(0.0)) + abs(end))
        mean = ends if self.schedule is None else (ends + sum(abs(self._at(time)) for time in between)) / PARTS_OF_RUN
        turns = mean * scene.run.until
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
        rests = self.acceleration == 0 if self.schedule is None else True
        return "the hub does not turn" if self.hub_frequency == 0 and rests else None

    def step_advice(self, gain: float) -> str:
        """A slower frame or a shorter step."""
        return "the frame turns too fast for the step"
