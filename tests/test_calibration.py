"""Fits to measured curves: known parameters come back, and what the data leave open is said."""

from __future__ import annotations

import json
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from membrane_rs import InputError, Scene, run, scenes
from membrane_rs.cli.application import USAGE, app
from membrane_rs.results import Experiment
from membrane_rs.study import Calibration, calibrate
from membrane_rs.study.calibration.model import DataColumn, FitModel, data_columns
from membrane_rs.study.common.one_run import RunPoint, RunResult
from typer.testing import CliRunner

END, SAMPLES = 0.15, 151
NOISE = {"phase_difference_deg": 0.05, "largest_cord_tension": 0.01}
"""Standard deviations of synthetic data."""
TRUE = {"laws.spin.frequency": 3.0, "parts.0.tip_mass": 0.01}
RANGES = {"laws.spin.frequency": "2:5", "parts.0.tip_mass": "0.002:0.05:log"}


@pytest.fixture(scope="module")
def scene() -> Scene:
    return scenes.load("spinning-tether").with_values({"parts.0.segments": 4})


@pytest.fixture(scope="module")
def begin(scene: Scene) -> Scene:
    """The scene with other values than those that made the data."""
    return scene.with_values({"laws.spin.frequency": 4.0, "parts.0.tip_mass": 0.005})


def measured(scene: Scene, seed: int = 0, noise: float = 1.0, columns: tuple[str, ...] = tuple(NOISE)) -> Experiment:
    """Curves of a scene at 16 times, with noise."""
    history, random = run(scene, END, samples=SAMPLES, frames=2).history, np.random.default_rng(seed)
    rows = slice(None, None, 10)
    values = {name: history[name][rows] + noise * NOISE[name] * random.standard_normal(16) for name in columns}
    return Experiment("synthetic", history["time"][rows], values, {name: history.units[name] for name in columns})


@pytest.fixture(scope="module")
def found(scene: Scene, begin: Scene) -> Calibration:
    return calibrate(begin, measured(scene), RANGES, samples=SAMPLES, uncertainty=NOISE)


def test_known_parameters_come_back_within_their_errors(found: Calibration) -> None:
    assert found.outcome == "converged"
    assert not found.undetermined
    assert found.misfit < 0.2 * found.first_misfit
    assert 0.7 < found.misfit < 1.3  # noise of the size that was said
    for one in found.parameters:
        deviation = (one.high - one.low) / 2
        assert abs(one.value - TRUE[one.key]) < 3.0 * deviation, one
        assert deviation < 0.1 * TRUE[one.key], one
    assert found.scene.value("laws.spin.frequency") == found.values["laws.spin.frequency"]


def test_errors_have_the_size_of_the_scatter_of_fits(scene: Scene, found: Calibration) -> None:
    """The standard deviation that one fit gives is that of the values which fits to other noise find."""
    values = []
    for seed in range(1, 7):
        again = calibrate(found.scene, measured(scene, seed), RANGES, samples=SAMPLES, uncertainty=NOISE)
        values.append([again.values[key] for key in TRUE])
    scatter = np.std([*values, [found.values[key] for key in TRUE]], axis=0, ddof=1)
    said = [(one.high - one.low) / 2 for one in found.parameters]
    assert (scatter / said > 0.4).all(), (scatter, said)
    assert (scatter / said < 2.5).all(), (scatter, said)


def test_the_simplex_finds_them_too(scene: Scene, begin: Scene) -> None:
    found = calibrate(
        begin, measured(scene), RANGES, samples=SAMPLES, uncertainty=NOISE, method="nelder-mead", starts=2
    )
    assert found.misfit < 1.3
    assert found.values == pytest.approx(TRUE, rel=0.05)


def test_what_the_data_do_not_determine_is_said(scene: Scene) -> None:
    """The swing of a tip does not depend on the damping of its cord's own vibrations."""
    data = measured(scene, noise=0.2, columns=("phase_difference_deg",))
    ranges = {"laws.spin.frequency": "2:5", "laws.spring_damping.ratio": "0.005:0.08:log"}
    from_elsewhere = scene.with_values({"laws.spin.frequency": 4.0})
    found = calibrate(from_elsewhere, data, ranges, samples=SAMPLES, uncertainty={"phase_difference_deg": 1.0})
    frequency, ratio = found.parameters
    assert frequency.is_determined
    assert abs(frequency.value - 3.0) < 0.1
    assert not ratio.is_determined
    assert any("laws.spring_damping.ratio" in one for one in found.undetermined)
    assert not any("laws.spin.frequency" in one for one in found.undetermined)
    assert "not determined by these data" in found.table()
    assert repr(found).startswith(f"Calibration({found.outcome}: {found.parameters[0].key} = ")


