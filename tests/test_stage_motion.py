"""Motions through stages, against solutions in closed form."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from membrane_rs import Fixed, Gravity, Scene, Simulation, Spin, Stage, TipMasses, integrators
from small_scenes import Floats, cord, rates
from staged_scenes import AMPLITUDE, PULL, STIFFNESS, extension, free, oscillator, started

SOFT = {"parts.spring.axial_stiffness": 0.5}
METHODS = ("rk4", "leapfrog", "dopri5", "generalized_alpha")


@pytest.mark.parametrize("boundary", [0.25, 0.2503127, 1e-5])
def test_a_spring_half_as_stiff_from_a_boundary_on(boundary: float) -> None:
    sim = started(oscillator(free("stiff", boundary), free("soft", 0.7, scale=SOFT)), "rk4", 1e-3)
    sim.reach(boundary)
    assert (sim.stage, sim.stage_name, sim.time, sim.boundaries) == (1, "soft", boundary, [boundary])
    at_boundary = extension(boundary)
    changes = sim.ledger()["changes"]
    assert changes == {"soft: tethers": pytest.approx(-0.25 * STIFFNESS * at_boundary[0] ** 2, rel=1e-9)}
    for time in (boundary + 0.1, boundary + 0.3333, boundary + 0.7):
        sim.reach(time)
        expected = extension(time - boundary, 0.5 * STIFFNESS, at_boundary)
        assert sim.positions[1, 0] - 1.0 == pytest.approx(expected[0], abs=1e-8)
        assert sim.velocities[1, 0] == pytest.approx(expected[1], abs=1e-7)
    assert sim.is_over
    assert abs(sim.ledger()["error"]) < 1e-7


@pytest.mark.parametrize("integrator", METHODS)
def test_the_time_at_which_a_measure_passes_its_value_converges_with_the_method(integrator: str) -> None:
    # The mass rises from its lowest place; it passes its equilibrium after a quarter of the period.
    scene = oscillator(
        free("rise", 1.0, measure=lambda sim: float(sim.positions[1, 0]), below=1.0 + PULL / STIFFNESS),
        free("on", 0.1, scale=SOFT),
    )
    exact = 0.5 * math.pi / math.sqrt(STIFFNESS)
    steps = (4e-3, 2e-3, 1e-3)
    errors = []
    for dt in steps:
        sim = started(scene, integrator, dt)
        sim.reach(0.2)
        assert sim.stages[0].ended_by == "measure"
        errors.append(sim.boundaries[0] - exact)
    order = integrators()[integrator].order
    assert rates(errors)[-1] == pytest.approx(order, abs=0.3) or max(map(abs, errors)) < 1e-12
    assert abs(errors[-1]) < {2: 1e-5, 4: 1e-10, 5: 1e-12}[order]


def test_a_measure_is_met_to_rounding() -> None:
    level = 1.0 + PULL / STIFFNESS + 0.3 * AMPLITUDE
    stages = free("a", 1.0, measure=lambda sim: float(sim.positions[1, 0]), below=level), free("b", 0.5)
    for dt in (1e-3, 3.3e-3, 7e-3):
        sim = started(oscillator(*stages), "rk4", dt)
        sim.reach(0.4)
        sim = started(oscillator(*stages), "rk4", dt)
        while sim.stage == 0:
            sim.step()
        times = sim.boundaries
        sim = started(oscillator(*stages), "rk4", dt)
        sim.reach(times[0])
        assert sim.positions[1, 0] == pytest.approx(level, abs=1e-15)


def test_settled_until_the_kinetic_energy_is_small() -> None:
    # It starts at rest, so that the measure is beyond its value at once: it must come back first.
    damped = Stage("settle", 10.0, "kinetic_energy", below=1e-4)
    sim = started(oscillator(damped, free("on", 0.1)), "rk4", 1e-3)
    sim.run()
    end = sim.boundaries[0]
    assert 0.1 < end < 2.0
    record = sim.stages[0]
    assert record.ended_by == "measure"
    assert record.work_by_law["mass_damping"] < 0.0
    assert abs(record.error) < 1e-6
    assert sim.is_over  # its second stage has ended, too
    assert sim.time == pytest.approx(end + 0.1)


def test_what_is_let_go_falls_and_what_is_caught_stops() -> None:
    scene = oscillator(
        free("hang", 0.2),
        free("fall", 0.3, without=("hold",)),
        free("caught", 0.1),
    )
    sim = started(scene, "rk4", 1e-3)
    sim.reach(0.2)
    centre = sim.masses @ sim.positions / sim.masses.sum()
    speed = sim.masses @ sim.velocities / sim.masses.sum()
    sim.reach(0.45)
    now = sim.masses @ sim.positions / sim.masses.sum()
    assert now[0] == pytest.approx(centre[0] + 0.25 * speed[0] + 0.5 * PULL * 0.25**2, rel=1e-9)


def heavy(*stages: Stage) -> Scene:
    """Two masses on a spring in free fall."""
    part = cord(fixed=False, name="cord")
    parts = [part, TipMasses(3.0, (0,)), Fixed((0,), name="hold"), Fixed((1,), name="other")]
    return Scene(None, None, [Gravity((0.0, 0.0, -9.81))], parts, stages=stages)


def test_a_hold_placed_on_a_moving_node_books_the_energy_that_it_takes() -> None:
    sim = Simulation(heavy(Stage("fall", 0.5, without=("hold", "other")), Stage("held", 0.1, without=("other",))))
    sim.reach(0.5)
    moving = 0.5 * 3.0 * (9.81 * 0.5) ** 2
    assert sim.ledger()["changes"] == {"held: kinetic": pytest.approx(-moving, rel=1e-9)}
    assert (sim.velocities[0] == 0.0).all()
    assert sim.ledger()["kinetic"] == pytest.approx(0.5 * (9.81 * 0.5) ** 2, rel=1e-9)
    sim.reach(0.6)
    assert abs(sim.ledger()["error"]) < 1e-4


def test_two_holds_of_one_scene_take_turns() -> None:
    stages = (
        Stage("by one", 0.1, without=("other",)),
        Stage("by the other", 0.1, without=("hold",)),
        Stage("by both", 0.1),
    )
    sim = Simulation(heavy(*stages), dt=1e-3)
    for time, held in ((0.05, (0,)), (0.15, (1,)), (0.25, (0, 1))):
        sim.reach(time)
        assert tuple(sim.assembly.fixed) == held
        assert (sim.velocities[list(held)] == 0.0).all()


def test_the_balance_is_one_over_all_stages() -> None:
    scene = oscillator(
        Stage("damped", 0.3), free("soft", 0.31, scale=SOFT), free("fall", 0.1, without=("hold",)), Stage("end", 0.2)
    )
    sim = started(scene, "rk4", 1e-3)
    first = sum(sim.energies().values())
    for time in np.linspace(0.05, 0.9, 18):
        sim.reach(float(time))
        ledger, stages = sim.ledger(), sim.stages
        now = sum(sim.energies().values())
        residual = now - first - ledger["work"] - sum(ledger["changes"].values())
        assert ledger["error"] == pytest.approx(residual / ledger["reference_energy"], abs=1e-12)
        assert abs(ledger["error"]) < 1e-7
        assert ledger["work"] == pytest.approx(sum(sum(stage.work_by_law.values()) for stage in stages))
        assert ledger["reference_energy"] == max(stage.reference_energy for stage in stages)
    assert list(ledger["changes"]) == ["soft: tethers", "fall: tethers", "end: kinetic"]


def test_each_stage_has_its_own_method_and_step() -> None:
    stages = (
        free("one", 0.1),
        free("two", 0.1, set={"run.dt": 2e-3, "run.integrator": "leapfrog"}),
        free("three", 0.1, set={"run.integrator": "dopri5"}),
    )
    sim = started(oscillator(*stages, dt=1e-3))
    sim.reach(0.3)
    assert [(stage.integrator, stage.steps) for stage in sim.stages[:2]] == [("rk4", 100), ("leapfrog", 50)]
    assert (sim.stages[2].integrator, sim.stages[2].dt) == ("dopri5", 1e-3)
    assert sim.step_count == sum(stage.steps for stage in sim.stages)
    assert sim.evaluation_count == sum(stage.evaluations for stage in sim.stages)
    given = started(oscillator(*stages), "rk4", 5e-4)
    given.reach(0.3)
    assert [(stage.integrator, stage.dt) for stage in given.stages] == [
        ("rk4", 5e-4),
        ("leapfrog", 2e-3),
        ("dopri5", 5e-4),
    ]


def test_a_start_from_another_motion_begins_with_the_first_stage() -> None:
    other = started(oscillator(free("alone", 5.0)), "rk4", 1e-3)
    other.reach(0.4)
    sim = Simulation(oscillator(free("a", 0.1), free("b", 0.2, scale=SOFT)), "rk4", 1e-3, start=other)
    assert (sim.time, sim.stage) == (0.4, 0)
    sim.run()
    assert sim.time == pytest.approx(0.7)
    assert sim.boundaries == [0.5]
    assert np.isclose(sim.positions[1, 0] - 1.0, extension(0.2, 0.5 * STIFFNESS, extension(0.5))[0], atol=1e-8)


def test_a_stage_shorter_than_a_step() -> None:
    sim = started(oscillator(free("a", 1e-4), free("b", 2.5e-4), free("c", 0.1)), "leapfrog", 1e-3)
    sim.step(5)
    assert [stage.steps for stage in sim.stages] == [0, 0, 5]
    assert sim.time == 1e-4 + 2.5e-4 + 5e-3


@pytest.mark.parametrize("after", [{"laws.spin.frequency": 3.0}, {"laws.spin.frequency": -0.5}, None])
def test_nodes_keep_their_velocity_in_space_where_the_rate_of_the_hub_jumps(after: dict[str, Any] | None) -> None:
    part = cord(axial_stiffness=1e4, start=(0.2, 0.1, 0.0), end=(1.0, 0.3, 0.1), fixed=False, name="cord")
    parts = [part, TipMasses(2.0, (0,))]
    second = Stage("after", 0.05, without=("spin",)) if after is None else Stage("after", 0.05, set=after)
    sim = Simulation(Scene(None, None, [Spin(1.0)], parts, stages=[Stage("before", 0.05), second]), dt=1e-4)

    def in_space(sim: Simulation, rate: float) -> Floats:
        x, v = sim.positions, sim.velocities
        moving = v + 2.0 * np.pi * rate * np.stack([-x[:, 1], x[:, 0], 0.0 * x[:, 2]], axis=1)
        cosine, sine = np.cos(sim.hub_angle), np.sin(sim.hub_angle)
        found: Floats = moving @ np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        return found

    first = in_space(sim, 1.0)
    momentum = sim.masses @ first
    sim.reach(0.05 - 1e-9)
    before = in_space(sim, 1.0)
    sim.reach(0.05)
    rate = 0.0 if after is None else after["laws.spin.frequency"]
    assert in_space(sim, rate) == pytest.approx(before, abs=1e-4)
    assert sim.masses @ in_space(sim, rate) == pytest.approx(momentum, abs=1e-9)
    assert {"after: kinetic", "after: spin"} <= sim.ledger()["changes"].keys()
    sim.reach(0.1)
    assert sim.masses @ in_space(sim, rate) == pytest.approx(momentum, abs=1e-8)
    assert abs(sim.ledger()["error"]) < 1e-6
