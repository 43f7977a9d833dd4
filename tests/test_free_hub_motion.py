"""A hub that turns freely in motion: through stages, from other motions and saved states, to rest and to a rate."""

from __future__ import annotations

import math
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    AirDrag,
    InputError,
    MassDamping,
    RunSettings,
    Scene,
    Schedule,
    Simulation,
    Spin,
    Springs,
    Stage,
    Tether,
    resume,
    run,
    scenes,
)
from membrane_rs.folding import Disc
from membrane_rs.results import read_history, read_summary
from small_scenes import RUBBER

INERTIA = 0.004
FREE = Spin(2.0, inertia=INERTIA)
METHODS_OF_FREE = ("leapfrog", "rk4")
UP = Schedule((0.0, 0.05), (1.0, 3.0), 0.5)


def whirled(spin: Spin, *stages: Stage, swing: float = 0.05, **run: Any) -> Scene:
    """A mass on a cord, off the radial direction, that a hub turns: of 0.002 kg m2 about the axis."""
    tether = Tether((0.1, 0.0, 0.0), (0.2, swing, 0.0), 2, 17.0, 1e-3, tip_mass=0.05, strain_limit=10.0)
    settings = RunSettings(
        **{"until": 0.1, "frames": 3, "samples": 11, "snapshots": (), "integrator": "leapfrog", **run}
    )
    return Scene(None, None, [spin], [tether], stages=stages, run=settings, name="whirled")


def key(**values: Any) -> dict[str, Any]:
    return {f"laws.spin.{name}": value for name, value in values.items()}


def momentum_in_space(sim: Simulation) -> float:
    """Of all nodes about the axis, by their positions and velocities [kg m2/s]."""
    (x, y, _), (u, v, _) = sim.positions.T, sim.velocities.T
    return float(sim.masses @ (x * (v + sim.hub_rate * x) - y * (u - sim.hub_rate * y)))


@pytest.mark.parametrize("method", METHODS_OF_FREE)
def test_the_momentum_is_that_of_hub_and_nodes(method: str) -> None:
    sim = Simulation(whirled(FREE), method)
    sim.reach(0.05)
    found = sim.angular_momentum()
    assert found.hub == pytest.approx(INERTIA * sim.hub_rate, rel=1e-12)
    assert found.sail == pytest.approx(momentum_in_space(sim), rel=1e-12)
    assert found.total == found.hub + found.sail
    before = Simulation(whirled(FREE), method)
    assert found.total == pytest.approx(before.angular_momentum().total, rel=1e-9)
    assert abs(sim.hub_rate - before.hub_rate) > 1e-3 * before.hub_rate


@pytest.mark.parametrize("method", METHODS_OF_FREE)
def test_the_momentum_of_a_driven_hub_is_that_of_the_nodes(method: str) -> None:
    sim = Simulation(whirled(Spin(schedule=UP)), method)
    sim.reach(0.03)
    found = sim.angular_momentum()
    assert found.hub == 0.0
    assert found.sail == pytest.approx(momentum_in_space(sim), rel=1e-12)


@pytest.mark.parametrize("method", METHODS_OF_FREE)
def test_the_motor_of_a_driven_hub_changes_the_momentum(method: str) -> None:
    """By its torque, summed over the steps of a spin-up; its power is that torque times the rate."""
    sim = Simulation(whirled(Spin(schedule=UP)), method, dt=2e-5)
    before, torques = sim.angular_momentum().total, []
    for _ in range(2501):
        torques.append(sim.hub_motor().torque)
        assert sim.hub_motor().power == torques[-1] * sim.hub_rate
        now = sim.angular_momentum().total
        sim.step()
    given = 2e-5 * (sum(torques) - 0.5 * (torques[0] + torques[-1]))
    assert given == pytest.approx(now - before, rel=1e-3)
    assert abs(now - before) > 1e-3 * before


def test_the_motor_of_a_free_hub_is_its_torque() -> None:
    torque = Schedule((0.0, 0.1), (0.0, 0.02))
    sim = Simulation(whirled(replace(FREE, torque=torque)))
    assert (sim.hub_motor().torque, sim.hub_motor().power) == (0.0, 0.0)
    before = sim.angular_momentum().total
    sim.reach(0.08)
    motor = sim.hub_motor()
    assert motor.torque == pytest.approx(0.016, rel=1e-12)
    assert motor.power == pytest.approx(motor.torque * sim.hub_rate, rel=1e-12)
    assert sim.angular_momentum().total - before == pytest.approx(torque.integral(0.0, 0.08), rel=1e-6)
    assert Simulation(whirled(FREE)).hub_motor().torque == 0.0
    history = run(whirled(replace(FREE, torque=torque)), samples=2001).history
    power, time = history["motor_power"], history["time"]
    assert history["motor_work"][-1] == pytest.approx(
        float(((power[1:] + power[:-1]) * np.diff(time)).sum() / 2), rel=1e-5
    )


