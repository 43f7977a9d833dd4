"""Cords hauled in and paid out: closed forms, the work of the winch, and what is refused."""

from __future__ import annotations

from math import cos, sin
from typing import Any

import numpy as np
import pytest
from membrane_rs import Cord, Gravity, InputError, Scene, Schedule, Simulation, SpringDamping, TipMasses
from membrane_rs.scene.laws import Law
from small_scenes import rates, refused

MASS, LENGTH, STIFFNESS = 2.0, 1.0, 1e4
"""Of the load [kg], of the cord [m], EA [N]."""


def hauled(factor: Schedule | None, segments: int = 1, laws: tuple[Law, ...] = (), **changes: Any) -> Scene:
    """A load on a cord along x from a fixed point."""
    rope: dict[str, Any] = {
        "axial_stiffness": STIFFNESS,
        "linear_density": 0.0 if segments == 1 else 1e-3,
        "length": LENGTH,
    }
    rope |= {"strain_limit": 10.0, "length_factor": factor, **changes}
    part = Cord((0.0, 0.0, 0.0), (LENGTH, 0.0, 0.0), segments, **rope, name="c")
    return Scene(None, None, list(laws), [part, TipMasses(MASS, "c-end")])


def test_a_load_hauled_in_at_a_constant_speed() -> None:
    # r = L (1 - a t): with the elongation e = x - r, m x'' = -EA e/r. Over a time in which r changes by 1e-6 of itself
    # the frequency w = (EA/(m L))^(1/2) is constant: x - r = e, e'' = -w^2 e, e(0) = 0, e'(0) = a L. So
    # x = L - a L t + (a L/w) sin(w t) and the tension is EA (a/w) sin(w t).
    a, omega = 1e-6, (STIFFNESS / (MASS * LENGTH)) ** 0.5
    sim = Simulation(hauled(Schedule([0.0, 1.0], [1.0, 1.0 - a])), dt=1e-4)
    for time in (0.01, 0.02, 0.04):  # taut up to pi/w
        sim.run(until=time)
        elongation = a * LENGTH / omega * sin(omega * time)
        moved = a * LENGTH * time - elongation
        assert LENGTH - sim.positions[1, 0] == pytest.approx(moved, rel=2e-5)
        assert sim.cord_tensions()[0] == pytest.approx(max(0.0, STIFFNESS * elongation / LENGTH), rel=2e-5, abs=1e-9)
        assert sim.spring_strains()[0] == pytest.approx(elongation / LENGTH, rel=2e-5)


def test_the_work_of_a_slow_winch_lifts_the_load() -> None:
    # So slowly that the load hangs at rest all the time: the winch lifts it by W (1 + W/EA) dr against its weight W,
    # less what the cord had stored in the length that is hauled in: its work is W dr + W^2/(2 EA) dr.
    weight = MASS * 9.81
    strain = weight / STIFFNESS
    laws = (Gravity((9.81, 0.0, 0.0)),)
    scene = hauled(Schedule([0.0, 4.0], [1.0, 0.5], 0.5), laws=laws)
    sim = Simulation(scene, dt=2e-4)
    sim.positions = np.array([[0.0, 0.0, 0.0], [LENGTH * (1.0 + strain), 0.0, 0.0]])
    sim.run(until=4.0)
    ledger = sim.ledger()
    work = weight * 0.5 * LENGTH * (1.0 + 0.5 * strain)
    assert ledger["work_by_law"]["winches"] == pytest.approx(work, rel=1e-6)
    assert sim.positions[1, 0] == pytest.approx(0.5 * LENGTH * (1.0 + strain), rel=1e-5)
    assert abs(float(ledger["error"])) < 1e-8


