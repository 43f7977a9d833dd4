"""Figures against time: what is drawn, its units and labels, and what is left out since it is rounding."""

from __future__ import annotations

import math
import pickle
import subprocess
import sys
from itertools import pairwise
from typing import Any

import membrane_rs
import numpy as np
import pytest
from membrane_rs import InputError, InputTypeError, Run, plotting
from membrane_rs.plotting.columns import label_of, prefixed, unit_of
from membrane_rs.plotting.panels import DENSE
from membrane_rs.results import read_experiment

TIME = np.linspace(0.0, 1.0, 50)
# Axes and artists of matplotlib have types that their users cannot index.
compare_runs: Any = plotting.compare_runs
plot_comparison: Any = plotting.plot_comparison
plot_crossings: Any = plotting.plot_crossings
plot_deployment: Any = plotting.plot_deployment
plot_energy: Any = plotting.plot_energy
plot_history: Any = plotting.plot_history


def table(phase: float = 5.0, hub: float = 3.0, scale: float = 1.0) -> dict[str, Any]:
    """Columns of a history."""
    return {
        "time": TIME, "deployment_rate": 0.5 + 0.1 * scale * TIME, "hub_angle": hub * TIME,
        "phase_difference_deg": -phase * np.sin(5.0 * TIME), "kinetic_energy": 2e-3 * TIME, "hub_torque": 3e-3 * TIME,
        "energy_springs": -1e-3 * TIME, "work_spring_damping": 1e-3 * TIME, "motor_work": 1e-3 * TIME,
    }  # fmt: skip


@pytest.fixture(scope="module")
def run() -> Run:
    return membrane_rs.run("spinning-tether", 0.02, frames=3, samples=21)


def names(figure: Any) -> list[str]:
    """Entries of all legends."""
    legends = [*figure.legends, *(axes.get_legend() for axes in figure.axes if axes.get_legend())]
    return [text.get_text() for legend in legends for text in legend.get_texts()]


def labels(figure: Any) -> list[str]:
    return [axes.get_ylabel() for axes in figure.axes]


