"""Figures bear any values: what is infinite or beyond all physics is left out and said, and nothing warns."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from membrane_rs._arrays import Floats
from membrane_rs.plotting import plot_comparison, plot_deployment, plot_energy, plot_history
from membrane_rs.plotting.drawable import LARGEST, count_beyond, drawable
from membrane_rs.plotting.page_panel import Curve, panel_svg

COUNT = 20
TIME = np.linspace(0.0, 1.0, COUNT)
EVERY_OTHER = np.arange(COUNT) % 2 == 0
VALUES = {
    "from -1e308 to 1e308": np.where(EVERY_OTHER, 1e308, -1e308),
    "all 1e308": np.full(COUNT, 1e308),
    "one of 1e308": np.where(np.arange(COUNT) == 5, 1.7e308, TIME),
    "infinite": np.where(EVERY_OTHER, np.inf, -np.inf),
    "nothing": np.full(COUNT, np.nan),
    "one alone": np.where(np.arange(COUNT) == 5, 3.0, np.nan),
    "denormal": np.where(EVERY_OTHER, 1e-320, -1e-320),
    "large": 1e90 * TIME,
}
COLUMNS = ("deployment_rate", "phase_difference_deg", "hub_torque", "kinetic_energy", "energy_springs", "work_drag")


def history(values: Floats) -> dict[str, Floats]:
    return {"time": TIME, "hub_angle": TIME, **dict.fromkeys(COLUMNS, values)}


@pytest.fixture(autouse=True)
def no_warnings() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


FIGURES: dict[str, Callable[[dict[str, Floats]], Any]] = {
    "deployment": plot_deployment,
    "history": lambda table: plot_history(table, ["hub_torque", ["kinetic_energy", "energy_springs"]]),
    "energy": plot_energy,
    "runs": lambda table: plot_comparison({"a": table, "b": history(TIME)}, ["hub_torque"]),
    "spread": lambda table: plot_comparison(ensembles={"a": [table, table, history(TIME)]}, members=True),
    "range": lambda table: plot_comparison(ensembles={"a": [table, history(TIME)]}, spread="range"),
}


@pytest.mark.parametrize("values", VALUES.values(), ids=VALUES)
@pytest.mark.parametrize("figure", FIGURES.values(), ids=FIGURES)
def test_any_values_are_drawn(figure: Callable[[dict[str, Floats]], Any], values: Floats) -> None:
    drawn = figure(history(values))
    drawn._repr_png_()
    notes = [text.get_text() for axes in drawn.axes for text in axes.texts if "not shown" in text.get_text()]
    assert bool(notes) is bool(count_beyond([values]))


@pytest.mark.parametrize("values", VALUES.values(), ids=VALUES)
def test_any_values_are_drawn_in_pages(values: Floats) -> None:
    curves = [Curve(TIME, values), Curve(TIME, TIME, edges=(values, values)), Curve(TIME, values, line="", marker="o")]
    assert ("not shown" in panel_svg(curves, "label", level=1.0)) is bool(count_beyond([values]))


def test_times_beyond_all_are_left_out() -> None:
    figure = plot_history({**history(TIME), "time": np.where(TIME > 0.9, 1e308, TIME)}, ["hub_torque"])
    figure._repr_png_()  # type: ignore[attr-defined]
    (note,) = [text.get_text() for text in figure.axes[0].texts]
    assert note == "2 values are not shown: infinite or beyond 1e+100"


def test_an_experiment_with_large_deviations_is_drawn() -> None:
    measured = {"time": TIME, "hub_torque": TIME, "hub_torque_std": np.full(COUNT, 1e308)}
    plot_comparison(columns=["hub_torque"], experiments={"rig": measured})._repr_png_()  # type: ignore[attr-defined]


def test_what_can_be_drawn_stays_as_it_is() -> None:
    values = np.array([0.0, -LARGEST, np.nan])
    assert drawable(values) is values
    assert np.isnan(drawable(np.array([1.1 * LARGEST, -np.inf]))).all()
    assert count_beyond([values, [np.inf, 1.0, -2.0 * LARGEST]]) == 2
