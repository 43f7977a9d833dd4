"""Curves against time: deployment rate and phase difference, as in Figs. 14 to 17 of Okuizumi et al. 2012.

A dotted line marks the time at which the phase comes back through zero, and a thin grey one the start of a stage.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import NoneType

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._files import path_of
from membrane_rs._given_arrays import numeric
from membrane_rs._validation import check_kind
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.plotting.drawing import Drawing
from membrane_rs.plotting.figure import plain_text, save_figure
from membrane_rs.plotting.stage_marks import mark_stages, stage_starts
from membrane_rs.results.history import read_history
from membrane_rs.results.summary import LEAST_PHASE, curve_features
from membrane_rs.simulation.stepper import Stepper

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
            _picture([("", self.record.table)], self.record.path / "deployment.png", sim.scene.name, None, names)


def plot_deployment(table: Mapping[str, Floats], path: Path | str, title: str = "", dpi: float | None = None) -> None:
    """Draw one run's deployment rate and phase difference as a PNG, PDF or SVG figure, by the ending of `path`.

    `table` holds the columns of a history; without a hub that turns, or corners that turn relative to it, the phase
    is left out. `dpi` are pixels per inch. Raises InputError for another ending, OutputError where `path` cannot be
    written.
    """
    check_kind(title, str, "title", "a text")
    _check_table(table)
    _picture([("", table)], path_of(path), title, dpi)


def compare_runs(
    folders: Sequence[Path | str], path: Path | str, labels: Sequence[str] | None = None, dpi: float | None = None
) -> None:
    """Draw the curves of several runs on one picture, as `plot_deployment` does.

    `labels` are the folders' names where not given. Raises InputError where their number differs from the
    folders', MissingFileError for a folder without history, OutputError where `path` cannot be written.
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
    _picture(list(zip(names, tables, strict=True)), path_of(path), "", dpi)


def _check_table(table: Mapping[str, Floats]) -> None:
    """Refuse what is no table of a history. Raises InputTypeError."""
    check_kind(table, Mapping, "table", "the columns of a history by name, as read_history gives them")
    names = ("time", *(column for column, _, _ in PANELS))
    lengths = set()
    for name in names:
        if name not in table:
            raise InputTypeError(f"table: has no column {name!r}; give what read_history gives")
        column = numeric(table[name], f"table[{name!r}]", "fiu", "numbers")
        lengths.add(column.shape)
    if len(lengths) > 1 or len(lengths.pop()) != 1:
        raise InputTypeError(f"table: the columns {', '.join(names)} must be lists of equal length, one entry a sample")


def _turns(table: Mapping[str, Floats]) -> bool:
    """Whether a hub turns, where the table says so, and corners turn relative to it by more than rounding."""
    angle, phase = table.get("hub_angle"), table["phase_difference_deg"]
    known = phase[np.isfinite(phase)]
    return (angle is None or bool(np.any(angle != 0.0))) and bool(np.any(np.abs(known) > LEAST_PHASE))


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


def _picture(
    runs: Sequence[tuple[str, Mapping[str, Floats]]],
    path: Path,
    title: str,
    dpi: float | None,
    stages: Sequence[str] = (),
) -> None:
    """Runs, as (label, table), in one or two panels above each other that share the time axis; the names of stages
    stand at their starts.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    shown = PANELS if any(_turns(table) for _, table in runs) else PANELS[:1]
    figure = Figure(figsize=(7.0, 0.4 + 3.0 * len(shown)), layout="constrained")
    FigureCanvasAgg(figure)
    panels = list(figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0])
    for axes, (column, label, level) in zip(panels, shown, strict=True):
        for k, (name, table) in enumerate(runs):
            axes.plot(table["time"], table[column], color=f"C{k}", linewidth=1.5, label=plain_text(name))
        axes.set_ylim(*_scale([table[column] for _, table in runs], level))
        axes.axhline(level, color="0.5", linewidth=0.8)
        for k, (_, table) in enumerate(runs):
            crossing = curve_features(table)["zero_crossing_time"]
            if crossing is not None and len(shown) > 1:
                axes.axvline(crossing, color=f"C{k}", linewidth=0.8, linestyle=":")
        axes.set_ylabel(label)
        axes.grid(color="0.9")
        axes.margins(x=0.0)
        axes.spines[["top", "right"]].set_visible(False)
    if len(runs) == 1:
        mark_stages(panels, stage_starts(runs[0][1]), stages)
    panels[-1].set_xlabel("Time [s]")
    panels[0].set_title(plain_text(title), wrap=True)
    if len(runs) > 1:
        panels[0].legend(frameon=False, loc="lower center")
    save_figure(figure, path, dpi)
