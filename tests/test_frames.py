"""The same motion seen from two frames, and the same scene turned in space."""

from __future__ import annotations

import numpy as np
import pytest
from membrane_rs import AirDrag, Creases, Gravity, Scene, Simulation, SolarPressure, Spin, SpringDamping, Springs
from membrane_rs.folding import Strip
from membrane_rs.scene.laws import Law
from small_scenes import RUBBER, Floats, rates, rotation, turned

AXIS = np.array([0.0, 0.0, 1.0])
OMEGA = 2 * np.pi * 3.0
LIGHT = SolarPressure(0.84, 0.04, (1.0, 0.5, 2.0), 2e8, back_specular=0.3, front_emissivity=0.1, back_emissivity=0.6)
"""Of 2.5 Pa, about as strong as the weight of the strip."""


def free_strip(laws: list[Law], turn: Floats | None = None, dt: float | None = None) -> Simulation:
    """A free creased strip, folded by one radian and tossed, with a smooth field of velocities."""
    mesh = Strip(0.12, 0.04, 6, 2, creases=(0.5,), fold_angle=1.0).mesh()
    turn = np.eye(3) if turn is None else turn
    creases = Creases(stiffness=10.0, natural_angle=1.0)
    sim = Simulation(Scene(turned(mesh, turn), RUBBER, [Springs(), SpringDamping(), creases, *laws]), dt=dt)
    x = mesh.positions
    sim.velocities = (np.cross([1.0, -4.0, 2.0], x) + 10.0 * x[:, ::-1] * x + [0.3, 0.1, 0.5]) @ turn.T
    return sim


def from_both_frames(dt: float, steps: int) -> float:
    """Largest difference of positions [m] after `steps` in the turning and in the resting frame."""
    everywhere: list[Law] = [Gravity((3.0, 1.0, -9.0)), AirDrag(pressure=1e4), LIGHT]
    turning = free_strip([Spin(OMEGA / (2 * np.pi)), *everywhere], dt=dt)
    resting = free_strip(everywhere, dt=dt)
    resting.velocities = turning.velocities + OMEGA * np.cross(AXIS, turning.positions)
    turning.step(steps)
    resting.step(steps)
    assert turning.hub_angle == pytest.approx(OMEGA * dt * steps)
    seen = turning.positions @ rotation([0.0, 0.0, 1.0], turning.hub_angle).T
    moved = np.abs(resting.positions - resting.scene.assemble().positions).max()
    assert moved > 0.01
    return float(np.abs(seen - resting.positions).max())


def test_a_motion_is_the_same_in_the_turning_and_in_the_fixed_frame() -> None:
    # Each frame makes its own error of order dt^4, which falls until rounding (1e-16 x 1e4 steps) is reached.
    dt = 4e-5
    errors = [from_both_frames(dt, 500), from_both_frames(dt / 2, 1000), from_both_frames(dt / 8, 4000)]
    assert rates(errors[:2])[0] == pytest.approx(4.0, abs=0.5)
    assert errors[-1] < 1e-12


@pytest.mark.parametrize("axis", [[0, 0, 1], [1, 0, 0], [1, 1, 1], [2, -1, 0.3]])
def test_a_scene_turned_in_space_moves_alike(axis: list[float]) -> None:
    turn = rotation(axis, 1.234)
    weight = np.array([3.0, 1.0, -9.0])
    sims = [
        free_strip([Gravity((float(g[0]), float(g[1]), float(g[2]))), AirDrag(pressure=1e4)], t, dt=2e-5)
        for g, t in ((weight, np.eye(3)), (turn @ weight, turn))
    ]
    for sim in sims:
        sim.step(1000)
    assert np.abs(sims[0].positions - sims[0].scene.assemble().positions).max() > 0.01
    # Rounding of 1e-16 m in each of 1000 steps, not yet magnified by wrinkles.
    assert np.abs(sims[0].positions @ turn.T - sims[1].positions).max() < 1e-12
    assert sims[0].ledger()["kinetic"] == pytest.approx(sims[1].ledger()["kinetic"], rel=1e-10)


def test_a_spinning_scene_turned_about_its_axis_moves_alike() -> None:
    turn = rotation([0, 0, 1], 0.7)
    sims = [free_strip([Spin(3.0, acceleration=5.0)], t, dt=2e-5) for t in (np.eye(3), turn)]
    for sim in sims:
        sim.step(1000)
    assert np.abs(sims[0].positions @ turn.T - sims[1].positions).max() < 1e-12


def test_a_spinning_up_frame_is_the_resting_one_seen_from_a_turning_hub() -> None:
    spin = Spin(1.0, acceleration=20.0)
    turning, resting = free_strip([spin], dt=1e-5), free_strip([], dt=1e-5)
    resting.velocities = turning.velocities + 2 * np.pi * np.cross(AXIS, turning.positions)
    for sim in (turning, resting):
        sim.step(2000)
    assert turning.hub_angle == pytest.approx(2 * np.pi * (0.02 + 0.5 * 20.0 * 0.02**2))
    seen = turning.positions @ rotation([0, 0, 1], turning.hub_angle).T
    assert np.abs(seen - resting.positions).max() < 1e-10
    # Work of the frame is counted, so the balance closes in both.
    assert abs(turning.ledger()["error"]) < 1e-6
    assert abs(resting.ledger()["error"]) < 1e-6


def test_two_mirrored_hubs_make_mirrored_motions() -> None:
    mirror = np.diag([1.0, -1.0, 1.0])
    left, right = free_strip([Spin(3.0)], dt=2e-5), free_strip([Spin(-3.0)], dt=2e-5)
    velocities = left.velocities
    right.velocities = velocities @ mirror
    # The strip is its own mirror image up to its diagonals, so compare a motion without strain: forces alone.
    right.positions = left.positions @ mirror
    assert left.forces("spin") @ mirror == pytest.approx(right.forces("spin"), abs=1e-15)
