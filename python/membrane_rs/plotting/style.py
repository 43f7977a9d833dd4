"""How figures look: widths, fonts, colours and lines, as parameters of matplotlib that a user may change.

Colours are those of Okabe and Ito (jfly.uni-koeln.de/color, 2008), which readers with any colour vision distinguish;
the lines differ in their dashes too, for a grey print.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import field
from pathlib import Path
from typing import Annotated, Any

from annotated_types import Ge, Le

from membrane_rs._extras import need
from membrane_rs._files import check_regular, path_of
from membrane_rs._quantities import split, to_si
from membrane_rs._validation import Flag, Positive, Unit, nearest, number_of, show, validated
from membrane_rs.errors import InputError, InputTypeError, MissingFileError

WIDTHS = {"single": 85.0, "double": 174.0}
"""Widths of one and of two columns of a journal [mm]."""
NARROWEST, WIDEST = 20.0, 1000.0
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
DASHES: tuple[Any, ...] = (
    "-",
    (0, (5, 2)),
    (0, (6, 1.5, 1, 1.5)),
    (0, (10, 2)),
    (0, (3, 1, 1, 1, 1, 1)),
    (0, (1, 1.2)),
)
"""Lines as matplotlib takes them: solid, dashed, dash-dotted, long dashes, dash-dot-dotted, dotted."""
INCH = 25.4
"""[mm]"""
MOST_SHEET_BYTES = 2**20
_NOT_A_LOOK = ("backend", "backend_fallback", "interactive", "toolbar", "timezone", "webagg.", "date.epoch")
"""Parameters that choose a program's windows, and are left as they are."""


def width_of(value: float | str, name: str = "width") -> float:
    """A width [mm]: a number, a text with its unit, "single" or "double". Raises InputTypeError and InputError."""
    if isinstance(value, bool):
        raise InputTypeError(f"{name} = {value}: must be a number (mm), 'single' or 'double'")
    millimetres = WIDTHS[value] if isinstance(value, str) and value in WIDTHS else value
    if isinstance(millimetres, str):
        found = split(millimetres)
        if found is None or not found.unit:
            wanted = f"must be a length with its unit such as '85 mm', or {' or '.join(map(repr, WIDTHS))}"
            raise InputError(f"{name} = {show(value)}: {wanted}")
        millimetres = 1e3 * to_si(millimetres, "m", name)
    if not NARROWEST <= millimetres <= WIDEST:
        raise InputError(f"{name} = {show(value)}: must be from {NARROWEST:g} to {WIDEST:g} (mm)")
    return float(millimetres)


