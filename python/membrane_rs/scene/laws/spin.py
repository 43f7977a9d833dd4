"""The turning frame."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator
from dataclasses import field, replace
from typing import Annotated, Any, ClassVar

from membrane_rs._validation import Finite, Positive, Unit, show, validated
from membrane_rs.errors import InputError
from membrane_rs.scene.law import Law, StiffThrough, Surroundings
from membrane_rs.scene.plausible import FILM, RATES, STRETCHED, Doubt, implausible
from membrane_rs.scene.scales import moment_of_inertia, outermost
from membrane_rs.scene.schedule import Schedule

OF_FREE = ("inertia", "torque", "mass", "transverse_inertia", "tumble")
"""Fields of a free hub."""
FREQUENCY = 3.0
"""Of the deployment experiments of Okuizumi et al. [Hz]."""
FASTEST = 300.0
"""Speed of the rim [m/s]: about that at which rotors of strong plastics burst."""
PARTS_OF_RUN = 1000
"""Intervals by which the turns of a schedule are summed up."""
TURNS = (1e-4, 1000.0)
"""In a run: below, the frame hardly moves; a sail is deployed after some tens of turns."""
LIGHT_HUB, HEAVY_HUB = 1e-6, 1e9
"""Inertia of a free hub over that of the sail at the start: below, the hub is a thread; above, its rate stays that of a
hub that is driven, to all digits that are shown [-]."""


@validated
class Spin(Law):
    """The hub turns about z, and the scene is computed in the frame that turns with it.

    Omega(t) = 2 pi (frequency + acceleration t), or 2 pi schedule(t): the hub is driven. With an inertia it is free:
    its rate follows from the balance of angular momentum about z, by what the sail and the torque exert on it. With
    a mass and a transverse inertia besides, it is a symmetric rigid body in six degrees of freedom, whose centre of
    mass is the origin of the frame that is fixed in it.

    Parameters
    ----------
    frequency : float or None
        Turns per second at t = 0 [Hz]; the sign gives the sense. Of a free hub that at the start of the run. Default:
        3, or none with a schedule.
    acceleration : float
        Its rate of change [Hz/s], from t = 0, or from the start of the stage that sets it.
    schedule : Schedule or None
        Turns per second [Hz] as a function of time, for spin-up, hold and ramp, in place of the other two.
    inertia : float, optional
        Moment of inertia of the hub about z [kg m2], above 0, without the nodes that it holds. None: the hub is driven.
        Set by a stage it holds in later ones too, and a free hub goes on at the rate that it has. By keyword alone.
    torque : Schedule, optional
        Torque of a motor, or from outside, on a free hub about z [N m]. None: none. By keyword alone.
    mass : float, optional
        Mass of a hub that is free in six degrees of freedom [kg], above 0, without the nodes that it holds. None: the
        hub turns about its axis alone. By keyword alone.
    transverse_inertia : float, optional
        Moment of inertia of that hub about any axis across its own [kg m2], at least half of the inertia. By keyword
        alone.
    tumble : float, optional
        Turns per second of that hub about x at the start [Hz]. None: none. By keyword alone.

    Raises
    ------
    InputError
        A schedule beside a frequency or an acceleration, either beside an inertia, a torque or a mass without one, a
        mass without a transverse inertia or the reverse, a number outside its range.
    InputTypeError
        What is no number or no schedule.

    Examples
    --------
    >>> from membrane_rs import Schedule, Spin
    >>> Spin(frequency=4.0).frequency
    4.0
    >>> Spin(schedule=Schedule([0.0, 2.0], [4.0, 1.0])).schedule.at(1.0)
    2.5
    >>> Spin(frequency=4.0, inertia=0.02).turning_in_words
    '4 Hz at the start, then freely: a hub of 0.02 kg m2'
    """

    kind: ClassVar[str] = "spin"
    stiff_through: ClassVar[StiffThrough] = "law"
    turns_hub: ClassVar[bool] = True
    held_fields: ClassVar[tuple[str, ...]] = ("inertia",)
    frequency: Annotated[Finite | None, Unit("Hz")] = None
    acceleration: Annotated[Finite, Unit("Hz/s")] = 0.0
    schedule: Annotated[Schedule | None, Unit("Hz")] = None

    inertia: Annotated[Positive | None, Unit("kg m2")] = field(default=None, kw_only=True)
    torque: Annotated[Schedule | None, Unit("N m")] = field(default=None, kw_only=True)
    mass: Annotated[Positive | None, Unit("kg")] = field(default=None, kw_only=True)
    transverse_inertia: Annotated[Positive | None, Unit("kg m2")] = field(default=None, kw_only=True)
    tumble: Annotated[Finite | None, Unit("Hz")] = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        """Check that the motion of the hub is given once."""
        if self.inertia is not None:
            self._check_free()
        elif self.torque is not None:
            what = "acts on a free hub alone; give its inertia (kg m2), or leave the torque out, {} in a stage (N m)"
            raise InputError(f"Spin.torque = {show(self.torque)}: {what}")
        self._check_body()
        if self.schedule is None:
            if self.frequency is None:
                object.__setattr__(self, "frequency", FREQUENCY)
            return
        if self.acceleration != 0.0:
            what = "is not used with a schedule; leave it out, or set a frequency in place of the schedule"
            raise InputError(f"Spin.acceleration = {self.acceleration!r}: {what}")
        if self.frequency is not None:
            raise InputError(f"Spin.frequency = {self.frequency!r}: is not used with a schedule; leave it out")

    def _check_body(self) -> None:
        """Refuse half of a hub in six degrees of freedom. Raises InputError."""
        needed = {"inertia": self.inertia, "mass": self.mass, "transverse_inertia": self.transverse_inertia}
        is_body = all(value is not None for value in needed.values())
        for name, value, unit in (
            ("mass", self.mass, "kg"),
            ("transverse_inertia", self.transverse_inertia, "kg m2"),
            ("tumble", self.tumble, "Hz"),
        ):
            if value is not None and not is_body:
                lacking = " and ".join(other for other, given in needed.items() if given is None)
                what = "belongs to a hub that is free in six degrees of freedom; give its"
                raise InputError(f"Spin.{name} = {show(value)}: {what} {lacking} too, or leave it out ({unit})")
        if self.inertia is not None and self.transverse_inertia is not None:
            least = 0.5 * self.inertia
            if self.transverse_inertia < least:
                what = f"must be at least half of the inertia, {least:g}, as that of any body"
                raise InputError(f"Spin.transverse_inertia = {show(self.transverse_inertia)}: {what} (kg m2)")

    def _check_free(self) -> None:
        """Refuse a prescribed motion beside an inertia. Raises InputError."""
        remedy = "leave it out, or drive the hub: leave the inertia out, {} in a stage"
        for name, value, is_given in (
            ("schedule", self.schedule, self.schedule is not None),
            ("acceleration", self.acceleration, self.acceleration != 0.0),
        ):
            if is_given:
                unit = "Hz" if name == "schedule" else "Hz/s"
                what = "is not used with an inertia, by which the hub turns freely"
                raise InputError(f"Spin.{name} = {show(value)}: {what}; {remedy} ({unit})")

    def core_parameters(self) -> dict[str, Any]:
        """A number as frequency beside a schedule, too, with which the core does not use it; what a driven hub lacks is
        left out.
        """
        given = super().core_parameters() | {"frequency": self._at_start, "tumble": (self.tumble or 0.0, 0.0)}
        is_free = self.inertia is not None
        return {name: value for name, value in given.items() if name not in OF_FREE or (is_free and value is not None)}

    def replaced_by(self, name: str) -> tuple[str, ...]:
        """A schedule by a frequency, frequency and acceleration by a schedule, and by an inertia all but the frequency,
        which is that at the start.
        """
        replaced = {
            "schedule": ("frequency", "acceleration"),
            "frequency": ("schedule",),
            "inertia": ("acceleration", "schedule"),
        }
        return replaced.get(name, ())

    def check_set(self, given: Law, names: Collection[str], *, is_first: bool) -> None:
        """Refuse a frequency and a tumble that a free hub does not start at, and a default in place of a schedule."""
        if self.inertia is not None and not is_first and "frequency" in names:
            what = "has no effect: a free hub goes on at the rate that it has; leave it out here"
            remedy = "set it in the scene or in the first stage, or change the rate by a torque"
            raise InputError(f"Spin.frequency = {self.frequency!r}: {what}, {remedy} (Hz)")
        if self.tumble is not None and not is_first and "tumble" in names:
            what = "has no effect: a hub goes on at the rates that it has; leave it out here"
            raise InputError(f"Spin.tumble = {self.tumble!r}: {what}, set it in the scene or in the first stage (Hz)")
        had_schedule = given.hub is not None and given.hub.schedule is not None
        starts = self.inertia is None or is_first
        if had_schedule and starts and "inertia" in names and not {"frequency", "schedule"} & {*names}:
            what = "stands in place of the schedule of the scene, and no rate is given"
            remedy = "set the frequency too (Hz)" if self.inertia is not None else "set a frequency or a schedule (Hz)"
            raise InputError(f"Spin.inertia = {show(self.inertia)}: {what}; {remedy}")

    def carried(self, before: Callable[[], Law | None], time: float) -> Spin:
        """A free hub goes on at the rates that it has: as far as they are known before a run, those at which it was set
        free.
        """
        if self.inertia is None:
            return self
        law = before()
        hub = None if law is None else law.hub
        rate = 0.0 if hub is None else hub.planned_turning(time)
        tumble = None if hub is None or self.mass is None else hub.tumble
        return replace(self, frequency=rate, tumble=tumble)

    def while_held(self, rate: float) -> Spin:
        """A hub that turns at the rate that a free one has."""
        return self if self.inertia is None else Spin(rate / (2.0 * math.pi))

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

    @property
    def hub(self) -> Spin:
        """The hub that it turns."""
        return self

    def fastest_turning(self, until: float) -> float:
        """That at the start, at the end, or the most of a schedule; of a free hub also what its torque gives the hub
        alone, without the sail, by one of its knots.
        """
        return self._fastest(until, 0.0)

    def _fastest(self, until: float, sail: float) -> float:
        """The same, with the moment of inertia of a sail that turns with a free hub [kg m2]."""
        most = abs(self.hub_frequency)
        if self.schedule is not None:
            return most
        if self.inertia is None or self.torque is None:
            return max(most, abs(self._at(until)))
        ends = (*(time for time in self.torque.times if 0.0 < time < until), until)
        gains = (self.torque.integral(0.0, time) / (2.0 * math.pi * (self.inertia + sail)) for time in ends)
        return max(most, *(abs(self._at_start + gain) for gain in gains))

    def planned_turning(self, time: float) -> float:
        """Turns per second, as far as they are known before a run: of a free hub those at its start.

        Parameters
        ----------
        time : float
            [s]

        Returns
        -------
        float
            [Hz]

        Examples
        --------
        >>> from membrane_rs import Spin
        >>> Spin(3.0, -0.5).planned_turning(2.0), Spin(3.0, inertia=0.1).planned_turning(2.0)
        (2.0, 3.0)
        """
        return self._at_start if self.inertia is not None else self._at(time)

    @property
    def _at_start(self) -> float:
        """The frequency, 0 beside a schedule."""
        return 0.0 if self.frequency is None else self.frequency

    def _at(self, time: float) -> float:
        """The frequency at a time [s]."""
        if self.schedule is not None:
            return self.schedule.at(time)
        return self._at_start + self.acceleration * time

    @property
    def turning_in_words(self) -> str:
        """Its frequency, and the inertia of a free hub."""
        turning = f"{self.hub_frequency:g} Hz"
        if self.inertia is None:
            return turning
        driven = "" if self.torque is None else " under a torque"
        size = f"{self.inertia:.4g} kg m2" if self.mass is None else f"{self.mass:.4g} kg in six degrees of freedom"
        return f"{turning} at the start, then freely{driven}: a hub of {size}"

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """The rim of the flat shape moves more slowly than `FASTEST`, and a film is stretched by less than `STRETCHED`
        as a ring of this speed would be; a run has a number of turns within `TURNS`. The inertia of a free hub is that
        of the sail within `LIGHT_HUB` and `HEAVY_HUB`.
        """
        radius = outermost(scene, with_cords=False)
        sail = 0.0 if self.inertia is None else moment_of_inertia(scene)
        highest, fastest = self._fastest(scene.run.until, sail), FASTEST
        if scene.material is not None and scene.mesh is not None:
            tearing = math.sqrt(STRETCHED * scene.material.youngs_modulus / scene.material.density)
            fastest = min(FASTEST, tearing)
        tumble = () if self.tumble is None else (("tumble", abs(self.tumble)),)
        for name, rate in ((self._fastest_by(highest), highest), *tumble):
            speed = 2.0 * math.pi * rate * radius
            if speed > fastest:
                reason = f"the rim, {radius:.4g} m from the axis, would move at {speed:.4g} m/s; beyond "
                reason += f"{fastest:.4g} m/s " + ("it is torn" if fastest < FASTEST else "rotors burst")
                most = fastest / (2.0 * math.pi * radius)
                derived: tuple[str, ...] = FILM if fastest < FASTEST else ("mesh", "parts")
                derived += () if self.torque is None else (f"{where}.inertia",)
                place = f"{where}.{name}"
                yield from implausible(place, rate, "Hz", reason, most=most, units=RATES, derived_from=derived)
        yield from self._implausible_inertia(sail, where)
        turns = self._turns(scene.run.until)
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

    def _fastest_by(self, highest: float) -> str:
        """What gives the hub its highest frequency [Hz]."""
        if self.schedule is not None:
            return "schedule (at most)"
        if abs(self.hub_frequency) >= highest:
            return "frequency"
        return "acceleration (at the end)" if self.inertia is None else "torque (at most)"

    def _turns(self, until: float) -> float:
        """Turns up to a time [s], regardless of the sense; 0 where a torque turns a free hub."""
        if self.torque is not None:
            return 0.0
        ends = 0.5 * (abs(self._at(0.0)) + abs(self._at(until)))
        if self.schedule is None:
            return ends * until
        between = (until * share / PARTS_OF_RUN for share in range(1, PARTS_OF_RUN))
        return (ends + sum(abs(self._at(time)) for time in between)) / PARTS_OF_RUN * until

    def _implausible_inertia(self, sail: float, where: str) -> Iterator[Doubt]:
        """A hub that is a thread beside a sail of this moment of inertia [kg m2], or one that no sail moves."""
        if self.inertia is None or not 0.0 < sail < math.inf:
            return
        reason = f"that is {self.inertia / sail:.3g} times the moment of inertia of the sail at the start, "
        reason += f"{sail:.3g} kg m2"
        units = {"kg cm2": 1e-4, "kg mm2": 1e-6, "g cm2": 1e-7}
        bounds = {"least": LIGHT_HUB * sail, "most": HEAVY_HUB * sail}
        place, derived = f"{where}.inertia", (*FILM, "parts")
        yield from implausible(place, self.inertia, "kg m2", reason, **bounds, units=units, derived_from=derived)

    def why_idle(self, scene: Surroundings) -> str | None:
        """A driven hub at rest; a free one is turned by what acts on it."""
        if self.inertia is not None:
            return None
        rests = self.acceleration == 0 if self.schedule is None else True
        return "the hub does not turn" if self.hub_frequency == 0 and rests else None

    def step_advice(self, gain: float) -> str:
        """A slower frame or a shorter step."""
        return "the frame turns too fast for the step"
