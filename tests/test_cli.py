"""The command line: what it prints, what it leaves behind, and its exit codes."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from child_processes import SECONDS, started, wait_until
from membrane_rs import Scene, Simulation, scenes
from membrane_rs.cli import app
from membrane_rs.results import read_history
from small_scenes import hanging_strip
from typer.testing import CliRunner

COMMAND = [sys.executable, "-m", "membrane_rs.cli"]
SHORT = ["--until", "0.01", "--frames", "3", "--no-pictures"]


def call(*words: object) -> tuple[int, str]:
    """Exit code and everything that was printed."""
    result = CliRunner().invoke(app, [str(word) for word in words])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.exit_code, result.output


def summary(folder: Path) -> dict[str, object]:
    """summary.json of a run's folder."""
    found: dict[str, object] = json.loads((folder / "summary.json").read_text())
    return found


def test_help_is_quick_and_loads_nothing_heavy() -> None:
    words = "import sys; sys.argv = ['membrane-rs', '--help']\nfrom membrane_rs.cli import main\n"
    words += "try: main()\nexcept SystemExit: pass\n"
    words += "print([m for m in ('scipy', 'pyvista', 'matplotlib', 'meshio') if m in sys.modules])"
    shown = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=True).stdout
    assert all(name in shown for name in ("run", "resume", "scenes", "check"))
    assert shown.strip().endswith("[]")


def test_scenes_are_listed() -> None:
    code, shown = call("scenes")
    assert code == 0
    assert [line.split()[0] for line in shown.splitlines()] == scenes.names()


def test_run_writes_a_folder(tmp_path: Path) -> None:
    code, shown = call("run", "spinning-tether", *SHORT, "--out", tmp_path / "run", "--dt", "1e-5")
    assert (code, "Results are in" in shown) == (0, True)
    assert f"  membrane-rs view {tmp_path / 'run'} " in shown
    assert f"  membrane-rs report {tmp_path / 'run'} " in shown
    assert summary(tmp_path / "run")["outcome"] == "finished"
    assert summary(tmp_path / "run")["dt"] == 1e-5
    assert read_history(tmp_path / "run" / "history.csv")["time"][-1] == pytest.approx(0.01)
    assert len(list((tmp_path / "run" / "frames").glob("*.vtu"))) == 3
    code, _ = call("run", "spinning-tether", *SHORT, "--out", tmp_path / "soft", "--spectral-radius", 0.5)
    assert code == 0
    assert Scene.from_toml(tmp_path / "soft" / "scene.toml").run.spectral_radius == 0.5
    code, shown = call("run", "spinning-tether", *SHORT, "--out", tmp_path / "hard", "--spectral-radius", 1.5)
    assert (code, "run.spectral_radius = 1.5: must be at least 0 and at most 1" in " ".join(shown.split())) == (2, True)
    code, shown = call("run", "spinning-tether", *SHORT, "--out", tmp_path / "run")
    assert (code, shown.count("Error:"), "--overwrite" in shown) == (1, 1, True)
    assert call("run", "spinning-tether", *SHORT, "--out", tmp_path / "run", "--overwrite")[0] == 0


@pytest.mark.parametrize(("option", "warnings"), [("--substeps", 0), ("--short-steps", 1)])
def test_check_and_run_take_substeps_by_both_names(option: str, warnings: int, tmp_path: Path) -> None:
    path = tmp_path / "strip.toml"
    path.write_text(hanging_strip().to_toml(), encoding="utf-8")
    words = ["--integrator", "leapfrog", option, 3]
    code, shown = call("check", path, *words)
    assert (code, "once a step  gravity; the others in 3 substeps" in shown) == (0, True)
    assert shown.count("Warning: --short-steps is deprecated and is removed in version 0.4; use --substeps") == warnings
    code, shown = call("run", path, *words, *SHORT, "--out", tmp_path / "results")
    assert (code, shown.count("deprecated")) == (0, warnings)
    assert Scene.from_toml(tmp_path / "results" / "scene.toml").run.substeps == 3


def test_old_keys_of_a_scene_file_are_shown_as_warnings(tmp_path: Path) -> None:
    path = tmp_path / "old.toml"
    text = hanging_strip().to_toml()
    path.write_text(text.replace("substeps = 1\n", "short_steps = 1\n"), encoding="utf-8")
    code, shown = call("check", path)
    assert (code, shown.count("Warning: run.short_steps is deprecated and is removed in version 0.4")) == (0, 1)


def test_chart_is_the_old_name_of_work_precision(tmp_path: Path) -> None:
    words = ["--until", "0.001", "--steps", "1", "--repeats", "1", "--integrators", "leapfrog"]
    code, shown = call("chart", "spinning-tether", *words, "--out", tmp_path / "chart")
    assert (code, (tmp_path / "chart" / "chart.png").is_file()) == (0, True)
    assert (
        "Warning: membrane-rs chart is deprecated and is removed in version 0.4; use membrane-rs work-precision"
        in shown
    )


def test_run_takes_a_file_and_its_own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_text(scenes.load("single-crease").to_toml())
    assert call("run", "mine.toml", "--until", "0.001", "--no-pictures", "--integrator", "rk4")[0] == 0
    assert summary(Path("runs/single-crease"))["integrator"] == "rk4"


def test_resume_continues_with_the_same_bits(tmp_path: Path) -> None:
    assert call("run", "spinning-tether", *SHORT, "--out", tmp_path / "a")[0] == 0
    state = tmp_path / "a" / "state.npz"
    code, _ = call("resume", state, "--until", "0.02", "--frames", "3", "--no-pictures")
    assert code == 0
    whole = Simulation(scenes.load("spinning-tether"))
    again = Simulation.restore(tmp_path / "a-continued" / "state.npz")
    whole.reach(0.02)
    assert again.time == 0.02
    assert (whole.positions == again.positions).all()
    code, shown = call("resume", state, "--until", "0.005")
    assert (code, "give a later time" in shown) == (2, True)
    code, shown = call("resume", tmp_path / "none.npz")
    assert (code, shown.count("Error:")) == (2, 1)