def test_a_parameter_at_the_end_of_its_range_is_said(scene: Scene) -> None:
    found = calibrate(scene, measured(scene), {"laws.spin.frequency": "3.5:5"}, samples=SAMPLES)
    assert found.parameters[0].end == "lower"
    assert not found.parameters[0].is_determined
    assert any("lower end" in warning for warning in found.warnings)


def test_a_parameter_whose_interval_holds_an_end_of_its_range_is_not_determined(scene: Scene) -> None:
    """The same data and the same error, in a range that ends within the 95 % interval, and in one that does not."""
    data, deviation = measured(scene), {"phase_difference_deg": 1.0, "largest_cord_tension": 1.0}
    for low, is_determined in ((2.0, True), (2.97, False)):
        ranges = {"laws.spin.frequency": f"{low}:5"}
        found = calibrate(scene, data, ranges, samples=SAMPLES, uncertainty=deviation)
        (one,) = found.parameters
        deviations = (one.value - low) / (0.5 * (one.high - one.low))
        assert (deviations > 1.96) is is_determined, one
        assert one.is_determined is is_determined
        assert one.reaches == ("" if is_determined else "lower")
        assert any("whose 95 % interval holds the lower end" in line for line in found.warnings) is not is_determined


@pytest.mark.parametrize("end", [2.0, 5.0])
def test_a_fit_begins_at_an_end_of_the_range_where_the_scene_does(scene: Scene, end: float) -> None:
    at_end = scene.with_values({"laws.spin.frequency": end})
    found = calibrate(at_end, measured(scene), {"laws.spin.frequency": "2:5"}, samples=SAMPLES, uncertainty=NOISE)
    assert found.parameters[0].start == end
    assert found.values["laws.spin.frequency"] == pytest.approx(3.0, rel=0.02)


def test_few_runs_give_the_best_so_far_and_no_errors(scene: Scene, begin: Scene) -> None:
    found = calibrate(begin, measured(scene), RANGES, samples=SAMPLES, most_runs=3)
    assert found.runs <= 3
    assert found.outcome.startswith("stopped at 3 runs")
    assert found.analysis is None
    assert "did not suffice" in " ".join(found.warnings)


def test_runs_that_fail_are_walked_around(scene: Scene) -> None:
    """A fast hub tears the cord."""
    limited = scene.with_values({"parts.0.strain_limit": 0.012})
    slow = limited.with_values({"laws.spin.frequency": 2.0})
    data = measured(slow, noise=0.0, columns=("phase_difference_deg",))
    found = calibrate(limited, data, {"laws.spin.frequency": "1:6"}, samples=SAMPLES, method="nelder-mead")
    assert "over its bound" in " ".join(found.failures)
    assert found.warnings[-1].startswith("failed: laws.spin.frequency = ")
    assert found.values["laws.spin.frequency"] == pytest.approx(2.0, rel=0.01)


def too_fast(sim: Any) -> float:
    """A measure that fails beyond 2.4 Hz."""
    if sim.scene.value("laws.spin.frequency") > 2.4:
        raise ValueError("too fast")
    return float(np.linalg.norm(sim.hub_load().force))


@pytest.mark.parametrize("method", ["least-squares", "nelder-mead"])
def test_runs_that_fail_are_not_taken_for_better_than_a_bad_fit(scene: Scene, method: str) -> None:
    """The data, of 3 Hz, lie far beyond what can run, by more than the residuals of failed runs at first."""
    slow = scene.with_values({"laws.spin.frequency": 2.0})
    history = run(scene, 0.02, samples=21, frames=2).history
    data = {"time": history["time"], "own": history["hub_force"]}
    found = calibrate(
        slow, data, {"laws.spin.frequency": "1:5"}, samples=21, record={"own": too_fast}, method=method, most_runs=60
    )
    assert found.failures
    assert found.misfit > 10.0
    assert 2.35 < found.values["laws.spin.frequency"] <= 2.4


def test_a_folder_makes_no_run_twice(scene: Scene, begin: Scene, tmp_path: Path) -> None:
    shown: list[int] = []
    options = {"samples": SAMPLES, "out": tmp_path / "fit", "most_runs": 12}
    first = calibrate(begin, measured(scene), RANGES, **options)  # type: ignore[arg-type]
    written = {path: path.stat().st_mtime_ns for path in (tmp_path / "fit" / "runs").iterdir()}
    again = calibrate(begin, measured(scene), RANGES, progress=lambda *now: shown.append(now[0]), **options)  # type: ignore[arg-type]
    assert again.values == first.values
    assert {path: path.stat().st_mtime_ns for path in (tmp_path / "fit" / "runs").iterdir()} == written


