"""Methods whose step has no limit: where they earn their place, what they count, what they refuse."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from membrane_rs import InputError, RunSettings, Simulation, integrators, scenes

IMPLICIT = [name for name, facts in integrators().items() if not math.isfinite(facts.imaginary_limit)]
UNTIL = 0.3


@pytest.mark.parametrize("name", IMPLICIT)
def test_a_crease_that_settles_takes_a_hundredth_of_the_evaluations_of_rk4(name: str) -> None:
    # Opens against strong friction: nothing of what limits rk4's step is left in the motion.
    scene = scenes.load("single-crease")
    exact = Simulation(scene)
    exact.step(round(UNTIL / exact.dt))
    assert exact.time == pytest.approx(UNTIL, rel=1e-9)
    # What the long steps do not resolve at the start is misjudged, and then removed.
    sim = Simulation(replace(scene, run=replace(scene.run, energy_loss=0.5)), name, 1e-3)
    assert sim.dt > 100 * exact.stable_dt()
    sim.run()
    assert np.abs(sim.positions - exact.positions).max() < 3e-6
    assert abs(sim.ledger()["error"]) < 1e-3
    assert sim.evaluation_count < 0.01 * exact.evaluation_count
    assert sim.statistics["factorisations"] < 2 * sim.step_count
    assert sim.statistics["fallbacks"] == 0


@pytest.mark.parametrize("name", IMPLICIT)
def test_a_step_that_is_too_much_is_taken_in_halves_and_counted(name: str, tmp_path: Path) -> None:
    scene = scenes.load("single-crease")
    scene = replace(scene, run=replace(scene.run, integrator=name, dt=3e-3, energy_loss=10.0, snapshots=()))
    sim = Simulation(scene)
    sim.run(out=tmp_path / "run", frames=2, samples=11, pictures=False)
    assert sim.statistics["fallbacks"] > 0
    assert sim.step_count == 100
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert {key: summary[key] for key in sim.statistics} == sim.statistics
    exact = Simulation(scenes.load("single-crease"))
    exact.step(round(UNTIL / exact.dt))
    assert np.abs(sim.positions - exact.positions).max() < 1e-5


@pytest.mark.parametrize("name", IMPLICIT)
def test_counts_survive_saving(name: str, tmp_path: Path) -> None:
    sim = Simulation(scenes.load("single-crease"), name, 1e-3)
    sim.step(40)
    sim.save(tmp_path / "state.npz")
    again = Simulation.restore(tmp_path / "state.npz")
    assert again.statistics == sim.statistics
    for each in (sim, again):
        each.step(40)
    assert again.statistics == sim.statistics
    assert (again.positions == sim.positions).all()


@pytest.mark.parametrize("name", IMPLICIT)
def test_the_step_where_none_is_given(name: str) -> None:
    # 50 times 2/omega, and a whole number of them in a power of ten of a second.
    scene = scenes.load("single-crease")
    explicit = Simulation(scene, "leapfrog", 1e-9)
    undamped = Simulation(scene, "rk4", 1e-9).stable_dt() * 2.0 / math.sqrt(8.0)
    sim = Simulation(scene, name)
    assert 20 * explicit.stable_dt() < sim.dt <= 51 * undamped
    assert 0.1 / sim.dt == pytest.approx(round(0.1 / sim.dt), rel=1e-9)
    coarse = Simulation(replace(scene, run=replace(scene.run, samples=3001)), name)
    assert coarse.dt == sim.dt


def test_explicit_methods_spend_nothing_on_it() -> None:
    sim = Simulation(scenes.load("single-crease"), "rk4")
    sim.step(3)
    assert set(sim.statistics.values()) == {0}


@pytest.mark.parametrize("radius", [-0.1, 1.1, math.nan])
def test_a_spectral_radius_lies_between_0_and_1(radius: float) -> None:
    with pytest.raises(InputError, match="spectral_radius"):
        RunSettings(spectral_radius=radius)


@pytest.mark.parametrize("name", IMPLICIT)
def test_the_spectral_radius_sets_what_is_left_of_unresolved_vibrations(name: str) -> None:
    scene = scenes.load("spinning-tether")
    left = []
    for radius in (0.0, 0.8, 1.0):
        run = replace(scene.run, spectral_radius=radius, energy_loss=10.0, snapshots=())
        sim = Simulation(replace(scene, run=run), name, 1e-3)
        ends = sim.spring_pairs
        along = sim.positions[ends[:, 1]] - sim.positions[ends[:, 0]]
        kick = np.zeros_like(sim.positions)
        # The cord's shortest wave along itself, which no such step can resolve.
        kick[ends[:, 1]] = (
            1e-3 * along / np.linalg.norm(along, axis=1)[:, None] * (-1.0) ** np.arange(len(ends))[:, None]
        )
        other = Simulation(replace(scene, run=run), name, 1e-3)
        other.velocities = kick
        for each in (sim, other):
            each.step(20)
        left.append(float(np.linalg.norm(other.velocities - sim.velocities)))
    assert left[0] < left[1] < left[2]
