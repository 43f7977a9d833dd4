"""The energy balance of a run: its terms against time, and what each stage has exchanged.

The terms of the turning frame are those of the balance: what moves and what is stored has changed by the works of the
laws, which the residual lacks. The work of the motor that turns the hub is no term of it and stands apart; it is that
on the sail in inertial space. See docs/model.md.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._validation import check_kind
from membrane_rs.errors import InputError
from membrane_rs.plotting.columns import prefixed
from membrane_rs.plotting.drawable import count_beyond, drawable, note_beyond
from membrane_rs.plotting.drawing import Drawing
from membrane_rs.plotting.figure import add_letters, add_title, finished, new_figure, plain_text
from membrane_rs.plotting.panels import MARKS, add_legend, fit_label, space_times
from membrane_rs.plotting.sources import check_table, sources_of
from membrane_rs.plotting.stage_marks import mark_stages, stage_starts
from membrane_rs.plotting.stage_records import stage_records
from membrane_rs.plotting.style import INCH, SCREEN, Style, style_of
from membrane_rs.simulation.stepper import Stepper
from membrane_rs.simulation.timeline import StageRecord

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from membrane_rs.plotting.styled_figure import StyledFigure

KINETIC, MOTOR, CHANGES, RESIDUAL = "kinetic_energy", "motor_work", "energy_of_changes", "residual"
LEAST = 5e-3
"""Terms of the balance that stay below this share of the largest one are not drawn."""
ROUNDING = 1e-12
"""Changes below this share of an energy's own size are of rounding."""
APART = 4.0
"""Of a run without stages the motor's work has a panel of its own where it is so many times the largest term."""
MOST_COLUMNS, MOST_STAGES = 4, 12
LEAST_WIDTH = 2.25 * INCH
"""Of a column of bars [mm]."""
WIDE = 150.0
"""From this width on [mm] the legend stands at the right."""
SCREEN_ENERGY = replace(SCREEN, width=9.0 * INCH, panel_height=3.6 * INCH)


class EnergyPicture(Drawing):
    """Draws energy.png from the history, where that has two samples or more."""

    own_files = ("energy.png",)

    def draw(self, sim: Stepper) -> None:
        """Draw it."""
        if len(self.record.table["time"]) > 1:
            draw_energy(self.record.table, self.record.path / "energy.png", sim.scene.name, sim.stages)


def plot_energy(
    table: Any,
    path: Path | str | None = None,
    title: str = "",
    dpi: float | None = None,
    *,
    stages: Sequence[StageRecord] | None = None,
    style: Style | str | Path | Mapping[str, Any] | None = None,
) -> Figure:
    """The terms of the energy balance since the start against time, and below them what each stage has exchanged.

    Energies are solid, works dashed, the motor's work black. Terms that stay below 0.5 % of the largest one are left
    out, and so are changes that are rounding of an energy.

    Parameters
    ----------
    table : history or run
        A history is a mapping of names of columns to (samples,) arrays: "time" [s], "kinetic_energy",
        "energy_<law>" and "work_<law>" [J]. What has a `history` is a run.
    path : path, optional
        A PNG, PDF or SVG file, by its ending. Default: none is written.
    title : str
        Where the style has one.
    dpi : float, optional
        Resolution of a PNG file [1/inch]. Default: the style's.
    stages : sequence of StageRecord, optional
        Of the run, as `Simulation.stages` gives them. Default: those of a run.
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
    >>> from membrane_rs.plotting import plot_energy
    >>> time = np.linspace(0.0, 1.0, 50)
    >>> table = {"time": time, "kinetic_energy": 2e-3 * time, "energy_springs": -1e-3 * time, "work_spin": 1e-3 * time}
    >>> figure = plot_energy(table, style="paper")
    >>> figure.axes[0].get_ylabel()
    'Energy since the start [mJ]'
    """
    (source,) = sources_of([table], None, ("time", KINETIC))
    terms = [name for name in source.table if name.startswith(("energy_", "work_")) or name == MOTOR]
    check_table(source.table, terms)
    check_kind(title, str, "title", "a text")
    records = getattr(table, "stages", ()) if stages is None else stages
    if len(source.time) < 2:
        raise InputError(f"table: has {len(source.time)} samples; the energy since the start needs two or more")
    names = ("time", KINETIC, "stage", *terms)
    known = {name: np.asarray(source.table[name], dtype=np.float64) for name in names if name in source.table}
    return draw_energy(known, path, title, stage_records(records), dpi, style=style_of(style, SCREEN_ENERGY))


