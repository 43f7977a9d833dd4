"""Jumps of schedules: bodies, moved nodes and the hub's rate, against motions computed by hand; order, bits, stages."""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from killed_runs import contents, run_copied
from membrane_rs import (
    Cylinder,
    Fixed,
    Gravity,
    InputError,
    InputTypeError,
    Moved,
    Plane,
    RunSettings,
    Scene,
    Schedule,
    Simulation,
    Spin,
    Stage,
    UnstableError,
)
from membrane_rs.results import read_summary
from membrane_rs.runs import resume
from methods import METHODS, ORDER, WAYS
from small_scenes import Floats, cord, hanging_strip, rates

AT = 0.0312345
"""Time of a jump [s], at the end of no step."""
DEPTH, PENALTY = 0.01, 1000.0
"""By which a plane jumps into a mass of 1 kg [m], and its stiffness [N/m]."""
OMEGA = math.sqrt(PENALTY)


def jump(before: float, after: float, at: float = AT) -> Schedule:
    return Schedule((at, at), (before, after))


def pushed(travel: Schedule, *stages: Stage, **run: Any) -> Scene:
    """A mass without weight above a plane."""
    floor = Plane("floor", centre=(0.0, 0.0, -0.1), travel_z=travel, stiffness=PENALTY)
    settings = RunSettings(**{"until": 0.2, "frames": 3, "samples": 11, "snapshots": (), **run})
    return Scene(None, None, [], [cord(axial_stiffness=1e-9)], bodies=[floor], stages=stages, run=settings)


def height(time: float, at: float = AT) -> float:
    """Of the mass that the plane pushes out [m]: an oscillation until it leaves."""
    after = max(0.0, time - at)
    contact = min(after, 0.5 * math.pi / OMEGA)
    return DEPTH * (1.0 - math.cos(OMEGA * contact)) + DEPTH * OMEGA * (after - contact)


@pytest.mark.parametrize(("method", "substeps"), WAYS)
@pytest.mark.parametrize("at", [AT, 0.03])
def test_a_plane_that_jumps_into_a_mass_puts_in_the_energy_of_its_penalty(
    method: str, substeps: int, at: float
) -> None:
    sim = Simulation(pushed(jump(0.0, 0.1 + DEPTH, at), substeps=substeps), method, dt=1e-3)
    sim.reach(at - 1e-4)
    assert sim.energies() == {"kinetic": 0.0, "tethers": 0.0, "floor": 0.0}
    assert "changes" not in sim.ledger()
    sim.reach(at)
    booked = 0.5 * PENALTY * DEPTH**2
    assert sim.time == at
    assert sim.energies()["floor"] == pytest.approx(booked, rel=1e-12)
    for time in (at, at + 0.02, at + 0.1):
        sim.reach(time)
        ledger = sim.ledger()
        assert ledger["changes"] == {"floor": pytest.approx(booked, rel=1e-12)}
        assert sim.positions[1, 2] == pytest.approx(height(time, at), abs=2e-5 if ORDER[method] == 2 else 1e-7)
        assert abs(ledger["error"]) < (1e-3 if ORDER[method] == 2 else 1e-5)
    assert ledger["kinetic"] == pytest.approx(booked, rel=1e-3)
    assert ledger["work_by_law"].get("floor", 0.0) == 0.0
    assert sim.step_count == round((sim.time - at) / 1e-3) + math.floor(at / 1e-3 + 1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_the_order_is_kept_through_a_jump(method: str) -> None:
    """A mass on a spring whose end jumps by s: u = s (1 - cos w(t - t_j)), k s^2/2 and the stretched spring's k x s."""
    stretch, shift, omega = 0.3, 0.02, 10.0
    moved = Moved([0], x=Schedule((0.0, 0.01, AT, AT), (0.0, 0.0, 0.0, -shift)))
    laws = [Gravity((omega**2 * stretch, 0.0, 0.0))]
    scene = Scene(None, None, laws, [cord(), moved], run=RunSettings())
    errors, time = [], 0.4
    for dt in (4e-3, 2e-3, 1e-3):
        sim = Simulation(scene, method, dt=dt)
        positions = sim.positions.copy()
        positions[1, 0] = 1.0 + stretch
        sim.positions = positions
        sim.reach(time)
        errors.append(sim.positions[1, 0] - 1.0 - stretch + shift * (1.0 - math.cos(omega * (time - AT))))
        ledger = sim.ledger()
        added = 50.0 * ((stretch + shift) ** 2 - stretch**2)
        assert ledger["changes"] == {"tethers": pytest.approx(added, rel=1e-6)}
        assert ledger["work_by_law"].get("moved", 0.0) == 0.0
        assert sim.positions[0, 0] == -shift
        assert abs(ledger["error"]) < (1e-2 if ORDER[method] == 2 else 1e-5)
    assert rates(errors)[-1] > ORDER[method] - 0.2


def test_a_moved_node_whose_rate_jumps_too_takes_the_impulse_as_work() -> None:
    """As at a knot without a jump; the mass that it carries is displaced with it."""
    moved = Moved([0, 1], y=Schedule((0.0, AT, AT), (0.0, AT * 2.0, 1.0)))
    sim = Simulation(Scene(None, None, [], [cord(), moved]), "rk4", dt=1e-3)
    sim.reach(AT - 1e-5)
    assert sim.velocities[1, 1] == pytest.approx(2.0)
    sim.reach(AT)
    assert sim.positions[:, 1] == pytest.approx([1.0, 1.0])
    assert (sim.velocities == 0.0).all()
    ledger = sim.ledger()
    assert "changes" not in ledger
    assert ledger["work_by_law"]["moved"] == pytest.approx(-0.5 * 1.0 * 2.0**2)
    assert ledger["error"] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("method", "substeps"), WAYS)
