"""Leapfrog with substeps: slow laws are found, rest in between, and change neither energy balance nor bits."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from membrane_rs import InputError, RunSettings, Scene, Simulation, scenes


def divided(name: str, substeps: int) -> Scene:
    """A built-in scene by leapfrog with so many substeps."""
    scene = scenes.load(name)
    return replace(scene, run=replace(scene.run, integrator="leapfrog", substeps=substeps))


def test_creases_and_drag_are_slow_beside_springs() -> None:
    sim = Simulation(divided("okuizumi-model-1", 4))
    assert {"creases", "air_drag"} <= set(sim.slow_laws)
    assert not {"springs", "spring_damping", "tethers", "spin"} & set(sim.slow_laws)
    assert Simulation(divided("okuizumi-model-1", 1)).slow_laws == []
    assert Simulation(divided("okuizumi-model-1", 4), "rk4").slow_laws == []
    whole = Simulation(divided("okuizumi-model-1", 1))
    assert sim.stable_dt() == pytest.approx(4 * whole.stable_dt(), rel=1e-4)
    assert sim.dt == pytest.approx(4 * whole.dt, rel=0.01)


def test_the_release_of_a_sail_is_that_of_leapfrog() -> None:
    whole, parted = (Simulation(divided("okuizumi-model-1", count)) for count in (1, 4))
    for sim in (whole, parted):
        sim.run(until=3e-3, frames=2, samples=301)
    # The motion is chaotic at the scale of wrinkles; it has not spread yet.
    assert np.abs(whole.positions - parted.positions).max() < 2e-5
    assert parted.ledger()["error"] == pytest.approx(whole.ledger()["error"], rel=0.05)
    work = [sim.ledger()["work_by_law"]["air_drag"] for sim in (whole, parted)]
    assert work[1] == pytest.approx(work[0], rel=0.01)


def test_save_and_restore_continue_with_the_same_bits(tmp_path: Path) -> None:
    sims = [Simulation(divided("okuizumi-model-1", 4)) for _ in range(2)]
    sims[0].step(100)
    sims[1].step(37)
    sims[1].save(tmp_path / "state.npz")
    sims[1] = Simulation.restore(tmp_path / "state.npz")
    sims[1].step(63)
    a, b = sims
    assert (a.positions == b.positions).all()
    assert (a.velocities == b.velocities).all()
    assert a.ledger() == b.ledger()
    assert a.slow_laws == b.slow_laws


@pytest.mark.parametrize("count", [0, -1, 1.5, 1001, True])
def test_substeps_are_counted(count: int) -> None:
    with pytest.raises(InputError, match="substeps"):
        RunSettings(substeps=count)
