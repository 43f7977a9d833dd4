"""Schedules: knots, formula, delays, errors, and their place in other classes and in scene files."""

from __future__ import annotations

import math
import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from membrane_rs import InputError, InputTypeError, Schedule
from membrane_rs._validation import build, validated
from membrane_rs.scene.schedule import MOST_KNOTS


@validated
class Holder:
    """A class with a schedule in a field."""

    rate: float = 1.0
    schedule: Schedule | None = None


def formula(times: list[float], values: list[float], ease: float, time: float) -> float:
    """The value by quadrature of the rate."""
    k = int(np.clip(np.searchsorted(times, time, side="right") - 1, 0, len(times) - 2))
    length, change = times[k + 1] - times[k], values[k + 1] - values[k]
    grid = np.linspace(0.0, min(max((time - times[k]) / length, 0.0), 1.0), 20001)
    u = np.clip(np.minimum(grid, 1.0 - grid) / ease, 0.0, 1.0)
    rate = change / (1.0 - ease) * u * u * (3.0 - 2.0 * u)
    return values[k] + float(np.sum(0.5 * (rate[1:] + rate[:-1]) * np.diff(grid)))


@pytest.mark.parametrize("ease", [0.0, 0.1, 0.3, 0.5])
def test_knots_are_met_and_values_beyond_stay(ease: float) -> None:
    """At the knots every bit of the value."""
    schedule = Schedule((0.0, 0.3, 0.7), (1.0, -2.0, 0.1), ease)
    assert [schedule.at(time) for time in (-5.0, 0.0, 0.3, 0.7, 9.0)] == [1.0, 1.0, -2.0, 0.1, 0.1]
    assert schedule.last == 0.1


@pytest.mark.parametrize("ease", [0.02, 0.25, 0.5])
@pytest.mark.parametrize("time", [0.0, 0.004, 0.1, 0.2, 0.3, 0.31, 0.45, 0.69, 0.8])
def test_value_is_the_integral_of_the_rate(ease: float, time: Any) -> None:
    """By the trapezoidal rule on 20,000 intervals."""
    times, values = [0.0, 0.3, 0.7], [1.0, -2.0, 0.1]
    assert Schedule(times, values, ease).at(time) == pytest.approx(formula(times, values, ease, time), abs=1e-6)


def test_linear_and_smooth() -> None:
    """Two shapes by hand."""
    assert Schedule([0, 2], [1, 5]).at(0.5) == 2.0
    assert Schedule([0, 1], [0, 1], 0.5).at(0.25) == 3 / 32


def test_two_knots_at_one_time_are_a_jump() -> None:
    """The value is that of the first until then, and that of the second from then on; at both ends, too."""
    jumps = Schedule([0, 0, 1, 1, 2, 2], [5, 1, 3, -3, -4, 7], 0.25)
    times = (-1e-300, 0.0, 0.5, math.nextafter(1.0, 0.0), 1.0, math.nextafter(2.0, 0.0), 2.0, 9.0)
    assert [jumps.at(time) for time in times] == pytest.approx([5.0, 1.0, 2.0, 3.0, -3.0, -4.0, 7.0, 7.0])
    assert jumps.at(0.0) == 1.0
    assert jumps.delayed(0.1).at(1.1) == -3.0


def test_single_knot_is_a_constant() -> None:
    """One knot is enough."""
    assert Schedule([3.0], [7.0]).at(-1e9) == 7.0


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=6, unique=True), st.floats(0.0, 0.5), st.floats(-50, 50))
def test_values_stay_between_those_of_the_knots(times: list[float], ease: float, time: Any) -> None:
    """And a delay moves all of it."""
    times = sorted(float(f"{t:.3f}") for t in times)
    if len(set(times)) < len(times) or 0 < ease < 1e-6:
        return
    schedule = Schedule(times, [math.sin(k) for k in range(len(times))], ease)
    assert min(schedule.values) - 1e-12 <= schedule.at(time) <= max(schedule.values) + 1e-12
    assert schedule.delayed(2.5).at(time + 2.5) == pytest.approx(schedule.at(time), abs=1e-6)


