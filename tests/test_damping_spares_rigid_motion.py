"""Dashpots take nothing from a body that flies or spins as a whole, over many steps."""

from __future__ import annotations

import numpy as np
import pytest
from membrane_rs import Scene, Simulation, SpringDamping
from membrane_rs.folding import Disc
from membrane_rs.scene.run_settings import RunSettings
from small_scenes import RUBBER, UNBUCKLED

STEPS = 20_000
RUN = RunSettings(until=100.0, snapshots=())


def disc(ratio: float) -> Simulation:
    return Simulation(Scene(Disc(0.05, rings=3).mesh(), RUBBER, [UNBUCKLED, SpringDamping(ratio)], run=RUN))


def angular_momentum(sim: Simulation) -> float:
    x, v = sim.positions, sim.velocities
    return float(np.sum(sim.masses * (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0])))


@pytest.mark.parametrize("ratio", [0.02, 0.5, 3.0])
def test_free_flight_loses_nothing(ratio: float) -> None:
    sim = disc(ratio)
    sim.velocities = np.tile([3.0, -2.0, 1.0], (sim.node_count, 1))
    before = sim.energies()["kinetic"]
    sim.step(STEPS)
    assert sim.energies()["kinetic"] == pytest.approx(before, rel=1e-12)
    assert abs(sim.ledger()["work_by_law"].get("spring_damping", 0.0)) < 1e-13 * before


@pytest.mark.parametrize("ratio", [0.02, 0.5])
def test_rigid_spin_loses_nothing_once_the_disc_has_widened(ratio: float) -> None:
    sim = disc(ratio)
    spin = 2 * np.pi * 2.0
    x = sim.positions
    sim.velocities = spin * np.column_stack([-x[:, 1], x[:, 0], 0 * x[:, 0]])
    momentum = angular_momentum(sim)
    # It widens by a few parts in ten thousand and rings; the dashpots take that.
    sim.step(STEPS)
    sim.velocities = sim.velocities
    before = sim.energies()["kinetic"]
    sim.step(STEPS)
    turns = spin * STEPS * sim.dt / (2 * np.pi)
    assert turns > 1.0
    assert sim.energies()["kinetic"] == pytest.approx(before, rel=1e-9)
    # The stages of a step lie on tangents to the circle, so the books show a stretch that the body never had.
    assert abs(sim.ledger()["work_by_law"]["spring_damping"]) < 1e-5 * before
    assert angular_momentum(sim) == pytest.approx(momentum, rel=1e-9)


def test_but_it_takes_what_deforms() -> None:
    sim = disc(0.5)
    sim.velocities = 1e-3 * np.random.default_rng(1).normal(size=(sim.node_count, 3)) * [1, 1, 0]
    sim.step(2000)
    assert sim.ledger()["work_by_law"]["spring_damping"] < 0
