"""Nodes that move as prescribed: place, exact motions of what hangs on them, order, work, restart, wrong input."""

from __future__ import annotations

import copy
import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    Fixed,
    Gravity,
    InputError,
    Material,
    Moved,
    RunSettings,
    Scene,
    SceneError,
    Schedule,
    Simulation,
    Spin,
    SpringDamping,
    Springs,
    Stage,
    Tether,
    UnstableError,
)
from membrane_rs.folding import Strip
from membrane_rs.results.history import read_history
from methods import METHODS, ORDER, WAYS

SHAKEN = Schedule((0.0, 0.05, 0.15, 0.2), (0.0, 1e-3, -1e-3, 0.0), 0.5)
G, EA, LENGTH, TIP = 9.81, 17.0, 0.1, 0.05
FILM = Material(youngs_modulus=3.2e9, poisson_ratio=0.34, density=1420.0, thickness=7.5e-6)


def hanging(*parts: Any, laws: tuple[Any, ...] = (), density: float = 0.0, **run: Any) -> Scene:
    """A mass on a cord without mass, at (0.1, 0)."""
    start, end = (0.1, 0.0, 0.0), (0.1, 0.0, -LENGTH)
    tether = Tether(start, end, 1, EA, density, tip_mass=TIP, strain_limit=10.0)
    return Scene(None, None, [Gravity((0.0, 0.0, -G)), *laws], [tether, *parts], run=RunSettings(**run))


def at_rest(scene: Scene, **how: Any) -> Simulation:
    """The mass at its rest position on the cord."""
    sim = Simulation(scene, **how)
    positions = sim.positions.copy()
    positions[1, 2] -= TIP * G * LENGTH / EA
    sim.positions = positions
    return sim


def moved_film(**run: Any) -> Scene:
    """A strip of film in a turning frame, whose start is moved along and turned."""
    prescribed = Moved("start", x=Schedule((0, 0.01), (0, 1e-3), 0.3), turn=Schedule((0.0, 0.01), (0.0, 0.02), 0.5))
    laws = [Springs(), SpringDamping(0.01), Spin(frequency=3.0), Gravity((0.0, 0.0, -1.0))]
    mesh = Strip(0.05, 0.02, 5, 2, (0.4,), 0.6).mesh()
    return Scene(mesh, FILM, laws, [prescribed, Fixed("start", name="hold")], run=RunSettings(**run))


def place(prescribed: Moved, start: np.ndarray, time: float) -> np.ndarray:
    """Where nodes should be (k, 3), with schedules that begin with 0."""
    turn = 0.0 if prescribed.turn is None else prescribed.turn.at(time)
    rotation = np.array([[math.cos(turn), -math.sin(turn), 0], [math.sin(turn), math.cos(turn), 0], [0, 0, 1]])
    moved: np.ndarray = start @ rotation.T
    return moved + [0.0 if along is None else along.at(time) for along in (prescribed.x, prescribed.y, prescribed.z)]


@pytest.mark.parametrize(("method", "substeps"), WAYS)
def test_nodes_are_where_they_are_told(method: str, substeps: int) -> None:
    """At the ends of steps and between them, with velocities; by the formula of the schedules in Python."""
    scene = moved_film(substeps=substeps)
    sim = Simulation(scene, method, dt=2e-6)
    prescribed = scene.parts[0]
    assert isinstance(prescribed, Moved)
    nodes = scene.assemble().node_sets["start"]
    start = sim.positions[nodes]
    for time in (2e-6, 1.1e-5, 0.0011, 0.00413579, 0.0105):
        sim.reach(time)
        assert sim.positions[nodes] == pytest.approx(place(prescribed, start, time), abs=1e-16)
        rate = (place(prescribed, start, time + 1e-7) - place(prescribed, start, time - 1e-7)) / 2e-7
        assert sim.velocities[nodes] == pytest.approx(rate, abs=1e-8)
    assert abs(sim.ledger()["error"]) < (1e-3 if ORDER[method] == 2 else 1e-6)


