"""Figures as objects of matplotlib without pyplot, and as files: the format by the ending of the name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from membrane_rs._files import path_of, replacing
from membrane_rs._validation import check_kind, number_of
from membrane_rs.errors import InputError
from membrane_rs.plotting.style import FILES, Style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from membrane_rs.plotting.styled_figure import StyledFigure

DPI = 200.0
"""Resolution of pictures in pixels [1/inch]."""
FORMATS: dict[str, dict[str, None] | None] = {".png": None, ".pdf": {"CreationDate": None}, ".svg": {"Date": None}}
"""Metadata by the ending of the name: without the time, so that the same figure is the same file."""
LETTERS = "abcdefghijklmnopqrstuvwxyz"


def save_figure(figure: Figure, path: Path | str, dpi: float | None = None) -> None:
    """Write a figure as PNG, PDF or SVG, by the ending of `path`, whole or not at all.

    The same figure gives the same bits: a file holds no date. Text stays text, in PDF with its fonts, as TrueType, in
    SVG by the name of its font.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        What a function of this package returns, or any other.
    path : path
        The file.
    dpi : float, optional
        Resolution [1/inch]. Default: that of the figure's style; 200 for figures of others.

    Raises
    ------
    InputError
        Another ending, `dpi` that is not from 10 to 2400, or a style that matplotlib cannot draw.
    InputTypeError
        No figure, no path, or no number.
    OutputError
        `path` cannot be written.

    Examples
    --------
    >>> import numpy as np
    >>> from membrane_rs.plotting import plot_history, save_figure
    >>> figure = plot_history({"time": np.arange(3.0), "hub_torque": np.ones(3)}, ["hub_torque"], style="paper")
    >>> save_figure(figure, "torque.pdf")
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    check_kind(figure, Figure, "figure", "a figure of matplotlib")
    path = path_of(path)
    files: Any = FILES
    own = figure.style.dpi if isinstance(figure, _styled()) else DPI
    dots = own if dpi is None else _checked(dpi)
    ending = path.suffix.lower()
    if ending not in FORMATS:
        raise InputError(f"{path}: the ending {ending!r} is no format of a figure; must be one of {', '.join(FORMATS)}")
    with replacing(path) as part, rc_context(files):
        try:
            figure.savefig(part, format=ending[1:], dpi=dots, metadata=FORMATS[ending])
        except (RuntimeError, ArithmeticError, ValueError) as error:
            reason = " ".join(str(error).split())[:200]
            raise InputError(f"{path}: matplotlib cannot draw this figure ({reason}); change its style") from error


def new_figure(style: Style, size: tuple[float, float]) -> StyledFigure:
    """An empty figure of width and height [inch], laid out by its content; called inside the context of the style."""
    figure = _styled()(figsize=size, layout="constrained")
    figure.style = style
    return figure


def finished(figure: StyledFigure, path: Path | str | None, dpi: float | None) -> StyledFigure:
    """The figure, saved where there is a path, with another resolution where one is given."""
    if dpi is not None:
        figure.style = replace(figure.style, dpi=_checked(dpi))
    if path is not None:
        save_figure(figure, path)
    return figure


def _checked(dpi: object) -> float:
    dots = number_of("dpi", dpi, "pixels per inch")
    if not 10.0 <= dots <= 2400.0:
        raise InputError(f"dpi = {dpi}: must be from 10 to 2400 (pixels per inch)")
    return dots


def _styled() -> type[StyledFigure]:
    from membrane_rs.plotting.styled_figure import StyledFigure

    return StyledFigure


def add_title(axes: Axes, title: str, style: Style) -> None:
    """The title above the first panel, where the style has one."""
    if style.title:
        axes.set_title(plain_text(title), wrap=True)


def add_letters(panels: Sequence[Axes], style: Style) -> None:
    """(a), (b) ... at the upper left of panels, where the style has them and there is more than one."""
    for axes, letter in zip(panels if style.letters and len(panels) > 1 else (), LETTERS, strict=False):
        axes.set_title(f"({letter})", loc="left")


def plain_text(text: str) -> str:
    """A text as matplotlib shows it letter by letter: `$` begins no formula, `_` hides no entry of a legend."""
    shown = text.replace("$", r"\$").encode(errors="replace").decode()
    return f" {shown}" if shown.startswith("_") else shown
