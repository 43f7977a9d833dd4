"""Bodies of prescribed motion: known answers for their push, their work and their bounds."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    Cylinder,
    Fixed,
    Gravity,
    MassDamping,
    Plane,
    Scene,
    Schedule,
    Simulation,
    Springs,
    Tether,
    UnstableError,
    integrators,
)
from membrane_rs.folding import Strip
from membrane_rs.scene.bodies import Body
from membrane_rs.scene.laws import Law
from membrane_rs.scene.parts import Part
from small_scenes import RUBBER, cord

METHODS = list(integrators())


def string(segments: int = 20, pull: float = 1.0) -> list[Part]:
    """A string of 1 m along x, held at both ends: EA = 100 N, 10 g, with a tension [N] at the start."""
    length = 1.0 / (1.0 + pull / 100.0)
    line = Tether((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), segments, 100.0, 0.01, length=length, strain_limit=10.0)
    return [line, Fixed("tether-0-end")]


def scene_of(parts: list[Part], bodies: list[Body], laws: list[Law] | None = None) -> Scene:
    return Scene(None, None, laws or [], parts, bodies=bodies)


def rising(to: float, begin: float = 0.0, time: float = 1.0) -> Schedule:
    return Schedule((0.0, time), (begin, to), ease=0.4)


def error_of(sim: Simulation) -> float:
    return abs(float(sim.ledger()["error"]))


def test_a_moving_plane_puts_in_the_energy_that_a_mass_gains() -> None:
    # 1 kg rests on a floor, 9.81 mm deep, which lifts it by 0.3 m in 1 s, and never leaves it.
    floor = Plane("floor", centre=(0.0, 0.0, 9.81e-3), travel_z=rising(0.3), stiffness=1e3)
    sim = Simulation(scene_of([cord(axial_stiffness=1e-9)], [floor], [Gravity()]), "rk4", dt=5e-4)
    assert sim.forces(floor)[1] == pytest.approx((0.0, 0.0, 9.81))
    for _ in range(20):
        sim.step(100)
        assert sim.body_loads()["floor"].force[2] < -5.0
        assert error_of(sim) < 1e-9
    assert sim.ledger()["work_by_law"]["floor"] == pytest.approx(9.81 * 0.3, rel=0.02)
    assert sim.body_loads()["floor"].force == pytest.approx(-sim.forces(floor).sum(axis=0))


@pytest.mark.parametrize("felt_by", ["edges", "triangles"])
def test_a_bar_deflects_a_taut_string_as_statics_say(felt_by: Any) -> None:
    # A bar of 4 mm between nodes 5 cm apart comes to push the string aside by 2 cm at x = 0.525.
    bar = Cylinder("bar", 0.004, centre=(0.525, -0.01, 0.0), travel_y=rising(0.026), stiffness=5e4, felt_by=felt_by)
    sim = Simulation(scene_of(string(), [bar], [MassDamping(20.0)]))
    sim.run(3.0)
    # The edge that touches it lies nearly flat: legs of 0.5 and 0.45 m rise by 2 cm.
    legs = np.hypot(0.02, np.array([0.5, 0.45]))
    tension = 100.0 * ((legs.sum() + 0.05) * 1.01 - 1.0)
    expected = tension * float((0.02 / legs).sum())
    load = sim.body_loads()["bar"]
    assert load.force[1] == pytest.approx(-expected, rel=1e-2)
    assert sim.positions[:, 1].max() == pytest.approx(0.02, rel=0.06)  # the nodes beside it, 2.5 cm off
    assert np.abs(load.force[[0, 2]]).max() < 0.02 * expected


def test_nodes_alone_do_not_feel_a_thin_bar_that_edges_feel() -> None:
    sweep = {"centre": (0.525, -0.01, 0.0), "travel_y": rising(0.02), "stiffness": 1e3}
    for felt_by, is_felt in (("edges", True), ("nodes", False)):
        sim = Simulation(scene_of(string(), [Cylinder("bar", 0.004, felt_by=felt_by, **sweep)]))  # type: ignore[arg-type]
        sim.run(1.0)
        assert (np.abs(sim.positions[:, 1]).max() > 5e-3) == is_felt


def test_an_endless_bar_that_is_tilted_pushes_across_its_axis_alone() -> None:
    # Friction is none: the force is normal to the axis, which lies in the x-y plane at 60 degrees to the string.
    bar = Cylinder("bar", 0.01, centre=(0.5, 0.0, -0.015), direction=(1.0, np.sqrt(3.0), 0.0), travel_z=rising(0.02))
    sim = Simulation(scene_of(string(), [bar], [MassDamping(20.0)]))
    sim.run(2.0)
    force = sim.body_loads()["bar"].force
    assert force[2] < -0.01
    assert abs(force @ (1.0, np.sqrt(3.0), 0.0)) < 1e-12


@pytest.mark.parametrize("method", METHODS)
def test_a_bar_that_comes_and_goes_does_no_work_in_all(method: str) -> None:
    # Slowly against the vibrations of the string, so that it is left at rest.
    sweep = Schedule((0.0, 2.0, 4.0), (0.0, 0.04, 0.0), ease=0.5)
    bar = Cylinder("bar", 0.01, centre=(0.512, -0.03, 0.0), travel_y=sweep, stiffness=100.0)
    sim = Simulation(scene_of(string(8), [bar]), method, dt=5e-4)
    sim.step(4000)
    most = sim.ledger()["work_by_law"]["bar"]
    sim.step(4000)
    assert most > 5e-4
    assert abs(sim.ledger()["work_by_law"]["bar"]) < 5e-3 * most
    assert error_of(sim) < 5e-3


def test_the_balance_of_a_moving_bar_is_exact_to_the_order_of_the_method() -> None:
    bar = Cylinder("bar", 0.05, centre=(0.512, -0.1, 0.0), turn=rising(0.2), travel_radial=rising(0.05), stiffness=50.0)
    errors = []
    for steps in (2000, 4000):
        sim = Simulation(scene_of(string(8), [bar]), "rk4", dt=1.0 / steps)
        sim.step(steps)
        errors.append(error_of(sim))
    assert sim.ledger()["work_by_law"]["bar"] > 1e-3
    assert errors[1] < min(1e-6, errors[0])


def test_a_body_that_moves_past_the_film_is_the_film_that_moves_past_the_body() -> None:
    # One mass that flies against a plane at rest, and the same seen from a frame that flies with it.
    def bounce(speed: float, body_speed: float) -> Simulation:
        wall = Plane("wall", centre=(1.5, 0.0, 0.0), direction=(-1, 0, 0), stiffness=500.0, **drift(body_speed))
        sim = Simulation(scene_of([cord(axial_stiffness=1e-9, fixed=False, linear_density=1e-3)], [wall]), dt=1e-4)
        sim.velocities = np.array([[speed, 0.0, 0.0]] * 2)
        sim.step(8000)
        return sim

    def drift(speed: float) -> dict[str, Any]:
        return {"travel_x": Schedule((0.0, 10.0), (0.0, 10.0 * speed))} if speed else {}

    still, moving = bounce(1.0, 0.0), bounce(0.0, -1.0)
    assert still.velocities[1, 0] < -0.5
    assert moving.positions[:, 0] == pytest.approx(still.positions[:, 0] - 0.8, abs=1e-9)
    assert moving.velocities[:, 0] == pytest.approx(still.velocities[:, 0] - 1.0, abs=1e-9)


def test_a_scene_that_is_turned_moves_as_it_did() -> None:
    angle = 0.7
    values: dict[str, Any] = {"stiffness": 300.0, "friction": 0.3, "damping": 0.2}
    sine, cosine = np.sin(angle), np.cos(angle)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    mesh = Strip(0.1, 0.04, 6, 2).mesh()
    turned = replace_positions(mesh, turn)
    bar = Cylinder("bar", 0.006, centre=(0.05, 0.0, -0.008), direction=(0, 1, 0), travel_z=rising(0.02), **values)
    other = replace(bar, centre=tuple(turn @ bar.centre), direction=tuple(turn @ bar.direction))
    ends = []
    for one, body in ((mesh, bar), (turned, other)):
        scene = Scene(one, RUBBER, [Springs()], [Fixed((0, 1, 2))], bodies=[body])
        sim = Simulation(scene, "rk4", dt=1e-4)
        sim.step(3000)
        ends.append(sim.positions)
    assert np.abs(ends[0] - mesh.positions).max() > 1e-3
    assert np.abs(ends[1] - ends[0] @ turn.T).max() < 1e-9


def replace_positions(mesh: Any, turn: Any) -> Any:
    return type(mesh)(mesh.reference @ turn.T, mesh.triangles, positions=mesh.positions @ turn.T)


def test_copies_are_turned_evenly_about_the_axis() -> None:
    # Four cords outward, each pushed aside by its copy: alike, and the torque is that of all four.
    spokes = [
        Tether((0.1 * np.cos(a), 0.1 * np.sin(a), 0.0), (np.cos(a), np.sin(a), 0.0), 6, 100.0, 0.01, fixed=True)
        for a in np.pi / 2 * np.arange(4)
    ]
    held: list[Part] = [*spokes, *(Fixed(f"tether-{k}-end") for k in range(4))]
    bars = Cylinder("bars", 0.01, centre=(0.5, -0.015, 0.0), copies=4, turn=rising(0.1), stiffness=500.0)
    sim = Simulation(scene_of(held, [bars], [MassDamping(10.0)]))
    sim.run(1.5)
    load = sim.body_loads()["bars"]
    assert load.contact > 0.1
    assert np.abs(load.force).max() < 1e-9 * load.contact
    assert load.torque[2] == pytest.approx(-0.5 * load.contact, rel=0.05)
    assert sim.hub_load().torque[2] == pytest.approx(0.0, abs=1.0)
    for k in range(4):
        nodes = sim.assembly.node_sets[f"tether-{k}"]
        x, y, _ = sim.positions[nodes].T
        assert np.hypot(x, y) == pytest.approx(np.hypot(*sim.positions[:7, :2].T), abs=1e-9)


def test_damping_takes_energy_from_an_approach_and_never_pulls() -> None:
    wall = Plane("wall", centre=(1.5, 0.0, 0.0), direction=(-1, 0, 0), stiffness=500.0, damping=0.3)
    sim = Simulation(scene_of([cord(axial_stiffness=1e-9, fixed=False, linear_density=1e-3)], [wall]), dt=1e-4)
    sim.velocities = np.array([[1.0, 0.0, 0.0]] * 2)
    most = 0.0
    for _ in range(1600):
        sim.step(10)
        both = sim.forces("wall") + sim.forces("wall_friction")
        assert both[:, 0].max() <= 0.0
        most = max(most, -both[1, 0])
    assert most > 5.0
    assert -0.95 < sim.velocities[1, 0] < -0.5
    assert sim.ledger()["work_by_law"]["wall_friction"] < -0.05
    assert error_of(sim) < 1e-3


def test_a_run_stops_where_the_film_would_come_out_on_the_other_side() -> None:
    for stiffness, speed in ((1.0, 1.0), (1e3, 3000.0)):
        bar = Cylinder("bar", 0.01, centre=(0.51, -0.05, 0.0), travel_y=rising(speed), stiffness=stiffness)
        sim = Simulation(scene_of(string(), [bar]), dt=1e-4)
        with pytest.raises(UnstableError, match="deep into the body bar") as caught:
            sim.run(1.0)
        assert all(word in str(caught.value) for word in ("an edge goes", "between nodes", "stiffer", "smaller dt"))
        assert caught.value.law == "bar"


def test_the_ends_of_a_cylinder_are_round_and_felt_by_triangles() -> None:
    # From below, its end pokes into the middle of a triangle: edges do not meet it, triangles do.
    mesh = Strip(0.1, 0.1, 1, 1).mesh()
    middle = mesh.reference[mesh.triangles[0]].mean(axis=0)
    for felt_by, is_felt in (("triangles", True), ("edges", False)):
        poke = Cylinder(
            "poke",
            0.005,
            half_length=0.02,
            centre=(*middle[:2], -0.03),
            travel_z=rising(0.015),
            felt_by=felt_by,  # type: ignore[arg-type]
        )
        sim = Simulation(Scene(mesh, RUBBER, [Springs()], [], bodies=[poke]))
        sim.run(1.0)
        assert (sim.positions[:, 2].max() > 1e-3) == is_felt


def test_bodies_rest_while_a_scene_is_relaxed() -> None:
    bar = Cylinder("bar", 0.01, centre=(0.512, 0.005, 0.0), travel_y=rising(1.0), stiffness=100.0)
    sim = Simulation(scene_of(string(), [bar]))
    sim.relax(0.5)
    assert sim.body_loads()["bar"].contact > 0.01
    assert np.abs(sim.positions[:, 1]).max() < 0.01