def exact(time: float) -> tuple[float, float]:
    """Displacement [m] of a mass at rest on a spring whose end is moved by `SHAKEN`, and the work [J] of that motion.

    u'' = w^2 (s - u), so u(t) = w integral of sin w(t - a) s(a) da; the force on the end is k (s - u) + m g.
    """
    omega = math.sqrt(EA / LENGTH / TIP)
    times = np.linspace(0.0, time, 40_001)
    moved = np.array([SHAKEN.at(t) for t in times])
    h = times[1]

    def integral(values: np.ndarray) -> np.ndarray:
        """By the rule of order 4, from 0 to each second point."""
        return np.concatenate([[0.0], np.cumsum(h / 3.0 * (values[:-2:2] + 4.0 * values[1:-1:2] + values[2::2]))])

    cosine, sine = (integral(wave(omega * times) * moved) for wave in (np.cos, np.sin))
    even = times[::2]
    u = omega * (np.sin(omega * even) * cosine - np.cos(omega * even) * sine)
    force = EA / LENGTH * (moved[::2] - u) + TIP * G
    work = float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(moved[::2])))
    return float(u[-1]), work


@pytest.mark.parametrize(("method", "substeps"), WAYS)
def test_mass_on_a_shaken_spring(method: str, substeps: int) -> None:
    """Displacement and work as computed by hand, with the order of the method."""
    u, work = exact(0.2)
    rest = -LENGTH - TIP * G * LENGTH / EA
    errors = []
    for dt in (1e-3, 5e-4):
        sim = at_rest(hanging(Moved("tether-0-start", z=SHAKEN), substeps=substeps), integrator=method, dt=dt)
        sim.reach(0.2)
        balance = sim.ledger()
        errors.append((abs(sim.positions[1, 2] - rest - u), abs(balance["work_by_law"]["moved"] - work)))
        assert abs(balance["error"]) < (1e-3 if ORDER[method] == 2 else 1e-7)
    (far, far_work), (near, near_work) = errors
    assert near < 1e-5 * abs(u) + (2e-6 if ORDER[method] == 2 else 0.0)
    assert near_work < (1e-3 if ORDER[method] == 2 else 1e-5) * abs(work)
    if ORDER[method] == 2:
        assert far_work / near_work > 2.0**1.7
        assert far / near > 2.0**1.5


def test_order_of_position_and_work() -> None:
    """Against the finest steps; each halving takes 2^order off both."""
    sets = [(name, 1e-3, 3.5 if ORDER[name] == 4 else 1.6 if ORDER[name] == 2 else 4.3) for name in METHODS]
    fine = at_rest(hanging(Moved("tether-0-start", z=SHAKEN)), integrator="rk4", dt=2.5e-5)
    fine.reach(0.2)
    for method, dt, least in sets:
        found = []
        for step in (dt, dt / 2):
            sim = at_rest(hanging(Moved("tether-0-start", z=SHAKEN)), integrator=method, dt=step)
            sim.reach(0.2)
            work = [one.ledger()["work_by_law"]["moved"] for one in (sim, fine)]
            found.append((abs(sim.positions[1, 2] - fine.positions[1, 2]), abs(work[0] - work[1])))
        for coarse, half in zip(*found, strict=True):
            assert math.log2(coarse / half) > least, (method, found)


def test_energy_is_balanced_by_the_work_of_the_motion() -> None:
    """To 1e-11 of what is exchanged, by the method of order 4."""
    sim = at_rest(hanging(Moved("tether-0-start", z=SHAKEN), density=1e-3), integrator="rk4", dt=1.25e-4)
    sim.reach(0.2)
    assert abs(sim.ledger()["error"]) < 1e-11


