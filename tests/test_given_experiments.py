"""Measured curves as callers give them: one rule for `calibrate`, `compare`, figures and reports."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import InputError, InputTypeError, Run, run
from membrane_rs.plotting import plot_comparison
from membrane_rs.report import write_report
from membrane_rs.results import Experiment
from membrane_rs.results.given_experiment import experiment_of
from membrane_rs.study import calibrate, compare

TIMES = [0.0, 0.004, 0.008]
FORCES = [250.0, float("nan"), 500.0]


def experiment(tmp_path: Path) -> Experiment:
    return Experiment("rig", np.array(TIMES), {"hub_force": np.array(FORCES)}, {"hub_force": "mN"})


def file(tmp_path: Path) -> Path:
    path = tmp_path / "rig.csv"
    path.write_text("time [ms],hub_force (mN)\r\n0,250\r\n4,\r\n8,500\r\n")
    return path


def mapping(tmp_path: Path) -> dict[str, Any]:
    return {"time [ms]": [0, 4, 8], "hub_force [mN]": FORCES}


def frame(tmp_path: Path) -> Any:
    return pytest.importorskip("pandas").DataFrame({"hub_force [mN]": FORCES}, index=_index())


def nullable(tmp_path: Path) -> Any:
    pandas = pytest.importorskip("pandas")
    forces = pandas.array([250, None, 500], dtype="Int64")
    return pandas.DataFrame({"time": TIMES, "hub_force [mN]": forces})


def _index() -> Any:
    return pytest.importorskip("pandas").Index([0, 4, 8], name="time [ms]")


KINDS = [experiment, file, mapping, frame, nullable]


@pytest.fixture(scope="module")
def tether() -> Run:
    return run("spinning-tether", until=0.01, samples=11, frames=2)


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_is_the_same_everywhere(kind: Any, tmp_path: Path, tether: Run) -> None:
    given = kind(tmp_path)
    found = experiment_of(given, {"hub_force": "N"})
    assert found.time == pytest.approx(TIMES)
    assert found.columns["hub_force"] == pytest.approx([0.25, np.nan, 0.5], nan_ok=True)
    assert dict(found.units) == {"hub_force": "N"}
    difference = compare({"run": tether, "rig": given}).difference("rig", "hub_force")
    assert (difference.peak, difference.unit) == (0.5, "N")
    figure = plot_comparison(tether, ["hub_force"], experiments={"rig": given})
    (marks,) = [line for line in figure.axes[0].lines if line.get_marker() == "o"]
    assert np.asarray(marks.get_ydata(), float)[[0, 2]] == pytest.approx([0.25, 0.5])
    write_report(tether, tmp_path / "page.html", data=given)
    assert "Force on the hub [N]" in (tmp_path / "page.html").read_text()
    fitted = calibrate("spinning-tether", given, {"laws.spin.frequency": "1:4"}, samples=11, most_runs=1)
    assert fitted.columns[0].values == pytest.approx([0.25, 0.5])


def test_standard_deviations_follow_their_column(tmp_path: Path) -> None:
    path = tmp_path / "warm.csv"
    path.write_text("time,speed [km/h],speed_std,heat [degC],heat_std\n0,36,3.6,20,1\n")
    found = experiment_of(path, {"speed": "m/s", "heat": "K"})
    assert {name: float(values[0]) for name, values in found.columns.items()} == pytest.approx(
        {"speed": 10.0, "speed_std": 1.0, "heat": 293.15, "heat_std": 1.0}
    )
    assert found.units["speed_std"] == "m/s"


def test_a_share_in_percent_becomes_a_number(tmp_path: Path) -> None:
    given = {"time": TIMES, "deployment_rate [%]": [50.0, 60.0, 70.0]}
    fitted = calibrate("spinning-tether", given, {"laws.spin.frequency": "1:4"}, samples=11, most_runs=1)
    assert fitted.columns[0].values == pytest.approx([0.5, 0.6, 0.7])


def test_a_history_is_an_experiment_too(tether: Run) -> None:
    found = experiment_of(tether.history)
    assert found.units["hub_force"] == "N"
    assert (found.columns["hub_force"] == tether.history["hub_force"]).all()
    pytest.importorskip("pandas")
    assert experiment_of(tether.to_pandas()).units["hub_force"] == "N"


WRONG = [
    (3.0, "data = 3.0: must be the path of a CSV file, an Experiment, a mapping"),
    ({}, "data: no column is named 'time'"),
    ({"time": TIMES}, "'time' is the only column"),
    ({"Time": TIMES, "a": TIMES}, "did you mean 'Time'"),
    ({"time": TIMES, "a": [1.0, 2.0]}, r"column 'a': has shape \(2,\); must be a list of 3 numbers"),
    ({"time": TIMES, "a": ["x", "y", "z"]}, "column 'a' has dtype <U1"),
    ({"time": TIMES, "a": [1j, 2j, 3j]}, "column 'a' has dtype complex128"),
    ({"time": TIMES, "a": [1.0, 2.0, np.inf]}, "column 'a': holds a value that is not finite"),
    ({"time": TIMES, "a": [[1.0, 2.0, 3.0]]}, r"has shape \(1, 3\)"),
    ({"time": [0.0, np.nan, 1.0], "a": TIMES}, "a time is missing"),
    ({"time": [0.0, 1.0, 1.0], "a": TIMES}, "time 1 s comes after 1 s; order the values by time"),
    ({"time": [], "a": []}, "time: holds no values"),
    ({"time": TIMES, "a [N]": TIMES, "a [mN]": TIMES}, "data, column 3: 'a' is there already"),
    ({"time": TIMES, 3: TIMES}, "data, column 2: 3 is no name"),
    ({"time [kg]": TIMES, "a": TIMES}, "column 'time': 'kg' is a mass"),
    ({"time": TIMES, "hub_force [m]": TIMES}, "column 'hub_force': 'm' is a length; must be a unit of a force"),
    ({"time": TIMES, "deployment_rate (1/s)": TIMES}, "'1/s' is no unit of a plain number; leave it out"),
    ({"time": TIMES, "hub_force [furlongs/moon]": TIMES}, "unit 'furlongs' is not known"),
    ({"time": np.ma.masked_equal(TIMES, 0.004), "a": TIMES}, "time has masked entries"),
]


@pytest.mark.parametrize(("given", "words"), WRONG)
def test_what_is_none_is_refused(given: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        experiment_of(given, {"hub_force": "N", "deployment_rate": ""})


def test_a_frame_of_other_things_is_refused() -> None:
    pandas = pytest.importorskip("pandas")
    columns: list[Any] = [["x", "y", "z"], pandas.date_range("2020", periods=3), [None, {}, 2]]
    for column in columns:
        with pytest.raises(InputTypeError, match="column 'a' has dtype"):
            experiment_of(pandas.DataFrame({"time": TIMES, "a": column}))
    twice = pandas.DataFrame([[0.0, 1.0, 2.0]], columns=["time", "a", "a"])
    with pytest.raises(InputError, match="'a' is there already"):
        experiment_of(twice)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"name": 3}, "name = 3: must be a text"),
        ({"columns": TIMES}, "must be a mapping of names to arrays"),
        ({"columns": {}}, "has 0 columns beside the time"),
        ({"units": "N"}, "units = 'N': must be a mapping"),
        ({"units": {"a": 3}}, "unit 3: must be a text"),
    ],
)
def test_an_experiment_that_is_none_is_refused(values: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        Experiment(**{"name": "rig", "time": np.array(TIMES), "columns": {"a": np.array(TIMES)}, **values})


def test_lists_become_arrays_that_nobody_else_changes() -> None:
    values = np.array(TIMES)
    made = Experiment("rig", values, {"a": values})
    values[:] = 7.0
    assert made.time == pytest.approx(TIMES)
    assert made.units == {"a": ""}
