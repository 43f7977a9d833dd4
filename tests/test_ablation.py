"""Ablation: dispensable and needed elements, what cannot be left out, and the smallest model as a scene."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from membrane_rs import AirDrag, Fixed, InputError, Scene, Simulation, Spin, SpringDamping, Springs, scenes
from membrane_rs.check import softening_advice
from membrane_rs.check.softening import LEAST_FACTOR, step_of_softened_film
from membrane_rs.folding import Disc, Strip
from membrane_rs.results.measures import peak_stress
from membrane_rs.study import Ablation, ablate
from membrane_rs.study.ablation import INSTANTS
from membrane_rs.study.ablation_result import Change, Item
from membrane_rs.study.variants import variants, without
from small_scenes import RUBBER, hanging_strip, refused


@pytest.fixture(scope="module")
def tether() -> Ablation:
    """A cord that needs its spin, and fewer segments than it has."""
    return ablate(scenes.load("spinning-tether"), 0.1, members=2)


def test_every_law_and_part_has_a_row(tether: Ablation) -> None:
    names = [item.name for item in tether.items]
    assert names == [
        "law spin",
        "law spring_damping",
        "mean mass in law spring_damping",
        "part tether",
        "all but 2 of 10 segments in part tether",
        "smallest model",
    ]
    verdicts = {item.name: item.verdict for item in tether.items}
    assert verdicts["law spin"] == "needed"
    assert verdicts["part tether"].startswith("cannot be left out: mesh: is missing")
    assert verdicts["smallest model"] == "within tolerance"


def test_costs_are_shares_of_the_whole(tether: Ablation) -> None:
    fewer = tether.items[4]
    assert fewer.may_go
    assert fewer.step_limit > 3.0
    assert fewer.cost == pytest.approx(fewer.time_per_step / fewer.step_limit)
    assert 0.1 < fewer.time_per_step < 2.0
    assert math.isnan(tether.items[3].cost)


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
    assert data["items"][3]["change"] is None
    table = (tmp_path / "ablation.md").read_text()
    assert table == tether.table()
    assert all(line.count("|") == 10 for line in table.splitlines())


@pytest.fixture(scope="module")
def strip() -> Ablation:
    """A strip that falls, whole and on two other meshes."""
    return ablate(hanging_strip(4, 2), 0.02, members=1, integrator="leapfrog", dense_until=0.011)


def test_the_mesh_is_made_coarser_and_finer(strip: Ablation) -> None:
    items = {item.name: item for item in strip.items}
    coarse, fine = items["every other line of the mesh"], items["nothing; mesh twice as dense (first 0.011 s)"]
    assert coarse.change is not None
    assert fine.change is not None
    assert coarse.step_limit > 1.3
    assert fine.step_limit < 0.7
    assert fine.cost > 1.5
    assert not fine.may_go
    assert "tolerance" in fine.verdict
    assert all(change.rate > 0.0 and change.stress != 0.0 for change in (coarse.change, fine.change))
    interval, default = 0.02 / INSTANTS, Simulation(hanging_strip(4, 2), "leapfrog").dt
    assert strip.dt == interval / round(interval / default)  # the nearest that meets all instants


def test_steps_are_shares_of_the_limit() -> None:
    scene = hanging_strip()
    found = ablate(scene, 0.01, members=0, share=0.1)
    assert found.dt == pytest.approx(0.1 * Simulation(scene).stable_dt(), rel=0.5)
    assert found.dt < 0.5 * Simulation(scene).dt


def test_a_coarser_mesh_may_be_part_of_the_smallest_model() -> None:
    found = ablate(hanging_strip(4, 2), 0.01, tolerance=0.6, members=0)
    assert "every other line of the mesh" in found.left_out
    assert found.smallest is not None
    assert found.smallest.mesh is not None
    source = found.smallest.mesh.source
    assert isinstance(source, Strip)
    assert (source.columns, source.rows) == (2, 1)


def test_a_mesh_that_cannot_be_coarser_says_why() -> None:
    found = {variant.name: variant for variant in variants(scenes.load("single-crease"))}
    assert "falls inside one of 1 columns" in found["every other line of the mesh"].reason


def spun_disc(**material: Any) -> Scene:
    """A stiff disc that spins slowly, which the rule lets be softened."""
    mesh = Disc(0.1, rings=2).mesh()
    film = replace(RUBBER, youngs_modulus=1e8, **material)
    return Scene(mesh, film, [Springs(buckling=0.0), SpringDamping(), Spin(2.0)], [Fixed((0,))], name="disc")


def test_a_softened_film_runs_by_its_own_step() -> None:
    scene = spun_disc()
    factor = softening_advice(scene).factor
    assert factor > 1.5
    found = ablate(scene, 0.2, tolerance=0.9, members=0, integrator="leapfrog", share=0.5, dense_until=0.01)
    items = {item.name: item for item in found.items}
    soft = items[f"all but 1/{factor:g} of the in-plane stiffness"]
    assert soft.step_limit > 1.2
    assert soft.step == pytest.approx(soft.step_limit, rel=0.2)  # both divide the interval between two samples
    assert soft.change is not None
    assert math.isnan(soft.change.strain)
    assert math.isnan(soft.change.stress)
    assert soft.change.rate < 1e-3  # the strain of the flat disc
    assert f"by steps {soft.step:.2g} times as long" in found.table()
    assert items["law spin"].step <= 1.0


def test_a_softened_film_is_joined_with_what_else_is_left_out() -> None:
    scene = scenes.load("okuizumi-model-1")
    found = {variant.name: variant for variant in variants(scene)}
    chosen = [found["all but 1/5 of the in-plane stiffness"], found["law air_drag"]]
    left = without(scene, chosen)
    assert left.material == replace(scene.material, softening=5.0)  # type: ignore[type-var]
    assert [law.kind for law in left.laws] == [law.kind for law in scene.laws if law.kind != "air_drag"]
    assert "softening = 5.0" in left.to_toml()


def test_neither_a_softened_film_nor_reduced_masses_are_simplified_again() -> None:
    names = [variant.name for variant in variants(spun_disc())]
    assert "mean mass in law spring_damping" in names
    reduced = replace(spun_disc(softening=3.0), laws=[Springs(), SpringDamping(mass="reduced"), Spin(2.0)])
    assert not [v.name for v in variants(reduced) if "stiffness" in v.name or "mean mass" in v.name]


def test_a_film_is_softened_for_an_explicit_method_alone() -> None:
    scene = spun_disc()
    assert softened_variants(scene, "leapfrog") == softened_variants(scene) != []
    assert not softened_variants(scene, "generalized_alpha")
    assert not softened_variants(scene.with_values({"run.integrator": "generalized_alpha"}))


def test_the_least_softening_that_check_names_is_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    advice = replace(softening_advice(spun_disc()), factor=LEAST_FACTOR)
    monkeypatch.setattr("membrane_rs.study.variants.softening_advice", lambda _: advice)
    monkeypatch.setattr("membrane_rs.check.softening.softening_advice", lambda _: advice)
    assert softened_variants(spun_disc())
    # The disc's step is set by other laws too: what counts is that the factor is not dropped.
    monkeypatch.setattr("membrane_rs.check.softening.LEAST_GAIN", 0.0)
    assert list(step_of_softened_film(spun_disc()))


def softened_variants(scene: Scene, integrator: str | None = None) -> list[str]:
    """Names of the variants with a softer film."""
    return [variant.name for variant in variants(scene, integrator) if "in-plane stiffness" in variant.name]


@pytest.mark.parametrize(("step", "is_named"), [(1.0, False), (1.001, False), (1.05, False), (1.2, True)])
def test_a_step_that_is_hardly_longer_is_not_named(step: float, is_named: bool) -> None:
    row = Item("law air_drag", 0.8, 1.0, 0.8, Change(0.0, 0.0, 0.0), "can be omitted", step)
    none = Change(0.0, 0.0, 0.0)
    table = Ablation("sail", 0.1, 0.01, 0, 1e-5, 1e-3, math.nan, none, none, (row,), (), None).table()
    assert ("times as long" in table) == is_named


def test_a_law_that_is_left_out_is_not_replaced_as_well() -> None:
    scene = spun_disc()
    found = {variant.name: variant for variant in variants(scene)}
    left = without(scene, [found["mean mass in law spring_damping"]])
    assert left.law(SpringDamping) == SpringDamping(mass="reduced")
    assert without(scene, [found["law spring_damping"]]).law(SpringDamping) is None


def test_starts_are_perturbed_by_the_shift() -> None:
    scene = scenes.load("spinning-tether")
    small, large = (ablate(scene, 0.01, members=1, shift=shift).spread.rate for shift in (1e-9, 1e-5))
    assert 1e2 * small < large
    assert "(by 1e-05 m)" in ablate(scene, 0.001, members=1, shift=1e-5).heading()


def test_peak_stress_is_that_of_the_film() -> None:
    scene = scenes.load("spinning-disc")
    assert scene.material is not None
    assert scene.mesh is not None
    sim = Simulation(scene)
    nu, stretch = scene.material.poisson_ratio, 1.001
    modulus, strain = scene.material.youngs_modulus, (stretch**2 - 1.0) / 2.0
    sim.positions = scene.mesh.reference * [stretch, 1.0, 1.0]
    assert peak_stress(sim) == pytest.approx(modulus * strain / (1.0 - nu**2))
    sim.positions = scene.mesh.reference * [stretch, 0.9, 1.0]  # pressed across: wrinkles, E e1 along them
    assert peak_stress(sim) == pytest.approx(modulus * strain)
    sim.positions = scene.mesh.reference * 0.9
    assert peak_stress(sim) == 0.0
    assert math.isnan(peak_stress(Simulation(scenes.load("spinning-tether"))))


def test_peak_stress_of_a_softened_film_is_of_its_lower_modulus() -> None:
    scene = scenes.load("spinning-disc")
    assert scene.mesh is not None
    found = []
    for values in ({}, {"material.softening": 10.0}):
        sim = Simulation(scene.with_values(values))
        sim.positions = scene.mesh.reference * [1.001, 1.0, 1.0]
        found.append(peak_stress(sim))
    assert found[1] == pytest.approx(found[0] / 10.0)


def test_peak_stress_has_a_column(strip: Ablation, tether: Ablation) -> None:
    assert strip.peak_stress > 0.0
    assert "peak stress" in strip.heading()
    assert math.isnan(tether.peak_stress)
    assert "peak stress" not in tether.heading()


def test_what_does_nothing_can_be_omitted() -> None:
    scene = hanging_strip()
    vacuum = replace(scene, laws=[*scene.laws, AirDrag(pressure=0.0)])
    found = ablate(vacuum, 0.02, members=0)
    items = {item.name: item for item in found.items}
    assert items["law air_drag"].verdict == "can be omitted"
    assert items["law air_drag"].change == Change(0.0, 0.0, 0.0, 0.0)
    assert items["law gravity"].verdict.startswith("needed")
    fixes = "cannot be left out: it alone fixes the scene in space; without it no node is fixed"
    assert items["part fixed"].verdict == fixes
    assert found.smallest is not None
    assert found.smallest.law("air_drag") is None
    assert found.smallest.law("gravity") is not None


def test_a_scene_may_be_the_smallest_model_of_itself(tmp_path: Path) -> None:
    found = ablate(scenes.load("single-crease"), 0.01, tolerance=1e-9, members=0)
    assert found.smallest is None
    assert found.left_out == ()
    assert "Nothing can be omitted." in found.summary()
    found.save(tmp_path)
    assert not (tmp_path / "smallest-model").exists()


def test_a_change_within_the_spread_can_be_omitted_and_is_reported() -> None:
    allowed = Change(0.1, 1.0, 1e-3)
    assert Change(0.05, -1.0, -1e-3).within(allowed)
    assert not Change(0.11, 0.0, 0.0).within(allowed)
    assert Change(math.nan, math.nan, 5e-4).within(allowed)
    assert Change(0.2, 0.5, 5e-4).largest_share(allowed) == pytest.approx(2.0)
    assert Change(0.0, 0.0, 0.0).largest_share(Change(0.0, 0.0, 0.0)) == 0.0


def test_starts_that_all_stop_leave_the_spread_unknown(tmp_path: Path) -> None:
    found = ablate(hanging_strip(4, 2), 0.005, members=2, shift=0.01, dense_until=1e-4)
    assert found.members == 0
    assert all(map(math.isnan, vars(found.spread).values()))
    assert "2 of 2 starts perturbed by 0.01 m did not reach the end, the first: stopped at t = " in found.stopped_starts
    assert found.stopped_starts.endswith("the spread is unknown, take a smaller shift")
    assert f"\nWarning: {found.stopped_starts}\n" in found.summary()
    assert "| *spread of perturbed starts* |  |  |  | - | - | - | - |  |" in found.table()
    assert not any("within the spread" in item.verdict for item in found.items)
    found.save(tmp_path)
    data = json.loads((tmp_path / "ablation.json").read_text())
    assert data["stopped_starts"] == found.stopped_starts
    assert set(data["spread"].values()) == {None}
    none = ablate(hanging_strip(4, 2), 0.005, members=0, shift=1.0, dense_until=1e-4)
    assert none.stopped_starts == ""
    assert none.allowed == found.allowed


def test_tethers_that_hold_a_sail_stay_with_fewer_segments() -> None:
    found = {variant.name: variant for variant in variants(scenes.load("okuizumi-model-1"))}
    assert found["part tethers"].scene is None
    assert "fixes the scene" in found["part tethers"].reason
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
        ({"members": -1}, "members = -1.*--ensemble"),
        ({"shift": 0.0}, "shift = 0.0: must be above 0"),
        ({"shift": 1.0}, "shift = 1: must be below [0-9.]+, the shortest edge or cord of the scene"),
        ({"until": -1.0}, "until = -1.0"),
        ({"dense_until": 0.0}, "dense_until = 0.0: must be greater than 0"),
        ({"integrator": "leapfrogs"}, "there is no 'leapfrogs'; did you mean 'leapfrog'"),
        ({"share": 1.0}, "share = 1.0: must be greater than 0 and less than 1"),
        ({"jobs": -2}, "jobs = -2: must be from 1 to"),
    ],
)
def test_wrong_numbers_are_refused(given: dict[str, Any], words: str) -> None:
    refused(lambda: ablate(hanging_strip(), **given), InputError, words)
