"""Panels of curves against time, above each other: runs as lines, experiments as marks, ensembles as bands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.plotting.columns import axis_label, label_of, prefixed, unit_of
from membrane_rs.plotting.drawable import count_beyond, drawable, note_beyond
from membrane_rs.plotting.ensemble import Band, Ensemble
from membrane_rs.plotting.figure import add_letters, add_title, new_figure, plain_text
from membrane_rs.plotting.sources import Source
from membrane_rs.plotting.stage_marks import mark_stages, stage_starts
from membrane_rs.plotting.style import DASHES, INCH, Style
from membrane_rs.results.experiment import DEVIATION

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from membrane_rs.plotting.styled_figure import StyledFigure

MARKS = "osD^vPX"
DENSE = 100
"""Points of an experiment beyond which their marks would hide the curves."""
_BAND = 0.22
_THIN = 0.4
"""Width of the line of a member of an ensemble [pt]."""


@dataclass(frozen=True)
class Content:
    """What is drawn: runs, experiments and ensembles."""

    runs: Sequence[Source] = ()
    experiments: Sequence[Source] = ()
    ensembles: Sequence[Ensemble] = ()

    @property
    def tables(self) -> list[Any]:
        """All tables."""
        some = [source.table for source in (*self.runs, *self.experiments)]
        return [*some, *(source.table for ensemble in self.ensembles for source in ensemble.members)]

    def given(self, panel: Panel) -> list[Any]:
        """The times and the values of a panel as they were given."""
        shown = [source.table for k, source in enumerate(self.runs) if k not in panel.without]
        tables = [*shown, *self.tables[len(self.runs) :]]
        return [table[name] for table in tables for name in ("time", *panel.columns) if name in table]


@dataclass(frozen=True)
class Panel:
    """Columns in one panel, and levels that are marked by a thin line; those whose curves are of rounding are in
    `without`, by index of the run.
    """

    columns: Sequence[str]
    label: str | None = None
    levels: Sequence[float] = ()
    without: frozenset[int] = field(default_factory=frozenset)


def draw_panels(content: Content, panels: Sequence[Panel], style: Style, title: str) -> tuple[StyledFigure, list[Axes]]:
    """The figure, and its panels, which share the time axis; inside the context of the style."""
    figure = new_figure(style, style.size(len(panels), extra=0.4 * INCH if style.title else 2.0))
    places = list(figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0])
    for axes, panel in zip(places, panels, strict=True):
        _draw(axes, panel, content)
        fit_label(axes, style)
        axes.margins(x=0.0)
    if len(content.runs) == 1 and not content.ensembles:
        source = content.runs[0]
        mark_stages(places, stage_starts(source.table), source.stages)
    space_times(places[-1], style)
    places[-1].set_xlabel(axis_label(label_of("time"), "s"))
    add_letters(places, style)
    add_title(places[0], title, style)
    shared = [axes for axes, panel in zip(places, panels, strict=True) if len(panel.columns) == 1]
    for axes in places:
        if axes not in shared:
            _add_own_legend(axes, style)
    add_legend(figure, shared, style)
    figure.align_ylabels(places)
    return figure, places


def line_look(index: int) -> dict[str, Any]:
    """Colour and dashes of a curve, so that curves differ in colour and in a grey print."""
    from matplotlib import rcParams

    colors = rcParams["axes.prop_cycle"].by_key().get("color", ["C0"])
    return {"color": colors[index % len(colors)], "linestyle": DASHES[index % len(DASHES)]}


def add_legend(figure: StyledFigure, places: Sequence[Axes], style: Style) -> None:
    """One legend above all panels, beside no curve, of what has a label in any of them."""
    known: dict[str, Any] = {}
    for axes in places:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            known.setdefault(label, handle)
    if known:
        size, columns = _small(style), _legend_columns(list(known), style.millimetres, style)
        figure.legend(list(known.values()), list(known), loc="outside upper center", ncols=columns)
        width, height = figure.get_size_inches()
        figure.set_size_inches(width, height + 1.6 * size * -(-len(known) // columns) / INCH)


def _add_own_legend(axes: Axes, style: Style) -> None:
    """A legend of one panel, above it at the right."""
    handles, labels = axes.get_legend_handles_labels()
    columns = _legend_columns(labels, style.millimetres - 25.0, style)
    axes.legend(handles, labels, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, borderaxespad=0.1)


def _legend_columns(labels: Sequence[str], room: float, style: Style) -> int:
    """Columns of a legend that has so much room [mm]: a line and the space beside it are 5 of the size of the font."""
    longest = max(map(_width_of_text, labels), default=0.0) * INCH / 72.0 + 5.0 * _small(style)
    return max(1, min(len(labels), int(room / longest)))


def space_times(axes: Axes, style: Style) -> None:
    """As many marks of the time axis as have room: each takes up to eight letters, of 0.6 of the size of the font."""
    from matplotlib.ticker import MaxNLocator

    room = max(style.millimetres - 20.0, 10.0) / (0.6 * 8.0 * _small(style))
    axes.xaxis.set_major_locator(MaxNLocator(max(2, min(9, int(room))), steps=[1, 2, 2.5, 5, 10]))


def fit_label(axes: Axes, style: Style) -> None:
    """Put the unit in a line of its own where the label is longer than the panel is high."""
    room = (style.height_of_panel - 2.0) / INCH * 72.0
    text = axes.get_ylabel()
    if _width_of_text(text) * style.font_size / max(style.font_size - 1.0, 1.0) > room:
        axes.set_ylabel(text.replace(" [", "\n["))


def _small(style: Style) -> float:
    """Size of the font of ticks and legends [mm]."""
    return max(style.font_size - 1.0, 1.0) * INCH / 72.0


def _width_of_text(text: str) -> float:
    """In the font of legends [pt]; inside the context of the style."""
    if not text:
        return 0.0
    from matplotlib import rcParams
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    font = FontProperties(size=rcParams["legend.fontsize"])
    path = TextPath((0.0, 0.0), text, font.get_size_in_points(), prop=font)
    return float(path.get_extents().width) if len(path.vertices) else 0.0


def _draw(axes: Axes, panel: Panel, content: Content) -> None:
    bands = [[ensemble.band(column) for column in panel.columns] for ensemble in content.ensembles]
    curves = [
        source.column(column) for source in _with(content, panel) for column in panel.columns if column in source.table
    ]
    edges = [edge for some in bands for band in some for edge in (band.low, band.high)]
    units = {unit_of(column, content.tables) for column in panel.columns}
    factor, unit = prefixed(units.pop(), [*curves, *edges]) if len(units) == 1 else (1.0, "")
    for level in panel.levels:
        axes.axhline(level / factor, color="0.5", linewidth=0.8)
    index = 0
    for ensemble, some in zip(content.ensembles, bands, strict=True):
        for column, band in zip(panel.columns, some, strict=True):
            _draw_band(axes, band, factor, index, _entry(ensemble.label, column, panel))
            for member in ensemble.members if ensemble.shows_members else ():
                look = {"color": line_look(index)["color"], "alpha": 0.6, "linewidth": _THIN}
                axes.plot(member.time, member.column(column) / factor, **look)
            index += 1
    for k, source in enumerate(content.runs):
        for column in panel.columns:
            if column in source.table and k not in panel.without:
                entry = _entry(source.label, column, panel)
                axes.plot(source.time, source.column(column) / factor, label=entry, **line_look(index))
            index += 1
    for k, source in enumerate(content.experiments):
        for column in panel.columns:
            if column in source.table:
                mark = {"marker": MARKS[k % len(MARKS)], "label": _entry(source.label, column, panel)}
                _draw_marks(axes, source, column, factor, mark)
    note_beyond(axes, count_beyond(content.given(panel)))
    label = label_of(panel.columns[0]) if panel.label is None and len(panel.columns) == 1 else panel.label or ""
    axes.set_ylabel(axis_label(plain_text(label), unit))


def _with(content: Content, panel: Panel) -> list[Source]:
    runs = [source for k, source in enumerate(content.runs) if k not in panel.without]
    return [*runs, *content.experiments]


def _entry(label: str, column: str, panel: Panel) -> str:
    """What a curve is called in the legend; an empty text: it has no entry."""
    parts = [label, label_of(column)] if len(panel.columns) > 1 else [label]
    return plain_text(": ".join(part for part in parts if part))


def _draw_band(axes: Axes, band: Band, factor: float, index: int, entry: str) -> None:
    some = line_look(index)
    axes.fill_between(band.time, band.low / factor, band.high / factor, color=some["color"], alpha=_BAND, linewidth=0.0)
    axes.plot(band.time, band.mean / factor, label=entry, **some)


def _draw_marks(axes: Axes, source: Source, column: str, factor: float, look: dict[str, Any]) -> None:
    """Hollow marks, with bars where the standard deviation is known; of many points dots behind the curves."""
    is_dense = len(source.time) > DENSE
    uncertainty = source.table.get(column + DEVIATION)
    axes.errorbar(
        source.time,
        source.column(column) / factor,
        yerr=None if uncertainty is None else np.abs(drawable(uncertainty)) / factor,
        linestyle="none",
        color="0.6" if is_dense else "black",
        markerfacecolor="0.6" if is_dense else "white",
        markeredgewidth=0.0 if is_dense else 0.8,
        markersize=4.5 if is_dense else 4.0,
        elinewidth=0.7,
        capsize=0.0 if is_dense else 1.5,
        zorder=1.5 if is_dense else 3,
        **look,
    )


def values_of(content: Content, panel: Panel) -> list[Floats]:
    """All values that a panel shows."""
    found = [source.column(name) for source in _with(content, panel) for name in panel.columns if name in source.table]
    bands = [ensemble.band(name) for ensemble in content.ensembles for name in panel.columns]
    shown = [source for ensemble in content.ensembles if ensemble.shows_members for source in ensemble.members]
    members = [source.column(name) for source in shown for name in panel.columns]
    return [*found, *members, *(edge for band in bands for edge in (band.low, band.high))]
