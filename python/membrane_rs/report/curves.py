"""Curves of all runs over one another, with experiments: which columns are shown, and how."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from xml.etree.ElementTree import Element

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.plotting.columns import axis_label, label_of, prefixed, unit_of
from membrane_rs.plotting.ensemble import Ensemble
from membrane_rs.plotting.page_panel import Curve, panel_svg
from membrane_rs.plotting.sources import Source
from membrane_rs.plotting.stage_marks import stage_starts
from membrane_rs.report.markup import drawing, element
from membrane_rs.report.sources import BLACK, LabelledRun, Sources
from membrane_rs.results.features import LEAST_PHASE

FIRST = ("deployment_rate", "phase_difference_deg")
NO_PANEL = (
    "time", "hub_angle", "reference_energy", "stage", "kinetic_energy", "stored_energy", "motor_work", "motor_torque",
    *(f"attitude_{name}" for name in "wxyz"),
)  # fmt: skip
"""Columns without a panel; the torque of the motor is given for a free hub, and of a driven one minus hub_torque."""
OF_BALANCE = ("energy_", "work_")
"""What columns of the energy balance begin with, which has figures of its own."""
LEVELS = {"deployment_rate": 1.0, "phase_difference_deg": 0.0, "hub_torque": 0.0}
LEAST = {"phase_difference_deg": LEAST_PHASE}
"""Range below which a column shows rounding; of others `ROUNDING`, over their largest value."""
ROUNDING = 1e-9
SCALES = {"hub_torque": "hub_force"}
"""A column whose rounding is that of another one: a torque that is none, of forces at radii of some metres or less."""
LARGEST = 1e150
"""Larger values are damaged, and are gaps in a curve: their squares, and axes around them, would be infinite."""
MANY_POINTS = 80
"""Of an experiment, which are then drawn as a line without marks."""
_LINES, _MARKS = ("--", ":", "-."), "os^Dv"
_EACH, _MEAN = "each", "mean"


def curve_section(sources: Sources) -> Element:
    """All panels, and above them the list of what is drawn, by which it is shown and hidden."""
    section = element("section", element("h2", "Curves"), id="curves")
    names = shown_columns(sources)
    if not names:
        section.append(element("p", "No measure of these runs has changed."))
        return section
    grid = element("div", class_="panels")
    for k, name in enumerate(names):
        grid.append(element("figure", drawing(_panel(sources, name), f"curve{k}", _described(sources, name))))
    section.extend([_legend(sources), grid])
    unknown = [f"{one.name}: {', '.join(names)}" for one in sources.experiments if (names := sources.unknown(one))]
    if unknown:
        section.append(element("p", f"Measured columns that no run has: {'; '.join(unknown)}.", class_="note"))
    return section


def shown_columns(sources: Sources) -> list[str]:
    """Columns that have a panel: those that change in a run or were measured, the deployment first."""
    found: dict[str, bool] = dict.fromkeys(FIRST, False)
    for labelled in sources.runs:
        for name in labelled.run.history:
            found[name] = found.get(name, False) or (is_measure(name) and changes(name, labelled.run.history))
    for experiment in sources.experiments:
        found |= {name: True for name in experiment.columns if name in found}
    return [name for name, is_shown in found.items() if is_shown]


def is_measure(name: str) -> bool:
    """Whether a column is a measure of the motion, and not one of the energy balance, or of time."""
    return name not in NO_PANEL and not name.startswith(OF_BALANCE)


def changes(name: str, history: Mapping[str, Floats]) -> bool:
    """Whether a history has a column that changes by more than rounding."""
    known = finite(history[name]) if name in history else np.zeros(0)
    if len(known) < 2:
        return False
    scale = finite(history[SCALES[name]]) if SCALES.get(name) in history else known
    least = LEAST.get(name, ROUNDING * float(np.abs(scale).max(initial=0.0)))
    return float(np.ptp(known)) > least


def stage_names(labelled: LabelledRun) -> list[tuple[str, float]]:
    """Name and start [s] of each stage that a run has reached."""
    names = [stage.name for stage in labelled.run.scene.stages]
    return [(names[k], time) for k, time in stage_starts(labelled.run.history) if 0 <= k < len(names)]


def _panel(sources: Sources, name: str) -> str:
    """A column of all runs, and of experiments."""
    curves = _of_runs(sources, name)
    for k, experiment in enumerate(sources.experiments):
        if name in experiment.columns:
            times, measured = experiment.curve(name)
            values = drawable(measured)
            mark = "" if len(times) > MANY_POINTS else _MARKS[k % len(_MARKS)]
            line = _LINES[k % len(_LINES)]
            curves.append(Curve(times, values, experiment.name, BLACK, sources.key_of(k), line, mark, width=1.2))
    factor, unit = prefixed(_unit(sources, name), [curve.values for curve in curves])
    scaled = [replace(curve, values=curve.values / factor, edges=curve.edges_over(factor)) for curve in curves]
    spans = [time[[0, -1]] for one in sources.runs if len(time := finite(one.run.history["time"]))]
    ends = (float(np.min(spans)), float(np.max(spans))) if spans else None
    stages = [stage_names(one) for one in sources.runs]
    common = stages[0] if all(some == stages[0] for some in stages) else []
    return panel_svg(scaled, axis_label(label_of(name), unit), level=LEVELS.get(name), ends=ends, stages=common)


def _of_runs(sources: Sources, name: str) -> list[Curve]:
    """One curve for each run, or thin ones, and their mean with its spread."""
    runs = [one for one in sources.runs if name in one.run.history]
    tables = [{"time": one.run.history["time"], name: drawable(one.run.history[name])} for one in runs]
    curves = [
        Curve(one.run.history["time"], drawable(one.run.history[name]), one.label, one.color, one.key) for one in runs
    ]
    if not sources.ensemble:
        return curves
    thin = [replace(curve, key=_EACH, width=0.7, opacity=0.45) for curve in curves]
    if len(tables) < 2:
        return thin
    band = Ensemble(_MEAN, [Source("", table) for table in tables]).band(name)
    return [*thin, Curve(band.time, band.mean, _MEAN, BLACK, _MEAN, width=1.8, edges=(band.low, band.high))]


def _unit(sources: Sources, name: str) -> str:
    return unit_of(name, [one.run.history for one in sources.runs if name in one.run.history])


def _legend(sources: Sources) -> Element:
    """A box to tick for each curve."""
    entries = [(one.key, one.label, one.color, "solid") for one in sources.runs]
    if sources.ensemble:
        words = f"mean of {len(sources.runs)} runs, with one standard deviation to each side"
        entries = [(_MEAN, words, "var(--ink)", "solid"), (_EACH, "each run", "var(--muted)", "solid")]
    measured = [(sources.key_of(k), one.name, "var(--ink)", "dashed") for k, one in enumerate(sources.experiments)]
    legend = element("div", class_="legend", role="group", aria_label="Curves that are shown")
    for key, label, color, line in [*entries, *measured]:
        box = element("input", type="checkbox", checked=True, data_shows=key)
        legend.append(
            element("label", box, element("span", class_="sample", style=f"border-top: 3px {line} {color}"), label)
        )
    return legend


def _described(sources: Sources, name: str) -> str:
    """A panel in words, for those who do not see it."""
    words = [f"{axis_label(label_of(name), _unit(sources, name))} against time"]
    for one in sources.runs:
        known = finite(one.run.history[name]) if name in one.run.history else np.zeros(0)
        if len(known):
            ends = f"from {known[0]:.4g} to {known[-1]:.4g}"
            words.append(f"{one.label}: {ends}, between {known.min():.4g} and {known.max():.4g}")
    return "; ".join(words)


def drawable(values: Floats) -> Floats:
    """Values (n,) with NaN in place of those beyond `LARGEST`."""
    return np.where(np.abs(values) < LARGEST, values, np.nan)


def finite(values: Floats) -> Floats:
    """The values of (n,) that can be drawn."""
    return values[np.abs(values) < LARGEST]
