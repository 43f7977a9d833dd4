"""The built-in scenes of IKAROS: the balances of momentum and energy in parts of their stages."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from membrane_rs import Scene, Schedule, Simulation, Spin, scenes
from membrane_rs.check.stowed_energy import stowed_energy


@pytest.fixture(scope="module")
def whole() -> Scene:
    return scenes.load("ikaros-whole")


def momentum(sim: Simulation) -> float:
    found = sim.angular_momentum()
    return found.hub + found.sail


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
