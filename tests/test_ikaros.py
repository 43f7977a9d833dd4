"""The built-in scenes of IKAROS: their places, and the balances of momentum and energy in parts of their stages."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from membrane_rs import Scene, Schedule, Simulation, Spin, scenes
from membrane_rs.check.stowed_energy import stowed_energy
from membrane_rs.folding import SquareSail
from membrane_rs.scene.bodies import Cylinder

CLEARANCE = 0.03
"""Of the bars from the roll [m]."""
FREE = 0.7
"""Of each arm beyond its bar at the start [m]."""


@pytest.fixture(scope="module")
def whole() -> Scene:
    return scenes.load("ikaros-whole")


def bars_of(scene: Scene) -> Cylinder:
    found = next(body for body in scene.bodies if body.name == "bars")
    assert isinstance(found, Cylinder)
    return found


def momentum(sim: Simulation) -> float:
    found = sim.angular_momentum()
    return found.hub + found.sail


def test_bars_stand_beside_the_roll_and_end_on_the_diagonals(whole: Scene) -> None:
    assert whole.mesh is not None
    sail, bars = whole.mesh.source, bars_of(whole)
    assert isinstance(sail, SquareSail)
    outer, turns = sail.wound_outer_radius, sail.turns
    assert outer is not None
    assert turns is not None
    reach, diagonal = outer + bars.radius + CLEARANCE, math.pi / 4
    assert math.hypot(*bars.centre[:2]) == pytest.approx(reach, abs=1e-8)
    start = diagonal + 2.0 * math.pi * turns - FREE / outer
    azimuth = math.atan2(bars.centre[1], bars.centre[0])
    assert math.remainder(azimuth - start, math.pi / 2) == pytest.approx(0.0, abs=1e-6)
    turn = whole.stages[1].set["bodies.bars.turn"]
    assert isinstance(turn, Schedule)
    assert start + turn.last == pytest.approx(diagonal - math.asin(bars.radius / reach), abs=1e-6)
    assert turn.times[-1] == whole.stages[1].duration


@pytest.mark.parametrize("name", ["ikaros", "ikaros-whole"])
def test_film_and_tips_weigh_what_is_reported(name: str) -> None:
    scene = scenes.load(name)
    assert scene.mesh is not None
    assert scene.material is not None
    assert scene.mesh.masses(scene.material).sum() == pytest.approx(15.0, abs=0.03)
    assert np.ptp(scene.mesh.reference[:, 0]) == pytest.approx(14.0)


def test_both_scenes_have_the_same_sail(whole: Scene) -> None:
    """Of the same film, parts and hub; one starts as the cross into which the other is reeled out."""
    second = scenes.load("ikaros")
    assert whole.mesh is not None
    assert second.mesh is not None
    assert np.array_equal(whole.mesh.reference, second.mesh.reference)
    assert whole.material == second.material
    assert whole.parts[:2] == second.parts
    assert whole.stages[-1].without == ("mass_damping", "hold", "bars")
    kinds = {law.kind: law for law in second.laws}
    for law in whole.laws:
        if isinstance(law, Spin):
            assert law.inertia == scenes.load("ikaros").value("laws.spin.inertia")
        elif law.kind != "mass_damping":
            assert law == kinds[law.kind]


def test_momentum_and_energy_are_balanced_while_bars_turn_against_the_hub(whole: Scene) -> None:
    """In a settling of 2 s, with mass damping, and bars that then turn some ten times as fast as in the scene."""
    settle, reel = whole.stages[:2]
    turn = Schedule((0.0, 0.4), (0.0, -0.3), 0.2)
    short = replace(
        whole,
        stages=(
            replace(settle, duration=2.0, frames=2),
            replace(reel, duration=0.4, frames=2, set={"bodies.bars.turn": turn}),
        ),
        run=replace(whole.run, snapshots=(), samples=11),
    )
    sim = Simulation(short)
    start, rate = momentum(sim), sim.hub_rate
    for instant in (1.0, 2.0, 2.2, 2.4):
        sim.reach(instant)
        assert momentum(sim) == pytest.approx(start, rel=1e-11)
    assert abs(sim.hub_rate / rate - 1.0) > 1e-3
    ledger = sim.ledger()
    assert abs(ledger["error"]) < 0.01
    assert ledger["work_by_law"]["bars"] != 0.0


def test_a_free_hub_sets_free_what_momentum_leaves(whole: Scene) -> None:
    """L^2/2 (1/(I + J_start) - 1/(I + J_flat)), in place of what a hub of constant rate would."""
    assembly = whole.assemble()
    spin = whole.law("spin")
    assert isinstance(spin, Spin)
    assert spin.inertia is not None
    assert spin.frequency is not None
    wound, flat = (
        spin.inertia + float(Simulation(whole).masses @ (shape[:, :2] ** 2).sum(axis=1))
        for shape in (assembly.positions, assembly.reference)
    )
    squared = (math.tau * spin.frequency * wound) ** 2
    (found,) = stowed_energy(whole)
    freed = float(found.message.partition("flat shape ")[2].split()[0])
    assert freed == pytest.approx(0.5 * squared * (1.0 / wound - 1.0 / flat), rel=1e-3)
    driven = replace(whole, laws=[Spin(spin.frequency) if law is spin else law for law in whole.laws])
    (found,) = stowed_energy(driven)
    assert float(found.message.partition("flat shape ")[2].split()[0]) > 5.0 * freed
