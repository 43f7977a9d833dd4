"""Hostile options, names and outputs at the command line: one line that names the value, never a traceback."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from membrane_rs import InputError, RunSettings, Scene, SceneError, Simulation, Spin
from membrane_rs.cli import app
from membrane_rs.cli.application import TRACEBACK
from small_scenes import cord, refused
from typer.testing import CliRunner

SCENE = """
[laws.gravity]
[[parts]]
kind = "tether"
start = [0, 0, 0]
end = [1, 0, 0]
segments = 4
axial_stiffness = 10.0
linear_density = 0.1
[run]
until = 0.01
frames = 2
samples = 2
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    (tmp_path / "scene.toml").write_text(SCENE)
    return tmp_path / "scene.toml"


def printed(*words: str | Path, code: int) -> str:
    """What the command prints, in one line; it is no traceback."""
    result = CliRunner(env={"COLUMNS": "300"}).invoke(app, [str(word) for word in words])
    assert result.exception is None or isinstance(result.exception, SystemExit)
    assert result.exit_code == code
    return " ".join(result.output.split())


@pytest.mark.parametrize(
    ("option", "value", "words"),
    [
        ("--until", "1e308", "until = 1e+308: must be from 1e-15 to 1e+12 (s)"),
        ("--until", "5e-324", "until = 5e-324: must be from 1e-15 to 1e+12 (s)"),
        ("--until", "-1", "must be greater than 0"),
        ("--until", "nan", "must be finite"),
        ("--until", "1mm", "--until = '1mm': is a length; must be a time (s), such as '20 ms'"),
        ("--until", "soon", "--until = 'soon': must be a number (s), or a text with its unit such as '20 ms'"),
        ("--dt", "20uS", "--dt = '20uS': unit 'uS' is not known; did you mean 'us'?"),
        ("--dt", "5e-324", "steps of dt"),
        ("--frames", "1.5", "--frames = '1.5': must be a whole number"),
        ("--frames", "1" * 30, "frames"),
    ],
)
def test_numbers(option: str, value: str, words: str, scene: Path, tmp_path: Path) -> None:
    assert words in printed("run", scene, option, value, "--out", tmp_path / "run", code=2)
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ("--tolerance 1e-6 --integrator rk4", "run.tolerance = 1e-06 has no effect with 'rk4'"),
        ("--tolerance 1e-6 --integrator dopri5 --dt 1e-4", "run.tolerance = 1e-06 has no effect with 'dopri5'"),
        ("--substeps 4 --integrator rk4", "run.substeps = 4 has no effect with 'rk4'"),
        ("--spectral-radius 0.5 --integrator rk4", "run.spectral_radius = 0.5 has no effect with 'rk4'"),
        ("--tolerance 1e-6 --integrator dopri5", ""),
        ("--substeps 4 --integrator leapfrog", ""),
        ("--substeps 1 --integrator rk4", ""),
        ("--spectral-radius 0.5 --integrator generalized_alpha", ""),
    ],
)
def test_options_without_effect_are_told(options: str, why: str, scene: Path, tmp_path: Path) -> None:
    shown = printed("run", scene, *options.split(), "--out", tmp_path / "run", "--no-pictures", code=0)
    assert f"warning: {why}" in shown if why else "has no effect" not in shown


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ("--softening=", "Error: --softening = '': must be numbers separated by commas"),
        ("--density= --curves", "Error: --density = '': must be numbers separated by commas"),
        ("--integrators=", "Error: --integrators = '': must be names separated by commas"),
        ("--mesh --softening 3", "Error: --softening: has no effect with --mesh"),
        ("--mesh --density 2", "Error: --density: has no effect with --mesh"),
        ("--mesh --steps 3", "Error: --steps: has no effect with --mesh"),
        ("--mesh --shift 1e-6 --ensemble 1", "Error: --shift: has no effect with --mesh"),
        ("--softening 0", "Error: softenings (--softening): material.softening = 0.0: must be at least 1"),
        ("--softening nan", "Error: softenings = nan: must be finite (by which the film is softer in stretch, --soft"),
        ("--density nan --curves", "Error: densities = nan: must be finite (multiples of the scene's density, --dens"),
        ("--shift 0 --ensemble 1", "Error: shift = 0.0: must be above 0 (m, --shift)"),
        ("--jobs 0", "Error: jobs = 0: must be from 1 to 1,000 (runs at a time, --jobs)"),
        ("--rows 8", "Error: --rows: has no effect without --mesh"),
        ("--shift 1e-6", "Error: shift = 1e-06 (--shift): has no effect without perturbed starts"),
        ("--shift 1e-6 --curves --ensemble 0", "Error: shift = 1e-06 (--shift): has no effect without perturbed"),
    ],
)
def test_options_of_a_diagram_are_refused_before_a_run(options: str, said: str, tmp_path: Path) -> None:
    shown = printed("work-precision", "spinning-disc", *options.split(), "--out", tmp_path / "out", code=2)
    assert said in shown
    assert "reference" not in shown
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("ablate spinning-tether --ensemble 0 --shift 1e-6", "Error: --shift: has no effect without perturbed starts"),
        ("mesh-study okuizumi-model-1 --rows 8 --jobs 0", "Error: jobs = 0: must be from 1 to 1,000"),
    ],
)
def test_options_of_studies_are_refused_before_there_is_a_folder(command: str, said: str, tmp_path: Path) -> None:
    assert said in printed(*command.split(), "--out", tmp_path / "out", code=2)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", ["ablate", "work-precision", "mesh-study", "stability"])
