"""The scene files of examples/, and the page of bodies, whose keys and example are theirs."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

import pytest
from membrane_rs import Scene, Simulation
from membrane_rs.check import audit
from membrane_rs.cli import app
from membrane_rs.scene.bodies import BODIES
from typer.testing import CliRunner

ROOT = Path(__file__).parent.parent
EXAMPLES = sorted((ROOT / "examples").glob("*.toml"))
PAGE = (ROOT / "docs/bodies.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_an_example_is_sound_and_draws_a_picture(file: Path, tmp_path: Path) -> None:
    scene = Scene.from_toml(file)
    assert [str(one) for one in audit(scene, costly=False).without_facts().findings] == []
    words = ["run", str(file), "--until", "0.01", "--frames", "2", "--out", str(tmp_path / "run")]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output
    assert (tmp_path / "run" / "deployment.png").is_file()


def test_the_strip_is_pulled_until_a_measure_ends_it_and_springs_back() -> None:
    sim = Simulation(Scene.from_toml(ROOT / "examples/strip_round_post.toml"))
    sim.run(frames=2, samples=3)
    assert [stage.ended_by for stage in sim.stages] == ["measure", "duration"]
    assert sim.stages[0].work_by_law["roller"] > 0.0
    assert sim.stages[1].changes["roller"] < 0.0
    assert abs(sim.ledger()["error"]) < 0.01


def test_the_page_of_bodies_has_all_keys() -> None:
    named = {name for row in re.findall(r"^\| (`.*?) \|", PAGE, re.MULTILINE) for name in re.findall(r"`(\w+)`", row)}
    assert named == {"kind"} | {field.name for body in BODIES.values() for field in fields(body)}


def test_the_example_on_the_page_is_that_of_the_file(tmp_path: Path) -> None:
    text = (ROOT / "examples/strip_round_post.toml").read_text(encoding="utf-8")
    before, roller, after = text.partition("[[bodies]]                  # just above")
    _, _, run = (roller + after).partition("[[stages]]")
    blocks = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    (tmp_path / "scene.toml").write_text(before + blocks[0] + run[run.index("[run]") :], encoding="utf-8")
    found, whole = Scene.from_toml(tmp_path / "scene.toml"), Scene.from_toml(ROOT / "examples/strip_round_post.toml")
    assert (found.bodies, found.stages) == (whole.bodies, whole.stages)
