"""A hub that turns by a schedule: exact motions, angle, bounds of the step, work, restart, wrong input."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    AirDrag,
    Gravity,
    InputError,
    Material,
    RunSettings,
    Scene,
    Schedule,
    Simulation,
    Spin,
    SpringDamping,
    Springs,
    Tether,
)
from membrane_rs.check import audit
from membrane_rs.folding import Strip
from membrane_rs.scene.scales import hub_frequency
from methods import METHODS, ORDER, WAYS

UP = Schedule((0.02, 0.1, 0.2, 0.3), (1.0, 4.0, 4.0, -2.0), 0.4)
FILM = Material(youngs_modulus=3.2e9, poisson_ratio=0.34, density=1420.0, thickness=7.5e-6)


def whirled(spin: Spin, *more: Any, **run: Any) -> Scene:
    """A mass on a cord that a hub turns."""
    tether = Tether((0.1, 0.0, 0.0), (0.2, 0.0, 0.0), 2, 17.0, 1e-3, tip_mass=0.05, strain_limit=10.0)
    return Scene(None, None, [spin, *more], [tether], run=RunSettings(**run))


def angle_of(schedule: Schedule, time: float) -> float:
    """The angle by the rule of order 4 [rad]."""
    times = np.linspace(0.0, time, 20_001)
    values = np.array([schedule.at(t) for t in times])
    return 2.0 * math.pi * float(times[1]) / 3.0 * float(np.sum(values[:-2:2] + 4.0 * values[1:-1:2] + values[2::2]))


@pytest.mark.parametrize("method", METHODS)
def test_hub_angle_is_the_integral(method: str) -> None:
    """At any time, before, between and after the knots."""
    sim = Simulation(whirled(Spin(schedule=UP)), method, dt=2e-4)
    for time in (0.013, 0.05, 0.1, 0.1505, 0.25, 0.3, 0.4):
        sim.reach(time)
        assert sim.hub_angle == pytest.approx(angle_of(UP, time), abs=2e-7)


@pytest.mark.parametrize(("method", "substeps"), WAYS)
def test_free_node_goes_straight_in_space(method: str, substeps: int) -> None:
    """However the hub turns: centrifugal force and those of Coriolis and Euler make a straight line."""
    errors = []
    for dt in (2e-3, 1e-3):
        tether = Tether((0.1, 0.0, 0.0), (0.10001, 0.0, 0.0), 1, 1e-6, 0.0, fixed=False, tip_mass=1e-3)
        masses = dataclasses.replace(tether, linear_density=1.0)
        scene = Scene(None, None, [Spin(schedule=UP)], [masses], run=RunSettings(substeps=substeps, energy_loss=1e3))
        sim = Simulation(scene, method, dt=dt)
        velocities = np.zeros((2, 3))
        start = sim.masses @ sim.positions[:, 0] / sim.masses.sum()
        velocities[:, 1] = -2.0 * math.pi * start * UP.at(0.0) + 0.3
        sim.velocities = velocities
        sim.reach(0.3)
        turn = sim.hub_angle
        middle = sim.masses @ sim.positions / sim.masses.sum()
        seen = [
            math.cos(turn) * middle[0] - math.sin(turn) * middle[1],
            math.sin(turn) * middle[0] + math.cos(turn) * middle[1],
        ]
        errors.append(math.dist(seen, (start, 0.09)))
    assert errors[1] < (5e-4 if ORDER[method] == 2 else 1e-7)
    assert math.log2(errors[0] / errors[1]) > ORDER[method] - 1.0


@pytest.mark.parametrize("method", METHODS)
def test_linear_schedule_is_an_acceleration(method: str) -> None:
    """The same motion, energies and work; gravity and air turn with the frame."""
    more = (Gravity((0.5, -0.3, -1.0)),)
    ramp = Schedule((0.0, 1.0), (3.0, 1.0))
    sims = [Simulation(whirled(spin, *more), method, dt=2e-4) for spin in (Spin(3.0, -2.0), Spin(schedule=ramp))]
    for sim in sims:
        sim.reach(0.2)
    first, second = sims
    assert second.positions == pytest.approx(first.positions, abs=1e-11)
    assert second.hub_angle == pytest.approx(first.hub_angle, abs=1e-13)
    for law, work in first.ledger()["work_by_law"].items():
        assert second.ledger()["work_by_law"][law] == pytest.approx(work, abs=1e-11)


@pytest.mark.parametrize("method", METHODS)
def test_constant_schedule_is_a_frequency(method: str) -> None:
    """Bit by bit, with a film in air."""
    mesh, laws = Strip(0.05, 0.02, 5, 2, (0.4,), 0.6).mesh(), [Springs(), SpringDamping(0.01), AirDrag()]
    found = []
    for spin in (Spin(3.0), Spin(schedule=Schedule((0.5,), (3.0,)))):
        sim = Simulation(Scene(mesh, FILM, [*laws, spin], []), method, dt=2e-6)
        sim.step(300)
        found.append(sim.positions)
    assert np.array_equal(found[0], found[1])


@pytest.mark.parametrize("method", METHODS)
def test_energy_is_balanced(method: str) -> None:
    """By the work of the hub's motor: spun up, and stopped."""
    sim = Simulation(whirled(Spin(schedule=UP)), method, dt=2e-4)
    sim.reach(0.3)
    balance = sim.ledger()
    assert abs(balance["work_by_law"]["spin"]) > 0.1
    assert abs(balance["error"]) < (1e-3 if ORDER[method] == 2 else 1e-5)


