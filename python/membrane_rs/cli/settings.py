"""Values of the command line by dotted keys: `--set laws.creases.stiffness=20`."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from importlib import import_module
from typing import Any

from membrane_rs._validation import show
from membrane_rs.errors import InputError

tomllib = import_module("tomllib" if sys.version_info >= (3, 11) else "tomli")

LONGEST = 10_000
"""Letters of the longest value that is read."""
_OTHER_NUMBER = re.compile(r"[+-]?([0-9]+\.|\.[0-9]+)([eE][+-]?[0-9]+)?", re.ASCII)
"""Numbers that TOML has not, since digits are missing before or after their point: .3, 1."""
_OTHER_WORDS = {"True": True, "False": False}
"""Truth as Python writes it."""


def values_of(texts: Iterable[str], option: str = "--set") -> dict[str, Any]:
    """Values by keys, from texts such as "laws.spin.frequency=25 rpm".

    Raises
    ------
    InputError
        A text without a key or a value, two values for one key, a value that is neither of TOML nor plain text.
    """
    found: dict[str, Any] = {}
    for text in texts:
        key, sign, value = text.partition("=")
        key = key.strip()
        if not (key and sign and value.strip()):
            raise InputError(f"{option} {show(text)}: must be KEY=VALUE, such as laws.creases.stiffness=20")
        if key in found:
            raise InputError(f"{option} {show(text)}: {key} has a value already; leave out one of them")
        found[key] = value_of(value, f"{option} {key}")
    return found


def value_of(text: str, name: str) -> Any:
    """A value as TOML has it, or a plain text: 20, true, [0, 0, -9.81], {stiffness = 20}, "cross", cross, 25 rpm.

    Numbers such as .3 and 1. are numbers as well, True and False are true and false.

    Raises
    ------
    InputError
        What begins as a list, a table or a text in quotes, and is none; a text that is too long.
    """
    text = text.strip()
    if len(text) > LONGEST:
        raise InputError(f"{name} = {show(text)}: has {len(text)} letters; must have at most {LONGEST}")
    if _OTHER_NUMBER.fullmatch(text):
        return float(text)
    if text in _OTHER_WORDS:
        return _OTHER_WORDS[text]
    try:
        table = tomllib.loads(f"value = {text}")
        if len(table) == 1 and "\n" not in text:
            return table["value"]
        reason = "more than one line"
    except tomllib.TOMLDecodeError as error:
        reason = str(error)
    except (RecursionError, ValueError):
        reason = "nested too deeply, or a number of thousands of digits"
    if text[0] in "[{\"'" or not text.isprintable():
        raise InputError(
            f"{name} = {show(text)}: is no value of TOML ({reason}); write one such as 20 or [0, 0, -9.81]"
        )
    return text
