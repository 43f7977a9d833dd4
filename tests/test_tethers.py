"""Cords with known answers: pendulum, hanging chain, tethers whirled by a hub."""

from __future__ import annotations

import math

import numpy as np
import pytest
from membrane_rs import Gravity, Scene, Simulation, Spin, SpringDamping
from scipy.special import j0
from small_scenes import Floats, cord, frequencies, period, rates, rest

GRAVITY = 9.81


@pytest.mark.parametrize(("degrees", "ratio"), [(60.0, 1.07318), (90.0, 1.18034)])
def test_period_of_a_pendulum_on_a_stiff_spring(degrees: float, ratio: float) -> None:
    # T/T0 = 2 K(sin(a/2))/pi. The weight stretches the cord by 1e-5, three times that at the bottom: half
    # of it in the period. The cord hangs from the x axis and swings in the x-z plane.
    angle, length = math.radians(degrees), 1.0
    scene = Scene(
        None,
        None,
        [Gravity((0.0, 0.0, -GRAVITY)), SpringDamping(0.1)],
        [cord(end=(math.sin(angle), 0.0, -math.cos(angle)), axial_stiffness=GRAVITY * 1e5)],
    )
    sim = Simulation(scene, dt=5e-4)
    times, swing = [], []
    while sim.time < 4.0:
        times.append(sim.time)
        swing.append(sim.positions[1, 0])
        sim.step(10)
    assert period(times, swing) == pytest.approx(2 * math.pi * math.sqrt(length / GRAVITY) * ratio, rel=1e-4)


def chain(segments: int) -> Simulation:
    """1 m of cord that hangs at rest under its weight, stretched by 1e-4 at most."""
    part = cord(end=(0.0, 0.0, -1.0), segments=segments, axial_stiffness=1e4, linear_density=0.1, tip_mass=0.0)
    sim = Simulation(Scene(None, None, [Gravity((0.0, 0.0, -GRAVITY))], [part]))
    rest(sim, np.arange(1, segments + 1), [2], 1e-8)
    return sim


def test_small_swings_of_a_hanging_chain() -> None:
    exact = np.array([1.2024, 2.7600, 4.3269])  # zeros of J0, halved
    errors = []
    for segments in (20, 40, 80):
        # A step of 3e-7 m: the cord's stretch by it, and rounding, are 1e-3 of what they disturb at the
        # free end.
        found = frequencies(chain(segments), np.arange(1, segments + 1), 0, 3e-7)[:3] / math.sqrt(GRAVITY)
        errors.append(np.abs(found / exact - 1.0))
    # Measured in the third mode: 3.7, 0.96, 0.24 %.
    assert errors[-1].max() < 4e-3
    assert errors[-1][0] < 2e-4
    for mode in (1, 2):
        assert rates([error[mode] for error in errors]) == pytest.approx(2.0, abs=0.25)


def test_a_chain_swings_as_slowly_in_time() -> None:
    # The slowest mode, J0(2 w sqrt(s/g)) at height s above the free end, 1 mm at the end; 20 segments,
    # softer cord.
    part = cord(end=(0.0, 0.0, -1.0), segments=20, axial_stiffness=1e3, linear_density=0.1, tip_mass=0.0)
    sim = Simulation(Scene(None, None, [Gravity((0.0, 0.0, -GRAVITY))], [part]))
    rest(sim, np.arange(1, 21), [2], 1e-6)
    positions = sim.positions.copy()
    height = np.maximum(0.0, 1.0 + positions[:, 2])
    positions[1:, 0] = 1e-3 * j0(2.4048256 * np.sqrt(height[1:]))
    sim.positions = positions
    times, swing = [], []
    while sim.time < 5.0:
        times.append(sim.time)
        swing.append(sim.positions[-1, 0])
        sim.step(20)
    # Stretch 5e-4 and discretisation 1e-3.
    assert 2 * math.pi / period(times, swing) == pytest.approx(1.2024 * math.sqrt(GRAVITY), rel=2e-3)


@pytest.mark.parametrize(("axis", "ratio"), [(1, 0.1 / 0.3), (2, 1 + 0.1 / 0.3)])
def test_swings_of_a_massless_tether_whirled_by_a_hub(axis: int, ratio: float) -> None:
    # R = 0.1 m, L = 0.3 m, m = 10 g, 3 Hz: in the plane Omega sqrt(R/L), out of it Omega sqrt(1 + R/L).
    omega = 2 * math.pi * 3.0
    tension = 0.01 * omega**2 * 0.4
    stiffness = 1e4 * tension
    # Unloaded length such that the loaded one is L.
    part = cord(
        start=(0.1, 0.0, 0.0),
        end=(0.4, 0.0, 0.0),
        length=0.3 / (1 + tension / stiffness),
        axial_stiffness=stiffness,
        tip_mass=0.01,
    )
    sim = Simulation(Scene(None, None, [Spin(3.0)], [part]))
    assert sim.spring_strains()[0] * stiffness == pytest.approx(tension, rel=1e-9)
    assert np.abs(sim.forces()[1]).max() < 1e-9 * tension  # T = m Omega^2 (R + L)
    positions = sim.positions.copy()
    angle = 1e-3
    positions[1, 0] = 0.1 + 0.3 * math.cos(angle)
    positions[1, axis] = 0.3 * math.sin(angle)
    sim.positions = positions
    times, swing = [], []
    while sim.time < 2.0:
        times.append(sim.time)
        swing.append(sim.positions[1, axis])
        sim.step(50)
    # The cord gives by 1e-4 of its length; the swing's square adds 1e-6.
    assert 2 * math.pi / period(times, swing) == pytest.approx(omega * math.sqrt(ratio), rel=3e-4)
    assert np.abs(swing).max() == pytest.approx(0.3 * angle, rel=1e-3)


def whirled(segments: int) -> tuple[Floats, Floats]:
    """Tension [N] of a heavy tether with a tip mass at rest in the turning frame, and its closed form, per
    segment.
    """
    omega, linear, tip = 2 * math.pi * 3.0, 0.05, 0.01
    part = cord(
        start=(0.1, 0.0, 0.0),
        end=(0.4, 0.0, 0.0),
        segments=segments,
        axial_stiffness=1e6,
        linear_density=linear,
        tip_mass=tip,
    )
    sim = Simulation(Scene(None, None, [Spin(3.0)], [part]))
    rest(sim, np.arange(1, segments + 1), [0], 1e-9)
    assert np.abs(sim.forces()[1:]).max() < 1e-6
    radius = sim.positions[:, 0]
    middle, end = 0.5 * (radius[1:] + radius[:-1]), radius[-1]
    exact: Floats = omega**2 * (tip * end + 0.5 * linear * (end**2 - middle**2))
    return sim.spring_strains() * 1e6, exact


def test_tension_along_a_heavy_tether() -> None:
    # The cord stretches by 5e-6 only. Masses at the nodes stand for the cord up to half a segment beyond
    # them: what is left is mu Omega^2 l^2/8 at the tip, of second order.
    errors = []
    for segments in (5, 10, 20, 40):
        found, exact = whirled(segments)
        errors.append(float(np.abs(found - exact).max() / exact[0]))
    assert errors[-1] < 1e-4
    assert rates(errors[:3]) == pytest.approx(2.0, abs=0.1)