@pytest.mark.parametrize("below", ["", "deeper/still"])
def test_a_study_into_a_file_is_refused_before_it_is_made(command: str, below: str, tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("kept", encoding="utf-8")
    values = ("--values", "0.02") if command == "stability" else ()
    scene = "okuizumi-model-1" if command == "mesh-study" else "spinning-tether"
    shown = printed(command, scene, *values, "--out", file / below, code=1)
    assert f"Error: cannot write {file / below}: {file} is no folder; choose a folder" in shown
    assert "/" not in shown.partition("Error")[0]
    assert file.read_text(encoding="utf-8") == "kept"


def test_starts_as_far_apart_as_segments_are_long_are_refused(tmp_path: Path) -> None:
    shown = printed("ensemble", "spinning-tether", "--starts", "3", "--shift", "1", "--out", tmp_path / "out", code=2)
    assert "Error: shift = 1: must be below 0.02979, the shortest edge or cord" in shown
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("options", [("--dt", "5e-324"), ("--dt", "1e-300", "--until", "1e12")])
def test_check_refuses_more_steps_than_a_run_takes(options: tuple[str, ...], scene: Path) -> None:
    assert "Error: until = " in printed("check", scene, *options, "--integrator", "rk4", code=2)


@pytest.mark.parametrize("integrator", ["leapfrog", "dopri5", "generalized_alpha"])
def test_check_of_the_shortest_run(integrator: str, scene: Path) -> None:
    assert "1 steps, about" in printed("check", scene, "--until", "1e-15", "--integrator", integrator, code=0)


def test_ends_that_no_step_can_count() -> None:
    for until in (1e308, 5e-324, 1e-320, 1e13):
        refused(lambda until=until: RunSettings(until=until), InputError, "must be from 1e-15 to 1e.12")  # type: ignore[misc]


@pytest.mark.parametrize("frequency", [1e155, 1e300])
def test_a_hub_too_fast_for_any_step(frequency: float) -> None:
    scene = Scene(None, None, [Spin(frequency)], [cord()])
    refused(lambda: Simulation(scene), InputError, "the largest stable step is .* set by spin")


@pytest.mark.parametrize(
    "text",
    [
        "[mesh]\npattern = 'square-sail'\nspool_radius = 1e308",
        "[mesh]\npattern = 'strip'\nlength = 1e200\nwidth = 1e155\ncolumns = 2",
        "[mesh]\npattern = 'disc'\nradius = 1e308\nrings = 3\n[[parts]]\nkind = 'tethers'\nnodes = 'rim'",
        SCENE.replace("end = [1, 0, 0]", "end = [1e308, 1e308, 1e308]"),
        SCENE.replace("segments = 4", "segments = 4\nlength = 1e308"),
    ],
)
def test_scenes_of_values_beyond_nature(text: str, scene: Path, recwarn: pytest.WarningsRecorder) -> None:
    scene.write_text(text)
    if "[mesh]" in text:
        film = "youngs_modulus = 1e6\npoisson_ratio = 0.3\ndensity = 1e3\nthickness = 1e-4"
        scene.write_text(f"{text}\n[material]\n{film}\n")
    assert "Error: " in printed("check", scene, code=2)
    assert [str(w.message) for w in recwarn if w.category is RuntimeWarning] == []


def test_a_name_that_no_file_holds() -> None:
    refused(lambda: Scene(None, None, [], [cord()], name="a\ud800"), SceneError, "half of a surrogate pair")


def run(
    *words: str | bytes | Path, stdout: int = subprocess.PIPE, **environment: str
) -> subprocess.CompletedProcess[bytes]:
    command = [os.fsencode(sys.executable), b"-m", b"membrane_rs.cli", *map(os.fsencode, words)]
    return subprocess.run(command, stdout=stdout, stderr=subprocess.PIPE, check=False, timeout=300)


def test_a_file_name_that_is_no_text(scene: Path) -> None:
    path = os.fsencode(scene.parent) + b"/\xff.toml"
    scene.rename(os.fsdecode(path))
    out = os.fsencode(scene.parent) + b"/\xfe"
    done = run("run", path, "--out", out, "--no-pictures")
    assert done.returncode == 0, done.stderr
    assert b"Results are in" in done.stdout
    assert Path(os.fsdecode(out), "summary.json").is_file()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
@pytest.mark.parametrize("words", [("scenes",), ("--help",)])
def test_a_full_disk_behind_the_standard_output(words: tuple[str, ...]) -> None:
    with Path("/dev/full").open("wb") as full:
        done = run(*words, stdout=full.fileno())
    assert done.returncode == 1
    assert done.stderr.decode().splitlines() == ["Error: cannot write to the standard output: No space left on device"]


def test_an_unexpected_error_asks_to_report_it(scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(self: Simulation) -> float:
        raise LookupError("of a test")

    monkeypatch.setattr(Simulation, "stable_dt", fail)
    text = printed("check", scene, code=1)
    assert "unexpected LookupError: of a test. This is a fault of membrane_rs; please report it" in text
    assert "Traceback" not in text
    monkeypatch.setenv(TRACEBACK, "1")
    assert "Traceback" in printed("check", scene, code=1)
