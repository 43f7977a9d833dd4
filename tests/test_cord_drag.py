"""Drag on cords against closed forms: a cord across and along the flow, one that falls, one that turns."""

from __future__ import annotations

from math import cos, pi, radians, sin, tanh
from typing import Any

import numpy as np
import pytest
from membrane_rs import Boltrope, Cord, CordDrag, Gravity, Scene, Simulation, Spin, Springs, integrators
from membrane_rs.check.redundancy import idle_laws
from membrane_rs.scene.laws import Law
from small_scenes import RUBBER, Floats, patch, rates

AIR = CordDrag(diameter=2e-3, coefficient=1.2, density=1.25)
FACTOR = 0.5 * 1.25 * 1.2 * 2e-3
"""rho C_d d/2 [kg/m2]."""


def rope(laws: list[Law], segments: int, *, fixed: bool = False, **changes: Any) -> Scene:
    """A cord of 1 m along x."""
    values: dict[str, Any] = {"axial_stiffness": 1e3, "linear_density": 0.01, "strain_limit": 1.0, "fixed": fixed}
    part = Cord((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), segments, **(values | changes), name="rope")
    return Scene(None, None, laws, [part])


def turning(x: Floats, rate: float) -> Floats:
    """Velocities of a rotation about z [m/s]."""
    return np.column_stack([-rate * x[:, 1], rate * x[:, 0], np.zeros(len(x))])


@pytest.mark.parametrize("degrees", [0.0, 30.0, 60.0, 90.0])
def test_the_flow_across_alone_has_drag(degrees: float) -> None:
    sim, speed = Simulation(rope([AIR], 5)), 3.0
    along, across = speed * cos(radians(degrees)), speed * sin(radians(degrees))
    sim.velocities = np.tile([along, 0.0, across], (6, 1))
    drag = sim.forces("cord_drag")
    assert drag.sum(axis=0) == pytest.approx(np.array([0.0, 0.0, -FACTOR * across**2]), abs=1e-15)
    assert drag[0] == pytest.approx(drag[2] / 2.0)


@pytest.mark.parametrize("method", integrators())
def test_a_cord_that_falls_across_itself_reaches_its_terminal_speed(method: str) -> None:
    # mu g = (rho C_d d/2) v^2 at the end; v = v_t tanh(g t/v_t). All nodes fall alike.
    terminal = (0.01 * 9.81 / FACTOR) ** 0.5
    sim = Simulation(rope([AIR, Gravity()], 4), method, dt=1e-3)
    for time in (0.3, 1.0, 3.0):
        sim.run(until=time)
        expected = -terminal * tanh(9.81 * time / terminal)
        assert sim.velocities[:, 2] == pytest.approx(np.full(5, expected), rel=2e-5)
    ledger = sim.ledger()
    kinetic, fallen = 0.5 * 0.01 * terminal**2 * tanh(9.81 * 3.0 / terminal) ** 2, -0.01 * 9.81 * sim.positions[0, 2]
    assert ledger["work_by_law"]["cord_drag"] == pytest.approx(kinetic - fallen, rel=1e-4)
    assert abs(float(ledger["error"])) < 1e-4


def test_the_torque_on_a_cord_that_turns() -> None:
    # (rho C_d d/2) w^2 R^4/4, about an end: by middles of the segments, of second order.
    errors = []
    for segments in (5, 10, 20):
        sim = Simulation(rope([AIR], segments, fixed=True))
        sim.velocities = turning(sim.positions, 7.0)
        torque = float(np.sum(sim.positions[:, 0] * sim.forces("cord_drag")[:, 1]))
        errors.append(torque / (-FACTOR * 49.0 / 4.0) - 1.0)
    assert abs(errors[-1]) < 2e-3
    assert rates(errors) == pytest.approx(2.0, abs=0.05)


def test_a_cord_that_turns_is_slowed_as_a_rod() -> None:
    # I w' = -(rho C_d d/2) w^2 R^4/4 with I = mu R^3/3: 1/w = 1/w_0 + k t, k = 3 (rho C_d d/2) R/(4 mu).
    rate, time = 20.0, 0.5
    sim = Simulation(rope([AIR], 40, fixed=True, axial_stiffness=1e4))
    sim.velocities = turning(sim.positions, rate)
    energy = sim.energies()["kinetic"]
    sim.run(until=time)
    slowed = 1.0 / (1.0 / rate + 0.75 * FACTOR / 0.01 * time)
    # The cord lags behind a rod in its outer part; both have one momentum within 1 %.
    momentum = float(sim.masses @ np.cross(sim.positions, sim.velocities)[:, 2])
    assert momentum == pytest.approx(0.01 / 3.0 * slowed, rel=0.01)
    assert sim.ledger()["work_by_law"]["cord_drag"] == pytest.approx(-energy * (1.0 - (slowed / rate) ** 2), rel=0.02)
    assert abs(float(sim.ledger()["error"])) < 1e-3


def test_air_at_rest_drags_on_a_cord_that_turns_with_the_hub() -> None:
    found = []
    for spin, air in ((False, "still"), (True, "still"), (True, "turning")):
        laws: list[Law] = [CordDrag(2e-3, 1.2, 1.25, air="still" if air == "still" else "turning")]
        sim = Simulation(rope([*laws, *([Spin(2.0)] if spin else [])], 6, fixed=True))
        if not spin:
            sim.velocities = turning(sim.positions, 4.0 * pi)
        found.append(sim.forces("cord_drag"))
    assert found[1] == pytest.approx(found[0], rel=1e-12)
    assert np.abs(found[2]).max() == 0.0


def test_a_boltrope_has_no_drag_of_its_own() -> None:
    sim = Simulation(Scene(patch(), RUBBER, [Springs(), AIR], [Boltrope([0, 1, 2], 1.0, 0.0), Cord(1, 3, 1, 1.0, 0.0)]))
    sim.velocities = np.tile([0.0, 0.0, 1.0], (4, 1))
    of_cord = -0.5 * FACTOR * 0.1 * 2.0**0.5
    assert sim.forces("cord_drag")[:, 2] == pytest.approx([0.0, of_cord, 0.0, of_cord])


def test_drag_without_a_cord_in_the_air_is_told() -> None:
    hem = Boltrope([0, 1, 2], 1.0, 0.0)
    alone, beside = (
        Scene(patch(), RUBBER, [Springs(), AIR], parts) for parts in ([hem], [hem, Cord(1, 3, 1, 1.0, 0.0)])
    )
    assert [kind for kind, reason in idle_laws(alone) if "along edges" in reason] == ["cord_drag"]
    assert "cord_drag" not in dict(idle_laws(beside))