def test_velocities_in_space_are_kept_where_the_rate_of_the_hub_jumps(method: str, substeps: int) -> None:
    """Two free masses fly straight; the hub's angle is the integral of its rate."""
    part = cord(axial_stiffness=1e-9, start=(0.1, 0.0, 0.0), end=(0.2, 0.1, 0.0), fixed=False, linear_density=1.0)
    spin = Spin(schedule=Schedule((0.01, 0.01, AT, AT, 0.1), (1.0, 1.0, 2.0, -1.5, -1.5)))
    sim = Simulation(Scene(None, None, [spin], [part], run=RunSettings(substeps=substeps)), method, dt=1e-3)
    first = sim.positions
    velocities = 2.0 * math.pi * np.stack([-first[:, 1], first[:, 0], 0.0 * first[:, 0]], axis=1)

    def in_space(rate: float) -> tuple[Floats, Floats]:
        cosine, sine = math.cos(sim.hub_angle), math.sin(sim.hub_angle)
        back = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        x, v = sim.positions, sim.velocities
        moving = v + 2.0 * math.pi * rate * np.stack([-x[:, 1], x[:, 0], 0.0 * x[:, 2]], axis=1)
        return x @ back, moving @ back

    for time, rate in ((AT - 1e-6, 2.0), (AT, -1.5), (0.05, -1.5)):
        sim.reach(time)
        places, speeds = in_space(rate)
        accuracy = 1e-4 if ORDER[method] == 2 else 1e-7
        assert places == pytest.approx(first + time * velocities, abs=accuracy)
        assert speeds == pytest.approx(velocities, abs=1e-3 if ORDER[method] == 2 else 1e-4)
    ramp = 0.01 + 0.5 * (1.0 + 2.0) * (AT - 0.01)
    assert sim.hub_angle == pytest.approx(2.0 * math.pi * (ramp - 1.5 * (0.05 - AT)), abs=1e-12)
    ledger = sim.ledger()
    assert ledger["changes"].keys() == {"kinetic", "spin"}
    inertia = float(sim.masses @ np.square(first[:, :2] + AT * velocities[:, :2]).sum(axis=1))
    added = -2.0 * math.pi**2 * (1.5**2 - 2.0**2) * inertia
    assert ledger["changes"]["spin"] == pytest.approx(added, rel=1e-3)
    assert abs(ledger["error"] * ledger["reference_energy"]) < 1e-7 * ledger["kinetic"]


