"""Ablation: what may go, what is needed, what cannot be left out, and the smallest model as a scene."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from membrane_rs import AirDrag, InputError, Scene, Simulation, Spin, scenes
from membrane_rs.study import Ablation, ablate
from membrane_rs.study.ablation import Change
from membrane_rs.study.variants import variants, without
from small_scenes import hanging_strip, refused


@pytest.fixture(scope="module")
def tether() -> Ablation:
    """A cord that needs its spin, and fewer segments than it has."""
    return ablate(scenes.load("spinning-tether"), 0.1, members=2)


def test_every_law_and_part_has_a_row(tether: Ablation) -> None:
    names = [item.name for item in tether.items]
    assert names == [
        "law spin",
        "law spring_damping",
        "part tether",
        "all but 2 of 10 segments in part tether",
        "smallest model",
    ]
    verdicts = {item.name: item.verdict for item in tether.items}
    assert verdicts["law spin"] == "needed"
    assert verdicts["part tether"].startswith("cannot be left out: mesh: is missing")
    assert verdicts["smallest model"] == "within tolerance"


def test_costs_are_shares_of_the_whole(tether: Ablation) -> None:
    fewer = tether.items[3]
    assert fewer.may_go
    assert fewer.step_limit > 3.0
    assert fewer.cost == pytest.approx(fewer.time_per_step / fewer.step_limit)
    assert 0.1 < fewer.time_per_step < 2.0
    assert math.isnan(tether.items[2].cost)


def test_the_smallest_model_is_a_scene_within_the_tolerance(tether: Ablation, tmp_path: Path) -> None:
    tether.save(tmp_path)
    scene = Scene.from_toml(tmp_path / "smallest-model" / "scene.toml")
    assert scene.name == "spinning-tether-smallest"
    assert len(scene.assemble().positions) == 3
    assert scene.run.until == scenes.load("spinning-tether").run.until
    smallest = tether.items[-1]
    assert smallest.change is not None
    assert smallest.change.within(tether.allowed)
    sim = Simulation(scene)
    sim.run(until=0.01)
    with (tmp_path / "ablation.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["left_out"] for row in rows] == [item.name for item in tether.items]
    data = json.loads((tmp_path / "ablation.json").read_text())
    assert data["left_out"] == list(tether.left_out)
    assert data["items"][2]["change"] is None
    table = (tmp_path / "ablation.md").read_text()
    assert table == tether.table()
    assert all(line.count("|") == 9 for line in table.splitlines())


def test_what_does_nothing_may_go() -> None:
    scene = hanging_strip()
    vacuum = replace(scene, laws=[*scene.laws, AirDrag(pressure=0.0)])
    found = ablate(vacuum, 0.02, members=0)
    items = {item.name: item for item in found.items}
    assert items["law air_drag"].verdict == "may go"
    assert items["law air_drag"].change == Change(0.0, 0.0, 0.0)
    assert items["law gravity"].verdict.startswith("needed")
    assert items["part fixed"].verdict == (
        "cannot be left out: it alone holds the scene; without it nothing is held fast"
    )
    assert found.smallest is not None
    assert found.smallest.law("air_drag") is None
    assert found.smallest.law("gravity") is not None


def test_a_scene_may_be_the_smallest_model_of_itself(tmp_path: Path) -> None:
    found = ablate(scenes.load("single-crease"), 0.01, tolerance=1e-9, members=0)
    assert found.smallest is None
    assert found.left_out == ()
    assert "Nothing may go" in found.summary()
    found.save(tmp_path)
    assert not (tmp_path / "smallest-model").exists()


def test_what_is_hidden_by_chaos_may_go_and_is_told_so() -> None:
    allowed = Change(0.1, 1.0, 1e-3)
    assert Change(0.05, -1.0, -1e-3).within(allowed)
    assert not Change(0.11, 0.0, 0.0).within(allowed)
    assert Change(math.nan, math.nan, 5e-4).within(allowed)
    assert Change(0.2, 0.5, 5e-4).largest_share(allowed) == pytest.approx(2.0)
    assert Change(0.0, 0.0, 0.0).largest_share(Change(0.0, 0.0, 0.0)) == 0.0


def test_tethers_that_hold_a_sail_stay_with_fewer_segments() -> None:
    found = {variant.name: variant for variant in variants(scenes.load("okuizumi-model-1"))}
    assert found["part tethers"].scene is None
    assert "holds the scene" in found["part tethers"].reason
    fewer = found["all but 4 of 19 segments in part tethers"].scene
    assert fewer is not None
    assert fewer.counts()["springs"] == 5432 - 4 * 15


def test_several_things_are_left_out_at_once() -> None:
    scene = replace(hanging_strip(), laws=[*hanging_strip().laws, Spin(1.0)])
    found = {variant.name: variant for variant in variants(scene)}
    left = without(scene, [found["law spin"], found["law spring_damping"]])
    assert [law.kind for law in left.laws] == ["springs", "gravity"]
    assert len(left.parts) == len(scene.parts)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"tolerance": 0.0}, "tolerance = 0.0: must be greater than 0"),
        ({"tolerance": math.inf}, "tolerance = inf"),
        ({"members": -1}, "ensemble = -1"),
        ({"until": -1.0}, "until = -1.0"),
    ],
)
def test_wrong_numbers_are_refused(given: dict[str, Any], words: str) -> None:
    refused(lambda: ablate(hanging_strip(), **given), InputError, words)
