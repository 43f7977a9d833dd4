"""Warnings, each at the line of code that asked for what it is about."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

_PACKAGE = Path(__file__).parent
_INNER = (__file__, *(f"{_PACKAGE / name}/" for name in ("check", "report", "results", "runs", "simulation")))
"""The code through which a call goes to the place that warns."""


def warn(text: str, category: type[Warning] = UserWarning) -> None:
    """Warn at the line that called the code of runs from outside: of a user, or of a study or command."""
    frame, level = sys._getframe(), 1
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_INNER):
        frame, level = frame.f_back, level + 1
    warnings.warn(text, category, stacklevel=level)
