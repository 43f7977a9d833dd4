"""Loads with a factor of time: closed forms, jumps, the energy balance, stages, files, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    Fixed,
    Gravity,
    Pressure,
    RunSettings,
    Scene,
    Schedule,
    Simulation,
    SolarPressure,
    Spin,
    Springs,
    Stage,
    Tether,
)
from membrane_rs.check.redundancy import idle_laws
from membrane_rs.errors import InputError
from membrane_rs.folding import Disc
from membrane_rs.scene.laws import Law
from methods import METHODS, ORDER
from small_scenes import RUBBER

LOADS: dict[str, Law] = {
    "gravity": Gravity((3.0, 1.0, -9.0)),
    "pressure": Pressure(2.0),
    "solar_pressure": SolarPressure(0.84, 0.04, (1.0, 0.5, 2.0), 2e8, back_specular=0.3),
}
RAMP = Schedule((0.0, 0.4, 0.4), (0.0, 1.0, 1.0))
"""Of the factor [s, -]; two knots where its rate jumps, on which the power of a potential depends."""


def disc(*laws: Any, stages: tuple[Stage, ...] = (), **run: Any) -> Scene:
    """A disc of rubber that is held at its rim."""
    parts = [Fixed("rim")]
    return Scene(Disc(0.1, 3).mesh(), RUBBER, [Springs(), *laws], parts, stages=stages, run=RunSettings(**run))


def with_factor(kind: str, factor: Any) -> Law:
    """A load with a factor."""
    values = {name: value for name, value in vars(LOADS[kind]).items() if not name.startswith("_")}
    return type(LOADS[kind])(**(values | {"factor": factor}))


def falling(factor: Schedule | None, **run: Any) -> Scene:
    """Two free masses of 1.5 kg together."""
    line = Tether((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 1, 1e-6, 1.0, fixed=False, tip_mass=0.5, strain_limit=1e9)
    laws = [Gravity((0.0, 0.0, -10.0), factor=factor)]
    return Scene(None, None, laws, [line], run=RunSettings(energy_loss=1e3, **run))


@pytest.mark.parametrize("method", METHODS)
def test_a_mass_falls_by_the_double_integral_of_its_weight(method: str) -> None:
    """g t^3/(6 T) while the factor rises as t/T, and from there on by the speed that it has."""
    errors = []
    for dt in (4e-3, 2e-3):
        sim = Simulation(falling(RAMP), method, dt)
        sim.reach(0.4)
        errors.append(abs(sim.positions[0, 2] + 10.0 * 0.4**2 / 6.0))
        assert sim.velocities[0, 2] == pytest.approx(-10.0 * 0.4 / 2.0, rel=1e-4)
        sim.reach(0.5)
        assert sim.positions[0, 2] == pytest.approx(-10.0 * (0.4**2 / 6.0 + 0.4 * 0.1 / 2.0 + 0.1**2 / 2.0), rel=1e-4)
        ledger = sim.ledger()
        # The kinetic energy of 1.5 kg at 3 m/s.
        assert ledger["work_by_law"]["gravity"] == pytest.approx(0.5 * 1.5 * 3.0**2, rel=1e-3)
        assert abs(ledger["error"]) < 1e-3
    assert errors[1] < 1e-12 or np.log2(errors[0] / errors[1]) > ORDER[method] - 1.0


@pytest.mark.parametrize("method", METHODS)
def test_a_jump_of_the_weight_does_no_work_at_once(method: str) -> None:
    """Off until then: the mass rests, and then falls."""
    sim = Simulation(falling(Schedule((0.1003, 0.1003), (0.0, 1.0))), method, 1e-3)
    lifted = sim.positions + np.array([0.0, 0.0, 2.0])
    sim.positions = lifted
    sim.reach(0.1003)
    assert np.array_equal(sim.positions, lifted)
    sim.reach(0.3003)
    assert sim.positions[:, 2] == pytest.approx(2.0 - 10.0 * 0.2**2 / 2.0, rel=1e-6)
    ledger = sim.ledger()
    assert ledger["work_by_law"]["gravity"] == pytest.approx(0.5 * float(sim.masses.sum()) * 2.0**2, rel=1e-6)
    assert not ledger.get("changes")
    assert abs(ledger["error"]) < 1e-6


@pytest.mark.parametrize("method", ["rk4", "leapfrog", "dopri5"])
def test_the_balance_closes_at_the_knots_of_a_sampled_weight(method: str) -> None:
    hum = Schedule.sampled(lambda t: math.sin(100.0 * math.pi * t), np.linspace(0.0, 0.1, 201))
    sim = Simulation(disc(Gravity((0.0, 0.0, -9.81), factor=hum)), method)
    sim.reach(0.1)
    assert sim.ledger()["work_by_law"]["gravity"] != 0.0
    assert abs(sim.ledger()["error"]) < 2e-3


@pytest.mark.parametrize("kind", LOADS)
@pytest.mark.parametrize("method", METHODS)
def test_a_factor_of_one_leaves_every_bit(kind: str, method: str) -> None:
    found = []
    for law in (LOADS[kind], with_factor(kind, Schedule((0.0,), (1.0,)))):
        sim = Simulation(disc(law, Spin(2.0)), method, 2e-5)
        sim.step(50)
        found.append((sim.positions, sim.velocities, sim.energies(), sim.ledger()["work_by_law"]))
    assert np.array_equal(found[0][0], found[1][0])
    assert np.array_equal(found[0][1], found[1][1])
    assert found[0][2:] == found[1][2:]


@pytest.mark.parametrize("kind", LOADS)
def test_forces_are_the_factor_times_those_without(kind: str) -> None:
    """At any time, before, between and behind the knots; with the film held, so that they turn and nothing else."""
    factor = Schedule((0.01, 0.02, 0.02, 0.03), (0.5, 2.0, -1.0, 3.0), 0.3)
    scene = disc(with_factor(kind, factor), Spin(5.0))
    held = Scene(scene.mesh, RUBBER, scene.laws, [Fixed(tuple(range(scene.mesh.node_count)))])  # type: ignore[union-attr]
    bare = Scene(scene.mesh, RUBBER, [Springs(), LOADS[kind], Spin(5.0)], held.parts)
    sims = [Simulation(one, "leapfrog", 1e-3) for one in (held, bare)]
    for time in (0.0, 0.005, 0.013, 0.0195, 0.02, 0.024, 0.04):
        for sim in sims:
            sim.reach(time)
        wanted = factor.at(time) * sims[1].forces(kind)
        assert sims[0].forces(kind) == pytest.approx(wanted, abs=1e-12 * np.abs(wanted).max())


@pytest.mark.parametrize("kind", LOADS)
def test_times_count_from_the_stage_that_sets_the_factor(kind: str) -> None:
    set_late = Stage("b", 0.02, set={f"laws.{kind}.factor": Schedule((0.0, 0.01), (1.0, 2.0))})
    sim = Simulation(disc(LOADS[kind], stages=(Stage("a", 0.02), set_late)), "leapfrog", 1e-4)
    late = Schedule((0.02, 0.03), (1.0, 2.0))
    other = Simulation(disc(with_factor(kind, late), until=0.04), "leapfrog", 1e-4)
    for time in (0.01, 0.025, 0.04):
        sim.reach(time)
        other.reach(time)
        assert sim.positions == pytest.approx(other.positions, abs=1e-12)


@pytest.mark.parametrize("kind", LOADS)
def test_a_scene_is_relaxed_under_the_load_of_the_instant(kind: str) -> None:
    """The forces while it is relaxed at t = 0 are those of its factor there."""
    law = with_factor(kind, Schedule((0.0, 1.0), (0.25, 100.0)))
    sims = [Simulation(disc(one)) for one in (law, LOADS[kind])]
    assert sims[0].forces(kind) == pytest.approx(0.25 * sims[1].forces(kind), rel=1e-12, abs=1e-18)


@pytest.mark.parametrize("kind", LOADS)
def test_it_goes_through_files_and_a_run_goes_on_with_the_same_bits(kind: str, tmp_path: Path) -> None:
    scene = disc(with_factor(kind, Schedule((0.0, 0.004, 0.004), (0.5, 1.0, -1.0), 0.2)), until=0.008)
    scene.save(tmp_path)
    assert Scene.from_toml(tmp_path / "scene.toml").laws == scene.laws
    assert "factor = {" in scene.to_toml()
    whole, first = (Simulation(scene, "leapfrog", 1e-4) for _ in range(2))
    whole.reach(0.008)
    first.reach(0.003)
    second = Simulation(scene, "leapfrog", 1e-4)
    second.set_state(first.state())
    second.reach(0.008)
    assert np.array_equal(whole.positions, second.positions)


@pytest.mark.parametrize("kind", LOADS)
def test_what_is_no_factor_is_refused_and_one_of_nothing_named(kind: str) -> None:
    with pytest.raises(InputError, match=r"factor = 2\.0: must be a Schedule, or a table with times"):
        with_factor(kind, 2.0)
    idle = disc(with_factor(kind, Schedule((0.0, 1.0), (0.0, 0.0))))
    assert any("its factor is 0" in text for text in map(str, idle_laws(idle)))


def test_a_doubtful_load_is_one_by_its_largest_factor() -> None:
    strong = Gravity((0.0, 0.0, -9.81), factor=Schedule((0.0, 1.0), (0.0, -1000.0)))
    assert any("9810 m/s2" in doubt.message for doubt in strong.implausible_values(disc(), "laws.gravity"))
    blown = Pressure(1.0, factor=Schedule((0.0, 1.0), (0.0, 1e6)))
    assert any("1e+06 Pa" in doubt.message for doubt in blown.implausible_values(disc(), "laws.pressure"))