@pytest.mark.parametrize(("method", "substeps"), WAYS)
def test_step_is_bounded_by_the_largest_rate(method: str, substeps: int) -> None:
    """The limit and the default step are those of the fastest hub, from the start on."""
    run = {"substeps": substeps, "integrator": method, **({"dt": 1e-5} if method == "dopri5" else {})}
    rising = Simulation(whirled(Spin(schedule=Schedule((1.0, 2.0), (0.0, 40.0))), **run))
    fast = Simulation(whirled(Spin(40.0), **run))
    assert rising.stable_dt() == pytest.approx(fast.stable_dt(), rel=1e-9)
    assert rising.slow_laws == fast.slow_laws
    # Its response at the start is that of a hub at rest; the slow motion is bounded by its largest rate.
    assert rising.dt <= Simulation(whirled(Spin(0.0), **run)).dt
    bound = whirled(Spin(40.0), **run)
    assert hub_frequency(bound) == hub_frequency(rising.scene) == 40.0


@pytest.mark.parametrize("method", METHODS)
def test_goes_on_from_another_simulation(method: str) -> None:
    """At its angle, by a schedule that counts from there; and to the same bits from its own state."""
    scene = whirled(Spin(schedule=UP))
    whole, first = (Simulation(scene, method, dt=2e-4) for _ in range(2))
    for sim in (whole, first):
        sim.reach(0.15)
    turned = first.hub_angle
    later = Schedule((0.0, 0.1), (4.0, 0.0), 0.2).delayed(0.15)
    after = Simulation(whirled(Spin(schedule=later)), method, dt=2e-4, start=first)
    assert after.hub_angle == pytest.approx(turned, abs=1e-14)
    after.reach(0.25)
    assert after.hub_angle == pytest.approx(turned + 2.0 * math.pi * 0.5 * (4.0 + 0.0) * 0.1, abs=1e-12)
    again = Simulation(scene, method, dt=2e-4)
    again.set_state(first.state())
    for sim in (whole, again):
        sim.reach(0.3)
    assert np.array_equal(again.positions, whole.positions)
    assert again.hub_angle == whole.hub_angle


def test_hub_stands_still_while_a_scene_is_relaxed() -> None:
    """At the rate of the start."""
    sim = Simulation(whirled(Spin(schedule=Schedule((0.1, 0.2), (2.0, 30.0))), relax=1.0, relax_rate=20.0), dt=2e-4)
    sim.relax()
    pull = 0.05 * (2.0 * math.pi * 2.0) ** 2 * sim.positions[-1, 0]
    assert sim.positions[-1, 0] - 0.2 == pytest.approx(0.1 * pull / 17.0, rel=0.02)
    assert sim.hub_angle == 0.0


def test_checks_judge_the_largest_rate() -> None:
    """A rim that is torn at the top of the schedule; a hub that never turns."""
    mesh = Strip(0.5, 0.02, 5).mesh()
    fast = Scene(mesh, FILM, [Springs(), Spin(schedule=Schedule((0.0, 1.0), (1.0, 900.0)))], [])
    found = [finding for finding in audit(fast).findings if "laws.spin.schedule" in finding.message]
    assert found
    assert "900 Hz" in found[0].message
    rest = Spin(schedule=Schedule((0.0, 1.0), (0.0, 0.0)))
    assert rest.why_idle(fast) == "the hub does not turn"
    assert Spin(schedule=UP).why_idle(fast) is None
    long = Scene(
        mesh, FILM, [Springs(), Spin(schedule=Schedule((0.0, 1.0), (0.0, 2.0)))], [], run=RunSettings(until=1e4)
    )
    assert any("turns in this run" in finding.message for finding in audit(long).findings)


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "acceleration": ({"acceleration": 1.0, "schedule": UP}, r"Spin\.acceleration = 1\.0: is not used with a schedule"),
    "frequency": ({"frequency": 2.0, "schedule": UP}, r"Spin\.frequency = 2\.0: is not used with a schedule"),
    "default": ({"frequency": 3.0, "schedule": UP}, r"Spin\.frequency = 3\.0: is not used with a schedule"),
    "kind": ({"schedule": 3.0}, r"Spin\.schedule = 3\.0: must be a Schedule"),
    "knot": ({"schedule": {"times": [0, 1], "values": [0, None]}}, r"Spin\.schedule\.values\[1\] = None: must be a nu"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_input_is_named(case: str) -> None:
    """Key, value and remedy."""
    values, message = WRONG[case]
    with pytest.raises(InputError, match=message):
        Spin(**values)


def test_rate_beyond_numbers_is_refused_by_the_core() -> None:
    """Where 2 pi times it overflows."""
    with pytest.raises(InputError, match="rate of spin by its schedule"):
        Simulation(whirled(Spin(schedule=Schedule((0.0,), (1e308,)))), "rk4", dt=1e-4)


def test_scene_files_hold_the_schedule(tmp_path: Any) -> None:
    """Written and read again, and errors with their key."""
    scene = whirled(Spin(schedule=UP))
    scene.save(tmp_path)
    file = tmp_path / "scene.toml"
    text = file.read_text()
    assert "schedule = {times = [0.02, 0.1, 0.2, 0.3], values = [1.0, 4.0, 4.0, -2.0], ease = 0.4}  # Hz" in text
    assert Scene.from_toml(file).laws == scene.laws
    file.write_text(text.replace("ease = 0.4", "ease = 0.9"))
    with pytest.raises(InputError, match=r"laws\.spin\.schedule\.ease = 0\.9: must be at least 0 and at most 0\.5"):
        Scene.from_toml(file)