def test_an_interrupted_one_goes_on_to_the_same_bits(scene: Scene, begin: Scene, tmp_path: Path) -> None:
    """After Ctrl-C, in the runs that the optimiser asks for, the same call makes only the others."""
    options = {"samples": SAMPLES, "most_runs": 12}
    whole = calibrate(begin, measured(scene), RANGES, **options)  # type: ignore[arg-type]
    calls = 0

    def stop(*_: object) -> None:
        nonlocal calls
        calls += 1
        if calls == 6:
            raise KeyboardInterrupt

    folder = tmp_path / "fit"
    with pytest.raises(KeyboardInterrupt):
        calibrate(begin, measured(scene), RANGES, out=folder, progress=stop, **options)  # type: ignore[arg-type]
    kept = {path.name: path.stat().st_mtime_ns for path in (folder / "runs").iterdir()}
    assert 5 <= len(kept) < whole.runs
    again = calibrate(begin, measured(scene), RANGES, out=folder, **options)  # type: ignore[arg-type]
    assert again.as_dict() == whole.as_dict()
    assert {name: (folder / "runs" / name).stat().st_mtime_ns for name in kept} == kept


def test_values_that_are_not_used_are_counted(scene: Scene) -> None:
    data = measured(scene)
    found = calibrate(scene, data, {"laws.spin.frequency": "2:5"}, samples=SAMPLES, until=0.1, most_runs=1)
    assert found.unused == sum(int((data.time > 0.1).sum()) for _ in data.columns) > 0
    assert f"{found.unused} measured values are not used" in found.warnings[0]
    assert np.isnan(found.parameters[0].low)
    assert found.as_dict()["parameters"]["laws.spin.frequency"]["low"] is None


def test_runs_beyond_a_time_limit_count_as_failures(scene: Scene) -> None:
    with pytest.raises(InputError, match=r"the first runs failed: .* time limit: took more than 1e-06 s.*; allow more"):
        calibrate(scene, measured(scene), RANGES, samples=SAMPLES, time_limit=1e-6)


WRONG = [
    ({"laws.spin.frequency": [2.0, 3.0]}, {}, "is a list; give a range"),
    ({"parts.0.segments": "2:8"}, {}, "whole number"),
    ({"run.until": "1:2"}, {}, "runs end where the data end; leave it out"),
    ({}, {}, "names no parameter"),
    ({"laws.spin.frequenzy": "2:5"}, {}, "frequency"),
    ({"laws.spin.frequency": "5:2"}, {}, "lower to a higher"),
    (RANGES, {"method": "leastsquares"}, "least-squares"),
    (RANGES, {"starts": 0}, "from 1 to 1000"),
    (RANGES, {"starts": 3, "most_runs": 2}, "less than the 3 runs"),
    (RANGES, {"step": 0.0}, "share of the ranges"),
    (RANGES, {"uncertainty": {"phase": 1.0}}, "no column 'phase'"),
    (RANGES, {"columns": ["phase"]}, "no column 'phase'"),
    (RANGES, {"columns": "hub_force"}, "must be a list"),
    (RANGES, {"columns": []}, "no value"),
    (RANGES, {"columns": ["phase_difference_deg"], "until": -1.0}, "no value of 'phase_difference_deg' from 0"),
    (RANGES, {"uncertainty": {"phase_difference_deg": 1e-320}}, "from 1e-60 to 1e"),
    ({"laws.spin.frequency": "2:2"}, {}, "lower to a higher"),
    ({"run.integrator": "rk4:leapfrog"}, {}, "'rk4' is no number"),
    ({"parts.0.name": "a:b"}, {}, "'a' is no number"),
    ({"laws.spin": "true:false"}, {}, "True is no number"),
    ({"laws.spin.frequency": "nan:3"}, {}, "must be finite"),
    (RANGES, {"uncertainty": {"phase_difference_deg": -1.0}}, "above 0"),
    (RANGES, {"uncertainty": {"largest_cord_tension": "2 m"}}, "N"),
    (RANGES, {"until": -1.0}, "no value from 0"),
    (RANGES, {"columns": 3}, "must be a list"),
    (RANGES, {"record": {"hub_force": float}}, r"^record\['hub_force'\]: is the name of a column"),
    (RANGES, {"record": {"own": lambda sim: math.nan}}, r"= nan: must be finite$"),
    ({"laws.spin.frequency": "-1e308:1e308"}, {}, "must be finite; give the scene values that run"),
]


