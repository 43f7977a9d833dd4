"""What `run` and `resume` record on the command line, and what ends a run there."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from membrane_rs import open_run
from membrane_rs.cli.application import app
from typer.testing import CliRunner, Result

RUN = ("run", "spinning-tether", "--until", "4ms", "--frames", "3", "--no-pictures", "--json", "--quiet", "--out")


def called(*words: object) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


def test_run_records_at_an_interval_until_a_measure_passes_its_value(tmp_path: Path) -> None:
    options = ("--every", "0.5ms", "--record", "largest_speed", "--record", "kinetic_energy")
    shown = called(*RUN, tmp_path / "run", *options, "--stop-when", "hub_angle > 2deg")
    assert shown.exit_code == 0
    summary = json.loads(shown.stdout)
    assert summary["request"]["every"] == 5e-4
    assert summary["request"]["record"] == {"largest_speed": "m/s"}
    assert summary["stopped"]["by"].startswith("hub_angle above 0.0349")
    result = open_run(tmp_path / "run")
    assert result.history["time"][:-1].tolist() == [0.0, 5e-4, 1e-3, 1.5e-3]
    assert list(result.history)[-1] == "largest_speed"
    assert called("resume", tmp_path / "run", "--until", "3ms").exit_code == 0
    assert open_run(tmp_path / "run").history["time"][-3:].tolist() == [2e-3, 2.5e-3, 3e-3]


def test_run_takes_a_number_of_samples(tmp_path: Path) -> None:
    assert called(*RUN, tmp_path / "run", "--samples", 9).exit_code == 0
    result = open_run(tmp_path / "run")
    assert result.history.sample_count == 9
    assert result.scene.run.samples == 9


def test_a_saved_state_goes_on_with_a_history_of_its_own(tmp_path: Path) -> None:
    called(*RUN, tmp_path / "run")
    shown = called(
        "resume", tmp_path / "run/state.npz", "--until", "6ms", "--every", "1ms", "--record", "largest_speed",
        "--out", tmp_path / "more", "--frames", 2, "--no-pictures",
    )  # fmt: skip
    assert shown.exit_code == 0
    history = open_run(tmp_path / "more").history
    assert history["time"].tolist() == [4e-3, 5e-3, 6e-3]
    assert "largest_speed" in history


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--every", "1ms", "--samples", 3), "--every 0.001: --samples 3 is given too; leave one of them out"),
        (("--record", "largest_sped"), "did you mean 'largest_speed'?"),
        (("--stop-when", "hub_angle"), "must be a measure, < or >, and the value that it passes"),
        (("--stop-when", "hub_angle > 3kg"), "is a mass; must be an angle"),
        (("--every", "0"), "must be above 0"),
    ],
)
def test_what_no_run_can_be_asked_for_is_refused_before_it(
    words: tuple[object, ...], message: str, tmp_path: Path
) -> None:
    shown = called(*RUN, tmp_path / "run", *words)
    assert shown.exit_code == 2
    assert message in shown.stderr
    assert not (tmp_path / "run").exists()


OPTIONS = [("--samples", 3), ("--every", "1ms"), ("--record", "hub_angle"), ("--stop-when", "")]


@pytest.mark.parametrize("option", OPTIONS)
def test_a_run_goes_on_as_it_was_asked_for(option: tuple[object, ...], tmp_path: Path) -> None:
    called(*RUN, tmp_path / "run")
    shown = called("resume", tmp_path / "run", "--until", "5ms", *option)
    assert shown.exit_code == 2
    assert f"{option[0]}: a run is continued in its own folder as it was asked for" in shown.stderr
