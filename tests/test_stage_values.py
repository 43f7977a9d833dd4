"""What stages set: nothing in place of a value, keys without quotes, an acceleration; faults by their place."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from membrane_rs import Cylinder, Fixed, Scene, Schedule, Simulation, Spin, Stage, TipMasses
from membrane_rs.check import audit
from membrane_rs.errors import SceneError
from small_scenes import cord, hanging_strip, refused
from staged_scenes import oscillator

BAR = Cylinder(
    "bar", 0.01, centre=(0.0, 0.0, -1.0), direction=(0.0, 1.0, 0.0), travel_z=Schedule((0.0, 1.0), (0.0, 0.1))
)


def scene_of(*stages: Stage, **run: Any) -> Scene:
    return replace(oscillator(**run), bodies=[BAR], stages=stages)


@pytest.mark.parametrize(("key", "run"), [("bodies.bar.travel_z", {}), ("run.dt", {"dt": 1e-3})])
def test_files_and_digests_hold_a_value_taken_away(key: str, run: dict[str, Any], tmp_path: Path) -> None:
    stages = Stage("one", 0.1), Stage("two", 0.1, set={key: None})
    scene = scene_of(*stages, **run)
    scene.save(tmp_path)
    read = Scene.from_toml(tmp_path / "scene.toml")
    assert read.stages == scene.stages
    assert read.stages[1].set == {key: None} == Stage("two", 0.1, set={key: {}}).set
    staged = read.staged(1)
    assert (staged.bodies[0].travel_z if not run else staged.run.dt) is None
    plain = scene_of(stages[0], Stage("two", 0.1), **run)
    assert Simulation(scene).state()["scene_digest"] != Simulation(plain).state()["scene_digest"]
    sim = Simulation(scene)
    sim.reach(0.05)
    sim.save(tmp_path / "state.npz")
    other = Simulation.restore(tmp_path / "state.npz")
    for each in (sim, other):
        each.run()
    assert other.positions.tobytes() == sim.positions.tobytes()
    assert other.stages == sim.stages


def test_keys_without_quotes_are_refused_with_the_remedy(tmp_path: Path) -> None:
    text = scene_of(Stage("one", 0.1)).to_toml().replace("set = {}", "set.laws.mass_damping.rate = 1.0")
    (tmp_path / "scene.toml").write_text(text)
    words = "'laws': is no key of a value; write one such as 'laws.gravity.key', in quotes in files"
    refused(lambda: Scene.from_toml(tmp_path / "scene.toml"), SceneError, words)


def test_a_fault_names_a_part_by_its_index_in_the_scene() -> None:
    scene = oscillator(Stage("one", 0.1), Stage("two", 0.1))
    first, *others = scene.parts
    parts = [Fixed((0,), name="gone"), first, *others, TipMasses(1.0, (7,), name="far")]
    stages = Stage("one", 0.1, without=("far",)), Stage("two", 0.1, without=("gone",))
    words = r"stages\[1\]: parts\[4\]\.nodes = \(7,\): node 7 is not there"
    refused(lambda: replace(scene, parts=parts, stages=stages), SceneError, words)


@pytest.mark.parametrize("start", [0.0, 0.3])
def test_an_acceleration_counts_from_the_start_of_the_stage_that_sets_it(start: float) -> None:
    change = {"laws.spin.acceleration": 10.0}
    stages = Stage("one", 0.1), Stage("two", 0.1, set=change), Stage("three", 0.1)
    scene = Scene(None, None, [Spin(1.0)], [cord()], stages=stages)
    sim = Simulation(scene)
    if start:
        before = Simulation(Scene(None, None, [Spin(1.0)], [cord()]))
        before.reach(start)
        sim = Simulation(scene, start=before)
    rates = []
    for time in (0.05, 0.1, 0.15, 0.2 - 1e-9, 0.25):
        sim.reach(start + time)
        rates.append(sim._core.hub_rate / math.tau)
    assert rates == pytest.approx([1.0, 1.0, 1.5, 2.0, 1.0], rel=1e-6)


def test_the_audit_warns_of_what_no_stage_has() -> None:
    stages = Stage("one", 0.1, without=("bar",)), Stage("two", 0.1, "largest_film_stress", above=1.0, without=("bar",))
    found = {finding.kind: finding for finding in audit(scene_of(*stages), costly=False).warnings}
    assert found["idle_in_all"].message == "bar is at work in no stage: each is without it"
    assert found["measure"].message.startswith("stages[1].measure = 'largest_film_stress': there is no film")
    plain = audit(scene_of(Stage("one", 0.1, without=("bar",)), Stage("two", 0.1)), costly=False)
    assert not {"idle_in_all", "measure"} & {finding.kind for finding in plain.findings}
    strip = replace(hanging_strip(), stages=[Stage("one", 0.1, "largest_film_stress", above=1e9)])
    assert "measure" not in {finding.kind for finding in audit(strip, costly=False).findings}


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"friction": 10.5}, r"bodies\[0\]\.friction = 10\.5: more than 10 is hardly met"),
        ({"damping": 101.0}, r"bodies\[0\]\.damping = 101: .*was 101 percent meant\? That is 1\.01"),
        ({"spin": Schedule((0.0, 1.0), (0.0, 1.0))}, r"bodies\[0\]\.spin: is without effect.*no friction; give it"),
    ],
)
def test_the_audit_warns_of_values_of_bodies(values: dict[str, Any], words: str) -> None:
    scene = Scene(None, None, [], [cord()], bodies=[replace(BAR, **values)])
    texts = [f"{finding.message}; {finding.remedy}" for finding in audit(scene, costly=False).warnings]
    assert [text for text in texts if re.search(words, text)], texts
    plain = audit(replace(scene, bodies=[BAR]), costly=False)
    assert not any(finding.message.startswith(f"bodies[0].{next(iter(values))}") for finding in plain.findings)