def test_figures_are_returned_without_pyplot_and_shown_in_notebooks() -> None:
    code = (
        "import sys; from membrane_rs.plotting import plot_history\n"
        "figure = plot_history({'time': [0.0, 1.0], 'hub_torque': [0.0, 1.0]}, ['hub_torque'])\n"
        "assert figure._repr_png_().startswith(b'\\x89PNG') and 'matplotlib.pyplot' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=300)


def test_a_figure_can_be_pickled_and_keeps_its_style() -> None:
    figure = pickle.loads(pickle.dumps(plot_deployment(table(), style="paper")))
    assert figure.style.dpi == 300.0
    assert labels(figure) == ["Deployment rate", "Phase difference [deg]"]


def test_a_run_a_table_several_and_labels_are_taken(run: Run) -> None:
    assert len(plot_deployment(run).axes) == 2
    for several in ([table(), run], {"one": table(), "two": run}):
        figure = plot_deployment(several)
        assert len(figure.axes[0].get_lines()) == 4  # and the level of 1, and the crossing of the first
    assert names(plot_deployment({"one": table(), "two": run})) == ["one", "two"]
    assert names(plot_deployment([table(), run], labels=["_a", "$b"])) == [" _a", r"\$b"]


@pytest.mark.parametrize(("phase", "hub"), [(1e-13, 3.0), (5.0, 0.0), (0.0, 0.0)])
def test_a_phase_of_rounding_is_neither_drawn_nor_marked(phase: float, hub: float) -> None:
    figure = plot_deployment(table(phase, hub))
    assert labels(figure) == ["Deployment rate"]
    assert len(figure.axes[0].get_lines()) == 2  # the curve and the level: no crossing is marked
    both = plot_deployment([table(), table(phase, hub)])
    assert labels(both) == ["Deployment rate", "Phase difference [deg]"]
    assert len(both.axes[0].get_lines()) == 4  # two curves, the level, the crossing of the first
    assert len(both.axes[1].get_lines()) == 3


def test_a_crossing_is_marked_where_the_phase_comes_back() -> None:
    places = [line.get_xdata() for line in plot_deployment(table()).axes[1].get_lines()]
    assert [place[0] for place in places if len(place) == 2 and place[0] == place[1]] == [
        pytest.approx(math.pi / 5, abs=1e-3)
    ]


def test_energies_of_rounding_are_left_out() -> None:
    quiet = table()
    quiet["energy_creases"] = 4e-3 + 1e-18 * np.sin(TIME)
    quiet["motor_work"] = 1e-17 * TIME
    assert names(plot_energy(quiet)) == ["kinetic energy", "energy of springs", "work of spring damping"]
    still = {"time": TIME, "kinetic_energy": 0.0 * TIME, "energy_springs": 5.0 + 1e-15 * TIME}
    figure = plot_energy(still)
    assert names(figure) == []
    assert figure.axes[0].get_ylabel() == "Energy since the start [J]"


def test_the_motor_has_a_panel_of_its_own_where_it_hides_the_balance() -> None:
    figure = plot_energy({**table(), "motor_work": -5.0 * TIME}, style="paper")
    assert labels(figure) == ["Energy since the start [mJ]", "Work of the motor [J]"]
    assert names(figure) == ["kinetic energy", "energy of springs", "work of spring damping"]
    assert len(plot_energy(table()).axes) == 1


def test_terms_of_the_energy_are_distinguished_in_a_grey_print() -> None:
    lines = plot_energy(table(), style="paper").axes[0].get_lines()
    looks = [(line.get_linestyle(), line.get_marker()) for line in lines if not line.get_label().startswith("_")]
    assert len(looks) == 4
    assert len(set(looks)) == len(looks)


def test_columns_have_labels_units_and_prefixes() -> None:
    figure = plot_history(table(), ["hub_torque", ["energy_springs", "kinetic_energy"], "hub_angle"])
    assert labels(figure) == ["Torque on the hub [mN m]", "Energy [mJ]", "Angle of the hub [rad]"]
    assert figure.axes[0].get_lines()[0].get_ydata()[-1] == pytest.approx(3.0)
    assert names(figure) == ["Energy of springs", "Kinetic energy"]
    assert figure.axes[-1].get_xlabel() == "Time [s]"
    assert label_of("tip_height") == "Tip height"
    assert unit_of("work_spin") == "J"
    for unit, values, wanted in (
        ("Pa", [2e6, -7.0], (1e6, "MPa")),
        ("J", [0.0, math.nan], (1.0, "J")),
        ("N", [2e-13], (1e-9, "nN")),
        ("deg", [2e-4], (1.0, "deg")),
        ("m", [-0.5], (1e-3, "mm")),
    ):
        assert prefixed(unit, [np.array(values)]) == wanted


def test_units_of_recorded_measures_are_shown() -> None:
    class Recorded(dict[str, Any]):
        units = {"spread": "m"}  # noqa: RUF012 - as a table of a run has them

    figure = plot_history(Recorded(time=TIME, spread=2e-3 * TIME), ["spread"])
    assert labels(figure) == ["Spread [mm]"]


def test_columns_of_several_units_share_a_panel() -> None:
    """Without a label of its axis: the legend names them."""
    figure = plot_history(table(), [("hub_torque", "kinetic_energy")])
    assert labels(figure) == [""]
    assert len(names(figure)) == 2


def test_an_ensemble_is_a_mean_and_a_band() -> None:
    members = [table(scale=scale) for scale in (1.0, 2.0, 3.0)]
    short = {name: values[:25] for name, values in table(scale=6.0).items()}
    for spread, low, high in (("std", 0.1, 0.3), ("range", 0.1, 0.3)):
        figure = plot_comparison(
            ensembles={"starts": [*members, short]}, columns=["deployment_rate"], spread=spread, style="paper"
        )
        axes = figure.axes[0]
        mean = axes.get_lines()[0].get_ydata()
        assert mean[24] == pytest.approx(0.5 + 0.3 * TIME[24])  # of four
        assert mean[-1] == pytest.approx(0.5 + 0.2)  # of the three that came so far
        edges = axes.collections[0].get_paths()[0].vertices
        last = edges[edges[:, 0] == 1.0][:, 1]
        assert (last.min(), last.max()) == pytest.approx((0.5 + low, 0.5 + high))
        assert names(figure) == ["starts"]
    with pytest.raises(InputError, match=r"ensembles.*times must ascend"):
        plot_comparison(ensembles={"one": [{"time": [0.0, 2.0, 1.0], "deployment_rate": [0.0, 0.0, 0.0]}]})


def test_experiments_are_marks_with_bars(tmp_path: Any) -> None:
    file = tmp_path / "drop.csv"
    file.write_text("time [ms],hub_torque [mN m],hub_torque_std [mN m]\n100,1,0.5\n200,,\n500,2,0.5\n")
    measured = read_experiment(file, {"hub_torque": "N m", "hub_torque_std": "N m"})
    figure = plot_comparison({"run": table()}, ["hub_torque"], experiments={"drop": measured}, style="paper")
    (marks,) = figure.axes[0].containers
    assert marks.lines[0].get_ydata() == pytest.approx([1.0, math.nan, 2.0], nan_ok=True)
    assert marks.lines[0].get_linestyle() == "None"
    assert marks.lines[2][0].get_segments()[0][:, 1] == pytest.approx([0.5, 1.5])
    assert names(figure) == ["run", "drop"]


def test_runs_differ_in_colour_and_dashes_and_letters_are_of_the_paper() -> None:
    figure = plot_deployment([table(scale=k) for k in range(6)], style="paper", title="not shown")
    lines = [line for line in figure.axes[0].get_lines() if len(line.get_xdata()) > 2]
    assert len({line.get_color() for line in lines}) == len({str(line._dash_pattern) for line in lines}) == 6
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["(a)", "(b)"]
    assert figure.axes[0].get_title() == ""
    screen = plot_deployment(table(), title="a title")
    assert (screen.axes[0].get_title(), screen.axes[0].get_title(loc="left")) == ("a title", "")


def test_a_legend_stands_on_no_curve() -> None:
    figure = plot_deployment({f"a long name of run {k}": table(scale=k) for k in range(5)}, style="paper")
    figure.draw_without_rendering()
    box = figure.legends[0].get_window_extent()
    assert all(not box.overlaps(axes.get_window_extent()) for axes in figure.axes)
    assert figure.bbox.x0 <= box.x0
    assert box.x1 <= figure.bbox.x1


@pytest.mark.parametrize("style", ["paper", "screen"])
def test_marks_of_time_do_not_touch(style: str) -> None:
    figure = plot_deployment({**table(), "time": 0.02 * TIME}, style=style)
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in figure.axes[-1].get_xticklabels() if text.get_text()]
    assert len(boxes) > 2
    assert all(one.x1 + 2.0 < other.x0 for one, other in pairwise(boxes))


