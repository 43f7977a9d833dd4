"""The softened film: what it scales, and what it leaves."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from membrane_rs import Material, Scene, Simulation, scenes
from membrane_rs.errors import InputError
from membrane_rs.scene.laws import SpringDamping, Springs
from membrane_rs.scene.parts import PARTS

FACTOR = 10.0


def softened(name: str, factor: float = FACTOR) -> Scene:
    """A built-in scene with softening."""
    return scenes.load(name).with_values({"material.softening": factor})


def modulus(scene: Scene) -> float:
    """Young's modulus of a scene [Pa]."""
    assert scene.material is not None
    return scene.material.youngs_modulus


def dashpots(scene: Scene) -> SpringDamping:
    """The law of a scene."""
    law = scene.law(SpringDamping)
    assert law is not None
    return law


def moved(scene: Scene, shift: float, law: str) -> np.ndarray:
    """Forces of a law, with all nodes displaced from the flat shape by a fixed pattern of size `shift` [m]."""
    sim = Simulation(scene)
    pattern = np.sin(np.arange(3 * sim.node_count)).reshape(-1, 3)
    sim.positions = sim.assembly.reference + shift * pattern
    return sim.forces(law)


def test_a_stretched_film_has_the_forces_of_a_film_of_less_modulus() -> None:
    scene = scenes.load("spinning-disc")
    scene = replace(scene, laws=[Springs(buckling=0.0, buckling_on_creases=0.0)])
    soft = scene.with_values({"material.softening": FACTOR})
    np.testing.assert_allclose(moved(soft, 1e-6, "springs"), moved(scene, 1e-6, "springs") / FACTOR, rtol=1e-12, atol=0)


@pytest.mark.parametrize("name", ["okuizumi-model-1", "okuizumi-model-2"])
def test_springs_beyond_buckling_have_the_force_of_the_film(name: str) -> None:
    forces = []
    for scene in (scenes.load(name), softened(name)):
        sim = Simulation(scene)
        sim.positions = 0.5 * sim.assembly.reference  # every edge is far shorter than its critical length
        forces.append(sim.forces("springs"))
    np.testing.assert_allclose(forces[1], forces[0], rtol=1e-9, atol=1e-9 * np.abs(forces[0]).max())


def test_creases_have_their_moments() -> None:
    forces = [
        moved(scene, 1e-4, "creases") for scene in (scenes.load("okuizumi-model-1"), softened("okuizumi-model-1"))
    ]
    np.testing.assert_allclose(forces[1], forces[0], rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("mass", ["mean", "reduced"])
def test_dashpots_between_equal_masses_keep_their_coefficient(mass: Literal["mean", "reduced"]) -> None:
    scene = replace(scenes.load("spinning-disc"), parts=())
    scene = replace(scene, laws=[Springs(), SpringDamping(mass=mass, length=0.01)])
    forces = []
    for one in (scene, scene.with_values({"material.softening": FACTOR})):
        sim = Simulation(one)
        sim.velocities = np.sin(np.arange(3 * sim.node_count)).reshape(-1, 3)
        forces.append(sim.forces("spring_damping"))
    np.testing.assert_allclose(forces[1], forces[0], rtol=1e-12, atol=1e-12 * np.abs(forces[0]).max())


def test_the_step_grows_and_the_nodes_stay() -> None:
    scene = scenes.load("okuizumi-model-1").with_values({"run.integrator": "leapfrog", "run.substeps": 4})
    soft = scene.with_values({"material.softening": FACTOR})
    one, other = Simulation(scene), Simulation(soft)
    gain = other.stable_dt() / one.stable_dt()
    assert 0.8 * FACTOR**0.5 < gain < FACTOR**0.5
    np.testing.assert_array_equal(other.assembly.positions, one.assembly.positions)
    np.testing.assert_array_equal(other.assembly.cords.stiffness, one.assembly.cords.stiffness)
    assert scene.mesh is not None
    film = scene.mesh.node_count
    np.testing.assert_allclose(
        other.assembly.extra_masses[film + 1 :], FACTOR * one.assembly.extra_masses[film + 1 :], rtol=1e-12
    )


def test_the_scene_keeps_its_own_values() -> None:
    soft = softened("okuizumi-model-1")
    plain = scenes.load("okuizumi-model-1")
    assert modulus(soft) == modulus(plain)
    assert soft.law("springs") == plain.law("springs")
    assert modulus(soft.as_simulated) == modulus(plain) / FACTOR
    assert soft.as_simulated.as_simulated is soft.as_simulated
    assert plain.as_simulated is plain
    assert "softening = 10.0" in soft.to_toml()
    assert "\n# softening: not set\n" in plain.to_toml()
    assert "\nsoftening" not in plain.to_toml()


def test_a_softening_of_one_is_the_film_itself_but_for_its_dashpots() -> None:
    plain, soft = scenes.load("okuizumi-model-1"), softened("okuizumi-model-1", 1.0).as_simulated
    assert soft.material == plain.material
    assert soft.parts == plain.parts
    assert [law for law in soft.laws if law.kind != "spring_damping"] == [
        law for law in plain.laws if law.kind != "spring_damping"
    ]
    assert dashpots(soft).mass == "reduced"


def test_a_stage_may_be_softened_alone() -> None:
    scene = scenes.load("okuizumi-stage-1")
    plain = modulus(scene.staged(0))
    stage = replace(scene.stages[0], set={**scene.stages[0].set, "material.softening": 4.0})
    scene = replace(scene, stages=(stage, *scene.stages[1:]))
    assert modulus(scene.staged(0).as_simulated) == plain / 4.0
    assert scene.staged(1).as_simulated is scene.staged(1)


@pytest.mark.parametrize("kind", PARTS)
def test_no_part_changes_its_nodes(kind: str) -> None:
    for name in scenes.names():
        scene = scenes.load(name)
        if scene.material is not None and any(part.kind == kind for part in scene.parts):
            soft = scene.with_values({"material.softening": 3.0})
            assert soft.assemble().node_count == scene.assemble().node_count


@pytest.mark.parametrize("name", ["okuizumi-model-1", "okuizumi-model-2"])
def test_fast_scenes_are_their_full_models_but_for_softening_and_steps(name: str) -> None:
    full, fast = scenes.load(name), scenes.load(f"{name}-fast")
    assert fast.material is not None
    film = replace(fast.material, softening=None)
    assert replace(fast, name=full.name, run=full.run, material=film).to_toml() == full.to_toml()


@pytest.mark.parametrize("value", [0.5, 0.0, -1.0, 1.1e6, 1e300, float("nan"), float("inf")])
def test_a_softening_outside_its_range_is_refused(value: float) -> None:
    with pytest.raises(InputError, match="softening"):
        Material(3.2e9, 0.34, 1420.0, 7.5e-6, softening=value)