STEPS = Schedule(
    (0.01, 0.01, 0.0255, 0.0255, 0.03, 0.03, 0.07, 0.07), (0.0, 0.105, 0.11, 0.11, 0.1, 0.115, 0.05, 0.101)
)
"""Jumps of a plane, some at the ends of steps."""


def shaken(**run: Any) -> Scene:
    """A plane, a moved end and a hub's rate that jump, at times of their own."""
    scene = pushed(STEPS, **run)
    moved = Moved([0], z=jump(0.0, -0.02, 0.03), x=jump(0.0, 0.01, 0.0500001))
    spin = Spin(schedule=Schedule((0.02, 0.02, 0.06, 0.06), (0.3, 0.5, 0.5, 0.1)))
    return replace(scene, laws=[spin, Gravity((0.0, 0.0, -1.0))], parts=[cord(), moved])


def last(sim: Simulation) -> tuple[Any, ...]:
    """What two runs that are the same share."""
    counts = sim.step_count, sim.evaluation_count, sim.rejected_count
    return sim.time, sim.hub_angle, sim.positions.tobytes(), sim.velocities.tobytes(), sim.ledger(), counts


@pytest.mark.parametrize(("method", "substeps", "dt"), [*((*way, 7e-4) for way in WAYS), ("dopri5", 1, None)])
def test_no_bit_depends_on_outputs_or_interruptions(
    method: str, substeps: int, dt: float | None, tmp_path: Path
) -> None:
    """Outputs at, just before and just after jumps; saved, restored and copied there."""
    scene = shaken(substeps=substeps, tolerance=1e-8) if dt is None else shaken(substeps=substeps)
    whole, stepped, cut = (Simulation(scene, method, dt) for _ in range(3))
    whole.reach(0.12)
    knots = [0.01, 0.02, 0.03, 0.0500001, 0.06, 0.07]
    near = [time for knot in knots for time in (knot - 1e-5, np.nextafter(knot, 0.0), knot, knot + 1e-9, knot + 1e-4)]
    for k, time in enumerate([0.0, *near]):
        cut.reach(float(time))
        assert cut.time == pytest.approx(float(time), abs=1e-16)
        shown = last(cut)
        cut.save(tmp_path / f"{k}.npz")
        again = copy.copy(cut) if k % 2 else Simulation.restore(tmp_path / f"{k}.npz")
        assert last(again) == shown
        cut = again
    cut.reach(0.12)
    assert last(cut) == last(whole)
    assert len(whole.ledger()["changes"]) == 4
    if not whole.is_adaptive:
        stepped.step(whole.step_count)
        stepped.reach(0.12)
        assert last(stepped) == last(whole)


@pytest.mark.parametrize("method", METHODS)
def test_states_beside_a_jump_are_those_of_its_sides(method: str) -> None:
    """Whether steps are given or chosen by their error."""
    for dt in (1e-3, None):
        sim = Simulation(pushed(jump(0.0, 0.1 + DEPTH)), method, dt)
        for time, energy in ((AT - 1e-9, 0.0), (AT, 0.05), (AT + 1e-9, 0.05)):
            sim.reach(time)
            assert sim.energies()["floor"] == pytest.approx(energy, rel=1e-6)
            assert sim.forces("floor")[1, 2] == pytest.approx(10.0 if energy else 0.0, rel=1e-6)
            assert sim.positions[1, 2] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("at", [0.0, -1.0, 1e-17])