@pytest.mark.parametrize("value", [math.nan, math.inf, 1e300, 0.0, -1e-300])
def test_values_of_every_kind_are_drawn(value: float) -> None:
    """Lists in place of arrays, too, and a table without rows."""
    columns = {name: [value] * 3 for name in table()} | {"time": [0.0, 1.0, 2.0]}
    for figure in (
        plot_deployment(columns),
        plot_energy(columns),
        plot_history(columns, ["hub_torque"]),
        plot_comparison(ensembles={"all": [columns, columns]}, columns=["hub_torque"]),
        plot_deployment({name: [] for name in columns}),
    ):
        figure.draw_without_rendering()


@pytest.mark.parametrize(
    ("call", "kind", "words"),
    [
        (lambda: plot_history(table(), ["hub_torqe"]), InputError, "'hub_torqe'; did you mean 'hub_torque'"),
        (lambda: plot_history(table(), "hub_torque"), InputTypeError, "must be a list of names"),
        (lambda: plot_history(table(), []), InputError, "0 panels; must be from 1 to 26"),
        (lambda: plot_history(3, ["hub_torque"]), InputTypeError, "table = 3: must be the columns"),
        (lambda: plot_history([], ["hub_torque"]), InputError, "must hold one history or more"),
        (lambda: plot_history({"time": TIME, "a": TIME[1:]}, ["a"]), InputTypeError, "lists of equal length"),
        (lambda: plot_deployment([table(), {"time": TIME}]), InputTypeError, r"table\[1\]: has no column"),
        (lambda: plot_deployment([table()], labels=["a", "b"]), InputError, "2 labels for 1 runs"),
        (plot_comparison, InputError, "nothing to draw"),
        (lambda: plot_comparison(experiments=table()), InputError, "is one table; give each a label"),
        (lambda: plot_comparison(table(), spread="sd"), InputError, "spread = 'sd': did you mean 'std'"),
        (lambda: plot_comparison({"time": TIME, "x": TIME}), InputError, "say which columns to draw"),
        (lambda: plot_energy({"time": TIME}), InputTypeError, "has no column 'kinetic_energy'"),
        (lambda: plot_energy({"time": [0.0], "kinetic_energy": [0.0]}), InputError, "has 1 samples; .* needs two"),
        (lambda: plot_crossings({"time": TIME}), InputTypeError, "has no column 'crossing'"),
        (lambda: compare_runs([]), InputTypeError, "folders = "),
    ],
)  # fmt: skip
def test_what_cannot_be_drawn_is_refused(call: Any, kind: type[Exception], words: str) -> None:
    with pytest.raises(kind, match=words):
        call()


@pytest.mark.parametrize(("count", "is_above"), [(DENSE, True), (DENSE + 1, False)])
def test_marks_of_many_points_stand_behind_the_curves(count: int, is_above: bool) -> None:
    time = np.linspace(0.0, 1.0, count)
    measured = {"time": time, "hub_torque": time}
    figure = plot_comparison({"run": table()}, ["hub_torque"], experiments={"drop": measured})
    line, marks = (line.get_zorder() for line in figure.axes[0].lines)
    assert (marks > line) is is_above
