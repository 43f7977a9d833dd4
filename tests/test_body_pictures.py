"""Pictures of bodies: where they stand, in which stage they are at work, and nothing twice."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from fake_simulation import FakeSimulation, small_sail
from membrane_rs import Cylinder, Plane, Schedule, Simulation, Stage
from membrane_rs.analysis.attitude import turned
from membrane_rs.plotting.matplotlib import MatplotlibPainter
from membrane_rs.plotting.painter import ProcessPainter, pyvista_works
from membrane_rs.plotting.picture import Subject
from membrane_rs.plotting.scenery import BodiesInTime, Scenery, cylinder_ends, reach_of, stage_at
from membrane_rs.scene.solid import Solid

PAINTERS = [MatplotlibPainter, *([ProcessPainter] if pyvista_works() else [])]
BARS = Cylinder(
    "bars", 0.003, centre=(0.05, 0.0, 0.0), copies=4, turn=Schedule((0.0, 2.0), (0.0, -3.0)),
    travel_radial=Schedule((0.0, 1.0), (0.0, 0.02)), tilt=Schedule((0.0, 1.0), (0.0, 0.5)),
)  # fmt: skip


def different(one: Any, other: Any) -> float:
    """Share of the pixels that differ."""
    return float((np.abs(one.astype(int) - other).max(axis=2) > 8).mean())


def of(body: Any, *, stowed: Any = None) -> BodiesInTime:
    scene = replace(small_sail(), bodies=[body])
    sim: Any = SimpleNamespace(scene=scene, stages=())
    return BodiesInTime(sim, scene.assemble().positions if stowed is None else stowed)


def test_a_body_stands_where_its_schedules_say() -> None:
    solids = BARS.solids(1.0)
    assert len(solids) == 4
    for copy, solid in enumerate(solids):
        angle = -1.5 + copy * math.pi / 2.0
        outward = np.array((math.cos(angle), math.sin(angle), 0.0))
        assert solid.centre == pytest.approx(0.07 * outward)
        assert solid.direction == pytest.approx(math.sin(0.5) * outward + [0.0, 0.0, math.cos(0.5)])
        assert (solid.radius, solid.half_length) == (0.003, None)
    assert BARS.solids(9.0)[0].centre == pytest.approx(BARS.solids(2.0)[0].centre)
    (floor,) = Plane("floor", centre=(0.0, 0.0, -0.1), direction=(0.0, 3.0, 4.0)).solids(0.0)
    assert floor.direction == pytest.approx([0.0, 0.6, 0.8])
    assert (floor.radius, floor.half_length) == (None, None)


def test_a_body_stands_where_the_core_has_it() -> None:
    """A node just below the surface of a bar as it stands now is pushed by the bar, and one just above is not."""
    scene = small_sail()
    for time in (0.0, 0.6, 1.7):
        later = {key: getattr(BARS, key).delayed(-time) for key in ("turn", "travel_radial", "tilt")}
        bars = replace(BARS, felt_by="nodes", **later)
        sim = Simulation(replace(scene, laws=scene.laws[:1], bodies=[bars]))
        for solid in BARS.solids(time):
            across = np.cross(solid.direction, (1.0, 0.0, 0.0))
            across /= np.linalg.norm(across)
            for end in cylinder_ends(replace(solid, half_length=0.01)):
                for distance, is_felt in ((0.0029, True), (0.0031, False)):
                    positions = np.full_like(sim.positions, 1.0)
                    positions[0] = end + distance * across
                    sim.positions = positions
                    assert bool(np.abs(sim.forces("bars")[0]).max() > 0.0) == is_felt


def test_endless_cylinders_are_drawn_a_little_longer_than_the_membrane() -> None:
    stowed = small_sail().assemble().positions
    (solid, *_) = of(BARS, stowed=stowed).at(0.0)
    low, high = cylinder_ends(solid)
    assert low[2] < stowed[:, 2].min() < stowed[:, 2].max() < high[2]
    assert high[2] - low[2] < 2.0 * np.ptp(stowed[:, 2]) + 0.1 * np.ptp(stowed, axis=0).max() + 1e-12
    (short, *_) = of(replace(BARS, half_length=0.5)).at(0.0)
    assert short.half_length == 0.5


@pytest.mark.parametrize(
    ("body", "count"),
    [
        (Cylinder("spool", 0.025), 0),
        (Cylinder("spool", 0.025, direction=(0.0, 0.0, -2.0)), 0),
        (Cylinder("wider", 0.03), 1),
        (Cylinder("beside", 0.025, centre=(0.1, 0.0, 0.0)), 1),
        (Cylinder("across", 0.025, direction=(1.0, 0.0, 0.0)), 1),
        (Plane("floor"), 1),
    ],
)
def test_the_spool_of_the_tethers_is_not_drawn_twice(body: Any, count: int) -> None:
    assert len(of(body).at(0.0)) == count


def test_a_body_that_is_not_at_work_is_not_drawn() -> None:
    stages: list[Any] = [SimpleNamespace(start=0.0), SimpleNamespace(start=1.0), SimpleNamespace(start=2.5)]
    three = (Stage("a", 1.0), Stage("b", 1.5, without=("bars",)), Stage("c", 1.0))
    scene = replace(small_sail(), bodies=[BARS], stages=three)
    sim: Any = SimpleNamespace(scene=scene, stages=stages)
    bodies = BodiesInTime(sim, scene.assemble().positions)
    assert [len(bodies.at(time)) for time in (0.0, 0.5, 1.0, 1.01, 2.5, 3.0)] == [4, 4, 4, 0, 0, 4]
    assert len(bodies.at(1.0, 1)) == 0
    assert len(bodies.at(2.5, 2)) == 4
    assert [stage_at(stages, time) for time in (0.0, 1.0, 1.1)] == [0, 0, 1]
    # Schedules of the scene go on through all stages.
    expected = replace(BARS, half_length=0.01).solids(3.0)
    assert [solid.direction.tolist() for solid in bodies.at(3.0)] == [solid.direction.tolist() for solid in expected]


@pytest.mark.parametrize("painter", PAINTERS)
def test_bodies_are_drawn_and_turn_with_the_hub(painter: type[Any]) -> None:
    sim: Any = FakeSimulation()
    subject = replace(Subject.of(sim, [sim.positions]), spool=None)
    artist = painter(subject, 200)
    flat = sim.assembly.reference
    bar = Solid(np.array((0.1, 0.0, 0.02)), np.array((0.6, 0.0, 0.8)), 0.01, 0.03)
    plane = Solid(np.array((0.0, 0.0, -0.01)), np.array((0.0, 0.0, 1.0)))
    bare, barred, floored = (artist.paint(flat, 0.0, Scenery(solids)) for solids in ((), (bar,), (plane,)))
    angle = 0.7
    seen = artist.paint(flat, angle, Scenery((bar,)))
    centre, direction = turned(np.stack([bar.centre, bar.direction]), angle)
    expected = artist.paint(turned(flat, angle), 0.0, Scenery((replace(bar, centre=centre, direction=direction),)))
    again = artist.paint(flat)
    artist.close()
    assert 0.002 < different(bare, barred) < 0.1
    assert different(bare, floored) > 0.1
    # One sees the membrane on a plane.
    tones = floored.reshape(-1, 3)[(np.ptp(bare.astype(int), axis=2) > 60).reshape(-1)]
    assert np.ptp(tones.astype(int), axis=1).mean() > 30
    assert different(seen, expected) < 0.01
    assert np.array_equal(again, bare)


@pytest.mark.parametrize("painter", PAINTERS)
def test_a_camera_of_a_picture_is_its_own(painter: type[Any]) -> None:
    sim: Any = FakeSimulation()
    subject = Subject.of(sim, [sim.positions])
    artist = painter(subject, 200)
    flat = sim.assembly.reference
    usual = artist.paint(flat)
    near = artist.paint(flat, 0.0, Scenery(camera=replace(subject.camera, reach=0.5 * subject.reach)))
    far = artist.paint(flat, 0.0, Scenery(camera=replace(subject.camera, reach=2.0 * subject.reach)))
    again = artist.paint(flat)
    artist.close()
    assert np.array_equal(usual, again)
    ink = [float((image.min(axis=2) < 250).mean()) for image in (near, usual, far)]
    assert ink[0] > 1.8 * ink[1] > 3.0 * ink[2]


def test_bodies_near_the_membrane_fit_into_a_picture() -> None:
    shape = np.array([(0.1, 0.0, 0.0), (0.0, -0.05, 0.0)])
    up = np.array((0.0, 0.0, 1.0))
    near, far = (Solid(np.array((x, 0.0, 0.0)), up, 0.01, 0.02) for x in (0.11, 3.0))
    assert reach_of(shape, []) == reach_of(shape, [far, Solid(np.array((9.0, 0.0, 0.0)), up)]) == pytest.approx(0.1)
    assert reach_of(shape, [near, far]) == pytest.approx(math.hypot(0.11, 0.02) + 0.01)