@pytest.mark.parametrize("method", METHODS_OF_FREE)
def test_a_hub_is_spun_up_and_then_set_free(method: str) -> None:
    """Its rate goes over from stage to stage, and the momentum is conserved once it is free."""
    stages = (
        Stage("spin up", 0.05, set=key(schedule=UP)),
        Stage("free", 0.05, set=key(inertia=INERTIA)),
        Stage("heavier cord", 0.05, scale={"parts.0.axial_stiffness": 2.0}),
        Stage("driven", 0.05, set=key(inertia=None, frequency=1.5)),
    )
    sim = Simulation(whirled(Spin(1.0), *stages), method)
    sim.reach(0.05)
    assert sim.stage_name == "free"
    assert sim.hub_rate == pytest.approx(3.0 * math.tau, rel=1e-12)
    total = sim.angular_momentum().total
    for time in (0.08, 0.1, 0.13, 0.15 - 1e-9):
        sim.reach(time)
        assert sim.angular_momentum().total == pytest.approx(total, rel=1e-8)
    rate = sim.hub_rate
    assert abs(rate - 3.0 * math.tau) > 1e-2
    sail = sim.angular_momentum().sail
    sim.reach(0.15 + 1e-9)
    assert sim.stage_name == "driven"
    assert sim.hub_rate == pytest.approx(1.5 * math.tau, rel=1e-12)
    # The nodes keep their velocities in space, but for the one that the hub holds.
    held = sim.masses[0] * 0.1**2 * (sim.hub_rate - rate)
    assert sim.angular_momentum().sail == pytest.approx(sail + held, rel=1e-8)
    sim.reach(0.2)
    assert sim.is_over


def test_a_stage_ends_at_a_rate_of_the_hub() -> None:
    torque = Schedule((0.0,), (-0.02,))
    stages = (
        Stage("slow down", 1.0, measure="hub_rate", below=10.0, set=key(torque=torque)),
        Stage("on", 0.05, set=key(torque=None)),
    )
    sim = Simulation(whirled(FREE, *stages))
    sim.run()
    first = sim.stages[0]
    assert first.ended_by == "measure"
    again = Simulation(whirled(FREE, *stages))
    again.reach(first.end)
    assert again.hub_rate == pytest.approx(10.0, rel=1e-9)
    stopped = run(whirled(replace(FREE, torque=torque), until=1.0), stop_when="hub_rate < 90 rpm")
    assert stopped.history["hub_rate"][-1] == pytest.approx(3.0 * math.pi, rel=1e-9)


@pytest.mark.parametrize("method", METHODS_OF_FREE)
def test_it_goes_on_from_a_saved_state_with_the_same_bits(method: str, tmp_path: Path) -> None:
    stages = (Stage("up", 0.05, set=key(schedule=UP)), Stage("free", 0.05, set=key(inertia=INERTIA)))
    for scene in (whirled(FREE, integrator=method), whirled(Spin(1.0), *stages, integrator=method)):
        whole = Simulation(scene)
        for time in (0.03005, 0.0712):
            whole.reach(time)
            whole.save(tmp_path / "state.npz")
            again = Simulation.restore(tmp_path / "state.npz")
            for sim in (whole, again):
                sim.reach(time + 0.01)
            assert np.array_equal(again.positions, whole.positions)
            assert (again.hub_rate, again.hub_angle) == (whole.hub_rate, whole.hub_angle)
            assert again.ledger() == whole.ledger()
            assert again.angular_momentum().total == whole.angular_momentum().total


@pytest.mark.parametrize("method", METHODS_OF_FREE)
def test_it_goes_on_from_another_motion_at_its_rate(method: str) -> None:
    first = Simulation(whirled(FREE), method)
    first.reach(0.04)
    second = Simulation(whirled(replace(FREE, frequency=7.0)), method, start=first)
    assert second.hub_rate == pytest.approx(first.hub_rate, rel=1e-14)
    assert second.hub_angle == pytest.approx(first.hub_angle, rel=1e-14)
    assert second.angular_momentum().total == pytest.approx(first.angular_momentum().total, rel=1e-12)
    driven = Simulation(whirled(Spin(1.0)), method, start=first)
    assert driven.hub_rate == pytest.approx(math.tau, rel=1e-14)


