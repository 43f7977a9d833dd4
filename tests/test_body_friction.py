"""Friction of bodies: the rope round a post, rollers, and the power that they put in."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from membrane_rs import Cylinder, Fixed, Gravity, MassDamping, Plane, Scene, Schedule, Simulation, Tether, integrators
from membrane_rs.scene.bodies import Body
from membrane_rs.scene.laws import Law
from small_scenes import cord

SPEED = 1e-4
"""Of sliding below which friction is viscous [m/s]."""


def test_the_tension_of_a_rope_that_slides_round_a_post_grows_with_the_exponent_of_the_angle() -> None:
    # A post of 0.1 m turns under a cord that is held at one end and pulled by a weight at the other: it lies on the
    # upper half, 180 degrees. The surface slides towards the weight, so the held end bears less.
    friction, radius, segments = 0.2, 0.1, 90
    drum = Cylinder(
        "drum",
        radius,
        direction=(0.0, 1.0, 0.0),
        stiffness=2e4,
        friction=friction,
        friction_speed=1e-3,
        spin=Schedule((0.0, 0.5, 10.0), (0.0, 0.5, 20.0), ease=0.1),
    )
    ends = (-radius, 0.0, -0.3), (radius, 0.0, -0.3)
    line = Tether(*ends, segments, 200.0, 1e-2, length=0.6 + math.pi * radius, tip_mass=0.1, strain_limit=1.0)
    sim = Simulation(Scene(None, None, [Gravity(), MassDamping(20.0)], [line], bodies=[drum]), "leapfrog")
    # On the post at the start: down, half a turn, down.
    length = np.linspace(0.0, 0.6 + math.pi * radius, segments + 1)
    angle = np.clip((length - 0.3) / radius, 0.0, math.pi)
    x, z = -radius * np.cos(angle), radius * np.sin(angle)
    z += np.minimum(length - 0.3, 0.0) - np.maximum(length - 0.3 - math.pi * radius, 0.0)
    sim.positions = np.column_stack([x, np.zeros_like(x), z])
    sim.run(2.0)
    tensions = np.array(sim.cord_tensions())
    held, hanging = tensions[5:20].mean(), tensions[-20:-5].mean()
    ratio = max(held, hanging) / min(held, hanging)
    assert ratio == pytest.approx(math.exp(friction * math.pi), rel=0.03)


@pytest.mark.parametrize("method", list(integrators()))
def test_a_belt_drags_a_mass_to_its_speed(method: str) -> None:
    # 1 kg lies on a floor that moves at 0.2 m/s: it accelerates by mu g, then goes with it.
    belt = Schedule((0.0, 5.0), (0.0, 1.0))
    floor = Plane("belt", centre=(0.0, 0.0, 9.81e-3), stiffness=1e3, friction=0.1, travel_x=belt)
    sim = Simulation(Scene(None, None, [Gravity()], [cord(axial_stiffness=1e-9)], bodies=[floor]), method, dt=2e-4)
    sim.step(500)
    assert sim.velocities[1, 0] == pytest.approx(0.0981, rel=1e-2)
    sim.step(1500)
    assert sim.velocities[1, 0] == pytest.approx(0.2, rel=1e-3)
    work = sim.ledger()["work_by_law"]["belt_friction"]
    assert work == pytest.approx(0.5 * 0.2**2, rel=1e-2)
    assert abs(sim.ledger()["error"]) < 1e-3


def test_a_roller_that_spins_throws_a_mass_off_its_top() -> None:
    roller = Cylinder(
        "roller",
        0.5,
        direction=(0.0, 1.0, 0.0),
        centre=(1.0, 0.0, -0.49),
        stiffness=981.0,
        friction=0.2,
        spin=Schedule((0.0, 1.0), (0.0, 10.0)),
    )
    sim = Simulation(Scene(None, None, [Gravity()], [cord(axial_stiffness=1e-9)], bodies=[roller]), dt=2e-4)
    sim.step(200)
    # About y from z towards x: the top moves along x.
    assert sim.velocities[1, 0] > 0.05
    assert sim.ledger()["work_by_law"].get("roller", 0.0) == pytest.approx(0.0, abs=1e-12)
    assert sim.ledger()["work_by_law"]["roller_friction"] > 0.0


def test_steps_and_pieces_of_a_run_have_the_same_bits() -> None:
    def made() -> Simulation:
        bar = Cylinder("bar", 0.05, centre=(0.5, 0.0, -0.06), direction=(0, 1, 0), friction=0.3, damping=0.2, **moves)
        line = Tether((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 10, 100.0, 0.01)
        return Simulation(Scene(None, None, laws, [line, Fixed("tether-0-end")], bodies=[bar]), dt=1e-4)

    moves: dict[str, Any] = {
        "travel_z": Schedule((0.0, 0.1), (0.0, 0.05), ease=0.3),
        "spin": Schedule((0.0, 1.0), (0.0, 3.0)),
    }
    laws: list[Law] = [MassDamping(1.0)]
    whole, pieces = made(), made()
    whole.step(1500)
    pieces.step(700)
    state = pieces.state()
    again = made()
    again.set_state(state)
    again.step(800)
    assert whole.ledger()["work_by_law"]["bar"] > 1e-3
    assert np.array_equal(whole.positions, again.positions)
    assert np.array_equal(whole.velocities, again.velocities)
    assert whole.ledger() == again.ledger()


def test_friction_never_exceeds_its_share_of_the_pressure() -> None:
    floor: Body = Plane("floor", centre=(0.0, 0.0, 9.81e-3), stiffness=1e3, friction=0.4, friction_speed=SPEED)
    sim = Simulation(Scene(None, None, [Gravity()], [cord(axial_stiffness=1e-9)], bodies=[floor]), "rk4", dt=1e-5)
    for speed in (0.1 * SPEED, SPEED, 1.0):
        sim.velocities = np.array([[0.0] * 3, [0.0, speed, 0.0]])
        found = -sim.forces("floor_friction")[1, 1]
        assert found == pytest.approx(0.4 * 9.81 * speed / math.hypot(speed, SPEED), rel=1e-9)
