"""A number as a function of time, by knots."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Annotated

from annotated_types import Le

from membrane_rs._arrays import Floats
from membrane_rs._validation import NonNegative, Numbers, OuterUnit, Unit, is_list, number_of, show, validated
from membrane_rs.errors import InputError, InputTypeError

MOST_KNOTS = 10_000
"""More would be a table of a motion's every step."""


@validated
class Schedule:
    """A number as a function of time, by knots: constant before the first and after the last one.

    Between two knots, T apart and with values that differ by D, with s = (t - t_k)/T from 0 to 1, the rate rises
    over the first share e of the time, is constant, and falls over the last share e::

        rate   D/(T (1 - e)) w(s),   w = S(s/e) for s < e, 1, S((1 - s)/e) for s > 1 - e,   S(u) = 3 u^2 - 2 u^3
        value  v_k + D p(s),         p = e (u^3 - u^4/2)/(1 - e) for u = s/e < 1, (s - e/2)/(1 - e) up to s = 1/2,
                                     p(s) = 1 - p(1 - s) from there

    So e = 0 is linear, where the rate jumps at the knots; with e > 0 the rate and its derivative are continuous.
    Methods of high order keep their order across a knot only with e > 0, or where two knots are at its time.

    Two knots at one time are a jump: before it the value is that of the first, from then on that of the second. No step
    crosses it, and what it changes of energies is listed in `Simulation.ledger()["changes"]`. With equal values the
    rate alone jumps.

    Parameters
    ----------
    times : sequence of float
        Of the knots [s], ascending, 1 to 10,000; two may be at one time. They count from the start of the stage that
        gives the schedule; in a scene without stages, from t = 0.
    values : sequence of float
        One for each time, in the unit of the field that the schedule stands in.
    ease : float
        Share e of the time between two knots over which the rate rises, and again falls [-]; 0 to 0.5.

    Raises
    ------
    InputError
        Lists of different lengths or none, times that do not ascend, or lie too near for the difference of values,
        three knots at one time.
    InputTypeError
        What is no list of numbers.

    Examples
    --------
    >>> from membrane_rs import Schedule
    >>> ramp = Schedule([0.0, 2.0], [0.0, 10.0])
    >>> ramp.at(0.5), ramp.at(3.0)
    (2.5, 10.0)
    >>> ramp.delayed(1.0).at(1.5)
    2.5
    """

    times: Annotated[Numbers, Unit("s")]
    values: Annotated[Numbers, OuterUnit()]
    ease: Annotated[NonNegative, Le(0.5)] = 0.0

    def __post_init__(self) -> None:
        """Check the knots against each other."""
        count = len(self.times)
        if not 1 <= count <= MOST_KNOTS:
            raise InputError(f"Schedule.times: holds {count} times; must be 1 to {MOST_KNOTS} (s)")
        if len(self.values) != count:
            what = f"Schedule.values = {show(self.values)}: holds {len(self.values)} values"
            raise InputError(f"{what} for {count} times; give one for each")
        area = 0.0
        for k in range(1, count):
            where = f"Schedule.times[{k}] = {show(self.times[k])}"
            length = self.times[k] - self.times[k - 1]
            if length < 0.0:
                what = "sort the knots by time"
                raise InputError(f"{where}: must not be below the time before, {show(self.times[k - 1])}; {what} (s)")
            if length == 0.0:
                if k > 1 and self.times[k - 2] == self.times[k]:
                    raise InputError(f"{where}: is the third knot at that time; a jump has two: leave out one (s)")
                continue
            change = self.values[k] - self.values[k - 1]
            area += (0.5 * self.values[k - 1] + 0.5 * self.values[k]) * length
            if not all(map(math.isfinite, (length, area, self._steepest(change, length)))):
                what = f"the value changes from {show(self.values[k - 1])} to {show(self.values[k])} in {length:g} s"
                raise InputError(f"{where}: {what}, which is too much to compute with; give SI units (s)")

    @classmethod
    def sampled(cls, function: Callable[[float], float], times: Sequence[float] | Floats) -> Schedule:
        """A linear schedule through the values of a function at some times.

        The function is called here, once for each time, in their order; no step of a run calls it. The schedule costs
        what one of as many knots does, and goes into scene files. Between the times it is linear: from a smooth
        function it differs by at most T^2/8 times the largest second derivative, with T the time between two knots,
        an error of second order in T. Its rate jumps at the knots, as that of any linear schedule.

        Parameters
        ----------
        function : callable
            Of a time [s]; gives the value, in the unit of the field that the schedule stands in.
        times : sequence of float
            Of the knots [s], as those of the class; before the first and after the last one the value is constant.

        Returns
        -------
        Schedule
            With these times and ease 0.

        Raises
        ------
        InputError
            A value that is not finite, with its time; times as the class refuses them.
        InputTypeError
            What is no function or no list of numbers; a value that is no number, with its time.

        Examples
        --------
        >>> from math import sin
        >>> from membrane_rs import Schedule
        >>> wave = Schedule.sampled(sin, [0.0, 0.5, 1.0])
        >>> wave.at(0.5) == sin(0.5), round(wave.at(0.25), 3)
        (True, 0.24)
        """
        if not callable(function):
            raise InputTypeError(f"Schedule.sampled: function = {show(function)}: must be a function of the time")
        count = len(times) if is_list(times) else 1
        knots = cls(times, [0.0] * count).times  # type: ignore[arg-type]
        name = "Schedule.sampled: function"
        return cls(knots, [number_of(f"{name}({time!r})", function(time), "") for time in knots])

    @property
    def last(self) -> float:
        """The value from the last knot on, in the unit of the values."""
        return self.values[-1]

    def delayed(self, by: float) -> Schedule:
        """The same schedule, later by a time [s].

        Parameters
        ----------
        by : float
            Time by which all knots are later [s].

        Returns
        -------
        Schedule
            With the same values.

        Raises
        ------
        InputError, InputTypeError
            A time that is no finite number, or so late that two knots become one.
        """
        by = number_of("by", by)
        times = tuple(time + by for time in self.times)
        for k in range(1, len(times)):
            if times[k] == times[k - 1] and self.times[k] != self.times[k - 1]:
                what = f"times[{k}] = {show(self.times[k])} and the time before, {show(self.times[k - 1])}, become one"
                raise InputError(f"by = {by:g}: {what}; delay it by less (s)")
        return replace(self, times=times)

    def at(self, time: float) -> float:
        """The value at a time [s]; at a jump, the one after it.

        Parameters
        ----------
        time : float
            [s]

        Returns
        -------
        float
            In the unit of the values.

        Raises
        ------
        InputError, InputTypeError
            A time that is no finite number.
        """
        k, before, after = self._place(number_of("time", time))
        if k is None:
            return before
        change = self.values[k + 1] - self.values[k]
        if before <= after:
            return self.values[k] + change * self._risen(before)
        return self.values[k + 1] - change * self._risen(after)

    def integral(self, start: float, end: float) -> float:
        """The integral of the value over time.

        Parameters
        ----------
        start, end : float
            From when to when [s].

        Returns
        -------
        float
            In the unit of the values, times seconds.

        Raises
        ------
        InputError, InputTypeError
            A time that is no finite number.

        Examples
        --------
        >>> from membrane_rs import Schedule
        >>> Schedule([0.0, 2.0], [0.0, 10.0]).integral(0.0, 3.0)
        20.0
        """
        return self._area(number_of("end", end)) - self._area(number_of("start", start))

    def _area(self, time: float) -> float:
        """The integral from the first knot on."""
        times, values = self.times, self.values
        if time <= times[0]:
            return values[0] * (time - times[0])
        k = bisect_right(times, time) - 1
        lengths = [times[i + 1] - times[i] for i in range(k)]
        whole = [0.5 * (values[i] + values[i + 1]) * length for i, length in enumerate(lengths)]
        if k == len(times) - 1:
            return math.fsum([*whole, values[-1] * (time - times[-1])])
        length, change = times[k + 1] - times[k], values[k + 1] - values[k]
        share = (time - times[k]) / length
        return math.fsum([*whole, values[k] * (time - times[k]), change * length * self._risen_area(share)])

    def _risen_area(self, share: float) -> float:
        """The integral of p from 0 to s."""
        if share > 0.5:
            return share - 0.5 + self._risen_area(1.0 - share)
        ease = self.ease
        if share >= ease:
            return (0.15 * ease * ease + 0.5 * share * (share - ease)) / (1.0 - ease)
        u = share / ease
        return ease * ease * u**4 * (0.25 - 0.1 * u) / (1.0 - ease)

    def _steepest(self, change: float, length: float) -> float:
        """The largest rate between two knots, or the largest second derivative where that is more."""
        rate = change / (length * (1.0 - self.ease))
        return rate if self.ease == 0.0 else max(abs(rate), 1.5 * abs(rate) / (self.ease * length))

    def _place(self, time: float) -> tuple[int | None, float, float]:
        """The knot before a time, and the shares before and after it; None with the value, beyond the knots."""
        times = self.times
        k = bisect_right(times, time) - 1
        if k < 0 or k == len(times) - 1:
            return None, self.values[max(k, 0)], 0.0
        length = times[k + 1] - times[k]
        return k, (time - times[k]) / length, (times[k + 1] - time) / length

    def _risen(self, share: float) -> float:
        """p(s) for s up to one half."""
        ease = self.ease
        if share >= ease:
            return (share - 0.5 * ease) / (1.0 - ease)
        u = share / ease
        return ease * u * u * u * (1.0 - 0.5 * u) / (1.0 - ease)
