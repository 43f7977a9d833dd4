"""The built-in scenes of IKAROS, and the balance of momentum by which docs/ikaros.md judges them."""

from __future__ import annotations

import math

import ikaros_momentum as momentum
import ikaros_runs as runs
import numpy as np
import pytest
from membrane_rs import Schedule, Simulation, scenes

NAMES = ("ikaros", "ikaros-whole")


@pytest.mark.parametrize("name", NAMES)
def test_the_sail_weighs_what_was_reported_and_the_hub_is_a_solid_cylinder(name: str) -> None:
    scene = scenes.load(name)
    assert runs.film_masses(scene).sum() == pytest.approx(15.0, rel=2e-3)
    assert runs.hub_inertia(scene) == pytest.approx(0.5 * 290.0 * momentum.BODY**2, rel=0.01)
    assert scene.value("laws.spin.frequency") * 60.0 == pytest.approx(7.4 if name == "ikaros" else 25.0, rel=1e-4)


def test_both_scenes_are_of_one_sail() -> None:
    cross, roll = map(scenes.load, NAMES)
    assert cross.material == roll.material
    assert cross.parts == roll.parts[:2]
    assert cross.mesh is not None
    assert roll.mesh is not None
    assert np.allclose(cross.mesh.reference, roll.mesh.reference, atol=1e-12)


@pytest.mark.parametrize("change", [lambda scene: scene, runs.finer], ids=["as it is", "finer"])
def test_bars_stand_beside_the_roll_and_end_on_the_diagonals(change) -> None:  # type: ignore[no-untyped-def]
    scene = change(runs.whole())
    azimuth, turn, reach = runs.roll_of(scene)
    centre = runs.bars_of(scene).centre
    assert math.hypot(*centre[:2]) == pytest.approx(reach, abs=1e-8)
    apart = math.remainder(math.atan2(centre[1], centre[0]) - azimuth, math.pi / 2)
    assert apart == pytest.approx(0.0, abs=1e-6)
    schedule = scene.stages[runs.REEL].set["bodies.bars.turn"]
    assert isinstance(schedule, Schedule)
    assert schedule.last == pytest.approx(turn, abs=1e-6)
    assert azimuth + turn == pytest.approx(math.pi / 4 - math.asin(runs.bars_of(scene).radius / reach), abs=1e-6)
    assert schedule.times[-1] == scene.stages[runs.REEL].duration


def test_the_finer_mesh_is_wound_on_nearly_the_same_radius() -> None:
    own, fine = runs.sail_of(runs.whole()).wound_radius, runs.sail_of(runs.finer(runs.whole())).wound_radius
    assert own is not None
    assert fine == pytest.approx(own, rel=0.01)


def test_the_hub_gives_its_momentum_to_the_sail() -> None:
    """Nothing from outside acts, the friction that settles the sail among it."""
    for scene in (scenes.load("ikaros"), scenes.load("ikaros-whole")):
        sim = Simulation(scene)
        total, rate = sim.angular_momentum().total, sim.hub_rate
        sim.reach(0.3)
        assert sim.angular_momentum().total == pytest.approx(total, rel=1e-11)
        assert sim.hub_rate != rate


def test_flat_moments_are_those_of_a_square_with_a_hole_and_of_its_tips() -> None:
    film, rest = runs.flat_moments(scenes.load("ikaros"))
    assert film == pytest.approx(15.0 * (14.0**2 + 3.8**2) / 6.0, rel=0.01)
    assert rest == pytest.approx(4 * 0.5 * 98.0, rel=0.01)