def test_arrays_are_taken_and_a_schedule_is_plain() -> None:
    """Numpy arrays become tuples; schedules compare, hash and pickle."""
    times: Any = np.arange(3)
    values: Any = np.array([1.0, 2.0, 4.0])
    schedule = Schedule(times, values)
    assert schedule == Schedule((0, 1, 2), (1, 2, 4))
    assert hash(schedule) == hash(Schedule((0, 1, 2), (1, 2, 4)))
    assert pickle.loads(pickle.dumps(schedule)) == schedule


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "none": ({"times": [], "values": []}, "times: holds 0 times; must be 1 to"),
    "lengths": ({"times": [0, 1], "values": [1]}, r"values = \(1.0,\): holds 1 values for 2 times"),
    "three": ({"times": [1, 1, 1], "values": [1, 2, 3]}, r"times\[2\] = 1.0: is the third knot at that time"),
    "order": ({"times": [0, 2, 1], "values": [1, 2, 3]}, r"times\[2\] = 1.0: must not be below .*, 2.0; sort"),
    "text": ({"times": [0, "a"], "values": [1, 2]}, r"times\[1\] = 'a': must be a number \(s\)"),
    "nan": ({"times": [0, 1], "values": [1, float("nan")]}, r"values\[1\] = nan: must be finite"),
    "inf": ({"times": [0, float("inf")], "values": [1, 2]}, r"times\[1\] = inf: must be finite"),
    "flag": ({"times": [False, 1], "values": [1, 2]}, r"times\[0\] = False: must be a number"),
    "ease": ({"times": [0, 1], "values": [1, 2], "ease": 0.6}, "ease = 0.6: must be at least 0 and at most 0.5"),
    "ease below": ({"times": [0, 1], "values": [1, 2], "ease": -0.1}, "ease = -0.1: must be at least 0"),
    "close": ({"times": [0, 1e-320], "values": [0, 1]}, r"times\[1\] = 1e-320: .* too much to compute with"),
    "high": ({"times": [0, 1], "values": [-1.7e308, 1.7e308]}, r"times\[1\] = 1.0: .* too much to compute"),
    "area": ({"times": [0, 1e200], "values": [1e200, 1e200]}, r"times\[1\] = 1e\+200: .* too much to compute"),
    "sharp": ({"times": [0, 1], "values": [0, 1], "ease": 1e-310}, r"times\[1\] = 1.0: .* too much to compute"),
    "many": ({"times": list(range(MOST_KNOTS + 1)), "values": [0]}, f"times: holds {MOST_KNOTS + 1} times"),
    "unknown": ({"times": [0], "values": [0], "eased": 0.1}, "eased: no such key; did you mean 'ease'"),
    "missing": ({"times": [0]}, "values: is missing"),
    "not a list": ({"times": "ab", "values": [0]}, "times = 'ab': must be a list of numbers"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_input_is_named_with_its_place(case: str) -> None:
    """By itself, in a field of a class, and in a table of a scene file."""
    values: Any
    values, message = WRONG[case]
    with pytest.raises(InputError, match=r"^Schedule\." + message):
        Schedule(**values)
    with pytest.raises(InputError, match=r"^Holder\.schedule\." + message):
        Holder(schedule=values)
    with pytest.raises(InputError, match=r"^laws\.spin\.schedule\." + message):
        build(Holder, {"schedule": values}, "laws.spin")


@pytest.mark.parametrize("value", [3, [1.0], "fast", True])
def test_what_is_no_schedule_is_refused(value: Any) -> None:
    """The message says what it may be."""
    with pytest.raises(InputTypeError, match=r"Holder.schedule = .* must be a Schedule, or a table with times"):
        Holder(schedule=value)


@pytest.mark.parametrize("time", [float("nan"), "a", None, True, 10**400])
def test_times_are_checked(time: Any) -> None:
    """In both methods."""
    schedule = Schedule([0, 1], [0, 1])
    for method in (schedule.at, schedule.delayed):
        with pytest.raises(InputError):
            method(time)


def test_delay_that_merges_times_is_refused() -> None:
    """Times so late that they cannot be told apart."""
    with pytest.raises(InputError, match=r"times\[1\]"):
        Schedule([0, 1], [0, 1]).delayed(1e300)


def test_a_sampled_function_is_met_at_its_times_and_nearly_between_them() -> None:
    """Every bit at the knots; T^2/8 between them, so that half the spacing leaves a quarter of the error."""
    calls: list[float] = []

    def wave(time: float) -> float:
        calls.append(time)
        return math.sin(3.0 * time)

    errors = []
    for count in (11, 21):
        times = np.linspace(0.0, 1.0, count)
        schedule = Schedule.sampled(wave, times)
        assert calls == times.tolist()
        assert [schedule.at(time) for time in times] == [math.sin(3.0 * time) for time in times]
        errors.append(max(abs(schedule.at(time) - math.sin(3.0 * time)) for time in np.linspace(0.0, 1.0, 1001)))
        assert errors[-1] <= 9.0 / 8.0 / (count - 1) ** 2
        assert len(calls) == count  # `at` calls no function
        calls.clear()
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.3)
    assert Schedule.sampled(abs, [-1, 2]) == Schedule((-1.0, 2.0), (1.0, 2.0))
    assert Schedule.sampled(lambda _: np.float32(0.5), (0.0,)).last == 0.5


@pytest.mark.parametrize(
    ("function", "times", "error", "words"),
    [
        (math.sqrt, (-0.0, 1.0, math.inf), InputError, r"Schedule\.times\[2\] = inf: must be finite \(s\)"),
        (abs, (1.0, 0.0), InputError, r"Schedule\.times\[1\] = 0\.0: must not be below the time before, 1\.0"),
        (abs, (), InputError, r"Schedule\.times: holds 0 times"),
        (abs, 3.0, InputTypeError, r"Schedule\.times = 3\.0: must be a list of numbers"),
        (2.0, (0.0, 1.0), InputTypeError, r"Schedule\.sampled: function = 2\.0: must be a function of the time"),
        (lambda _: math.inf, (0.0, 1.0), InputError, r"function\(0\.0\) = inf: must be finite"),
        (lambda t: math.nan if t > 0.5 else t, (0.0, 1.0), InputError, r"function\(1\.0\) = nan: must be finite"),
        (lambda _: "1", (0.25,), InputTypeError, r"function\(0\.25\) = '1': must be a number"),
        (lambda _: None, (0.25,), InputTypeError, r"function\(0\.25\) = None: must be a number"),
    ],
)
def test_what_cannot_be_sampled_is_refused_by_name_and_time(
    function: Any, times: Any, error: type[InputError], words: str
) -> None:
    with pytest.raises(error, match=words):
        Schedule.sampled(function, times)