def test_check_tells_counts_audit_step_and_cost() -> None:
    code, shown = call("check", "okuizumi-model-1", "--until", "0.1")
    assert code == 0
    for words in ("1,980", "5,432", "3,456", "stable step", "limited by", "steps, about", "no errors"):
        assert words in shown


@pytest.mark.parametrize("value", ["material.softening=1e6", "material.youngs_modulus=1"])
def test_check_of_a_run_that_stops_by_itself_reports_all_but_its_cost(value: str) -> None:
    code, shown = call("check", "spinning-disc", "--set", value)
    for words in ("no errors", "the run stops by itself: stopped at t =", "cost         unknown: the run stops by it"):
        assert words in shown
    found, text = call("check", "spinning-disc", "--set", value, "--json")
    (run,) = json.loads(text)["runs"]
    assert (code, found, run["steps"], run["seconds"]) == (0, 0, None, None)
    assert run["stable_dt"] > run["dt"] > 0.0


def test_check_finds_errors(tmp_path: Path) -> None:
    text = scenes.load("okuizumi-model-1").to_toml().replace('"ruled"', '"fan"')
    text = text.replace('negative = "refuse"', 'negative = "clip"')
    (tmp_path / "fan.toml").write_text(text)
    code, shown = call("check", tmp_path / "fan.toml")
    assert (code, "664" in shown) == (1, True)


@pytest.mark.parametrize(
    ("words", "code", "shown"),
    [
        (["run", "spinning-tethr"], 2, "did you mean 'spinning-tether'"),
        (["run", "nowhere.toml"], 2, "no such scene file"),
        (["check", "nowhere/at/all"], 2, "no such scene file"),
        (["run", "spinning-tether", "--dt", "0"], 2, "run.dt = 0.0: must be greater than 0 (s)"),
        (["run", "spinning-tether", "--dt", "nan"], 2, "must be finite"),
        (["run", "spinning-tether", "--dt", "9"], 2, "times the stability limit of rk4"),
        (["run", "spinning-tether", "--until", "-1"], 2, "run.until = -1.0: must be greater than 0"),
        (["run", "spinning-tether", "--frames", "1"], 2, "run.frames = 1: must be at least 2"),
        (["run", "spinning-tether", "--integrator", "rk5"], 2, "rk5"),
        (["run", "spinning-tether", "--speed"], 2, "Error: '--speed': no such option of membrane-rs run; did you mean"),
        (["fly"], 2, "Error: COMMAND = 'fly': no such command; known are: "),
        (["run"], 2, "Error: SCENE: is missing; such as: membrane-rs run "),
    ],
)
def test_mistakes_cost_one_line(
    words: list[str], code: int, shown: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    found, printed = call(*words)
    assert found == code
    assert shown in printed
    assert "Error:" in printed
    assert len(printed.strip().splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_folder_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    code, shown = call("run", "spinning-tether", "--out", tmp_path / "file" / "run")
    assert (code, shown.count("Error:")) == (1, 1)


def test_ctrl_c_stops_at_once_and_tells_how_to_go_on(tmp_path: Path) -> None:
    history = tmp_path / "run" / "history.csv"
    words = [*COMMAND, "run", "okuizumi-model-1", "--until", "1000", "--every", "1ms", "--no-pictures"]
    with started([*words, "--out", str(tmp_path / "run")], stderr=subprocess.PIPE, text=True) as process:
        wait_until(lambda: history.exists() and history.read_text().count("\n") > 3, "the run goes on", process)
        process.send_signal(signal.SIGINT)
        _, shown = process.communicate(timeout=SECONDS)
    assert process.returncode == 130
    assert "Stopped at" in shown
    assert "Traceback" not in shown
    assert "Continue with: membrane-rs resume" in shown
    assert summary(tmp_path / "run")["outcome"] == "interrupted"
    # Long before the end, to which it would take a day.
    assert 0.0 < Simulation.restore(tmp_path / "run" / "state.npz").time < 500.0


def test_work_precision_writes_data_and_picture(tmp_path: Path) -> None:
    words = ["--until", "0.01", "--steps", "2", "--repeats", "1", "--integrators", "rk4", "--error", "1e-4"]
    code, shown = call("work-precision", "spinning-tether", *words, "--out", tmp_path / "chart")
    assert code == 0
    assert "Least force evaluations for an error of 0.0001 (position): rk4" in shown
    assert sorted(path.name for path in (tmp_path / "chart").iterdir()) == ["chart.csv", "chart.json", "chart.png"]
    code, shown = call("work-precision", "spinning-tether", "--integrators", "rk4,rk5", "--out", tmp_path / "none")
    assert (code, "did you mean 'rk4'" in shown, (tmp_path / "none").exists()) == (2, True, False)


def test_ablate_writes_a_table_and_a_scene(tmp_path: Path) -> None:
    words = ["--until", "0.02", "--ensemble", "1", "--tolerance", "0.02", "--out", tmp_path / "a"]
    code, shown = call("ablate", "spinning-tether", *words)
    assert (code, "The smallest model leaves out" in shown) == (0, True)
    assert call("check", tmp_path / "a" / "smallest-model" / "scene.toml")[0] == 0
    code, shown = call("ablate", "spinning-tether", "--tolerance", "-1", "--out", tmp_path / "none")
    assert (code, "tolerance = -1.0" in shown, (tmp_path / "none").exists()) == (2, True, False)