def draw_energy(
    table: Mapping[str, Floats],
    path: Path | str | None,
    title: str = "",
    stages: Sequence[StageRecord] = (),
    dpi: float | None = None,
    *,
    style: Style = SCREEN_ENERGY,
) -> Figure:
    """As `plot_energy`, of a table that is known to be a history. Raises as `save_figure` does."""
    beyond = count_beyond(table.values())
    table = {name: drawable(values) for name, values in table.items()}
    curves = since_start(table)
    spans = [term_changes(table, stages, k) for k in range(len(stages))][:MOST_STAGES]
    sizes = {name: _largest([*values, *(span.get(name, 0.0) for span in spans)]) for name, values in curves.items()}
    most = max(size for name, size in sizes.items() if name != MOTOR)
    shown = [name for name, size in sizes.items() if size > LEAST * most]
    has_bars = len(spans) > 1
    is_apart = not has_bars and MOTOR in shown and sizes[MOTOR] > APART * most
    groups = [[name for name in shown if name != MOTOR], [MOTOR]] if is_apart else [shown]
    factors = [prefixed("J", [np.array([0.0, *(sizes[name] for name in names)])]) for names in groups]
    with style.context():
        columns = min(MOST_COLUMNS, max(1, int(style.millimetres / LEAST_WIDTH)))
        rows = -(-len(spans) // columns) if has_bars else 0
        height = INCH * (0.75 + 0.22 * (len(shown) + 1))
        figure = new_figure(style, style.size(len(groups), extra=rows * height))
        ratios = [*[style.height_of_panel] * len(groups), *[height] * rows]
        grid = figure.add_gridspec(len(ratios), columns, height_ratios=ratios)
        places: list[Axes] = []
        for k, (names, (factor, unit)) in enumerate(zip(groups, factors, strict=True)):
            places.append(figure.add_subplot(grid[k, :], sharex=places[0] if places else None))
            _draw_terms(places[-1], table["time"], {name: curves[name] / factor for name in names}, shown, style)
            what = "Work of the motor" if names == [MOTOR] else "Energy since the start"
            places[-1].set_ylabel(f"{what} [{unit}]")
            fit_label(places[-1], style)
        note_beyond(places[0], beyond)
        mark_stages(places, stage_starts(table), [stage.name for stage in stages])
        space_times(places[-1], style)
        places[-1].set_xlabel("Time [s]")
        for axes in places[:-1]:
            axes.tick_params(labelbottom=False)
        add_title(places[0], title, style)
        for k, span in enumerate(spans if has_bars else ()):
            place = figure.add_subplot(grid[1 + k // columns, k % columns])
            _bars(place, sorted([*shown, RESIDUAL], key=_order), span, factors[0][0], is_first=k % columns == 0)
            place.set_title(plain_text(f"{stages[k].name} [{factors[0][1]}]"), fontsize="small")
            places.append(place)
        _legend(figure, places[0], style, is_beside=has_bars or style.millimetres >= WIDE)
        add_letters(places, style)
        figure.align_ylabels(places[: len(groups)])
    return finished(figure, path, dpi)


def _draw_terms(axes: Axes, time: Floats, curves: Mapping[str, Floats], shown: Sequence[str], style: Style) -> None:
    """Curves of a panel against time [s]; `shown` are those of all panels."""
    for name, values in curves.items():
        look = {**line_of(name, shown), **_marks(name, shown, style)}
        axes.plot(time, values, label=plain_text(label(name)), **look)
    axes.axhline(0.0, color="0.5", linewidth=0.8)
    axes.margins(x=0.0)
    if not curves:
        axes.set_ylim(-1.0, 1.0)


def since_start(table: Mapping[str, Floats]) -> dict[str, Floats]:
    """Change of each energy and each work since the first sample [J], by column, and what changes of stage put in."""
    of_laws = [name for name in table if name.startswith("energy_") and name not in ("energy_error", CHANGES)]
    works = [name for name in table if name.startswith("work_")]
    others = [name for name in (CHANGES, MOTOR) if name in table and np.isfinite(table[name]).all()]
    return {name: _without_rounding(table[name]) for name in (KINETIC, *of_laws, *works, *others)}


def _without_rounding(values: Floats) -> Floats:
    """Values since the first one; 0 where all changes are rounding of the values themselves."""
    since = values - values[0]
    is_rounding = _largest(since) <= ROUNDING * _largest(values)
    return np.zeros_like(since) if is_rounding else since


def term_changes(table: Mapping[str, Floats], stages: Sequence[StageRecord], index: int) -> dict[str, float]:
    """What a stage has exchanged [J], by column of the history, and its "residual".

    Energies are taken before the change at its end, for which `StageRecord.changes` stand.
    """
    stage = stages[index]
    time = table["time"]
    first, last = (int(np.argmin(np.abs(time - at))) for at in (stage.start, stage.end))
    after = stages[index + 1].changes if index + 1 < len(stages) else {}
    found = {}
    for name, values in since_start(table).items():
        if name.startswith("work_"):
            found[name] = stage.work_by_law.get(name.removeprefix("work_"), 0.0)
        elif name == MOTOR:
            found[name] = stage.motor_work or 0.0
        elif name == CHANGES:
            found[name] = math.fsum(stage.changes.values())
        else:
            term = "kinetic" if name == KINETIC else name.removeprefix("energy_")
            found[name] = float(values[last] - values[first]) - after.get(term, 0.0)
    return found | {RESIDUAL: stage.error * stage.reference_energy}


def label(name: str) -> str:
    """A column, in words."""
    if name in (CHANGES, MOTOR):
        return "put in by changes" if name == CHANGES else "motor, in space"
    kind, _, law = name.partition("_")
    words = law.replace("_", " ")
    return {"work": f"work of {words}", "energy": f"energy of {words}"}.get(kind, name.replace("_", " "))


def line_of(name: str, shown: Sequence[str]) -> dict[str, Any]:
    """Colour and line of a term: energies solid, works dashed, the motor black."""
    if name in (MOTOR, RESIDUAL):
        return {"color": "black" if name == MOTOR else "0.6", "linestyle": "-."}
    same = [other for other in shown if other.startswith("work_") == name.startswith("work_") and other != MOTOR]
    return {"color": f"C{same.index(name) % 10}", "linestyle": "--" if name.startswith("work_") else "-"}


def _marks(name: str, shown: Sequence[str], style: Style) -> dict[str, Any]:
    """Marks that distinguish, in a grey print, energies from each other and works from each other."""
    if not style.marks or name == MOTOR:
        return {}
    k = shown.index(name)
    return {"marker": MARKS[k % len(MARKS)], "markevery": (0.02 + 0.03 * (k % 5), 0.16), "markerfacecolor": "white"}


def _legend(figure: StyledFigure, axes: Axes, style: Style, *, is_beside: bool) -> None:
    """At the right of the curves, or above all."""
    handles, names = axes.get_legend_handles_labels()
    if handles and is_beside:
        axes.legend(handles, names, loc="center left", bbox_to_anchor=(1.0, 0.5))
    elif handles:
        add_legend(figure, [axes], style)


def _order(name: str) -> int:
    """The residual behind the terms of the balance, the motor behind all."""
    return (RESIDUAL, MOTOR).index(name) + 1 if name in (RESIDUAL, MOTOR) else 0


def _bars(axes: Axes, names: Sequence[str], span: Mapping[str, float], unit: float, *, is_first: bool) -> None:
    """One bar for each term, the first at the top, with its value."""
    values = [span.get(name, 0.0) / unit for name in names]
    places = np.array([-k - 0.6 * (name == MOTOR) for k, name in enumerate(names)])
    for name, value, place in zip(names, values, places, strict=True):
        is_work = name.startswith("work_")
        axes.barh(
            place, value, height=0.7, color=line_of(name, names)["color"], alpha=0.55 if is_work else 1.0,
            hatch="////" if is_work else None, edgecolor="white" if is_work else None, linewidth=0.0,
        )  # fmt: skip
        axes.annotate(
            f"{value:+.3f}", (max(value, 0.0), place), (2, 0), textcoords="offset points", fontsize=6, va="center"
        )
    most = max(_largest(values), 1e-300)
    axes.set_xlim(-1.15 * most if min(values) < -0.02 * most else -0.1 * most, 1.7 * most)
    axes.axvline(0.0, color="0.5", linewidth=0.8)
    axes.set_yticks(places, [plain_text(label(name)) for name in names] if is_first else [""] * len(names), fontsize=7)
    axes.tick_params(axis="x", labelsize=6)
    axes.tick_params(axis="y", length=0.0)
    axes.spines[["top", "right", "left"]].set_visible(False)


def _largest(values: Sequence[float] | Floats) -> float:
    return float(np.nanmax(np.abs(np.asarray(values, dtype=np.float64)), initial=0.0))
