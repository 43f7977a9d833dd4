"""Units at the edge: text such as "7.5 um" or "25 rpm" to numbers in SI, and back.

Inside, all is in SI units, angles in radians; so is all that is written. Scene files, `Scene.with_values` and the
command line take text with a unit wherever a number is wanted; a script does the same with this module. pint is loaded
at the first text with a unit.

>>> from membrane_rs import units
>>> units.number("7.5 um", "m"), units.number("30 rpm", "Hz"), units.number("20 degC", "K")
(7.5e-06, 0.5, 293.15)
>>> units.text(7.5e-6, "m"), units.text(3.2e9, "Pa"), units.text(0.36e-3, "kg")
('7.5 um', '3.2 GPa', '360 mg')
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from membrane_rs._arrays import Floats
from membrane_rs._fields import unit_of
from membrane_rs._given_arrays import numeric
from membrane_rs._messages import show
from membrane_rs._quantities import KINDS, UnitError, compact, conversion, to_si
from membrane_rs._validation import check_kind, number_of
from membrane_rs.errors import InputError, InputTypeError

__all__ = ["KNOWN", "convert", "number", "of", "text"]

KNOWN: Mapping[str, tuple[str, str]] = MappingProxyType(KINDS)
"""What is measured in each unit of this package, and an example of a text for it."""


def number(value: str | float, unit: str, name: str = "value") -> float:
    """A number in SI units, from a text with a unit.

    Parameters
    ----------
    value : str or float
        Such as "7.5 um"; a number is taken as it is, in the unit of the result.
    unit : str
        In which the result is, such as "m", "Pa", "kg/m3", "Hz", "rad"; empty for a plain number.
    name : str
        What the number is called in errors.

    Returns
    -------
    float
        The number that was written, in the unit asked for, to the last bit: "7.5 um" is 7.5e-6.

    Raises
    ------
    InputTypeError
        No number, and no text of a number with a unit.
    InputError
        An unknown unit, one of another dimension, a number that is not finite.

    Examples
    --------
    >>> from membrane_rs import units
    >>> units.number("3.2 GPa", "Pa")
    3200000000.0
    >>> units.number("3 1/s", "Hz")
    Traceback (most recent call last):
    membrane_rs.errors.InputError: value = '3 1/s': is a rate; must be a frequency of turning (Hz), such as '25 rpm'; \
1/s may be turns or radians: write Hz, rpm, rad/s or deg/s
    """
    check_kind(name, str, "name", "a text: what the number is called in errors")
    _check_unit(unit)
    return to_si(value, unit, name) if isinstance(value, str) else number_of(name, value, unit)


def convert(values: ArrayLike, unit: str, wanted: str) -> Floats:
    """Numbers in one unit as numbers in another.

    Parameters
    ----------
    values : (...) array_like of float
        Numbers, in their unit.
    unit, wanted : str
        The unit that they are in, and the one that is wanted.

    Returns
    -------
    (...) array of float
        A new array, in the unit that is wanted.

    Raises
    ------
    InputError
        An unknown unit, or one of another dimension than the other.
    InputTypeError
        What is no array of numbers.

    Examples
    --------
    >>> from membrane_rs import units
    >>> units.convert([0.0, 0.5], "Hz", "rpm")
    array([ 0., 30.])
    """
    for name, given in (("unit", unit), ("wanted", wanted)):
        check_kind(given, str, name, "a text such as 'm' or 'kg/m3'")
    factor, offset = conversion(unit, wanted)
    return numeric(values, "values", "fiu", "numbers").astype(np.float64) * factor + offset


def of(cls: type, field: str) -> str:
    """The unit of a field of a material, a law, a part, a body, a pattern, a stage or run settings.

    Parameters
    ----------
    cls : type
        The class, such as `Material`.
    field : str
        The name of the field.

    Returns
    -------
    str
        Its unit; empty for a plain number, for what is no number, and where it depends on other fields.

    Raises
    ------
    InputError
        No such field.

    Examples
    --------
    >>> from membrane_rs import Material, units
    >>> units.of(Material, "density")
    'kg/m3'
    """
    known = getattr(cls, "__pydantic_fields__", {})
    if not isinstance(field, str) or field not in known:
        what = field if isinstance(field, str) else show(field)
        where = f"{getattr(cls, '__name__', show(cls))}.{what:.60}"
        raise InputError(f"{where}: no such field; known are: {', '.join(known)}")
    return unit_of(cls, field) or ""


def text(value: float, unit: str, digits: int = 4) -> str:
    """A number in SI units as a short text with a unit, with a prefix where that makes it shorter.

    Parameters
    ----------
    value : float
        The number, in its unit.
    unit : str
        Of the number, in SI.
    digits : int
        Significant digits, from 1 to 17.

    Returns
    -------
    str
        Which `number` reads.

    Raises
    ------
    InputError, InputTypeError
        A number that is not finite, an unknown unit, no number of digits.

    Examples
    --------
    >>> from membrane_rs import units
    >>> units.text(2.5e-6, "s"), units.text(17.0, "N"), units.text(0.02, "")
    ('2.5 us', '17 N', '0.02')
    """
    if isinstance(digits, bool) or not isinstance(digits, int) or not 1 <= digits <= 17:
        raise InputTypeError(f"digits = {show(digits)}: must be a whole number from 1 to 17")
    _check_unit(unit)
    return compact(number_of("value", value, unit), unit, digits)


def _check_unit(unit: str) -> None:
    """Refuse what is no unit. Raises InputError."""
    check_kind(unit, str, "unit", "a text such as 'm' or 'kg/m3'")
    if unit not in KINDS:
        try:
            conversion(unit, unit)
        except UnitError as error:
            raise InputError(f"unit = {show(unit)}: {error}; write one such as 'm' or 'kg/m3'") from None