@pytest.mark.parametrize(("vary", "options", "message"), WRONG)
def test_wrong_input_is_refused(
    scene: Scene, vary: dict[str, object], options: dict[str, object], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        calibrate(scene, measured(scene), vary, samples=SAMPLES, **options)  # type: ignore[arg-type]


def test_data_that_no_run_records_are_refused(scene: Scene) -> None:
    data = Experiment("data", np.array([0.0, 0.1]), {"tension": np.array([1.0, 2.0])}, {"tension": ""})
    with pytest.raises(InputError, match=r"'tension' of the data: no run records it.*hub_force.*record it \(record\)"):
        calibrate(scene, data, RANGES, samples=SAMPLES, until=0.1)


def test_data_that_end_before_the_runs_begin_are_refused(scene: Scene) -> None:
    for time in (0.0, -1.0):
        with pytest.raises(InputError, match=r"measured: ends at -?\d s, and runs begin at 0 s; give data of later"):
            calibrate(scene, {"time": [time], "hub_force": [1.0]}, RANGES, samples=SAMPLES)


def test_runs_end_with_the_data(scene: Scene) -> None:
    """A time of 30 years would run for ever."""
    found = calibrate(scene, measured(scene), {"laws.spin.frequency": "2:5"}, samples=SAMPLES, until=1e9, most_runs=1)
    assert found.runs == 1
    assert not found.unused


def test_the_command(scene: Scene, begin: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    begin.save(tmp_path / "scene")
    data = measured(scene)
    lines = ["time [ms], phase_difference_deg [deg], largest_cord_tension [mN]"]
    lines += [f"{1e3 * t}, {a}, {1e3 * b}" for t, a, b in zip(data.time, *data.columns.values(), strict=True)]
    (tmp_path / "data.csv").write_text("\n".join(lines))
    words = ["calibrate", "scene/scene.toml", "--data", "data.csv", "--vary", "laws.spin.frequency=2:5"]
    words += ["--vary", "parts.0.tip_mass=2g:50g:log", "--samples", str(SAMPLES), "--out", "fit", "--json"]
    words += ["--uncertainty", "phase_difference_deg=0.05", "--uncertainty", "largest_cord_tension=10 mN"]
    shown = CliRunner().invoke(app, words)
    assert shown.exit_code == 0, shown.stderr
    told = json.loads(shown.stdout)
    assert told["parameters"]["laws.spin.frequency"]["value"] == pytest.approx(3.0, rel=0.01)
    fitted = Scene.from_toml(tmp_path / "fit" / "calibrated" / "scene.toml")
    assert fitted.value("parts.0.tip_mass") == told["parameters"]["parts.0.tip_mass"]["value"]
    for name in ("calibration.md", "calibration.json", "calibration.png"):
        assert (tmp_path / "fit" / name).stat().st_size > 100
    assert CliRunner().invoke(app, words[:4]).exit_code == USAGE
    wrong = CliRunner().invoke(app, [*words[:4], "--vary", "laws.spin.frequency=2:5", "--uncertainty", "tension"])
    assert wrong.exit_code == USAGE
    assert "COLUMN=VALUE" in wrong.stderr


def test_the_noise_of_a_mean_is_its_standard_error() -> None:
    """Three starts, 1, 2 and 4 N: a standard deviation of sqrt(7/3) N, in scales of 0.5 N."""
    column = DataColumn("force", "N", np.zeros(1), np.ones(1), np.full(1, 0.5), True)
    runs = [
        RunResult(RunPoint({}, k), "finished", history={"time": np.zeros(1), "force": np.array([value])})
        for k, value in enumerate((1.0, 2.0, 4.0))
    ]
    model: Any = SimpleNamespace(columns=[column])
    found = FitModel._curves(model, runs)
    assert found.noise == pytest.approx([math.sqrt(7 / 3) / math.sqrt(3) / 0.5])
    assert found.residuals == pytest.approx([(7 / 3 - 1) / 0.5])


def test_data_of_another_time_are_left_out() -> None:
    time = np.array([-1.0, 0.0, 0.5, 1.0, 2.0])
    data = Experiment("drop", time, {"force": np.array([9.0, 1.0, np.nan, 3.0, 9.0])}, {"force": "N"})
    (found,) = data_columns(data, None, None, 1.0)
    assert (found.time.tolist(), found.values.tolist()) == ([0.0, 1.0], [1.0, 3.0])
