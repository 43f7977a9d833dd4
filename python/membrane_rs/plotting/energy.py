"""The energy balance of a run: its terms against time, and what each stage has exchanged.

The terms of the turning frame are those of the balance: what moves and what is stored has changed by the works of the
laws, which the residual lacks. The work of the motor that turns the hub is no term of it and stands apart; it is that
on the sail in inertial space. See docs/model.md.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.plotting.drawing import Drawing
from membrane_rs.plotting.figure import plain_text, save_figure
from membrane_rs.plotting.stage_marks import mark_stages, stage_starts
from membrane_rs.simulation.stepper import Stepper
from membrane_rs.simulation.timeline import StageRecord

if TYPE_CHECKING:
    from matplotlib.axes import Axes

KINETIC, MOTOR, CHANGES, RESIDUAL = "kinetic_energy", "motor_work", "energy_of_changes", "residual"
LEAST = 5e-3
"""Terms of the balance that stay below this share of the largest one are not drawn."""
COLUMNS, MOST_STAGES = 4, 12
UNITS = ((1.0, "J"), (1e-3, "mJ"), (1e-6, "uJ"))


class EnergyPicture(Drawing):
    """Draws energy.png from the history, where that has two samples or more."""

    own_files = ("energy.png",)

    def draw(self, sim: Stepper) -> None:
        """Draw it."""
        if len(self.record.table["time"]) > 1:
            draw_energy(self.record.table, self.record.path / "energy.png", sim.scene.name, sim.stages)


def draw_energy(
    table: Mapping[str, Floats],
    path: Path,
    title: str = "",
    stages: Sequence[StageRecord] = (),
    dpi: float | None = None,
) -> None:
    """Draw the terms of the balance since the start against time, and below it what each of `stages` has exchanged.

    `table` holds the columns of a history. Raises as `save_figure` does.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    curves = since_start(table)
    spans = [term_changes(table, stages, k) for k in range(len(stages))][:MOST_STAGES]
    sizes = {name: _largest([*values, *(span.get(name, 0.0) for span in spans)]) for name, values in curves.items()}
    most = max(size for name, size in sizes.items() if name != MOTOR)
    shown = [name for name, size in sizes.items() if name == MOTOR or size > LEAST * most]
    unit, symbol = next((pair for pair in UNITS if max(sizes.values()) >= pair[0]), UNITS[-1])
    rows = -(-len(spans) // COLUMNS) if len(spans) > 1 else 0
    height = 0.75 + 0.22 * (len(shown) + 1)
    figure = Figure(figsize=(9.0, 3.6 + rows * height), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(1 + rows, COLUMNS, height_ratios=[3.6, *[height] * rows])
    axes = figure.add_subplot(grid[0, :])
    for name in shown:
        axes.plot(
            table["time"], curves[name] / unit, label=plain_text(label(name)), linewidth=1.3, **style(name, shown)
        )
    mark_stages([axes], stage_starts(table), [stage.name for stage in stages])
    axes.axhline(0.0, color="0.5", linewidth=0.8)
    axes.margins(x=0.0)
    axes.set_xlabel("Time [s]")
    axes.set_ylabel(f"Since the start [{symbol}]")
    axes.grid(color="0.9")
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_title(plain_text(title), wrap=True)
    axes.legend(frameon=False, fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5))
    for k, span in enumerate(spans if rows else ()):
        place = figure.add_subplot(grid[1 + k // COLUMNS, k % COLUMNS])
        _bars(place, sorted([*shown, RESIDUAL], key=_order), span, unit, is_first=k % COLUMNS == 0)
        place.set_title(plain_text(f"{stages[k].name} [{symbol}]"), fontsize=8)
    save_figure(figure, path, dpi)


def since_start(table: Mapping[str, Floats]) -> dict[str, Floats]:
    """Change of each energy and each work since the first sample [J], by column, and what changes of stage put in."""
    of_laws = [name for name in table if name.startswith("energy_") and name not in ("energy_error", CHANGES)]
    works = [name for name in table if name.startswith("work_")]
    others = [name for name in (CHANGES, MOTOR) if name in table and np.isfinite(table[name]).all()]
    return {name: table[name] - table[name][0] for name in (KINETIC, *of_laws, *works, *others)}


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


def style(name: str, shown: Sequence[str]) -> dict[str, Any]:
    """Colour and line of a term: energies solid, works dashed, the motor black."""
    if name in (MOTOR, RESIDUAL):
        return {"color": "black" if name == MOTOR else "0.6", "linestyle": "-."}
    same = [other for other in shown if other.startswith("work_") == name.startswith("work_") and other != MOTOR]
    return {"color": f"C{same.index(name) % 10}", "linestyle": "--" if name.startswith("work_") else "-"}


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
            place, value, height=0.7, color=style(name, names)["color"], alpha=0.55 if is_work else 1.0,
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


def _largest(values: Sequence[float]) -> float:
    return float(np.max(np.abs(np.asarray(values, dtype=np.float64)), initial=0.0))