def test_a_jump_at_the_start_or_before_is_none(method: str, at: float) -> None:
    sim = Simulation(pushed(jump(0.0, 0.1 + DEPTH, at)), method, dt=1e-3)
    sim.reach(0.1)
    assert sim.positions[1, 2] == pytest.approx(height(0.1, 0.0), abs=2e-5 if ORDER[method] == 2 else 1e-7)
    changes = sim.ledger().get("changes", {})
    assert changes == ({} if at <= 0.0 else {"floor": pytest.approx(0.05)})


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("at", "is_passed"), [(0.2, True), (np.nextafter(0.2, 1.0), True), (0.2001, False)])
def test_a_jump_at_the_end_of_a_run_is_passed_and_one_after_it_is_not(
    method: str, at: float, *, is_passed: bool
) -> None:
    sim = Simulation(pushed(jump(0.0, 0.1 + DEPTH, at)), method, None if method == "dopri5" else 1e-3)
    if method == "dopri5" and at not in (0.2, 0.2001):
        return  # steps that the method chooses end at no time but that of the jump
    sim.run()
    assert sim.time == 0.2
    assert sim.ledger().get("changes", {}) == ({"floor": pytest.approx(0.05)} if is_passed else {})


def test_a_thousand_jumps_cost_a_thousand_restarts() -> None:
    """Closer together than steps, too: the plane goes in and out, and the mass gets what it is left with."""
    times = np.repeat(np.linspace(0.01, 0.1, 1000), 2)
    values = np.concatenate([[0.0], np.repeat(np.arange(1, 1000) % 2 * 0.05, 2), [0.0]])
    for method in METHODS:
        sim = Simulation(pushed(Schedule(tuple(times), tuple(values))), method, dt=1e-3)
        sim.reach(0.2)
        assert sim.positions[1, 2] == 0.0
        assert "changes" not in sim.ledger()


def test_a_bar_that_jumps_over_a_string_takes_no_path_through_it() -> None:
    """And one that jumps too deep into it stops the run."""

    def bar(to: float) -> Simulation:
        body = Cylinder("bar", 0.02, centre=(0.5, 0.1, 0.0), travel_y=jump(0.0, to), stiffness=10.0)
        return Simulation(Scene(None, None, [], [cord()], bodies=[body]), "rk4", dt=1e-3)

    sim = bar(-0.2)
    sim.reach(0.1)
    assert "changes" not in sim.ledger()
    with pytest.raises(UnstableError, match="deep into the body bar, over its bound"):
        bar(-0.105).reach(0.3)


def test_jumps_within_stages_and_at_their_ends() -> None:
    """Booked under the name of the stage, beside what the change of stage puts in."""
    stages = (
        Stage("first", 0.05),
        Stage("harder", 0.1, "kinetic_energy", above=0.04, scale={"bodies.floor.stiffness": 2.0}),
        Stage("third", 0.02, set={"bodies.floor.travel_z": {"times": [0.02, 0.02], "values": [0.0, 0.2]}}),
    )
    travel = Schedule((0.02, 0.02, 0.05, 0.05), (0.0, 0.0999, 0.0999, 0.1))
    for method in METHODS:
        sim = Simulation(pushed(replace(travel, values=(0.0, 0.105, 0.105, 0.11)), *stages), method, dt=1e-3)
        sim.run()
        records = sim.stages
        assert [record.ended_by for record in records] == ["duration", "measure", "duration"]
        changes = sim.ledger()["changes"]
        assert changes["first: floor"] > 0.0125  # and what the jump at its end adds, if the mass is still there
        assert list(changes)[-1] == "third: floor"
        assert abs(sim.ledger()["error"]) < (2e-2 if ORDER[method] == 2 else 1e-4)
        assert sim.time == pytest.approx(records[1].end + 0.02)