@validated
class Style:
    """How figures look. The defaults suit one column of a paper.

    Parameters
    ----------
    width : float or str
        Width of a figure [mm], from 20 to 1000, or a text such as "85 mm"; "single" is 85, "double" is 174.
    panel_height : float, optional
        Height of a panel with its time axis [mm]. Default: 28 and a fifth of the width.
    font : str
        Family of the fonts, as matplotlib knows it.
    font_size : float
        Of labels [pt]; ticks and legends are one point smaller.
    line_width : float
        Of curves [pt].
    colors : sequence of str
        Of curves, one after the other.
    letters : bool
        Whether panels are lettered (a), (b) ...
    title : bool
        Whether the title is drawn.
    marks : bool
        Whether curves that share a kind of line, as those of an energy balance, have marks for a grey print.
    dpi : float
        Resolution of PNG files [1/inch], from 10 to 2400.
    sheets : sequence of str or path
        Style sheets of matplotlib, by name or file, the last one the strongest. They change all but the width.
    rc : mapping
        Parameters of matplotlib (`matplotlib.rcParams`), stronger than the sheets.

    Raises
    ------
    InputTypeError, InputError
        A value of another kind, or outside its range.

    Examples
    --------
    >>> from membrane_rs.plotting import Style
    >>> Style(width="double").millimetres
    174.0
    >>> Style(width=120, rc={"axes.grid": False}).font_size
    8.0
    >>> import matplotlib.pyplot
    >>> with Style(width=80).context():
    ...     figure, axes = matplotlib.pyplot.subplots(figsize=Style(width=80).size(1))
    >>> [round(float(inches), 2) for inches in figure.get_size_inches()]
    [3.15, 1.73]
    """

    width: float | str = "single"
    panel_height: Annotated[Positive, Ge(5), Le(WIDEST), Unit("mm")] | None = None
    font: str = "DejaVu Sans"
    font_size: Annotated[Positive, Ge(2), Le(72), Unit("pt")] = 8.0
    line_width: Annotated[Positive, Le(72), Unit("pt")] = 1.1
    colors: Sequence[str] = COLORS
    letters: Flag = True
    title: Flag = False
    marks: Flag = True
    dpi: Annotated[Positive, Ge(10), Le(2400), Unit("1/inch")] = 300.0
    sheets: Sequence[str | Path] = ()
    rc: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the width, and that there is a colour."""
        _ = self.millimetres
        if not self.colors:
            raise InputError("Style.colors = (): must hold one colour or more")

    @property
    def millimetres(self) -> float:
        """Width of a figure [mm]."""
        return width_of(self.width, "Style.width")

    @property
    def height_of_panel(self) -> float:
        """Height of a panel [mm]."""
        return 28.0 + 0.2 * self.millimetres if self.panel_height is None else self.panel_height

    def size(self, panels: float, *, extra: float = 0.0) -> tuple[float, float]:
        """Width and height of a figure of so many panels above each other.

        Parameters
        ----------
        panels : float
            Number of panels [-].
        extra : float
            Height beside them [mm].

        Returns
        -------
        (float, float)
            [inch]

        Raises
        ------
        InputError, InputTypeError
            No number.
        """
        panels, extra = number_of("panels", panels, ""), number_of("extra", extra, "mm")
        return self.millimetres / INCH, (panels * self.height_of_panel + extra) / INCH

    @contextmanager
    def context(self) -> Iterator[None]:
        """Inside, matplotlib has the parameters of this style, and those of its user's own settings again after that.

        Yields
        ------
        None
            Nothing: it is for a `with`.

        Raises
        ------
        MissingFileError
            A style sheet that is neither a file nor a name that matplotlib knows.
        MissingExtraError
            matplotlib is not installed.
        InputError
            A parameter that matplotlib does not know, or a value that it refuses.
        """
        need("matplotlib", use="figures")
        from matplotlib import rc_context, rcdefaults

        with rc_context():
            rcdefaults()
            _update(self._own(), "Style")
            for sheet in self.sheets:
                _update(_sheet(sheet), f"style sheet {os.fspath(sheet)}")
            _update(self.rc, "Style.rc")
            _update(FILES, "Style")
            yield

    def _own(self) -> dict[str, Any]:
        from cycler import cycler
        from matplotlib.colors import is_color_like

        for color in self.colors:
            if not is_color_like(color):
                raise InputError(f"Style.colors: {show(color)} is no colour of matplotlib; write one as '#0072B2'")
        small = max(self.font_size - 1.0, 1.0)
        return {
            "font.family": [self.font],
            "font.size": self.font_size,
            "axes.labelsize": self.font_size,
            "axes.titlesize": self.font_size,
            "figure.titlesize": self.font_size,
            "xtick.labelsize": small,
            "ytick.labelsize": small,
            "legend.fontsize": small,
            "legend.frameon": False,
            "legend.handlelength": 2.4,
            "lines.linewidth": self.line_width,
            "lines.markersize": 3.0 * self.line_width,
            "axes.prop_cycle": cycler(color=list(self.colors)),
            "axes.linewidth": 0.6,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.grid": True,
            "axes.axisbelow": True,
            "axes.unicode_minus": True,
            "axes.formatter.use_mathtext": True,
            "grid.color": "0.9",
            "grid.linewidth": 0.5,
            "xtick.major.width": 0.6,
            "ytick.major.width": 0.6,
            "xtick.major.size": 2.5,
            "ytick.major.size": 2.5,
            "mathtext.fontset": "dejavusans",
            "figure.dpi": 100.0,
        }


FILES: dict[str, Any] = {
    "savefig.bbox": None,
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
    "svg.fonttype": "none",
    "svg.image_inline": True,
    "svg.hashsalt": "membrane_rs",
}
"""Parameters of all files: their bits follow from the figure, and text stays text."""

PAPER = Style()
"""For one column of a paper: 85 mm, letters, no title, 300 dpi."""
SCREEN = Style(
    width=7.0 * INCH,
    panel_height=3.0 * INCH,
    font_size=10.0,
    line_width=1.5,
    letters=False,
    title=True,
    marks=False,
    dpi=200.0,
)
"""For the folder of a run and a screen: a title, no letters, 200 dpi."""
NAMED = {"paper": PAPER, "screen": SCREEN}


def style_of(given: object, default: Style = SCREEN) -> Style:
    """The style that is given: itself, None for the default, "paper" or "screen", a style sheet or parameters.

    A sheet (the name that matplotlib has for it, or a file) or parameters of matplotlib change that of a paper.

    Raises
    ------
    InputTypeError
        None of these.
    MissingFileError
        A name that is neither a style's, nor a sheet's, nor a file's.
    """
    if given is None:
        return default
    if isinstance(given, Style):
        return given
    if isinstance(given, str) and given in NAMED:
        return NAMED[given]
    if isinstance(given, Mapping):
        return Style(rc=given)
    if isinstance(given, str | os.PathLike):
        _sheet(given)
        return Style(sheets=(path_of(given, "style") if isinstance(given, os.PathLike) else given,))
    raise InputTypeError(
        f"style = {show(given)}: must be a Style, 'paper', 'screen', a style sheet of matplotlib, or its parameters"
    )


def _sheet(sheet: str | os.PathLike[str]) -> Mapping[str, Any]:
    """The parameters of a style sheet, by the name that matplotlib has for it, or of a file."""
    import logging

    need("matplotlib", use="style sheets")
    from matplotlib import rc_params_from_file, style

    if isinstance(sheet, str) and sheet in style.library:
        return plain(style.library[sheet])
    path = path_of(sheet, "style")
    if not path.is_file():
        known = nearest(path.name, (*NAMED, *style.available))
        raise MissingFileError(f"style = {path}: no such file, and no style of matplotlib; {known}")
    lines: list[str] = []
    handler = logging.Handler()
    handler.emit = lambda record: lines.append(record.getMessage())  # type: ignore[method-assign]
    logger = logging.getLogger("matplotlib")
    logger.addHandler(handler)
    propagates, logger.propagate = logger.propagate, False
    try:
        check_regular(path, MOST_SHEET_BYTES)
        found = plain(rc_params_from_file(path, use_default_template=False))
    except OSError as error:
        raise InputError(f"style = {path}: {error.strerror or error}; name a style sheet of matplotlib") from None
    except (ValueError, UnicodeError, KeyError) as error:
        raise InputError(f"style = {path}: is no style sheet of matplotlib ({' '.join(str(error).split())})") from None
    finally:
        logger.removeHandler(handler)
        logger.propagate = propagates
    if lines:  # matplotlib itself goes on without such a line
        raise InputError(f"style = {path}: {' '.join(lines[0].split())}; correct or remove this line")
    return found


def plain(parameters: Any) -> dict[str, Any]:
    """Parameters of matplotlib as a dictionary with any names."""
    return dict(parameters)


def _update(values: Mapping[str, Any], where: str) -> None:
    """Set parameters of matplotlib. Raises InputError, which names what is wrong."""
    import matplotlib

    known: Any = matplotlib.rcParams
    for name, value in values.items():
        if isinstance(name, str) and name.startswith(_NOT_A_LOOK):
            continue
        if name not in known:
            raise InputError(f"{where}: matplotlib has no parameter {show(name)}; {nearest(str(name), known)}")
        _checked(lambda name=name, value=value: known.__setitem__(name, value), f"{where}: {name}", value)


def _checked(call: Any, where: str, value: object) -> Any:
    try:
        return call()
    except (ValueError, TypeError) as error:
        reason = " ".join(str(error).split())[:200]
        raise InputError(f"{where} = {show(value)}: matplotlib refuses it ({reason})") from None
