"""`--set KEY=VALUE` and options with units at the command line."""

from __future__ import annotations

import json
import re
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import pytest
import typer
from membrane_rs import RunSettings, Scene, Simulation, Spin, Stage, scenes
from membrane_rs.cli import app
from membrane_rs.cli.settings import LONGEST, value_of, values_of
from membrane_rs.errors import InputError
from membrane_rs.study import sweep
from small_scenes import hanging_strip, refused
from test_cli import call
from test_commands import examples

COMMANDS: dict[str, Any] = typer.main.get_command(app).commands  # type: ignore[attr-defined]
OF_SCENES = {
    name: command
    for name, command in COMMANDS.items()
    if any("SCENE" in (param.metavar or "") and param.param_type_name == "argument" for param in command.params)
}
SHORT = ["--until", "2ms", "--frames", "3", "--no-pictures"]


def test_every_command_of_a_scene_is_found() -> None:
    assert {"run", "check", "stability", "work-precision", "ablate", "mesh-study"} <= set(OF_SCENES)


@pytest.mark.parametrize("name", OF_SCENES)
def test_every_command_of_a_scene_takes_values(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    command = OF_SCENES[name]
    option = next(param for param in command.params if "--set" in param.opts)
    assert option.multiple
    *before, (_, *words) = examples(name)
    for line in before:
        assert call(*line)[0] == 0
    code, shown = call(name, *words, "--set", "laws.spin.frequenc=1")
    assert (
        code,
        "laws.spin.frequenc = 1: no such key; did you mean 'laws.spin.frequency'" in " ".join(shown.split()),
    ) == (
        2,
        True,
    )


def test_a_run_has_the_values_and_its_folder_shows_them(tmp_path: Path) -> None:
    values = ["laws.spin.frequency=25 rpm", "parts.0.tip_mass=0.36g", "run.integrator=leapfrog", "laws.gravity=true"]
    words = [word for value in values for word in ("--set", value)]
    code, shown = call("run", "spinning-tether", *words, *SHORT, "--dt", "10 us", "--out", tmp_path / "run")
    assert (code, "Results are in" in shown) == (0, True)
    text = (tmp_path / "run" / "scene.toml").read_text()
    assert f"frequency = {25 / 60!r}  # Hz" in text
    made = Scene.from_toml(tmp_path / "run" / "scene.toml")
    spin, part = made.law(Spin), made.parts[0]
    assert spin is not None
    assert (spin.frequency, part.tip_mass, made.run.integrator) == (25 / 60, 0.36e-3, "leapfrog")  # type: ignore[attr-defined]
    assert made.law("gravity") is not None
    assert (made.run.until, made.run.dt) == (2e-3, 10e-6)
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["dt"] == 10e-6


@pytest.mark.parametrize("integrator", ["rk4", "leapfrog", "dopri5"])
@pytest.mark.parametrize("option", [("--dt", "auto"), ("--set", "run.dt=auto"), ("--set", "run.dt= auto ")])
def test_a_step_of_the_scene_is_left_out(option: tuple[str, str], integrator: str, tmp_path: Path) -> None:
    words = ["--set", "run.substeps=1", "--integrator", integrator]
    fast = scenes.load("okuizumi-model-1-fast")
    own = fast.run.dt
    assert own is not None
    code, shown = call("run", fast.name, *words, *option, *SHORT, "--samples", 3, "--out", tmp_path / "run")
    assert (code, "above the stability limit" in shown) == (0, False), shown
    made = Scene.from_toml(tmp_path / "run" / "scene.toml")
    assert made.run == RunSettings(
        **{
            **asdict(fast.with_values({"run.dt": None}).run),
            "substeps": 1,
            "integrator": integrator,
            "until": 2e-3,
            "frames": 3,
            "samples": 3,
        }
    )
    sim = Simulation(made)
    assert sim.is_adaptive == (integrator == "dopri5")
    assert sim.dt < sim.stable_dt() < own


@pytest.mark.parametrize("integrator", ["rk4", "dopri5"])
def test_a_step_of_the_scene_above_the_limit_says_how_to_leave_it_out(integrator: str) -> None:
    said = " ".join(call("check", "okuizumi-model-1-fast", "--integrator", integrator)[1].split())
    assert "is above the stability limit of" in said
    assert "leave dt out (--dt auto, or --set run.dt=auto; None in Python), or use a smaller one" in said
    assert "later chosen by the tolerance" not in said  # a given step is not chosen


def test_a_step_is_left_out_in_files_studies_and_stages(tmp_path: Path) -> None:
    scene = scenes.load("spinning-tether").with_values({"run.dt": 1e-5})
    scene.save(tmp_path)
    path = tmp_path / "scene.toml"
    path.write_text(path.read_text().replace("dt = 1e-05", 'dt = "auto"'))
    assert Scene.from_toml(path).run == scene.with_values({"run.dt": "auto"}).run
    assert Scene.from_toml(path).run.dt is None
    staged = replace(scene, stages=[Stage("one", 0.1), Stage("two", 0.1, set={"run.dt": "auto"})])
    assert (staged.staged(0).run.dt, staged.staged(1).run.dt) == (1e-5, None)
    found = sweep(scene, {"run.dt": "auto,1e-5"}, until=1e-4, samples=2, out=tmp_path / "sweep", table="csv")
    first, second = (row["dt"] for row in found.rows)
    assert (found.outcomes(), second) == ({"finished": 2}, 1e-5)
    assert first == pytest.approx(Simulation(scene.with_values({"run.dt": None})).dt, rel=0.1)


@pytest.mark.parametrize("key", ["run.until", "material.thickness", "run.relax"])
def test_other_numbers_do_not_follow_from_any(key: str) -> None:
    refused(lambda: hanging_strip().with_values({key: "auto"}), InputError, f"^{key} = 'auto': must be a number")
    refused(lambda: RunSettings(dt="auto"), InputError, "dt = 'auto': must be a number")  # type: ignore[arg-type]


def test_check_shows_the_values() -> None:
    code, shown = call("check", "spinning-tether", "--set", "parts.0.segments=3", "--until", "1 ms")
    assert (code, re.search(r"springs +3\n", shown) is not None, "Run      0.001 s by" in shown) == (0, True, True)


def test_values_of_a_study_take_units(tmp_path: Path) -> None:
    words = ["--parameter", "laws.spin.frequency", "--integrator", "rk4", "--steps", "0.5", "--until", "1 ms"]
    code, shown = call("stability", "spinning-tether", *words, "--values", "30 rpm, 1", "--out", tmp_path / "map")
    assert (code, "frequency = 0.5 " in shown, "frequency = 1 " in shown) == (0, True, True)
    code, shown = call("stability", "spinning-tether", *words, "--values", "30 rpm,1 m")
    assert (code, "--values = '1 m': is a length; must be a frequency" in " ".join(shown.split())) == (2, True)
    code, shown = call("stability", "spinning-tether", *words, "--values", "1,fast")
    assert (code, "must be numbers separated by commas" in " ".join(shown.split())) == (2, True)


def test_resume_refuses_values(tmp_path: Path) -> None:
    assert call("run", "spinning-tether", *SHORT, "--out", tmp_path / "run")[0] == 0
    code, shown = call("resume", tmp_path / "run", "--set", "run.dt=1e-5", "--until", "4 ms")
    assert (code, "--set run.dt=1e-5: a run is continued under the scene" in " ".join(shown.split())) == (2, True)
    code, shown = call("resume", tmp_path / "run", "--until", "4 ms")
    assert code == 0, shown


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--until", "1 kg"], r"Error: --until = '1 kg': is a mass; must be a time \(s\), such as '20 ms'"),
        (["--until", "soon"], r"--until = 'soon': must be a number \(s\), or a text with its unit such as '20 ms'"),
        (["--until", "1 msc"], "unit 'msc' is not known"),
        (["--dt", "2 rpm"], r"--dt = '2 rpm': is a frequency of turning; must be a time \(s\)"),
        (["--checkpoint", "1 m"], "'1 m': is a length; must be a time"),
        (["--tolerance", "1 m"], "--tolerance = '1 m': must be a number, such as 0.5"),
        (["--set", "laws"], "--set 'laws': must be KEY=VALUE, such as laws.creases.stiffness=20"),
        (["--set", "=3"], "must be KEY=VALUE"),
        (["--set", "run.dt="], "must be KEY=VALUE"),
        (["--set", "run.dt=1", "--set", "run.dt = 2"], "run.dt has a value already; leave out one of them"),
        (["--set", "run.dt=[1"], r"--set run.dt = '\[1': is no value of TOML"),
        (["--set", "run.dt={}"], r"Error: run.dt = \{\}: must be a number, greater than 0 \(s\)"),
        (["--set", "run.dt=fast"], "run.dt = 'fast': must be a number"),
        (["--set", "run.dt=1 kg"], r"run.dt = '1 kg': is a mass; must be a time \(s\)"),
        (["--set", "run.dt=nan"], "run.dt = nan: must be finite"),
        (["--set", "run.dt=1979-05-27"], "must be a number"),
    ],
)
def test_wrong_values_are_refused(words: list[str], said: str, tmp_path: Path) -> None:
    code, shown = call("run", "spinning-tether", *words, "--out", tmp_path / "run")
    assert code == 2, shown
    assert re.search(said, " ".join(shown.split())), shown
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("20", 20),
        (" 2e1 ", 20.0),
        ("true", True),
        ("[0, 0.5]", [0, 0.5]),
        ('"a b"', "a b"),
        ("{stiffness = 2}", {"stiffness": 2}),
        ("cross", "cross"),
        ("25 rpm", "25 rpm"),
        ("a=b", "a=b"),
        ("01", "01"),
        (".3", 0.3),
        ("-1.", -1.0),
        ("1.e-3", 1e-3),
        ("True", True),
        ("False", False),
        (".", "."),
        (".3.", ".3."),
    ],
)
def test_values_are_of_toml_or_plain_text(text: str, value: object) -> None:
    assert values_of([f"a.b={text}"]) == {"a.b": value}


@pytest.mark.parametrize("text", ["[" * 5000, "{a = " * 900, "1" * 5000 + "[", "[1", "'", "1\n2", "x" * (LONGEST + 1)])
def test_hostile_values_are_refused(text: str) -> None:
    if text[0] == "1" and "\n" not in text:
        assert value_of(text, "x") == text  # a plain text, which a field then refuses
    else:
        refused(lambda: value_of(text, "x"), InputError, r"^x = ")


def test_numbers_of_thousands_of_digits_are_plain_text() -> None:
    scene = scenes.load("spinning-tether")
    values = values_of([f"run.dt={'1' * 5000}"])
    refused(lambda: scene.with_values(values), InputError, "run.dt = .*: must be")
