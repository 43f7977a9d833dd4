"""Impacts on bodies: damping that begins with the depth, restitution, momentum and energy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from membrane_rs import Cylinder, Plane, Scene, Simulation, Springs
from membrane_rs.folding import Strip
from small_scenes import RUBBER, cord, rotation, turned

pytestmark = pytest.mark.filterwarnings("ignore::membrane_rs.AuditWarning")


def dropped(wall: Plane, mass: float = 1.0, dt: float = 1e-4) -> Simulation:
    """A mass at the end of a cord without stiffness, above a floor."""
    line = cord(axial_stiffness=1e-9, tip_mass=mass)
    return Simulation(Scene(None, None, [], [line], bodies=[wall]), "rk4", dt=dt)


def restitution(damping: float) -> float:
    """Of y dy/dx = -x - 2 zeta x y/(x + y), with the depth x and the speed y: by u = y/x, by Simpson's rule over u =
    s/(1 - s).
    """
    s = np.linspace(0.0, 1.0, 20001)
    u = s[1:-1] / (1.0 - s[1:-1])
    damped = u * u + 1.0 + 2.0 * damping * u / (1.0 + u)
    values = np.zeros_like(s)
    values[1:-1] = (u / (u * u + 1.0) - u / damped) / (1.0 - s[1:-1]) ** 2
    weights = np.ones_like(s)
    weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
    return math.exp(-float(weights @ values) * (s[1] - s[0]) / 3.0)


def test_damping_and_friction_begin_with_the_depth() -> None:
    floor = Plane("floor", stiffness=1e3, damping=0.2, friction=0.5)
    sim = dropped(floor)
    speed, forces = 1.0, []
    for depth in (-1e-9, 0.0, 1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3):
        positions, velocities = sim.positions.copy(), np.zeros_like(sim.velocities)
        positions[1, 2], velocities[1] = -depth, (1.0, 0.0, -speed)
        sim.positions, sim.velocities = positions, velocities
        damping = sim.forces("floor_friction")[1, 2]
        pressure = damping + sim.forces("floor")[1, 2]
        assert -sim.forces("floor_friction")[1, 0] == pytest.approx(0.5 * pressure, rel=1e-5)
        assert 0.0 <= damping <= 0.4 * 1e3 * max(depth, 0.0) + 1e-12
        forces.append(damping)
    assert forces[:2] == [0.0, 0.0]
    assert 0.0 < forces[2] < 1e-9
    # Deep inside it is c s, with c = 2 zeta sqrt(k m).
    assert forces[-1] == pytest.approx(0.4 * math.sqrt(1e3) * speed, rel=1e-4)


@pytest.mark.parametrize("damping", [0.0, 0.05, 0.3, 1.0, 3.0])
def test_restitution_depends_on_the_ratio_alone(damping: float) -> None:
    expected = restitution(damping)
    for stiffness, mass, speed in ((1e3, 1.0, 1.0), (1e3, 1.0, 0.01), (400.0, 0.3, 1.0)):
        floor = Plane("floor", centre=(0.0, 0.0, -1e-3 * speed), stiffness=stiffness, damping=damping)
        dt = 2e-3 * math.sqrt(mass / stiffness)
        sim = dropped(floor, mass, dt)
        sim.velocities = np.array([[0.0] * 3, [0.0, 0.0, -speed]])
        sim.step(3000)
        assert sim.forces("floor")[1, 2] == 0.0
        assert sim.velocities[1, 2] / speed == pytest.approx(expected, rel=2e-4)
        lost = -sim.ledger()["work_by_law"].get("floor_friction", 0.0)
        assert lost == pytest.approx(0.5 * mass * speed**2 * (1.0 - expected**2), rel=1e-3, abs=1e-12)


@pytest.mark.parametrize(("damping", "felt_by"), [(0.0, "triangles"), (0.3, "triangles"), (0.3, "edges")])
def test_a_free_strip_that_bounces_off_a_post(damping: float, felt_by: str) -> None:
    # Upright, it falls on its edge. Momentum changes by the impulse of the body; energy is lost by its damping alone.
    post = Cylinder(
        "post",
        5e-3,
        centre=(0.022, 0.0, -0.016),
        direction=(0.0, 1.0, 0.0),
        stiffness=30.0,
        damping=damping,
        felt_by=felt_by,  # type: ignore[arg-type]
    )
    mesh = turned(Strip(0.05, 0.02, 6, 3).mesh(), rotation((1.0, 0.0, 0.0), math.pi / 2.0))
    sim = Simulation(Scene(mesh, RUBBER, [Springs()], [], bodies=[post]), "leapfrog", dt=2e-5)
    sim.velocities = np.tile((0.0, 0.0, -0.5), (len(mesh.positions), 1))
    masses = sim.masses[:, None]
    before, energy = (masses * sim.velocities).sum(axis=0), 0.5 * float((masses * sim.velocities**2).sum())
    impulse, load = np.zeros(3), -sim.body_loads()["post"].force
    for _ in range(3000):
        sim.step(1)
        last, load = load, -sim.body_loads()["post"].force
        impulse += 0.5 * sim.dt * (last + load)
    after = (masses * sim.velocities).sum(axis=0)
    assert not load.any()
    assert after[2] > 0.2 * abs(before[2])
    assert after - before == pytest.approx(impulse, abs=(1e-12 if damping == 0.0 else 1e-4) * abs(before[2]))
    ledger = sim.ledger()
    lost = -ledger["work_by_law"].get("post_friction", 0.0)
    assert (lost > 0.02 * energy) == (damping > 0.0)
    assert sum(sim.energies().values()) == pytest.approx(energy - lost, abs=1e-3 * energy)
    assert abs(ledger["error"]) < 1e-3
