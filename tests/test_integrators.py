"""Integrators on a linear oscillator and on a uniform chain: order, loss, and the limit of the step."""

from __future__ import annotations

import math

import numpy as np
import pytest
from membrane_rs import Gravity, InputError, Scene, Simulation, UnstableError
from small_scenes import cord, rates

FACTS = {"rk4": {"order": 4, "limit": math.sqrt(8.0), "evaluations": 4}}
"""What is known of each integrator: its order, its limit of omega dt on an oscillator, its evaluations per
step.
"""

OMEGA = 10.0
"""Of 1 kg on a cord of 100 N/m [rad/s]."""


def oscillator(integrator: str, dt: float, amplitude: float = 0.01) -> Simulation:
    """A mass on a cord that weight keeps taut: linear, x = L + m g/k + amplitude cos(omega t)."""
    scene = Scene(None, None, [Gravity((10.0, 0.0, 0.0))], [cord()])
    sim = Simulation(scene, integrator, dt)
    sim.positions = [[0.0, 0.0, 0.0], [1.1 + amplitude, 0.0, 0.0]]
    return sim


def test_every_integrator_has_its_facts() -> None:
    with pytest.raises(InputError) as caught:
        oscillator("no such method", 1e-3)
    known = str(caught.value).split("choose one of: ")[1]
    assert {name.strip() for name in known.split(",")} == set(FACTS)


@pytest.mark.parametrize("name", FACTS)
def test_order_is_as_stated(name: str) -> None:
    # Error at omega t = 5 against the closed form; omega dt from 0.1 to 0.0125, where the next order adds
    # some per cent.
    errors = []
    for count in (50, 100, 200, 400):
        sim = oscillator(name, 0.5 / count)
        sim.step(count)
        exact = [1.1 + 0.01 * math.cos(5.0), -0.01 * OMEGA * math.sin(5.0) / OMEGA]
        found = [sim.positions[1, 0], sim.velocities[1, 0] / OMEGA]
        errors.append(math.dist(found, exact))
        assert sim.evaluation_count == count * FACTS[name]["evaluations"]
    assert rates(errors) == pytest.approx(FACTS[name]["order"], abs=0.05)


@pytest.mark.parametrize("name", FACTS)
def test_stable_step_is_the_limit(name: str) -> None:
    sim = oscillator(name, 1e-3)
    assert sim.stable_dt() * OMEGA == pytest.approx(FACTS[name]["limit"], rel=1e-6)
    assert "tethers" in sim.limiting_part


@pytest.mark.parametrize("name", FACTS)
def test_bounded_below_the_limit_and_not_above(name: str) -> None:
    limit = FACTS[name]["limit"] / OMEGA
    sim = oscillator(name, 0.999 * limit)
    sim.step(10_000)
    assert abs(sim.positions[1, 0] - 1.1) <= 0.0101
    sim = oscillator(name, 1.01 * limit)
    with pytest.raises(UnstableError, match="above the stability limit"):
        sim.step(10_000)


def test_loss_of_amplitude_per_step_of_rk4() -> None:
    # |R(i z)|^2 = 1 - z^6/72 + z^8/576, so the loss per step is z^6/144 (1 + O(z^2)): 1 % at z = 0.2.
    z, steps = 0.2, 20_000
    sim = oscillator("rk4", z / OMEGA)
    sim.step(steps)
    amplitude = math.hypot(sim.positions[1, 0] - 1.1, sim.velocities[1, 0] / OMEGA) / 0.01
    assert -math.log(amplitude) / steps == pytest.approx(z**6 / 144, rel=0.02)
    assert -math.log(amplitude) / steps == pytest.approx(-0.5 * math.log(1 - z**6 / 72 + z**8 / 576), rel=1e-6)


@pytest.mark.parametrize("name", FACTS)
def test_limit_of_a_uniform_chain(name: str) -> None:
    # Springs k between masses m: omega_max = 2 sqrt(k/m) cos(pi/(2 n)), so dt < limit/2 sqrt(m/k) (RK4:
    # 1.414). Its last mass is half of the others, as half a segment hangs on it: omega_max is that of a
    # chain of 2 n springs.
    n, stiffness, mass = 40, 1000.0, 1e-3
    part = cord(segments=n, axial_stiffness=stiffness / n, linear_density=mass * n, tip_mass=0.0)
    scene = Scene(None, None, [Gravity((5.0, 0.0, 0.0))], [part])
    unit = math.sqrt(mass / stiffness)
    sim = Simulation(scene, name, 1e-6)
    expected = FACTS[name]["limit"] / 2 * unit
    assert sim.stable_dt() == pytest.approx(expected, rel=2e-3)
    # Seen to be so: a chain hung taut (tension of the mass below each spring), its fastest mode barely
    # excited.
    below = mass * (n - 0.5 - np.arange(n))
    stretched = 1.0 / n + 5.0 * below / stiffness
    positions = np.zeros((n + 1, 3))
    positions[1:, 0] = np.cumsum(stretched)
    velocities = np.zeros_like(positions)
    velocities[1:, 0] = 1e-6 * (-1.0) ** np.arange(n)
    for factor, bounded in ((0.99, True), (1.02, False)):
        sim = Simulation(scene, name, factor * expected)
        sim.positions = positions
        sim.velocities = velocities
        if bounded:
            sim.step(20_000)
            assert np.abs(sim.positions - positions).max() < 1e-6
        else:
            with pytest.raises(UnstableError):
                sim.step(20_000)


def test_time_is_a_multiple_of_the_step() -> None:
    sim = oscillator("rk4", 1e-4)
    for _ in range(1000):
        sim.step()
    assert sim.time == 1000 * 1e-4
    assert sim.step_count == 1000
