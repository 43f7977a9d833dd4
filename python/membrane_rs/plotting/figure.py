"""Figures of curves as files: the format by the ending of the name."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from membrane_rs._files import replacing
from membrane_rs._validation import number_of
from membrane_rs.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DPI = 200.0
"""Resolution of pictures in pixels [1/inch]."""
FORMATS: dict[str, dict[str, None] | None] = {".png": None, ".pdf": {"CreationDate": None}, ".svg": {"Date": None}}
"""Metadata by the ending of the name: without the time, so that the same figure is the same file."""


def save_figure(figure: Figure, path: Path, dpi: float | None = None) -> None:
    """Write a figure as PNG, PDF or SVG, by the ending of `path`, whole or not at all.

    Raises
    ------
    InputError
        Another ending, or `dpi` that is not from 10 to 2400.
    OutputError
        `path` cannot be written.
    """
    from matplotlib import rc_context

    dots = DPI if dpi is None else number_of("dpi", dpi, "pixels per inch")
    if not 10.0 <= dots <= 2400.0:
        raise InputError(f"dpi = {dpi}: must be from 10 to 2400 (pixels per inch)")
    ending = path.suffix.lower()
    if ending not in FORMATS:
        raise InputError(f"{path}: the ending {ending!r} is no format of a figure; must be one of {', '.join(FORMATS)}")
    with replacing(path) as part, rc_context({"svg.hashsalt": "membrane_rs"}):
        figure.savefig(part, format=ending[1:], dpi=dots, metadata=FORMATS[ending])


def plain_text(text: str) -> str:
    """A text as matplotlib shows it letter by letter: `$` begins no formula, `_` hides no entry of a legend."""
    shown = text.replace("$", r"\$").encode(errors="replace").decode()
    return f" {shown}" if shown.startswith("_") else shown