def test_a_run_is_resumed(tmp_path: Path) -> None:
    stages = (Stage("up", 0.05, set=key(schedule=UP)), Stage("free", 0.05, set=key(inertia=INERTIA)))
    scene = whirled(Spin(1.0), *stages)
    Simulation(scene).run(out=tmp_path / "whole", pictures=False)
    Simulation(scene).run(until=0.07, out=tmp_path / "part", pictures=False, samples=8)
    resume(tmp_path / "part", until=0.1)
    whole, part = (read_history(tmp_path / name) for name in ("whole", "part"))
    assert list(part) == list(whole)
    for name in ("hub_rate", "hub_momentum", "sail_momentum", "motor_torque"):
        assert part[name][-1] == whole[name][-1]
    summary = read_summary(tmp_path / "part")
    assert summary["momentum_error"] < 1e-9
    assert whole["hub_momentum"][0] == 0.0 < whole["hub_momentum"][-1]


def test_a_relaxed_start_keeps_the_rate() -> None:
    mesh = Disc(0.1, 2).mesh()
    scene = Scene(mesh, RUBBER, [Springs(), Spin(2.0, inertia=1e-3)], [], run=RunSettings(integrator="leapfrog"))
    driven = replace(scene, laws=[Springs(), Spin(2.0)])
    free, held = Simulation(scene), Simulation(driven)
    for sim in (free, held):
        sim.relax(0.2, 50.0)
    assert np.array_equal(free.positions, held.positions)
    assert free.hub_rate == pytest.approx(2.0 * math.tau, rel=1e-14)
    assert free.is_relaxed


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"integrator": "dopri5"}, "dopri5"),
        ({"integrator": "generalized_alpha"}, "generalized_alpha"),
        ({"substeps": 2}, "substeps"),
    ],
)
def test_what_moves_no_hub_is_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        Simulation(whirled(FREE, **changes))


def test_a_copy_and_a_pickle_go_on() -> None:
    sim = Simulation(whirled(FREE))
    sim.reach(0.03)
    other = deepcopy(sim)
    for one in (sim, other):
        one.reach(0.05)
    assert (other.hub_rate, other.angular_momentum().total) == (sim.hub_rate, sim.angular_momentum().total)


def test_a_very_heavy_hub_turns_as_a_driven_one() -> None:
    """The paper's first sail, for some steps."""
    scene = scenes.load("okuizumi-model-1")
    laws = [law for law in scene.laws if law.kind not in ("spin", "air_drag")]
    spin, found = scene.law(Spin), []
    assert spin is not None
    for one in (spin, replace(spin, inertia=1e3)):
        settings = replace(scene.run, integrator="leapfrog", dt=None, substeps=1)
        sim = Simulation(replace(scene, laws=[*laws, one], run=settings))
        sim.step(200)
        found.append(sim.positions)
    assert found[1] == pytest.approx(found[0], abs=1e-9)


def test_air_takes_momentum() -> None:
    scene = Scene(Disc(0.1, 2).mesh(), RUBBER, [Springs(), Spin(2.0, inertia=1e-5), AirDrag()], [])
    found = run(replace(scene, run=RunSettings(until=0.02, integrator="rk4")))
    assert found.summary["momentum_error"] is None
    assert "hub_rate" in found.history


def test_a_slow_change_of_shape_takes_the_energy_that_momentum_leaves() -> None:
    """A mass creeps out along a soft cord: w1 = w0 (I + J0)/(I + J1), and L^2/2 (1/(I + J0) - 1/(I + J1)) is lost or
    stored.
    """
    inertia, mass = 2e-3, 0.05
    cord = Tether((0.1, 0.0, 0.0), (0.2, 0.0, 0.0), 1, 2.0, 0.0, tip_mass=mass, strain_limit=10.0)
    run = RunSettings(until=20.0, integrator="leapfrog", dt=2e-4)
    sim = Simulation(Scene(None, None, [Spin(2.0, inertia=inertia), MassDamping(100.0)], [cord], run=run))
    rate, start = sim.hub_rate, mass * 0.2**2
    sim.reach(20.0)
    end = mass * float(np.square(sim.positions[1, :2]).sum())
    assert end > 1.5 * start
    assert sim.hub_rate == pytest.approx(rate * (inertia + start) / (inertia + end), rel=2e-6)
    momentum = rate * (inertia + start)
    freed = 0.5 * momentum**2 * (1.0 / (inertia + start) - 1.0 / (inertia + end))
    ledger = sim.ledger()
    lost, stored = -ledger["work_by_law"]["mass_damping"], ledger["stored_by_law"]["tethers"]
    assert min(lost, stored) > 0.1 * freed
    assert lost + stored == pytest.approx(freed, rel=1e-4)
