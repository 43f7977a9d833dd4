"""Integrators on a linear oscillator and on a uniform chain: order, loss, and the limit of the step."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    Gravity,
    InputError,
    RunSettings,
    Scene,
    Simulation,
    SpringDamping,
    UnstableError,
    integrators,
    scenes,
)
from small_scenes import cord, hanging_strip, rates

METHODS = integrators()
LIMITED = [name for name, facts in METHODS.items() if math.isfinite(facts.imaginary_limit)]
UNLIMITED = [name for name in METHODS if name not in LIMITED]

OMEGA = 10.0
"""Of 1 kg on a cord of 100 N/m [rad/s]."""


def oscillator(integrator: str, dt: float, amplitude: float = 0.01) -> Simulation:
    """A mass on a cord that weight keeps taut: linear, x = L + m g/k + amplitude cos(omega t)."""
    scene = Scene(None, None, [Gravity((10.0, 0.0, 0.0))], [cord()])
    sim = Simulation(scene, integrator, dt)
    sim.positions = [[0.0, 0.0, 0.0], [1.1 + amplitude, 0.0, 0.0]]
    return sim


def test_an_unknown_integrator_is_refused_with_the_names_of_all() -> None:
    with pytest.raises(InputError) as caught:
        oscillator("no such method", 1e-3)
    known = str(caught.value).split("choose one of: ")[1]
    assert {name.strip() for name in known.split(",")} == set(METHODS)


@pytest.mark.parametrize("name", METHODS)
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
        assert sim.evaluation_count == count * METHODS[name].evaluations + METHODS[name].evaluations_at_start
    # Below 1e-13 m the error is rounding.
    above = [error for error in errors if error > 1e-13]
    assert len(above) >= 3
    assert rates(above) == pytest.approx(METHODS[name].order, abs=0.05)


@pytest.mark.parametrize("name", METHODS)
def test_stable_step_is_the_limit(name: str) -> None:
    sim = oscillator(name, 1e-3)
    if name in UNLIMITED:
        assert sim.stable_dt() == math.inf
        assert integrators()[name].real_limit == math.inf
    assert sim.stable_dt() * OMEGA == pytest.approx(METHODS[name].imaginary_limit, rel=1e-5)
    assert "tethers" in sim.limiting_part


@pytest.mark.parametrize("name", LIMITED)
def test_bounded_below_the_limit_and_not_above(name: str) -> None:
    limit = METHODS[name].imaginary_limit / OMEGA
    sim = oscillator(name, 0.999 * limit)
    sim.step(10_000)
    assert abs(sim.positions[1, 0] - 1.1) <= 0.0101
    sim = oscillator(name, 1.01 * limit)
    with pytest.raises(UnstableError, match="above the stability limit"):
        # Beyond its limit a method may grow by less than 1e-5 per step, as dopri5 does.
        sim.step(2_000_000)


def test_loss_of_amplitude_per_step_of_rk4() -> None:
    # |R(i z)|^2 = 1 - z^6/72 + z^8/576, so the loss per step is z^6/144 (1 + O(z^2)): 1 % at z = 0.2.
    z, steps = 0.2, 20_000
    sim = oscillator("rk4", z / OMEGA)
    sim.step(steps)
    amplitude = math.hypot(sim.positions[1, 0] - 1.1, sim.velocities[1, 0] / OMEGA) / 0.01
    assert -math.log(amplitude) / steps == pytest.approx(z**6 / 144, rel=0.02)
    assert -math.log(amplitude) / steps == pytest.approx(-0.5 * math.log(1 - z**6 / 72 + z**8 / 576), rel=1e-6)


@pytest.mark.parametrize("name", LIMITED)
def test_limit_of_a_uniform_chain(name: str) -> None:
    # Springs k between masses m: omega_max = 2 sqrt(k/m) cos(pi/(2 n)), so dt < limit/2 sqrt(m/k) (RK4:
    # 1.414). Its last mass is half of the others, as half a segment hangs on it: omega_max is that of a
    # chain of 2 n springs.
    n, stiffness, mass = 40, 1000.0, 1e-3
    part = cord(segments=n, axial_stiffness=stiffness / n, linear_density=mass * n, tip_mass=0.0)
    scene = Scene(None, None, [Gravity((5.0, 0.0, 0.0))], [part])
    unit = math.sqrt(mass / stiffness)
    sim = Simulation(scene, name, 1e-6)
    expected = METHODS[name].imaginary_limit / 2 * unit
    assert sim.stable_dt() == pytest.approx(expected, rel=2e-3)
    # Seen to be so: a chain hung taut (tension of the mass below each spring), its fastest mode barely
    # excited.
    below = mass * (n - 0.5 - np.arange(n))
    stretched = 1.0 / n + 5.0 * below / stiffness
    positions = np.zeros((n + 1, 3))
    positions[1:, 0] = np.cumsum(stretched)
    velocities = np.zeros_like(positions)
    velocities[1:, 0] = 1e-6 * (-1.0) ** np.arange(n)
    # Beyond its limit dopri5 amplifies by little in a step.
    beyond = 1.1 if name == "dopri5" else 1.02
    for factor, bounded in ((0.99, True), (beyond, False)):
        sim = Simulation(scene, name, factor * expected)
        sim.positions = positions
        sim.velocities = velocities
        if bounded:
            sim.step(20_000)
            assert np.abs(sim.positions - positions).max() < 1e-6
        else:
            with pytest.raises(UnstableError):
                sim.step(120_000 if name == "dopri5" else 20_000)


@pytest.mark.parametrize("share", [0.1, 0.4, 0.95])
def test_leapfrog_swings_about_the_energy_and_does_not_drift(share: float) -> None:
    # It keeps v^2/2 + omega^2 x^2/2 (1 - z^2/4), so the energy swings by z^2/4 of the largest potential energy.
    sim = oscillator("leapfrog", 2.0 * share / OMEGA)
    start = math.fsum(sim.energies().values())
    potential = 0.5 * (OMEGA * 0.01) ** 2
    worst = []
    for _ in range(3):
        sim.step(100_000)
        off = []
        for _ in range(200):
            sim.step()
            off.append(math.fsum(sim.energies().values()) - start)
        worst.append(max(map(abs, off)) / potential)
    assert worst == pytest.approx([share**2] * 3, rel=0.05)


ADAPTIVE = [name for name, facts in integrators().items() if facts.is_adaptive]


def whirled(**settings: Any) -> Scene:
    """The tip mass on its cord, as a scene of 0.3 s."""
    scene = scenes.load("spinning-tether")
    return replace(scene, run=RunSettings(until=0.3, samples=31, frames=4, snapshots=(), **settings))


@pytest.mark.parametrize("name", ADAPTIVE)
def test_an_adaptive_run_looks_at_the_instants_that_were_asked_for(name: str) -> None:
    class Look:
        def __init__(self) -> None:
            self.samples: list[float] = []
            self.frames: list[float] = []

        def start(self, sim: Simulation) -> None:
            assert sim.time == 0.0

        def sample(self, sim: Simulation) -> None:
            self.samples.append(sim.time)

        def frame(self, sim: Simulation) -> None:
            self.frames.append(sim.time)

        def finish(self, sim: Simulation, error: BaseException | None) -> None:
            assert error is None

    look = Look()
    sim = Simulation(whirled(), name)
    assert sim.is_adaptive
    sim.run(observers=[look])
    assert look.samples == pytest.approx(np.linspace(0.0, 0.3, 31), rel=1e-11)
    assert look.frames == pytest.approx([0.0, 0.1, 0.2, 0.3], rel=1e-11)
    tries = sim.step_count + sim.rejected_count
    assert sim.evaluation_count == METHODS[name].evaluations * tries + METHODS[name].evaluations_at_start


@pytest.mark.parametrize("name", ADAPTIVE)
def test_an_adaptive_run_does_not_depend_on_who_looks_when(name: str, tmp_path: Path) -> None:
    whole = Simulation(whirled(), name)
    whole.run()
    cut = Simulation(whirled(), name)
    for until in (0.0123, 0.1, 0.2345, 0.3):
        cut.run(until=until, samples=7, frames=3)
        cut.save(tmp_path / "state.npz")
        cut = Simulation.restore(tmp_path / "state.npz")
        assert cut.is_adaptive
        assert cut.time == until
    assert (cut.positions == whole.positions).all()
    assert (cut.velocities == whole.velocities).all()
    assert cut.ledger() == whole.ledger()
    assert cut.evaluation_count == whole.evaluation_count
    assert cut.rejected_count == whole.rejected_count
    for each in (cut, whole):
        each.step(3)
    assert cut.time == whole.time > 0.3
    assert (cut.positions == whole.positions).all()


@pytest.mark.parametrize("name", ADAPTIVE)
def test_tolerance_sets_error_and_cost(name: str) -> None:
    def end(tolerance: float) -> tuple[Any, int]:
        sim = Simulation(whirled(tolerance=tolerance), name)
        sim.run()
        return sim.positions, sim.evaluation_count

    exact = end(1e-13)[0]
    # From 1e-10 up it is stability that bounds these steps, not the tolerance.
    (coarse, few), (fine, many) = (end(tolerance) for tolerance in (1e-6, 1e-11))
    errors = [float(np.abs(found - exact).max()) for found in (coarse, fine)]
    assert errors[1] < 1e-7
    assert errors[1] < 0.1 * errors[0]
    assert 1.2 * few < many


@pytest.mark.parametrize("name", ADAPTIVE)
def test_a_given_step_is_kept(name: str) -> None:
    sim = Simulation(whirled(dt=2e-5), name)
    assert not sim.is_adaptive
    sim.run()
    assert sim.time == pytest.approx(sim.step_count * 2e-5, rel=1e-15)
    assert sim.rejected_count == 0


@pytest.mark.parametrize("name", METHODS)
def test_the_release_of_a_sail_keeps_its_energy_balance(name: str) -> None:
    sim = Simulation(scenes.load("okuizumi-model-1"), name)
    if name == "leapfrog":
        sim = Simulation(sim.scene, name, 0.5 * sim.stable_dt())
    if name in UNLIMITED:
        # Wrinkles form all the time: long steps misjudge them.
        sim = Simulation(sim.scene, name, 1e-5)
    sim.run(until=3e-3, frames=2, samples=301)
    assert abs(sim.ledger()["error"]) < 0.01


@pytest.mark.parametrize("name", METHODS)
def test_save_and_restore_continue_with_the_same_bits(name: str, tmp_path: Path) -> None:
    scene = replace(hanging_strip(), laws=[Gravity((0.0, 0.0, -9.81)), SpringDamping(0.1), *hanging_strip().laws[:1]])
    sims = [Simulation(scene, name) for _ in range(2)]
    sims[0].step(300)
    sims[1].step(123)
    sims[1].save(tmp_path / "state.npz")
    sims[1] = Simulation.restore(tmp_path / "state.npz")
    sims[1].step(177)
    a, b = sims
    assert a.time == b.time
    assert (a.positions == b.positions).all()
    assert (a.velocities == b.velocities).all()
    assert a.ledger() == b.ledger()


def test_time_is_a_multiple_of_the_step() -> None:
    sim = oscillator("rk4", 1e-4)
    for _ in range(1000):
        sim.step()
    assert sim.time == 1000 * 1e-4
    assert sim.step_count == 1000