@pytest.mark.parametrize("method", METHODS)
def test_a_measure_that_a_jump_takes_past_its_value_ends_the_stage_there(method: str) -> None:
    def contact(sim: Simulation) -> float:
        return float(sim.forces("floor")[1, 2])

    stages = (Stage("wait", 0.1, contact, above=1.0), Stage("after", 0.05))
    sim = Simulation(pushed(jump(0.0, 0.1 + DEPTH), *stages), method, dt=None if method == "dopri5" else 1e-3)
    sim.reach(AT - 1e-6)
    assert sim.stage == 0
    sim.run()
    assert sim.boundaries == [pytest.approx(AT, rel=1e-14)]
    assert sim.ledger()["changes"] == {"wait: floor": pytest.approx(0.05)}
    assert sim.positions[1, 2] == pytest.approx(height(AT + 0.05), abs=2e-5 if ORDER[method] == 2 else 1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_a_run_that_is_killed_at_any_frame_ends_with_the_same_files(method: str, tmp_path: Path) -> None:
    strip = hanging_strip()
    moved = Moved("end", z=Schedule((0.002, 0.002, 0.0071, 0.0071), (0.0, 1e-4, 0.0, 1e-4)), name="end")
    stages = (Stage("held", 0.006), Stage("free", 0.006))
    for k, given in enumerate((strip, replace(strip, stages=stages))):
        parts, run = [Fixed("start"), moved], replace(strip.run, integrator=method, until=0.012)
        scene = replace(given, parts=parts, run=replace(run, until=RunSettings().until) if k else run)
        run_copied(Simulation(scene), tmp_path / f"{k}" / "whole", until=0.012, frames=7)
        whole = contents(tmp_path / f"{k}" / "whole")
        for left in sorted((tmp_path / f"{k}").glob("left-*"))[1:-1]:
            resume(left)
            assert contents(left) == whole
        summary = read_summary(tmp_path / f"{k}" / "whole")
        listed = summary["stages"][0]["changes"] if k else summary["energy_balance"]["changes"]
        assert listed["springs"] > 0.0


def test_scene_files_hold_jumps(tmp_path: Path) -> None:
    scene = shaken()
    scene.save(tmp_path)
    again = Scene.from_toml(tmp_path / "scene.toml")
    assert "times = [0.01, 0.01, 0.0255" in (tmp_path / "scene.toml").read_text()
    assert (again.bodies, again.laws, again.parts) == (scene.bodies, scene.laws, scene.parts)
    for sim in (first := Simulation(scene, dt=1e-3)), (second := Simulation(again, dt=1e-3)):
        sim.reach(0.1)
    assert last(first) == last(second)


def test_a_jump_while_a_scene_is_relaxed_waits_for_its_time() -> None:
    scene = replace(pushed(jump(0.0, 0.1 + DEPTH)), run=RunSettings(until=0.1, relax=0.05, relax_rate=30.0))
    sim = Simulation(scene, "rk4", dt=1e-3)
    sim.run()
    assert sim.positions[1, 2] == pytest.approx(height(0.1), abs=1e-7)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"origin_step": 10**9}, "steps before the origin"),
        ({"origin_step": -1}, "origin_step"),
        ({"origin_step": 1.5}, "origin_step"),
        ({"origin_step": True}, "origin_step"),
        ({"changes": np.zeros(1)}, "changes by jumps"),
        ({"changes": np.full(6, np.nan)}, "not finite"),
        ({"changes": "x"}, "changes"),
        ({"origin": 0.2}, "saved output time|origin|saved state"),
    ],
)
def test_a_damaged_state_after_a_jump_is_refused_and_changes_nothing(wrong: dict[str, Any], words: str) -> None:
    sim = Simulation(shaken(), "rk4", 7e-4)
    sim.reach(0.05)
    before = last(sim)
    with pytest.raises((InputError, InputTypeError), match=words):
        sim.set_state(sim.state() | wrong)
    assert last(sim) == before
