"""Paragraphs of Markdown."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

WIDTH = 118


def paragraph(words: str, first: str = "", further: str = "") -> str:
    """Words in lines of about equal length; `first` and `further` are what lines begin with."""
    return textwrap.fill(
        " ".join(words.split()),
        WIDTH,
        initial_indent=first,
        subsequent_indent=further,
        break_long_words=False,
        break_on_hyphens=False,
    )


def bullets(points: Sequence[str]) -> str:
    """A list of them."""
    return "\n".join(paragraph(point, "- ", "  ") for point in points)
