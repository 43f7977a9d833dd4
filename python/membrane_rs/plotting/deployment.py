"""Curves against time: deployment rate and phase difference, as in Figs. 14 to 17 of Okuizumi et al. 2012.

A dotted line marks the time at which the phase comes back through zero, and a thin grey one the start of a stage.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING, Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._files import path_of
from membrane_rs._validation import check_kind
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.plotting.drawing import Drawing
from membrane_rs.plotting.figure import finished, save_figure
from membrane_rs.plotting.panels import Content, Panel, draw_panels, line_look, values_of
from membrane_rs.plotting.sources import Source, sources_of
from membrane_rs.plotting.style import SCREEN, Style, style_of
from membrane_rs.results.features import LEAST_PHASE, curve_features
from membrane_rs.results.history import read_history
from membrane_rs.simulation.stepper import Stepper

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from membrane_rs.plotting.styled_figure import StyledFigure

# Column, label, and the level that is full deployment.
PANELS = (
    ("deployment_rate", "Deployment rate", 1.0),
    ("phase_difference_deg", "Phase difference [deg]", 0.0),
)
_AWAY = 2.0
"""Distance from a level, over the range of the curves, up to which the scale reaches it."""
_STEADY = 1e-6
"""Range below which a curve does not change: rounding of the rate, or in degrees of the phase."""


class DeploymentPicture(Drawing):
    """Draws deployment.png from the history, where that has two samples or more."""

    own_files = ("deployment.png",)

    def draw(self, sim: Stepper) -> None:
        """Draw it."""
        if len(self.record.table["time"]) > 1:
            names = [record.name for record in sim.stages]
            content = Content([Source("", self.record.table, names)])
            with SCREEN.context():
                figure = draw_deployment(content, deployment_panels(content), SCREEN, sim.scene.name)
            save_figure(figure, self.record.path / "deployment.png")


def plot_deployment(
    table: Any,
    path: Path | str | None = None,
    title: str = "",
    dpi: float | None = None,
    *,
    labels: Sequence[str] | None = None,
    style: Style | str | Path | Mapping[str, Any] | None = None,
) -> Figure:
    """Deployment rate and phase difference against time, of one run or several.

    Without a hub that turns, or corners that turn relative to it by more than rounding, the phase is left out.

    Parameters
    ----------
    table : history, run, sequence or mapping of them
        A history is a mapping of names of columns to (samples,) arrays, with "time" [s]; what has a `history` is a run.
        A mapping gives each its label.
    path : path, optional
        A PNG, PDF or SVG file, by its ending. Default: none is written.
    title : str
        Where the style has one.
    dpi : float, optional
        Resolution of a PNG file [1/inch]. Default: the style's.
    labels : sequence of str, optional
        Of several runs.
    style : Style, str, path or mapping, optional
        "screen" (the default), "paper", a `Style`, a style sheet of matplotlib, or its parameters.

    Returns
    -------
    matplotlib.figure.Figure
        Without pyplot: nothing has to be closed.

    Raises
    ------
    InputTypeError
        What is no history with these columns.
    InputError
        Another ending of `path`; a style or resolution that does not exist.
    MissingFileError
        No style sheet of that name.
    OutputError
        `path` cannot be written.

    Examples
    --------
    >>> import numpy as np
    >>> from membrane_rs.plotting import plot_deployment
    >>> time = np.linspace(0.0, 1.0, 50)
    >>> table = {"time": time, "deployment_rate": time, "phase_difference_deg": -9.0 * np.sin(time)}
    >>> figure = plot_deployment(table, style="paper")
    >>> [axes.get_ylabel() for axes in figure.axes]
    ['Deployment rate', 'Phase difference [deg]']
    """
    look = style_of(style)
    check_kind(title, str, "title", "a text")
    content = Content(sources_of(table, labels, [column for column, _, _ in PANELS]))
    with look.context():
        figure = draw_deployment(content, deployment_panels(content), look, title)
    return finished(figure, path, dpi)


def compare_runs(
    folders: Sequence[Path | str],
    path: Path | str | None = None,
    labels: Sequence[str] | None = None,
    dpi: float | None = None,
    *,
    style: Style | str | Path | Mapping[str, Any] | None = None,
) -> Figure:
    """Deployment rate and phase difference of several runs by their folders, as `plot_deployment` draws them.

    Parameters
    ----------
    folders : sequence of paths
        Of the runs.
    path, dpi, style
        As for `plot_deployment`.
    labels : sequence of str, optional
        One for each folder. Default: their names.

    Returns
    -------
    matplotlib.figure.Figure
        Without pyplot: nothing has to be closed.

    Raises
    ------
    InputError
        Another number of labels than of folders.
    InputTypeError
        What is no list of paths.
    MissingFileError
        A folder without history, or no style sheet of that name.
    OutputError
        `path` cannot be written.

    Examples
    --------
    >>> from membrane_rs import Simulation, scenes
    >>> from membrane_rs.plotting import compare_runs
    >>> for dt in (1e-5, 2e-5):
    ...     folder = Simulation(scenes.load("spinning-tether"), dt=dt).run(0.01, out=f"runs/{dt:g}", pictures=False)
    >>> figure = compare_runs(["runs/1e-05", "runs/2e-05"], labels=["10 us", "20 us"])
    """
    if isinstance(folders, str | Path) or not isinstance(folders, Sequence) or not folders:
        raise InputTypeError(f"folders = {folders!r:.60}: must be a list of one or more folders of runs")
    paths = [path_of(folder, "folders") for folder in folders]
    check_kind(labels, (Sequence, NoneType), "labels", "a list of texts, one for each folder")
    names = [path.name for path in paths] if labels is None else list(labels)
    for name in names:
        check_kind(name, str, "labels", "a list of texts, one for each folder")
    if len(names) != len(folders):
        raise InputError(f"{len(names)} labels for {len(folders)} runs; give one for each, or none at all")
    tables = [read_history(path) for path in paths]
    return plot_deployment(list(tables), path, dpi=dpi, labels=names, style=style)


def turns(table: Mapping[str, Floats]) -> bool:
    """Whether a hub turns, where the table says so, and corners turn relative to it by more than rounding."""
    angle, phase = table.get("hub_angle"), np.asarray(table["phase_difference_deg"], dtype=np.float64)
    known = phase[np.isfinite(phase)]
    return (angle is None or bool(np.any(np.asarray(angle) != 0.0))) and bool(np.any(np.abs(known) > LEAST_PHASE))


def _scale(curves: Sequence[Floats], level: float) -> tuple[float, float]:
    """The ends of the scale: around all curves, and up to the level where that leaves them a third of the height, or
    where they show nothing else.
    """
    values = np.concatenate([*curves, [np.nan]])
    values = values[np.isfinite(values)]
    low, high = (float(values.min()), float(values.max())) if len(values) else (level, level)
    away = max(level - high, low - level)
    if away <= _AWAY * (high - low) or high - low < _STEADY:
        low, high = min(low, level), max(high, level)
    margin = 0.05 * max(high - low, _STEADY)
    return low - margin, high + margin


def deployment_panels(content: Content) -> list[Panel]:
    """The panels: of the rate, and of the phase where that of any run is more than rounding."""
    rate, phase = (column for column, _, _ in PANELS)
    panels = []
    if any(rate in table for table in content.tables):
        panels.append(Panel((rate,), levels=(1.0,)))
    still = frozenset(
        k for k, source in enumerate(content.runs) if phase not in source.table or not turns(source.table)
    )
    others = [table for table in content.tables if phase in table and turns(table)]
    if others:
        panels.append(Panel((phase,), levels=(0.0,), without=still))
    if not panels:
        raise InputError(f"no table has a column {rate!r} or {phase!r}; say which columns to draw")
    return panels


def draw_deployment(content: Content, panels: Sequence[Panel], style: Style, title: str) -> StyledFigure:
    """The figure, with a dotted line where the phase of a run comes back through zero; inside the style's context."""
    figure, places = draw_panels(content, panels, style, title)
    for axes, panel in zip(places, panels, strict=True):
        axes.set_ylim(*_scale(values_of(content, panel), panel.levels[0]))
    first = len(content.ensembles)
    for k, source in enumerate(content.runs if len(panels) > 1 else ()):
        if k not in panels[-1].without and PANELS[0][0] in source.table:
            known = {name: source.column(name) for name in ("time", *(column for column, _, _ in PANELS))}
            crossing = curve_features(known)["zero_crossing_time"]
            for axes in places:
                if crossing is not None:
                    axes.axvline(crossing, color=line_look(first + k)["color"], linewidth=0.8, linestyle=":")
    return figure
