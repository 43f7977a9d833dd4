"""What charts by matplotlib share: their formats, and texts of users in them."""

from __future__ import annotations

from pathlib import Path

from membrane_rs.errors import InputError

FORMATS = ("png", "pdf", "svg")


def chart_format(path: Path) -> str:
    """The format of a chart, by the ending of its name. Raises InputError for one that is not written."""
    kind = path.suffix.removeprefix(".").lower()
    if kind not in FORMATS:
        raise InputError(f"path = {str(path)!r}: must end in one of {', '.join('.' + known for known in FORMATS)}")
    return kind


def plain_text(text: str) -> str:
    """A text as matplotlib shows it letter by letter: `$` begins no formula, `_` hides no entry of a legend."""
    shown = text.replace("$", r"\$").encode(errors="replace").decode()
    return f" {shown}" if shown.startswith("_") else shown
