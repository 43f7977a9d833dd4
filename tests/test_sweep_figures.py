"""Figures of sweeps: texts that do not lie over each other, and nothing that differs by rounding alone."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations, product
from typing import Any

import pytest
from membrane_rs.plotting.responses import responses_of
from membrane_rs.plotting.sweep import Varied, plot_sweep

pytest.importorskip("matplotlib")

from matplotlib.backends.backend_agg import FigureCanvasAgg


def rows_of(parameters: list[Varied], bad: int = 0) -> list[dict[str, Any]]:
    """A row for each combination, of which the first ones have failed."""
    points = list(product(*(one.values for one in parameters)))
    return [
        {
            "run": k, **dict(zip([one.key for one in parameters], point, strict=True)), "start": 0,
            "outcome": "unstable" if k < bad else "finished", "message": "",
            "final_rate": 0.5 + 0.1 * k, "final_phase_deg": -0.00123 * (k + 1),
        }
        for k, point in enumerate(points)
    ]  # fmt: skip


def overlaps(figure: Any, texts: Iterable[Any]) -> list[tuple[str, str]]:
    """Pairs of texts that lie over each other."""
    renderer = figure.canvas.get_renderer()
    boxes = [(text.get_text(), text.get_window_extent(renderer)) for text in texts if text.get_text()]
    return [(a, b) for (a, one), (b, other) in combinations(boxes, 2) if one.overlaps(other)]


def drawn(parameters: list[Varied], bad: int = 0) -> Any:
    figure = plot_sweep(rows_of(parameters, bad), parameters, title="of a sweep")
    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    return figure


@pytest.mark.parametrize("across", [2, 9, 12, 30])
def test_texts_of_a_map_have_room(across: int) -> None:
    values = [0.5 + 1.1875 * k for k in range(across)]
    figure = drawn([Varied("laws.spin.frequency", "Hz", values), Varied("run.dt", "s", [1e-5, 2e-5, 3e-5])], bad=1)
    for axes in figure.axes:
        assert not overlaps(figure, axes.texts)
        assert not overlaps(figure, axes.get_xticklabels())
    assert bool(figure.axes[0].texts) == (across < 9)
    assert figure.get_supxlabel() == f"1 of {3 * across} runs: 1 unstable"


def test_names_are_all_named() -> None:
    methods = ["rk4", "leapfrog", "generalized_alpha", "dopri5"]
    figure = drawn([Varied("run.integrator", "", methods), Varied("laws.springs", "", [True, False])])
    assert [label.get_text() for label in figure.axes[0].get_xticklabels()] == methods
    assert figure.axes[0].get_xticklabels()[0].get_rotation() == 20.0


def test_failures_do_not_lie_over_the_title() -> None:
    figure = drawn([Varied("laws.spin.frequency", "Hz", [0.1, 1.0, 10.0, 100.0], is_log=True)], bad=2)
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["2 of 4 runs: 2 unstable"]
    assert not overlaps(figure, [figure._suptitle, *legend.get_texts(), figure.axes[-1].xaxis.label])


def test_what_has_no_value_is_said() -> None:
    parameters = [Varied("a", "", [1, 2]), Varied("b", "", [1, 2])]
    rows = rows_of(parameters)
    rows[0]["final_rate"] = None
    figure = plot_sweep(rows, parameters, ["final_rate"])
    assert "no value" in [text.get_text() for text in figure.axes[0].texts]


@pytest.mark.parametrize(
    ("column", "values", "is_shown"),
    [
        ("final_rate", [1.0, 1.0 + 1e-8], False),
        ("final_rate", [1.0, 1.0 + 1e-5], True),
        ("final_phase_deg", [1e-5, -1e-4], False),
        ("final_phase_deg", [1e-2, -1e-1], True),
        ("highest_hub_torque", [0.0, 1e-17], False),
        ("highest_hub_torque", [0.0, 1e-9], True),
    ],
)
def test_what_differs_by_rounding_is_not_shown(column: str, values: list[float], is_shown: bool) -> None:
    rows = [{"run": k, "final_kinetic_energy": k + 1.0, column: value} for k, value in enumerate(values)]
    assert (column in [one.name for one in responses_of(rows, None, {}, [])]) == is_shown
