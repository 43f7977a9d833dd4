"""Numbers as text with a unit: in the notation of the field, and the very number when it is read again."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from typing import Any

import membrane_rs
import pytest
from hypothesis import given
from hypothesis import strategies as st
from membrane_rs import units
from membrane_rs._quantities import KINDS
from membrane_rs.errors import InputError, InputTypeError


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (1e-6, "N m", "1 uN m"),
        (1234.0, "N m", "1.234 kN m"),
        (0.0098, "m/s2", "9.8 mm/s2"),
        (1420.0, "kg/m3", "1420 kg/m3"),
        (3e-4, "m2", "0.0003 m2"),
        (0.0001004, "kg/m", "100.4 mg/m"),
        (1500.0, "kg", "1500 kg"),
        (1.0, "kg", "1 kg"),
        (0.99999, "kg", "1 kg"),
        (0.3, "kg", "300 g"),
        (4e-13, "kg", "4e-13 kg"),
        (5e-12, "kg", "5 ng"),
        (3600.0, "s", "3600 s"),
        (0.99999, "m", "1 m"),
        (999.96, "m", "1 km"),
        (3.2e12, "Pa", "3.2e+12 Pa"),
        (-2.5e-5, "m", "-25 um"),
        (0.0, "m", "0 m"),
        (0.25, "Hz/s", "0.25 Hz/s"),
        (2.0, "kg m2", "2 kg m2"),
        (0.002, "mm", "0.002 mm"),
        (20.0, "degC", "20 degC"),
        (1.5, "km/h", "1.5 km/h"),
        (12.0, "J/(kg K)", "12 J/(kg K)"),
        (2.0, "%", "2 %"),
    ],
)
def test_the_notation_is_that_of_the_unit(value: float, unit: str, text: str) -> None:
    assert units.text(value, unit) == text
    assert units.number(text, unit) == pytest.approx(value, rel=1e-4)


@pytest.mark.parametrize("unit", [unit for unit in KINDS if unit])
def test_all_digits_are_the_very_number(unit: str) -> None:
    numbers = random.Random(1)
    for _ in range(300):
        value = math.ldexp(numbers.uniform(-1.0, 1.0), numbers.randint(-60, 60))
        assert units.number(units.text(value, unit, 17), unit) == value
    for value in (0.0, 5e-324, -1e-300, 1.7e308, 1.0 / 3.0, 999.9999999999999):
        assert units.number(units.text(value, unit, 17), unit) == value


@given(st.floats(allow_nan=False, allow_infinity=False), st.sampled_from(sorted(KINDS)), st.integers(1, 17))
def test_a_text_of_few_digits_is_near_the_number(value: float, unit: str, digits: int) -> None:
    text = units.text(value, unit, digits)
    assert text.isascii()
    assert "*" not in text
    if unit and abs(value) < 1e308:
        assert units.number(text, unit) == pytest.approx(value, rel=10.0 ** (1 - digits), abs=0.0)


@pytest.mark.parametrize("text", ["5e-324 um", "1e-400 m", "-1e-330 mm"])
def test_a_text_that_would_be_0_is_refused_as_it_stands(text: str) -> None:
    with pytest.raises(InputError, match=f"gap = '{text}': is so small that it would be 0 m; check number and unit"):
        units.number(text, "m", "gap")
    assert units.number("0e-400 um", "m") == 0.0


@pytest.mark.parametrize(
    ("call", "place", "text", "unit"),
    [
        (lambda text: membrane_rs.run("spinning-tether", text), "until", "0.2 ms", "s"),
        (lambda text: membrane_rs.run("spinning-tether", 0.01, every=text), "every", "1 ms", "s"),
        (lambda text: membrane_rs.run("spinning-tether", 0.01, dt=text), "dt", "1 us", "s"),
        (lambda text: membrane_rs.Material(text, 0.3, 1420.0, 7.5e-6), "Material.youngs_modulus", "3.2 GPa", "Pa"),
    ],
)
def test_a_text_with_a_unit_in_python_is_answered_with_how_to_write_it(
    call: Callable[[Any], object], place: str, text: str, unit: str
) -> None:
    with pytest.raises(InputTypeError, match=f"{place} = '{text}': must be a number") as caught:
        call(text)
    advice = str(caught.value).rpartition("or as membrane_rs.")[2]
    value = eval(advice, {"units": units})
    assert value == units.number(text, unit)
    with pytest.raises(InputTypeError) as caught:
        call("fast")  # no number with a unit, to which no advice applies
    assert "units.number" not in str(caught.value)