@pytest.mark.parametrize("method", METHODS)
def test_pendulum_on_a_support_in_steady_motion(method: str) -> None:
    """Seen from the support, it swings as on one at rest."""
    still = at_rest(hanging(), integrator=method, dt=1e-4)
    speed = 0.3
    carried = at_rest(hanging(Moved([0], y=Schedule((0.0, 9.0), (0.0, 9.0 * speed)))), integrator=method, dt=1e-4)
    for sim, own in ((still, 0.0), (carried, speed)):
        velocities = np.zeros((2, 3))
        velocities[1] = (0.2, own, 0.1)
        sim.velocities = velocities
        sim.reach(0.1)
    seen = carried.positions - np.array([0.0, speed * 0.1, 0.0])
    assert seen == pytest.approx(still.positions, abs=1e-12)
    # The mass swings across the motion, so that the support does no work on it along the way but for rounding.
    assert carried.ledger()["work_by_law"].get("moved", 0.0) == pytest.approx(0.0, abs=1e-10)


@pytest.mark.parametrize("method", METHODS)
def test_support_that_turns_is_that_of_a_turning_hub(method: str) -> None:
    """A pendulum on a node that is turned about the axis, and on a fixed one of a hub that turns alike."""
    rate = 0.7
    turned = at_rest(hanging(Moved([0], turn=Schedule((0.0, 9.0), (0.0, 9.0 * rate)))), integrator=method, dt=2e-4)
    hub = at_rest(hanging(laws=(Spin(frequency=rate / (2.0 * math.pi)),)), integrator=method, dt=2e-4)
    velocities = np.zeros((2, 3))
    velocities[1, 1] = 0.1 * rate
    turned.velocities = velocities
    for sim in (turned, hub):
        sim.reach(0.4)
    angle = hub.hub_angle
    seen = hub.positions @ np.array(
        [[math.cos(angle), math.sin(angle), 0], [-math.sin(angle), math.cos(angle), 0], [0, 0, 1]]
    )
    assert turned.positions == pytest.approx(seen, abs=1e-6 if ORDER[method] == 2 else 1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_tether_wound_in_at_its_hub_end(method: str) -> None:
    """Slowly, in a turning frame: the work is that against the centrifugal force, m Omega^2 (r1^2 - r0^2)/2."""
    omega, way = 2.0 * math.pi * 3.0, 0.03
    tether = Tether((0.05, 0.0, 0.0), (0.15, 0.0, 0.0), 4, 20.0, 1e-3, tip_mass=0.01)
    wound = Moved("tether-0-start", x=Schedule((0.0, 2.0), (0.0, -way), 0.5), name="winch")
    scene = Scene(None, None, [Spin(3.0), SpringDamping(0.02)], [tether, wound])
    sim = Simulation(scene, method, dt=1e-4)
    sim.reach(2.2)
    work = sim.ledger()["work_by_law"]["moved"]
    masses, radii = sim.masses[1:], np.hypot(*sim.positions[1:, :2].T)
    expected = 0.5 * omega**2 * float(masses @ ((radii + way) ** 2 - radii**2))
    assert sim.positions[-1, 0] == pytest.approx(0.15 - way, abs=3e-3)
    assert work == pytest.approx(expected, rel=0.02)
    assert abs(sim.ledger()["error"]) < 1e-3


def test_impulse_of_a_sudden_start_and_stop_is_work() -> None:
    """Without easing the velocity jumps: the kinetic energy comes and goes as work."""
    scene = hanging(Moved([0, 1], y=Schedule((0.1, 0.3), (0.0, 0.2))))
    sim = Simulation(scene, "rk4", dt=1e-2)
    assert sim.energies()["kinetic"] == 0.0
    sim.reach(0.2)
    balance = sim.ledger()
    assert balance["kinetic"] == pytest.approx(0.5 * TIP)
    assert balance["work_by_law"]["moved"] == pytest.approx(0.5 * TIP)
    assert abs(balance["error"]) < 1e-12
    sim.reach(0.4)
    assert sim.ledger()["work_by_law"].get("moved", 0.0) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("method", METHODS)
def test_hub_bears_the_load_of_moved_nodes(method: str) -> None:
    """Weight and inertia of nodes that the hub's machinery moves."""
    rise = Schedule((0.0, 0.2), (0.0, 0.1), 0.5)
    sim = Simulation(hanging(Moved([0, 1], z=rise)), method, dt=1e-4)
    sim.reach(0.05)
    step = 1e-4
    acceleration = (rise.at(0.05 + step) - 2.0 * rise.at(0.05) + rise.at(0.05 - step)) / step**2
    assert acceleration > 5.0
    assert sim.hub_force()[2] == pytest.approx(-TIP * (G + acceleration), rel=1e-5)


@pytest.mark.parametrize(("method", "substeps"), WAYS)
@pytest.mark.parametrize("time", [0.002, 0.0020013])
def test_resumed_with_the_same_bits(method: str, substeps: int, time: float, tmp_path: Path) -> None:
    """From a file, a state and a copy, at the end of a step and between two."""
    scene = moved_film(substeps=substeps)
    whole = Simulation(scene, method, dt=4e-6)
    whole.reach(time)
    whole.save(tmp_path / "state.npz")
    others = [Simulation(scene, method, dt=4e-6), copy.copy(whole)]
    others[0].set_state(whole.state())
    others.append(Simulation.restore(tmp_path / "state.npz"))
    for sim in (whole, *others):
        sim.reach(0.0041)
    for sim in others:
        assert np.array_equal(sim.positions, whole.positions)
        assert np.array_equal(sim.velocities, whole.velocities)
        assert sim.ledger()["work_by_law"] == whole.ledger()["work_by_law"]


@pytest.mark.parametrize("method", METHODS)
def test_goes_on_from_another_simulation_where_that_is(method: str) -> None:
    """A later part of the motion, by the same schedules, and nodes that were free before: none jumps."""
    scene = moved_film()
    whole, first = (Simulation(scene, method, dt=4e-6) for _ in range(2))
    first.reach(0.004)
    after = Simulation(scene, method, dt=4e-6, start=first)
    assert after.positions == pytest.approx(first.positions, abs=1e-17)
    for sim in (whole, after):
        sim.reach(0.008)
    assert after.positions == pytest.approx(whole.positions, abs=1e-5 if ORDER[method] == 2 else 1e-8)
    late = Moved("end", z=Schedule((0.0, 0.004), (5.0, 5.01), 0.2).delayed(0.004))
    other = Simulation(Scene(scene.mesh, FILM, scene.laws, [late]), method, dt=4e-6, start=first)
    assert other.positions == pytest.approx(first.positions, abs=1e-14)
    other.reach(0.008)
    nodes = scene.assemble().node_sets["end"]
    assert other.positions[nodes] == pytest.approx(first.positions[nodes] + [0.0, 0.0, 0.01], abs=1e-14)


def test_steps_chosen_by_the_error() -> None:
    """The prescribed state at outputs, which lie within steps; the balance holds."""
    sim = at_rest(hanging(Moved("tether-0-start", z=SHAKEN), tolerance=1e-9), integrator="dopri5")
    assert sim.is_adaptive
    for time in (0.013, 0.05, 0.1777):
        sim.reach(time)
        assert sim.positions[0, 2] == SHAKEN.at(time)
    assert abs(sim.ledger()["error"]) < 1e-5


def test_time_stands_still_while_a_scene_is_relaxed() -> None:
    """Nodes that move from the start on are held where they start."""
    fast = Schedule((0.0, 1.0), (0.0, 0.5))
    scene = hanging(Moved("tether-0-start", z=fast), relax=0.2, relax_rate=30.0)
    sim = Simulation(scene, "rk4", dt=1e-4)
    sim.relax()
    assert np.array_equal(sim.positions[0], [0.1, 0.0, 0.0])
    assert sim.positions[1, 2] == pytest.approx(-LENGTH - TIP * G * LENGTH / EA, abs=1e-5)
    assert sim.velocities[0, 2] == 0.5


def test_set_positions_move_the_anchor() -> None:
    """The motion goes on from where nodes are put."""
    sim = Simulation(hanging(Moved([0, 1], turn=Schedule((0.0, 1.0), (0.0, 1.0)))), "rk4", dt=1e-2)
    sim.reach(0.5)
    sim.positions = np.array([[0.2, 0.0, 0.0], [0.0, 0.3, 0.0]])
    assert sim.velocities == pytest.approx(np.array([[0.0, 0.2, 0.0], [-0.3, 0.0, 0.0]]))
    sim.reach(1.0)
    turn = 0.5
    assert sim.positions[0] == pytest.approx([0.2 * math.cos(turn), 0.2 * math.sin(turn), 0.0])


def test_run_goes_back_to_its_last_good_state() -> None:
    """With the prescribed motion of that time."""
    scene = moved_film(watch=1)
    sim = Simulation(scene, "rk4", dt=2e-6)
    sim.step(50)
    velocities = sim.velocities.copy()
    velocities[-1] = 1e6
    sim.velocities = velocities
    with pytest.raises(Exception, match="stopped at"):
        sim.step(2000)
    nodes, prescribed = scene.assemble().node_sets["start"], scene.parts[0]
    assert isinstance(prescribed, Moved)
    start = scene.assemble().positions[nodes]
    assert sim.positions[nodes] == pytest.approx(place(prescribed, start, sim.time), abs=1e-16)


def test_scene_files_hold_the_motion(tmp_path: Path) -> None:
    """Written and read again."""
    scene = moved_film()
    scene.save(tmp_path)
    text = (tmp_path / "scene.toml").read_text()
    assert "x = {times = [0.0, 0.01], values = [0.0, 0.001], ease = 0.3}  # m" in text
    assert 'name = "hold"' in text
    assert Scene.from_toml(tmp_path / "scene.toml").parts == scene.parts


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "no schedule": ({"x": 1.0}, r"Moved\.x = 1\.0: must be a Schedule, or a table"),
    "knots": ({"turn": {"times": [0, -1], "values": [0, 1]}}, r"Moved\.turn\.times\[1\] = -1\.0: must not be below"),
    "value": ({"z": {"times": [0], "values": ["up"]}}, r"Moved\.z\.values\[0\] = 'up': must be a number"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_input_is_named(case: str) -> None:
    """Key, value and remedy."""
    values, message = WRONG[case]
    with pytest.raises(InputError, match=message):
        Moved("start", **values)


def test_nodes_follow_one_motion() -> None:
    """Two parts that move a node are named."""
    with pytest.raises(SceneError, match=r"parts\[2\]\.nodes: parts\[1\] moves node 0 too; leave it out"):
        hanging(Moved([0, 1], x=SHAKEN), Moved([0], y=SHAKEN))
    with pytest.raises(SceneError, match=r"parts\[1\]\.nodes .* node 7 is not there"):
        hanging(Moved([7], x=SHAKEN))


def test_motion_too_large_for_numbers_ends_in_an_error() -> None:
    """Where squares overflow."""
    wild = Schedule((0.0, 1.0), (0.0, 1e200))
    sim = Simulation(hanging(Moved([0], x=wild)), "rk4", dt=1e-4)
    with pytest.raises(UnstableError, match="no longer finite"):
        sim.step(200)


def test_stages_let_nodes_go_and_history_lists_the_work(tmp_path: Path) -> None:
    """A winch that pulls in its own stage: nodes go on from where they are; its work has a column."""
    winch = Moved("tether-0-start", z=Schedule((0.05, 0.1), (0.0, 2e-3), 0.5), name="winch")
    again = {"parts.winch.z": Schedule((0.0, 0.05), (0.0, -1e-3), 0.5)}
    stages = [Stage(name="hold", duration=0.05, without=("winch",)), Stage(name="pull", duration=0.1)]
    stages += [Stage(name="back", duration=0.1, set=again)]
    scene = hanging(winch)
    scene = dataclasses.replace(scene, stages=stages, run=RunSettings(until=0.25, dt=1e-3, samples=26))
    sim = Simulation(scene)
    sim.run(out=tmp_path / "run", frames=2)
    heights = sim.positions[0, 2]
    assert heights == pytest.approx(2e-3 - 1e-3, abs=1e-15)
    table = read_history(tmp_path / "run" / "history.csv")
    assert "work_moved" in table
    assert table["work_moved"][4] == 0.0
    assert table["work_moved"][-1] != 0.0
    assert np.abs(table["energy_error"]).max() < 1e-4
