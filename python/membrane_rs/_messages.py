"""Words of messages: values in one line, and the known word that an unknown one may stand for."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from functools import partial
from pathlib import Path

from membrane_rs._other_names import OTHER_NAMES

LONGEST_MESSAGE = 300
"""Characters of a message of another program, at most."""


def nearest(word: str, known: Iterable[str], place: str = "") -> str:
    """The end of a message about an unknown word: the known word that means it, or the nearest one, or all of them.

    The one that is meant is shown behind its place: "laws.creases.".
    """
    words = sorted(known)
    other = word.strip().lower().replace("'", "").replace("-", "_").replace(" ", "_")
    for name, unit in OTHER_NAMES.get(other, ()):
        if name in words:
            return f"did you mean '{place}{name}'{f' ({unit})' if unit else ''}?"
    close = difflib.get_close_matches(word, words, n=1)
    return f"did you mean '{place}{close[0]}'?" if close else "known are: " + ", ".join(words)


def show(value: object) -> str:
    """A value as messages show it: short, and in one line."""
    if isinstance(value, float):
        return repr(float(value))
    try:
        text = " ".join(repr(value).split())
    except ValueError:  # Python writes no integer of more than some thousand digits
        return "a number of thousands of digits"
    return text if len(text) <= 60 else text[:57] + "..."


def function_words(function: object) -> str:
    """A user's function, as messages call it: by its name, of a lambda by where it stands."""
    while isinstance(function, partial):
        function = function.func
    name = str(getattr(function, "__qualname__", type(function).__name__)).rpartition("<locals>.")[2]
    code = getattr(function, "__code__", None)
    if name != "<lambda>" or code is None:
        return name
    return f"a lambda in line {code.co_firstlineno} of {Path(code.co_filename).name}"


def in_one_line(error: BaseException) -> str:
    """An error of a user's function: its kind and its message, short and in one line."""
    words = " ".join(str(error).split())
    if len(words) > LONGEST_MESSAGE:
        words = words[: LONGEST_MESSAGE - 3] + "..."
    return f"{type(error).__name__}: {words}" if words else type(error).__name__
