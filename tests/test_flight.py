"""A sail and its hub under loads from outside: in six degrees of freedom, and on an axis."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    AirDrag,
    Fixed,
    Gravity,
    PointForces,
    RunSettings,
    Scene,
    Schedule,
    Simulation,
    SolarPressure,
    Spin,
    Tether,
    Triangles,
    scenes,
)
from membrane_rs.folding import Disc
from membrane_rs.results.momentum import momentum_error
from small_scenes import RUBBER, Floats

DISC = Disc(0.1, rings=3).mesh()
BODY = Spin(1.0, inertia=4e-5, mass=0.02, transverse_inertia=3e-5)
SUN = (0.6, 0.0, 0.8)
NEAR = 1e8
"""From the sun [m], where light presses with 10 Pa."""
METHODS = ("leapfrog", "rk4")


def flying(*laws: Any, spin: Spin = BODY, integrator: str = "leapfrog") -> Scene:
    """A disc of rubber whose rim is held on the hub."""
    run = RunSettings(until=0.05, integrator=integrator)
    return Scene(DISC, RUBBER, [Triangles(), spin, *laws], [Fixed("rim")], run=run)


def centre(sim: Simulation) -> Floats:
    """Of mass of hub and nodes, in space [m]; held nodes lie about the origin."""
    mass = BODY.mass or 0.0
    places = sim.positions @ sim.hub_rotation.T + sim.hub_displacement
    whole: Floats = (sim.masses @ places + mass * sim.hub_displacement) / (mass + sim.masses.sum())
    return whole


@pytest.mark.parametrize("integrator", METHODS)
def test_sunlight_moves_the_whole_and_its_work_closes_the_balance(integrator: str) -> None:
    light = SolarPressure(0.84, 0.04, sun=SUN, distance=NEAR)
    sim = Simulation(flying(light, integrator=integrator))
    start, count, until = centre(sim), 400, 0.05
    forces = []
    for k in range(count + 1):
        sim.reach(until * k / count)
        forces.append(sim.hub_rotation @ sim.forces("solar_pressure").sum(axis=0))
    mass = (BODY.mass or 0.0) + sim.masses.sum()
    # x(T) - x(0) = integral of (T - t) F/M, by the rule of trapezoids.
    time = np.linspace(0.0, until, count + 1)
    derived = np.trapezoid((until - time)[:, None] * np.array(forces) / mass, time, axis=0)
    moved = centre(sim) - start
    assert moved == pytest.approx(derived, rel=1e-4, abs=1e-6 * np.linalg.norm(derived))
    assert moved @ np.array(SUN) < -1e-3
    assert abs(sim.ledger()["error"]) < 1e-4
    assert sim.ledger()["work_by_law"]["solar_pressure"] > 0.0
    assert momentum_error({"time": time, "hub_momentum": time, "sail_momentum": time}, sim.scene) is None


@pytest.mark.parametrize("integrator", METHODS)
def test_in_a_uniform_field_hub_and_sail_fall_together(integrator: str) -> None:
    g = np.array([1.0, -2.0, -9.81])
    fields = (Gravity(tuple(field)) for field in (g, np.zeros(3)))
    falling, flown = (Simulation(flying(law, integrator=integrator), dt=2e-5) for law in fields)
    for sim in (falling, flown):
        sim.reach(0.005)
    assert falling.positions == pytest.approx(flown.positions, abs=1e-11)
    assert falling.hub_displacement == pytest.approx(flown.hub_displacement + 0.5 * g * 0.005**2, abs=1e-11)
    halved = Simulation(
        flying(Gravity(tuple(2.0 * g), factor=Schedule([0.0, 1.0], [0.5, 0.5])), integrator=integrator), dt=2e-5
    )
    halved.reach(0.005)
    fallen = -(0.02 + falling.masses.sum()) * g @ (0.5 * g * 0.005**2)
    for sim in (falling, halved):
        assert sim.energies()["gravity"] == pytest.approx(fallen, rel=1e-6)


@pytest.mark.parametrize("integrator", METHODS)
def test_the_axis_precesses_by_the_torque_over_the_spin(integrator: str) -> None:
    """A force at the end of a mast; at whole periods of the nutation the closed form holds to second order."""
    spin = Spin(8.0, inertia=1.0, mass=2.0, transverse_inertia=0.8)
    mast = Tether((0.0, 0.0, 0.1), (0.01, 0.0, 0.1), 1, 1e-3, 1e-9)
    push = PointForces("tether-0-start", (0.2, 0.0, 0.0), frame="inertial")
    run = RunSettings(until=1.0, integrator=integrator, dt=1e-4)
    sim = Simulation(Scene(None, None, [spin, push], [mast, Fixed("tether-0-end")], run=run))
    time = 10 * 0.8 / 8.0
    sim.reach(time)
    derived = 0.1 * 0.2 / (math.tau * 8.0) * time
    assert sim.hub_rotation[1, 2] == pytest.approx(derived, rel=1e-4)
    assert abs(sim.hub_rotation[0, 2]) < 1e-3 * derived


@pytest.mark.parametrize("integrator", METHODS)
def test_a_hub_on_its_axis_swings_under_a_weight_across_it(integrator: str) -> None:
    """A pendulum, let go at a small angle from the direction of the weight."""
    bob = Tether((0.2, 0.0, 0.0), (0.2, 0.0, 0.01), 1, 1.0, 1e-9, tip_mass=0.05)
    angle = 1e-3
    weight = Gravity((9.81 * math.cos(angle), 9.81 * math.sin(angle), 0.0))
    run = RunSettings(until=1.0, integrator=integrator, dt=1e-3)
    sim = Simulation(Scene(None, None, [Spin(0.0, inertia=0.01), weight], [bob, Fixed("tether-0-end")], run=run))
    rate = math.sqrt(0.05 * 9.81 * 0.2 / (0.01 + 0.05 * 0.2**2))
    for instant in np.linspace(0.1, 2.0, 20).tolist():
        sim.reach(instant)
        assert sim.hub_angle == pytest.approx(angle * (1.0 - math.cos(rate * instant)), abs=1e-5 * angle)
        assert abs(sim.ledger()["error"]) < 1e-4


@pytest.mark.parametrize("integrator", METHODS)
def test_a_falling_sail_reaches_the_speed_at_which_the_air_bears_it(integrator: str) -> None:
    air = AirDrag(pressure=1e5)
    sim = Simulation(flying(Gravity(), air, spin=replace(BODY, frequency=0.0), integrator=integrator))
    area, density = DISC.areas().sum(), 1e5 / (287.0 * 293.0)
    mass = 0.02 + sim.masses.sum()
    last = math.sqrt(2.0 * mass * 9.81 / (density * area))
    sim.reach(0.5)
    derived = -(last**2) / 9.81 * math.log(math.cosh(9.81 * 0.5 / last))
    assert centre(sim)[2] == pytest.approx(derived, rel=2e-3)
    assert abs(sim.ledger()["error"]) < 1e-3


def test_a_flight_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    light = SolarPressure(0.84, 0.04, sun=SUN, distance=NEAR)
    scene = flying(light, Gravity((1.0, 0.0, 0.0)), AirDrag(pressure=1e3))
    first = Simulation(scene)
    first.reach(0.0103)
    first.hub_load()
    first.save(tmp_path / "state.npz")
    again = Simulation.restore(tmp_path / "state.npz")
    for sim in (first, again):
        sim.reach(0.02)
    assert (again.positions == first.positions).all()
    assert (again.hub_attitude == first.hub_attitude).all()


def test_the_built_in_body_takes_every_load() -> None:
    body = scenes.load("nutating-hub")
    sim = Simulation(replace(body, laws=[*body.laws, Gravity((0.0, 0.0, -1.0))]))
    sim.reach(1.0)
    assert sim.hub_displacement[2] == pytest.approx(-0.5, rel=1e-9)
