"""The built-in scenes of the whole deployment, and reeling out in the plane against its quasi-static solution."""

from __future__ import annotations

import math

import deployment_plane as plane
import numpy as np
import pytest
from membrane_rs import Schedule, Simulation, scenes
from membrane_rs.folding import SquareSail
from membrane_rs.scene.bodies import Cylinder

WHOLE = ("okuizumi-whole", "okuizumi-whole-model-2")
FIRST = ("okuizumi-stage-1", "okuizumi-stage-1-model-2")


@pytest.mark.parametrize("name", [*WHOLE, *FIRST])
def test_bars_stand_beside_the_roll_and_end_on_the_diagonals(name: str) -> None:
    """1 mm of clearance and 22 mm of free arm at the start; at the end each touches an arm on its diagonal."""
    scene = scenes.load(name)
    assert scene.mesh is not None
    sail = scene.mesh.source
    assert isinstance(sail, SquareSail)
    bars = next(body for body in scene.bodies if body.name == "bars")
    assert isinstance(bars, Cylinder)
    outer, turns = sail.wound_outer_radius, sail.turns
    assert outer is not None
    assert turns is not None
    reach, diagonal = outer + bars.radius + 1e-3, math.pi / 4
    assert math.hypot(*bars.centre[:2]) == pytest.approx(reach, abs=1e-8)
    azimuth = math.atan2(bars.centre[1], bars.centre[0])
    start = diagonal + 2.0 * math.pi * turns - 0.022 / outer
    assert math.remainder(azimuth - start, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-6)
    turn = scene.stages[1].set["bodies.bars.turn"]
    assert isinstance(turn, Schedule)
    assert start + turn.last == pytest.approx(diagonal - math.asin(bars.radius / reach), abs=1e-6)
    assert turn.times[-1] == scene.stages[1].duration


@pytest.mark.parametrize("pair", list(zip(WHOLE, FIRST, strict=True)))
def test_the_first_stage_is_that_of_the_whole_deployment(pair: tuple[str, str]) -> None:
    """All but the release, its snapshots, its samples and the name are the same."""
    whole, first = map(scenes.load, pair)
    assert whole.stages[:-1] == first.stages
    assert (whole.laws, whole.parts, whole.bodies) == (first.laws, first.parts, first.bodies)
    assert np.array_equal(whole.mesh.positions, first.mesh.positions)  # type: ignore[union-attr]


@pytest.mark.parametrize("name", WHOLE)
def test_the_roll_starts_without_a_crossing_and_settles_with_its_energy_balanced(name: str) -> None:
    """In the first 2 ms, which free the strain of winding."""
    sim = Simulation(scenes.load(name))
    assert sim.crossings().count == 0
    sim.reach(2e-3)
    assert sim.stage_name == "settle in the roll"
    assert -0.02 < sim.ledger()["error"] < 1e-3


def test_the_sail_is_released_without_hold_and_bars() -> None:
    """And reeled out with both, ten times softer."""
    scene = scenes.load(WHOLE[0])
    reeled, released = scene.staged(1), scene.staged(3)
    assert [body.name for body in reeled.bodies] == ["spool", "bars"]
    assert [body.name for body in released.bodies] == ["spool"]
    assert any(part.name == "hold" for part in reeled.parts)
    assert not any(part.name == "hold" for part in released.parts)
    assert reeled.material is not None
    assert scene.material is not None
    assert reeled.material.youngs_modulus == pytest.approx(0.1 * scene.material.youngs_modulus)
    assert released.material == scene.material
    assert released.law("mass_damping") is None
    assert released.law("air_drag") is not None


def test_an_arm_reels_out_in_order_with_the_tension_of_its_own_rate() -> None:
    """T = (Omega + b)^2 m R, and the lag by which Coriolis's force bends it back, at |b|/Omega = 0.1."""
    run = plane.reel_out_arm(4.0, samples=400)
    assert float(run["tension"]) == pytest.approx(float(run["predicted_tension"]), rel=0.02)
    assert float(run["lead"]) == pytest.approx(float(run["predicted_lead"]), abs=1.5)
    assert float(run["kinetic"]) < 0.03
    assert float(run["largest_lead"]) < plane.LOST
    assert float(run["reach"]) == pytest.approx(0.2334, abs=2e-3)


def test_a_bar_that_turns_too_fast_loses_the_arm() -> None:
    """At |b|/Omega = 0.42 the tip swings round."""
    run = plane.reel_out_arm(1.0, samples=400)
    assert float(run["largest_lead"]) > plane.LOST
