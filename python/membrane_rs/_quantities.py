"""Numbers with units, as text: "7.5 um", "25 rpm". The grammar is this module's, the units are pint's.

    text     number unit                 3.2 GPa, 7.5um, -1.5e3 N/m, 50 1/s
    unit     product, or product/product/...
    product  factors by spaces or *      N m, kg*m
    factor   name, exponent              m2, m^2, m**2, m², s-1

A product behind a slash needs brackets: J/(kg K), for J/kg K has two meanings. pint evaluates nothing but names, so
that no text can take long; it computes with decimals, so that "7.5 um" is the very number 7.5e-6.

An angle has a dimension of its own here, and a hertz is one turn per second. So 25 rpm are 25/60 Hz, and 1/s, which may
mean turns as well as radians, is no frequency.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from decimal import Decimal
from functools import cache, lru_cache
from typing import Any

from membrane_rs._messages import show
from membrane_rs.errors import InputError, InputTypeError

DEFINITIONS = """
nano- = 1e-9 = n-
micro- = 1e-6 = u-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
deci- = 1e-1 = d-
hecto- = 1e2 = h-
kilo- = 1e3 = k-
mega- = 1e6 = M-
giga- = 1e9 = G-
meter = [length] = m = metre = meters = metres
second = [time] = s = sec = seconds
gram = [mass] = g = grams
kelvin = [temperature]; offset: 0 = K
radian = [angle] = rad = radians
percent = 0.01 = _
turn = 2 * 3.14159265358979323846264338327950288419716939937511 * radian = _ = turns = rev = revolution
degree = turn / 360 = deg = degrees
hertz = turn / second = Hz
revolutions_per_minute = turn / minute = rpm
minute = 60 * second = min = minutes
hour = 60 * minute = h = hours
day = 24 * hour = _ = days
degree_Celsius = kelvin; offset: 273.15 = degC = celsius
degree_Fahrenheit = 5 / 9 * kelvin; offset: 255.37222222222222222222222222 = degF
newton = 1000 * gram * meter / second ** 2 = N
pascal = newton / meter ** 2 = Pa
joule = newton * meter = J
watt = joule / second = W
newton_meter = newton * meter = Nm
bar = 1e5 * pascal
atmosphere = 101325 * pascal = atm
torr = atmosphere / 760 = Torr = mmHg
micron = 1e-6 * meter = microns
astronomical_unit = 149597870700 * meter = au
inch = 0.0254 * meter = in = inches
foot = 12 * inch = ft = feet
mil = 0.001 * inch
pound = 453.59237 * gram = lb
pound_force = 4.4482216152605 * newton = lbf
pound_force_per_square_inch = pound_force / inch ** 2 = psi
"""
"""Units in pint's form. Left out is what is mistaken for another: gr (a grain, not a gram), a (a year, so that pa would
be one), d (so that cd would be a hundredth of a day)."""

KINDS = {
    "": ("a plain number", "2 %"),
    "m": ("a length", "7.5 um"),
    "kg": ("a mass", "0.36 g"),
    "s": ("a time", "20 ms"),
    "K": ("a temperature", "20 degC"),
    "rad": ("an angle", "2 deg"),
    "deg": ("an angle", "2 deg"),
    "Hz": ("a frequency of turning", "25 rpm"),
    "Hz/s": ("a change of a frequency of turning", "10 rpm/s"),
    "rad/s": ("an angular rate", "25 rpm"),
    "1/s": ("a rate", "50 1/s"),
    "m/s": ("a speed", "5 cm/s"),
    "m/s2": ("an acceleration", "9.81 m/s2"),
    "N": ("a force", "5 mN"),
    "N/m": ("a stiffness, or a force per length", "2 N/cm"),
    "Pa": ("a pressure, a stress or a modulus", "3.2 GPa"),
    "kg/m": ("a mass per length", "0.1 g/m"),
    "kg/m2": ("a mass per area", "50 g/m2"),
    "kg/m3": ("a density", "1.42 g/cm3"),
    "1/m": ("a curvature", "2 1/m"),
    "J": ("an energy", "2 mJ"),
    "N m": ("a torque", "3 mN m"),
    "W": ("a power", "2 mW"),
    "m2": ("an area", "30 cm2"),
    "kg m2": ("a moment of inertia", "3 kg cm2"),
    "kg m2/s": ("an angular momentum", "2 mN m s"),
}
"""What is measured in a unit of this package, and an example of a text for it."""
USUAL = (
    "m", "mm", "um", "cm", "nm", "km", "in", "ft", "mil", "au", "kg", "g", "mg", "s", "ms", "us", "min", "h", "K",
    "degC", "rad", "deg", "Hz", "rpm", "N", "mN", "kN", "Pa", "kPa", "MPa", "GPa", "bar", "psi", "J", "mJ", "W", "%",
    "lb", "lbf", "turn",
)  # fmt: skip
"""Names among which that of an unknown unit is looked for."""
LONGEST, LONGEST_UNIT, MOST_FACTORS, HIGHEST = 200, 60, 8, 9
"""Letters of a text and of its unit, factors of a unit, and their exponents, at most."""
_PREFIXES = {-9: "n", -6: "u", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
"""Prefixes by their powers of ten."""
_PREFIXED = re.compile(r"(?!kg/m3)(m|kg|s|N|Pa|J|W)((?:[ /].*)?)")
"""Units whose first factor is written with a prefix; kg/m3 is not, by custom."""
MOST_KEPT = 1000
"""Units and conversions that are remembered, so that a file of many texts is read quickly."""
LONGEST_SYMBOL = 4
"""Letters of the longest name that is a symbol rather than a word, with an s behind it."""

_TEXT = re.compile(r"\s*([-+\u2212]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+\u2212]?\d+)?)\s*(.*?)\s*", re.DOTALL)
_FACTOR = re.compile(r"([^\W\d_]+(?:_[^\W\d_]+)*)(?:(?:\*\*|\^)?([-+]?\d{1,3}))?")
_SIGNS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻µμ·⋅\u2212", "0123456789-uu**-") | {ord("°"): "deg", ord("%"): "percent"}


class UnitError(InputError):
    """A unit that is no unit."""


@dataclass(frozen=True)
class Number:
    """A number as text, and its unit, taken apart."""

    value: str
    unit: str


def split(text: str) -> Number | None:
    """Number and unit of a text; None where it does not begin with a number."""
    found = _TEXT.fullmatch(text) if len(text) <= LONGEST else None
    return None if found is None else Number(found[1].replace("\u2212", "-"), found[2])


def in_python(value: object, unit: str) -> str:
    """The end of a message about a text with a unit where a script gives a number: how to write it. Else empty."""
    found = split(value) if isinstance(value, str) and unit in KINDS else None
    if found is None or not found.unit:
        return ""
    return f"; write it in SI units, without quotes, or as membrane_rs.units.number({show(value)}, {unit!r})"


def to_si(text: str, unit: str, name: str) -> float:
    """The number that a text with a unit means, in another unit, that of a field.

    Parameters
    ----------
    text : str
        Such as "7.5 um".
    unit : str
        The unit of the result, one that `KINDS` explains; empty for a plain number.
    name : str
        What the number is called in errors; empty where the caller says it.

    Raises
    ------
    InputTypeError
        A text that is no number with a unit.
    InputError
        A unit of another dimension or an unknown one; a number that is not finite, or so small that it would be 0.
    """
    what, example = KINDS.get(unit, (f"a number in {unit}", f"1 {unit}"))
    wanted = f"must be a number{f' ({unit})' if unit else ''}, or a text with its unit such as {example!r}"
    head = f"{name} = {show(text)}" if name else show(text)
    found = split(text)
    if found is None or len(found.unit) > LONGEST_UNIT or found.unit.startswith(","):
        comma = "; write a point for the decimals" if found is not None and found.unit.startswith(",") else ""
        raise InputTypeError(f"{head}: {wanted}{comma}")
    if not found.unit:
        with_unit = f", or with its unit: '{found.value} {unit}'" if unit else ""
        raise InputTypeError(f"{head}: must be a number; write it without quotes{with_unit}")
    value = float(found.value)
    if not math.isfinite(value):
        raise InputError(f"{head}: must be finite{f' ({unit})' if unit else ''}")
    try:
        line = _line(found.unit, unit)
    except UnitError as error:
        text = str(error)
        raise InputError(f"{head}: {text}" if text.endswith("?") else f"{head}: {text}; {wanted}") from None
    if line is None:
        given = kind_of(unit_named(found.unit))
        raise InputError(f"{head}: is {given}; must be {what}{f' ({unit})' if unit else ''}{_such(unit)}")
    factor, offset = line
    result = float(Decimal(found.value) * factor + offset)
    if not math.isfinite(result):
        raise InputError(f"{head}: must be finite{f' ({unit})' if unit else ''}")
    if result == 0.0 and Decimal(found.value) != 0:
        raise InputError(f"{head}: is so small that it would be 0{f' {unit}' if unit else ''}; check number and unit")
    return result


def conversion(unit: str, wanted: str) -> tuple[float, float]:
    """Factor and offset by which a value in one unit becomes one in another: value * factor + offset.

    Raises
    ------
    UnitError
        An unknown unit, or one of another dimension.
    """
    line = _line(unit, wanted)
    if line is None:
        what = KINDS[wanted][0] if wanted in KINDS else "such a quantity"
        given = kind_of(unit_named(unit))
        raise UnitError(f"{show(unit)} is {given}; must be a unit of {what}, such as {wanted!r}")
    return float(line[0]), float(line[1])


def compact(value: float, unit: str, digits: int) -> str:
    """A value in a unit as text, in the notation of that unit, with a prefix where that makes the number shorter."""
    found = _PREFIXED.fullmatch(unit)
    exact = Decimal(repr(value))
    rounded = Decimal(f"{exact:.{digits - 1}e}")
    if found is None or not rounded:
        return f"{value:.{digits}g} {unit}".rstrip()
    # A prefix stands before the gram; a thousand kilograms or seconds have none.
    shift, largest = {"kg": (3, 3), "s": (0, 0)}.get(found[1], (0, 9))
    step = 3 * ((rounded.adjusted() + shift) // 3)
    if step not in _PREFIXES or step > largest:
        return f"{value:.{digits}g} {unit}"
    number = rounded.scaleb(shift - step).normalize()
    return f"{number:f} {_PREFIXES[step]}{found[1][-1] if shift else found[1]}{found[2]}"


def kind_of(unit: Any) -> str:
    """What is measured in a unit of pint, in words, or its dimensions."""
    for symbol, (what, _) in KINDS.items():
        if unit_named(symbol).dimensionality == unit.dimensionality:
            return what
    return f"of dimension {unit.dimensionality}"


@lru_cache(MOST_KEPT)
def unit_named(text: str) -> Any:
    """The unit of pint that a text means. Raises UnitError."""
    registry = _registry()
    made = registry.Unit("")
    if not text:
        return made
    if len(text) > LONGEST_UNIT:
        raise UnitError(f"{show(text)} is no unit: too long")
    for count, (name, exponent) in enumerate(_factors(text.translate(_SIGNS)), start=1):
        if count > MOST_FACTORS or abs(exponent) > HIGHEST:
            raise UnitError(f"unit {show(text)}: too many factors, or an exponent beyond {HIGHEST}")
        made = made * _named(name) ** exponent
    return made


def _named(name: str) -> Any:
    """A unit of one name. Raises UnitError."""
    import pint

    try:
        # pint takes Pas for pascals and Ns for newtons, where products were meant; and it knows differences of degC.
        is_plural = len(name) <= LONGEST_SYMBOL and name.endswith("s") and _is_same(name, name[:-1])
        if is_plural or name.startswith("delta_"):
            raise pint.UndefinedUnitError(name)
        return _registry().parse_units(name)
    except pint.UndefinedUnitError:
        by_lower = {usual.lower(): usual for usual in USUAL}
        close = difflib.get_close_matches(name.lower(), by_lower, n=1)
        hint = f"; did you mean {by_lower[close[0]]!r}?" if close else ""
        raise UnitError(f"unit {name!r} is not known{hint}") from None


def _is_same(name: str, other: str) -> bool:
    """Whether two names are of one unit with one prefix."""
    first, second = ({found[:2] for found in _registry().parse_unit_name(each)} for each in (name, other))
    return bool(first & second)


def _factors(text: str) -> Iterator[tuple[str, int]]:
    """Names and exponents of the factors of a unit. Raises UnitError."""
    for k, part in enumerate(re.split(r"\s*/\s*", text.strip())):
        bare = part[1:-1] if part.startswith("(") and part.endswith(")") else part
        # A star alone multiplies, two raise to a power.
        words = re.split(r"\s*(?<!\*)\*(?!\*)\s*|\s+", bare.strip())
        if words in ([""], ["1"]) and k == 0 and "/" in text:
            continue
        if k > 0 and len(words) > 1 and bare == part:
            raise UnitError(f"unit {show(text)} has two meanings; put what is below the line in brackets")
        for word in words:
            found = _FACTOR.fullmatch(word)
            if found is None:
                raise UnitError(f"{show(text)} is no unit")
            yield found[1], int(found[2] or 1) * (-1 if k else 1)


@lru_cache(MOST_KEPT)
def _line(unit: str, wanted: str) -> tuple[Decimal, Decimal] | None:
    """Factor and offset from a unit to another; None where that is of another dimension. Raises UnitError."""
    import pint

    given, target = unit_named(unit), unit_named(wanted)
    if given.dimensionality != target.dimensionality:
        return None
    try:
        zero, one = (_registry().Quantity(Decimal(value), given).to(target).magnitude for value in (0, 1))
    except (pint.DimensionalityError, pint.OffsetUnitCalculusError):
        raise UnitError("degC and degF stand alone; in a product write K") from None
    return one - zero, zero


def _such(unit: str) -> str:
    """The end of a message about a wrong dimension."""
    turns = "; 1/s may be turns or radians: write Hz, rpm, rad/s or deg/s" if unit.startswith("Hz") else ""
    return f", such as {KINDS[unit][1]!r}{turns}" if unit in KINDS else ""


@cache
def _registry() -> Any:
    """The units that are known."""
    import pint

    return pint.UnitRegistry(DEFINITIONS.strip().splitlines(), non_int_type=Decimal)
