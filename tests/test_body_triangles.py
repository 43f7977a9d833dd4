"""Edges and triangles in contact with a cylinder: smooth forces, stable steps, film that is pierced."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from membrane_rs import Cylinder, Fixed, Material, Mesh, Scene, Schedule, Simulation, Springs, UnstableError
from membrane_rs.check import audit
from membrane_rs.folding import Strip
from small_scenes import RUBBER, Floats, rates, rotation, turned

RADIUS = 3e-3
CORNERS = np.array([[0.0, 0.0, 0.0], [0.02, 0.0, 0.0], [0.0, 0.015, 0.0]])
SOFT = Material(100.0, 0.3, 1000.0, 1e-4)
"""So soft that contact alone sets the step."""

pytestmark = pytest.mark.filterwarnings("ignore::membrane_rs.AuditWarning")


def touched(body: Cylinder, triangles: Any = ((0, 1, 2),), points: Floats = CORNERS) -> Simulation:
    return Simulation(Scene(Mesh(points, triangles), SOFT, [Springs()], [], bodies=[body]), "leapfrog", dt=1e-6)


def bar(**values: Any) -> Cylinder:
    given: dict[str, Any] = {"stiffness": 200.0, "felt_by": "triangles"}
    return Cylinder("bar", RADIUS, **(given | values))


def test_a_tilt_by_rounding_changes_forces_by_rounding() -> None:
    # Along x, half a millimetre deep, so that it crosses two edges at equal depth.
    forces = [
        touched(bar(centre=(0.005, 0.005, 0.0025), direction=(1.0, 0.0, tilt))).forces("bar")
        for tilt in (-1e-9, -1e-14, 0.0, 1e-14, 1e-9)
    ]
    assert np.abs(forces[0][:, 2]).min() > 0.01
    assert np.ptp(forces, axis=0).max() < 1e-6


def test_forces_have_no_jump_as_the_end_of_a_bar_moves_over_a_sheet() -> None:
    # Over edges and nodes, past the boundary; at 1 um per step no force may change by more than 1e-3 of the most.
    mesh = Strip(0.04, 0.04, 2, 2).mesh()
    rod = bar(half_length=0.02, centre=(0.0, 0.0, 0.0225), travel_x=Schedule((0.0, 0.05), (0.0, 0.05)))
    sim = Simulation(Scene(mesh, SOFT, [Springs()], [Fixed("start")], bodies=[rod]), "leapfrog", dt=1e-9)
    heights = []
    for place in np.arange(0.0, 0.045, 1e-6)[::10]:
        for sideways in (0.0, 1e-6):
            moved = mesh.positions - (place + sideways, 0.0002, 0.0)
            sim.positions = moved
            heights.append(sim.forces("bar"))
    pairs = np.array(heights).reshape(-1, 2, *mesh.positions.shape)
    most = np.abs(pairs).max()
    assert most > 0.1
    assert np.abs(pairs[:, 1] - pairs[:, 0]).max() < 2e-3 * most


@pytest.mark.parametrize("half_length", [None, 0.004])
def test_forces_are_the_slopes_of_the_energy_whatever_the_numbering(half_length: float | None) -> None:
    rng, felt = np.random.default_rng(1), 0
    for _ in range(40):
        points = CORNERS + rng.normal(size=(3, 3)) * 2e-3
        direction = rng.normal(size=3)
        centre = rng.dirichlet((1.0, 1.0, 1.0)) @ points + rng.normal(size=3) * 2e-3
        body = bar(centre=tuple(centre), direction=tuple(direction), half_length=half_length)
        sim = touched(body)
        sim.positions = points
        if sim.energies()["bar"] < 1e-7:
            continue
        felt += 1
        forces, slopes = sim.forces("bar"), np.zeros((3, 3))
        order = np.array([2, 0, 1])
        other = touched(body, [[1, 2, 0]], CORNERS[order])
        other.positions = points[order]
        assert other.forces("bar") == pytest.approx(forces[order], abs=1e-12)
        for node, axis in np.ndindex(3, 3):
            energies = []
            for step in (1e-8, -1e-8):
                moved = points.copy()
                moved[node, axis] += step
                sim.positions = moved
                energies.append(sim.energies()["bar"])
            slopes[node, axis] = (energies[1] - energies[0]) / 2e-8
        assert slopes == pytest.approx(forces, abs=2e-5 * 200.0 * RADIUS)
    assert felt > 15


def test_a_strip_on_edge_keeps_its_energy_beside_a_parallel_bar() -> None:
    # It stands upright, flies at 1 m/s against a bar that is upright too, and bends round it.
    mesh = Strip(0.06, 0.02, 6, 2).mesh()
    upright = turned(mesh, rotation((1.0, 0.0, 0.0), 0.5 * np.pi))
    post = bar(centre=(0.031, -0.0032, 0.0))
    errors = []
    for dt in (2e-5, 1e-5, 5e-6):
        sim = Simulation(Scene(upright, RUBBER, [Springs()], [], bodies=[post]), "leapfrog", dt=dt)
        sim.velocities = np.tile((0.0, -1.0, 0.0), (len(mesh.positions), 1))
        sim.run(0.004)
        errors.append(sim.ledger()["error"])
    assert sim.velocities[:, 1].max() > 0.1
    assert abs(errors[-1]) < 1e-4
    assert rates(errors).min() > 1.5


@pytest.mark.parametrize("half_length", [None, 0.02])
def test_film_that_an_axis_pierces_is_refused_and_stops_a_run(half_length: float | None) -> None:
    rod = Cylinder("rod", 1e-3, centre=(0.006, 0.004, 0.0), half_length=half_length, felt_by="triangles")
    scene = Scene(Mesh(CORNERS, [[0, 1, 2]]), SOFT, [Springs()], [], bodies=[rod])
    (found,) = (one for one in audit(scene).findings if one.kind == "start_inside")
    assert found.severity == "error"
    assert "a triangle goes 1.0000e-3 m deep into the body rod" in found.message
    assert "move the body away" in found.remedy
    # It comes from beside the film, so fast that it passes the edge within a step.
    fast = Schedule((0.0, 1e-3), (0.0, 0.018))
    sim = touched(
        Cylinder("rod", 1e-3, centre=(-0.01, 0.004, 0.0), half_length=half_length, felt_by="triangles", travel_x=fast)
    )
    with pytest.raises(UnstableError, match="deep into the body rod"):
        sim.run(1e-3)


@pytest.mark.parametrize("felt_by", ["nodes", "edges", "triangles"])
def test_an_axis_through_a_node_is_an_error_at_the_start(felt_by: Any) -> None:
    for half_length in (None, 0.01):
        rod = Cylinder("rod", 1e-3, centre=(0.02, 0.0, 0.0), half_length=half_length, felt_by=felt_by, damping=0.1)
        scene = Scene(Mesh(CORNERS, [[0, 1, 2]]), SOFT, [Springs()], [], bodies=[rod])
        assert next(one.severity for one in audit(scene).findings if one.kind == "start_inside") == "error"
        assert np.isfinite(Simulation(scene, "leapfrog", dt=1e-6).stable_dt())


def test_a_rod_beside_the_film_is_no_fault() -> None:
    for place in ((0.0, -0.002, 0.0), (0.013, 0.01, 0.0), (0.006, 0.004, 0.05)):
        rod = Cylinder("rod", 1e-3, centre=place, half_length=0.02, felt_by="triangles")
        scene = Scene(Mesh(CORNERS, [[0, 1, 2]]), SOFT, [Springs()], [], bodies=[rod])
        assert not [one for one in audit(scene).findings if one.kind == "start_inside"]


def depth_of_sides(points: Floats, centre: Floats, direction: Floats, half_length: float | None) -> float:
    """The largest depth of many points of the sides of a triangle."""
    share = np.linspace(0.0, 1.0, 201)[:, None, None]
    sides = (points + share * (np.roll(points, 1, axis=0) - points)).reshape(-1, 3) - centre
    height = np.clip(sides @ direction, -(half_length or np.inf), half_length or np.inf)
    return float(RADIUS - np.linalg.norm(sides - height[:, None] * direction, axis=1).min())


@pytest.mark.parametrize(("felt_by", "half_length"), [("edges", None), ("triangles", None), ("triangles", 0.004)])
def test_the_limit_of_the_step_holds_at_any_depth_and_angle(felt_by: Any, half_length: float | None) -> None:
    points = np.array([[0.0, 0.0, 0.0], [0.011, 0.0, 0.0], [0.0055, 0.011, 0.0]])
    rng, most = np.random.default_rng(0), 0.0
    for _ in range(60):
        tilt, azimuth, side = rng.uniform(0.0, 0.1), *rng.uniform(0.0, 2.0 * np.pi, 2)
        direction = (np.cos(tilt), np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth))
        off = rng.uniform(0.5, 1.0) * RADIUS * np.array([0.0, np.cos(side), np.sin(side)])
        centre = tuple(off + np.array([0.011 * rng.uniform(), 0.0, 0.0]))
        if depth_of_sides(points, np.array(centre), np.array(direction), half_length) > 0.5 * RADIUS:
            continue  # a run stops
        sim = touched(
            bar(centre=centre, direction=direction, felt_by=felt_by, half_length=half_length, stiffness=1e3),
            points=points,
        )
        limit, roots = sim.stable_dt(), 1.0 / np.sqrt(np.repeat(sim.masses, 3))
        stiffness = np.zeros((9, 9))
        for k in range(9):
            for sign in (1.0, -1.0):
                moved = points.copy()
                moved.flat[k] += sign * 1e-9
                sim.positions = moved
                stiffness[:, k] -= sign * sim.forces().ravel() / 2e-9
        squares = np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T) * np.outer(roots, roots))
        most = max(most, 0.5 * limit * float(np.sqrt(squares.max())))
    assert 0.5 < most < 1.0 + 1e-4