@pytest.mark.parametrize(("ease", "dt"), [(0.0, 4e-3), (0.5, 1e-3)])
@pytest.mark.parametrize(("method", "order"), [("rk4", 4), ("leapfrog", 2)])
def test_the_balance_closes_to_the_order_of_the_method(method: str, order: int, ease: float, dt: float) -> None:
    # Paid out and hauled in with knots between the steps; the cord is taut all the time. Where the rate jumps no step
    # crosses; eased, its second derivative jumps within steps, which lets the error of single steps vary.
    factor = Schedule([0.0, 0.0123, 0.0377, 0.06], [1.0, 1.002, 0.998, 1.0], ease)
    errors = []
    for step in (dt, dt / 2.0, dt / 4.0):
        sim = Simulation(hauled(factor, laws=(Gravity((200.0, 0.0, 0.0)),)), method, step)
        sim.positions = np.array([[0.0, 0.0, 0.0], [LENGTH + 0.05, 0.0, 0.0]])
        sim.run(until=0.06)
        assert sim.cord_tensions()[0] > 0.0
        ledger = sim.ledger()
        errors.append(abs(float(ledger["error"])) * float(ledger["reference_energy"]))
    assert rates(errors[::2], 4.0) > order - (1.0 if ease else 0.3)


@pytest.mark.parametrize("method", ["rk4", "leapfrog", "dopri5", "generalized_alpha"])
def test_a_load_hauled_in_on_several_segments_keeps_the_balance(method: str) -> None:
    factor = Schedule([0.0, 0.2], [1.0, 0.8], 0.2)
    scene = hauled(factor, 8, (Gravity((9.81, 0.0, 1.0)), SpringDamping(0.1)), linear_density=0.05)
    sim = Simulation(scene, method, 1e-4 if method == "generalized_alpha" else None)
    sim.run(until=0.25)
    ledger = sim.ledger()
    assert ledger["work_by_law"]["winches"] > 1.0
    assert abs(float(ledger["error"])) < 5e-3
    assert sim.energies()["tethers"] == 0.0
    assert np.linalg.norm(sim.positions[-1]) < 0.85


def test_a_cord_paid_out_is_slack_and_its_winch_does_no_work() -> None:
    sim = Simulation(hauled(Schedule([0.0, 0.1], [1.0, 2.0])), dt=1e-3)
    sim.run(until=0.1)
    assert sim.positions[1, 0] == LENGTH
    assert sim.buckled().tolist() == [True]
    assert "winches" not in sim.ledger()["work_by_law"]


def test_a_constant_factor_is_another_length() -> None:
    push = np.array([[0.0, 0.0, 0.0], [1.1, 0.2, 0.0]])
    forces = []
    for scene in (hauled(Schedule([0.0], [0.9])), hauled(None, length=0.9 * LENGTH)):
        sim = Simulation(scene)
        sim.positions = push
        forces.append(sim.forces())
    assert forces[0] == pytest.approx(forces[1], rel=1e-13)


def test_a_jump_of_the_length_is_a_change_and_no_gain() -> None:
    sim = Simulation(hauled(Schedule([0.0, 0.01, 0.01], [1.0, 1.0, 0.99])), dt=1e-3)
    sim.run(until=0.03)
    ledger = sim.ledger()
    assert ledger["changes"]["winches"] == pytest.approx(0.5 * STIFFNESS * (0.01 / 0.99) ** 2 * 0.99, rel=1e-9)
    assert abs(float(ledger["error"])) < 1e-6
    omega = (STIFFNESS / (MASS * 0.99)) ** 0.5
    assert sim.positions[1, 0] == pytest.approx(0.99 + 0.01 * cos(omega * 0.02), rel=1e-6)


def test_a_length_of_nothing_is_refused() -> None:
    refused(
        lambda: hauled(Schedule([0.0, 1.0], [1.0, 0.0])),
        InputError,
        r"Cord\.length_factor\.values: 0: must be at least",
    )


def test_a_winch_hauls_in_no_strut() -> None:
    refused(
        lambda: hauled(Schedule([0.0], [1.0]), critical_strain=1.0),
        InputError,
        r"Cord\.critical_strain = 1: must be 0 with",
    )


def test_the_default_step_is_that_of_the_shortest_length() -> None:
    steady, short = (Simulation(hauled(factor)).stable_dt() for factor in (None, Schedule([0.0, 1.0], [1.0, 0.25])))
    assert short == pytest.approx(0.5 * steady, rel=1e-6)


def test_a_saved_run_goes_on_with_the_same_bits(tmp_path: Any) -> None:
    scene = hauled(Schedule([0.0, 0.1], [1.0, 0.9], 0.1), 4)
    one, other = Simulation(scene), Simulation(scene)
    one.step(200)
    other.step(90)
    other.save(tmp_path / "state.npz")
    again = Simulation.restore(tmp_path / "state.npz")
    again.step(110)
    assert (one.positions == again.positions).all()
