"""Curves of runs and experiments laid over each other: differences, figure, and the command."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import membrane_rs
import numpy as np
import pytest
from membrane_rs import InputError, MissingFileError
from membrane_rs.cli import app
from membrane_rs.results.experiment import Experiment
from membrane_rs.study import compare
from small_scenes import refused
from typer.testing import CliRunner


def measured(name: str, time: Any, unit: str = "N", **columns: Any) -> Experiment:
    """Curves of given columns, all in one unit."""
    values = {key: np.asarray(column, float) for key, column in columns.items()}
    return Experiment(name, np.asarray(time, float), values, dict.fromkeys(values, unit))


DENSE = np.linspace(0.0, 2.0, 2001)
WAVE = measured("wave", DENSE, force=np.sin(np.pi * DENSE))


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs")
    for dt in (1e-6, 1e-5):
        membrane_rs.run("spinning-tether", 0.01, dt=dt, frames=2, out=folder / f"{dt:g}", pictures=False)
    return folder


def call(*words: object, code: int = 0) -> tuple[str, str]:
    """The standard output and error of the command."""
    result = CliRunner(env={"COLUMNS": "300"}).invoke(app, ["compare", *map(str, words)])
    assert result.exit_code == code, (result.output, result.exception)
    return result.stdout, result.stderr


def test_differences_are_those_of_the_curves() -> None:
    few = measured("few", [0.25, 0.75, 1.0, 1.5, 3.0], force=[0.1 + math.sqrt(0.5)] * 2 + [0.3, -0.9, 7.0])
    found = compare([WAVE, few]).difference("few", "force")
    assert (found.instants, found.start, found.end, found.unit) == (4, 0.25, 2.0, "N")
    d = np.array([0.1, 0.1, 0.3, 0.1])
    assert found.rms == pytest.approx(math.sqrt(np.mean(d**2)))
    assert found.mean == pytest.approx(d.mean())
    assert found.share == pytest.approx(found.rms / 2.0)
    assert found.largest == pytest.approx(0.3)
    assert found.largest_time == 1.0
    assert (found.peak, found.peak_time) == (-0.9, 1.5)
    assert abs(found.reference_peak) == pytest.approx(1.0)
    assert found.reference_peak_time % 1.0 == 0.5


@pytest.mark.parametrize("first", [True, False])
def test_the_sparse_curve_gives_the_instants(first: bool) -> None:
    # A chord of the wave would be off by much; the wave at the ends of the chord is not.
    chord = measured("chord", [0.0, 0.5, 1.0], force=[0.0, 1.0, 0.0])
    found = compare([chord, WAVE] if first else [WAVE, chord]).differences[0]
    assert (found.instants, found.end) == (3, 1.0)
    assert found.rms < 1e-15


def test_the_sign_is_that_of_the_curve_less_the_reference() -> None:
    high = measured("high", DENSE, force=WAVE.columns["force"] + 1.0)
    assert compare([WAVE, high]).differences[0].mean == pytest.approx(1.0)
    turned = compare([WAVE, high], reference="high")
    assert (turned.reference, turned.differences[0].label) == ("high", "wave")
    assert turned.differences[0].mean == pytest.approx(-1.0)


def test_a_reference_without_samples_in_the_common_time() -> None:
    found = compare([measured("far", [0.0, 10.0], force=[0.0, 10.0]), measured("near", [4, 5], force=[4, 3])])
    assert (found.differences[0].instants, found.differences[0].largest) == (2, -2.0)
    assert math.isnan(found.differences[0].reference_peak)


def test_values_that_are_missing_are_no_values() -> None:
    holes = measured("holes", [-1.0, 0.5, 1.0, 1.5, 9.0], force=[math.nan, 1.0, math.nan, -1.0, math.nan])
    found = compare([WAVE, holes]).differences[0]
    assert (found.instants, found.start, found.end) == (2, 0.5, 1.5)
    assert found.rms < 1e-12


def test_constant_and_huge_values() -> None:
    one, other = (measured(name, [0.0, 1.0], force=[value] * 2) for name, value in (("a", 1e300), ("b", -1e300)))
    found = compare([one, other]).differences[0]
    assert found.rms == pytest.approx(2e300)
    assert found.largest == pytest.approx(-2e300)
    assert math.isnan(found.share)
    assert "| - |" in compare([one, other]).table()


def test_columns_that_are_compared() -> None:
    time = [0.0, 1.0]
    run = measured("a", time, force=[0, 1], torque=[0, 1], other=[0, 1])
    test = measured("b", time, force=[0, 1], torque=[0, 2], force_std=[1, 1], stage=[0, 1])
    assert compare([run, test]).columns == ("force", "torque")
    assert compare([run, test], ["torque"]).columns == ("torque",)
    assert compare([run, test], ["torque", "torque"]).columns == ("torque",)
    empty = measured("d", time, force=[0, 1], torque=[math.nan] * 2)
    assert compare([run, empty]).columns == ("force",)
    assert (
        "| torque [N] | b | 2 | 0.7071 | 70.71 | 0.5 | 1 at 1 s | 2 at 1 s | 1 at 1 s |" in compare([run, test]).table()
    )
    assert compare([test, measured("c", time, force=[0, 1], stage=[1, 1])], "all").columns == ("force",)


@pytest.mark.parametrize(
    ("given", "options", "why"),
    [
        ([WAVE], {}, "1 of two or more curves"),
        ([], {}, "0 of two or more curves"),
        ("runs", {}, "must be a list of runs"),
        ([WAVE, WAVE], {"labels": ["a"]}, "1 labels for 2 curves"),
        ([WAVE, WAVE], {"labels": ["a", "a"]}, "'a' stands for two of them"),
        ([WAVE, 3], {}, "curves = 3: must be a path"),
        ([WAVE, WAVE], {"reference": "wavy"}, "reference = 'wavy': is no label"),
        ([WAVE, WAVE], {"columns": ["forse"]}, "'forse' is not in wave .1.; did you mean 'force'"),
        ([WAVE, WAVE], {"columns": []}, "must name one or more"),
        ([WAVE, WAVE], {"columns": "force"}, "must be a list of names"),
        ([WAVE, measured("x", [0, 1], torque=[1, 2])], {}, "shares no values of force, torque with another; known"),
        ([measured("x", [0, 1], forse=[1, 2]), WAVE], {}, "x: shares no values of forse.*; did you mean 'force'"),
        ([WAVE, measured("x", [5, 6], force=[1, 2])], {}, "wave: shares no time with another curve in force"),
        ([WAVE, measured("x", [0, 1], "m", force=[1, 2])], {}, "x, column 'force': 'm' is a length; .* a force"),
    ],
)
def test_what_cannot_be_compared(given: Any, options: dict[str, Any], why: str) -> None:
    refused(lambda: compare(given, **options), InputError, why)


def test_runs_by_their_folders_and_a_file(runs: Path, tmp_path: Path) -> None:
    history = membrane_rs.open_run(runs / "1e-06").history
    lines = [f"{1e3 * t},{1e3 * m}" for t, m in zip(history["time"][::100], history["hub_torque"][::100], strict=True)]
    (tmp_path / "torque.csv").write_text("\n".join(["time [ms],hub_torque [mN m]", *lines]))
    found = compare([runs / "1e-06", runs / "1e-05" / "summary.json", tmp_path / "torque.csv"])
    assert found.columns == ("hub_torque",)
    assert [curves.label for curves in found.curves] == ["1e-06", "1e-05", "torque"]
    assert found.difference("torque", "hub_torque").rms < 1e-15
    assert 0.0 < found.difference("1e-05", "hub_torque").share < 1e-4
    refused(lambda: found.difference("torque", "hub_force"), InputError, "no difference of 'torque' in 'hub_force'")
    assert repr(found) == "Comparison(1e-05, torque with 1e-06: hub_torque)"
    refused(lambda: compare([runs / "1e-06", runs / "none"]), MissingFileError, "no run and no file at .*none; name")


def test_the_same_name_twice_is_told_by_its_path(runs: Path, tmp_path: Path) -> None:
    (tmp_path / "1e-06").symlink_to(runs / "1e-06")
    found = compare([runs / "1e-06", tmp_path / "1e-06"])
    assert [curves.label for curves in found.curves] == [str(runs / "1e-06"), str(tmp_path / "1e-06")]
    refused(lambda: compare([runs / "1e-06"] * 2), InputError, "stands for two of them")


@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
def test_the_figure(ending: str, runs: Path, tmp_path: Path) -> None:
    found = compare({"fine": runs / "1e-06", "coarse": runs / "1e-05"})
    figure = found.plot(tmp_path / f"curves.{ending}", style="paper")
    assert [axes.get_ylabel() for axes in figure.axes] == ["Deployment rate", "Phase difference [deg]"]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["fine", "coarse"]
    assert (tmp_path / f"curves.{ending}").stat().st_size > 1000


def test_the_command(runs: Path, tmp_path: Path) -> None:
    picture = tmp_path / "curves.png"
    words = [runs / "1e-06", runs / "1e-05", "--columns", "kinetic_energy, hub_force", "--out", picture]
    shown, said = call(*words)
    assert shown.startswith("Differences from 1e-06\n\n| column | curve |")
    assert shown.count("| 1e-05 |") == 2
    assert (said, picture.is_file()) == (f"The figure is {picture}\n", True)
    shown, said = call(*words, "--json", "--no-figure", "--labels", "a,b", "--reference", "b", "--quiet")
    document = json.loads(shown)
    assert (document["reference"], document["columns"], document["figure"], said) == (
        "b",
        ["kinetic_energy", "hub_force"],
        None,
        "",
    )
    assert [found["label"] for found in document["differences"]] == ["a", "a"]


def test_the_command_without_options_writes_into_this_folder(
    runs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    _, said = call(runs / "1e-06", runs / "1e-05")
    assert (said, (tmp_path / "comparison.png").is_file()) == ("The figure is comparison.png\n", True)


def test_the_command_refuses(runs: Path, tmp_path: Path) -> None:
    (tmp_path / "binary.csv").write_bytes(bytes(range(256)))
    (tmp_path / "words.csv").write_text("time,hub_force\n0,1\n1,much\n")
    fine = runs / "1e-06"
    for words, why in (
        ([fine], "1 of two or more curves"),
        ([fine, tmp_path / "binary.csv"], "binary.csv"),
        ([fine, tmp_path / "words.csv"], "words.csv, line 3, column 'hub_force': 'much' is no number"),
        ([fine, tmp_path], "no summary at"),
        ([fine, runs / "1e-05", "--columns", "hub_force,,"], "--columns = 'hub_force,,': must be names separated"),
        ([fine, runs / "1e-05", "--out", tmp_path / "curves.gif"], "the ending '.gif' is no format of a figure"),
        ([fine, runs / "1e-05", "--dpi", "1e9", "--out", tmp_path / "curves.png"], "must be from 10 to 2400"),
        ([fine, runs / "1e-05", "--style", "nature", "--out", tmp_path / "curves.png"], "nature"),
    ):
        shown, said = call(*words, code=2)
        assert (shown, said.count("Error: ")) == ("", 1)
        assert why in said
    assert not list(tmp_path.glob("curves*"))
