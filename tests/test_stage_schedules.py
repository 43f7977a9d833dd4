"""Schedules in stages: from when they count, and how long they hold; bodies that push in one stage alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from membrane_rs import (
    Moved,
    Plane,
    RunSettings,
    Scene,
    SceneError,
    Schedule,
    Simulation,
    Spin,
    Stage,
    Tether,
    TipMasses,
    scenes,
)
from membrane_rs.results import read_history
from membrane_rs.runs import resume
from small_scenes import refused
from staged_scenes import free, oscillator, started

IN = Schedule((0.0, 0.1), (0.0, -0.2), ease=0.5)
OUT = Schedule((0.05,), (0.3,))
WALL = Plane("wall", centre=(2.2, 0.0, 0.0), direction=(-1.0, 0.0, 0.0), stiffness=1e4)


def scene_of(*stages: Stage, wall: Plane = WALL) -> Scene:
    return replace(oscillator(), bodies=[wall], stages=stages)


def travel(scene: Scene, index: int, starts: list[float] | None = None) -> Schedule | None:
    return scene.staged(index, starts).bodies[0].travel_x


def test_a_schedule_counts_from_the_start_of_its_stage_and_holds_in_later_ones() -> None:
    stages = [Stage(name, 0.5) for name in "abcd"]
    stages[1] = replace(stages[1], set={"bodies.wall.travel_x": IN})
    stages[3] = replace(stages[3], set={"bodies.wall.travel_x": OUT})
    scene = scene_of(*stages)
    assert travel(scene, 0) is None
    assert travel(scene, 1) == travel(scene, 2) == IN.delayed(0.5)
    assert travel(scene, 3) == OUT.delayed(1.5)
    assert travel(scene, 2, [0.0, 0.1, 0.3]) == IN.delayed(0.1)
    assert travel(scene, 3, [1.0, 1.1, 1.3, 1.4]) == OUT.delayed(1.4)


def test_a_schedule_of_the_scene_counts_from_the_first_stage() -> None:
    scene = scene_of(Stage("a", 0.5), Stage("b", 0.5), wall=replace(WALL, travel_x=IN))
    assert travel(scene, 0) == travel(scene, 1) == IN
    assert travel(scene, 1, [2.0, 2.5]) == IN.delayed(2.0)
    other = Stage("b", 0.5, set={"bodies.wall.stiffness": 20.0})
    wall = scene_of(Stage("a", 0.5), other, wall=replace(WALL, travel_x=IN)).staged(1, [2.0, 2.5]).bodies[0]
    assert (wall.stiffness, wall.travel_x) == (20.0, IN.delayed(2.0))


def test_a_table_is_a_schedule_and_is_written_as_one(tmp_path: Path) -> None:
    table = {"times": [0.0, 0.1], "values": [0.0, -0.2], "ease": 0.5}
    scene = scene_of(Stage("a", 0.5, set={"bodies.wall.travel_x": table}))
    assert scene.stages[0].set == {"bodies.wall.travel_x": IN}
    scene.save(tmp_path)
    again = Scene.from_toml(tmp_path / "scene.toml")
    assert again.stages == scene.stages
    assert 'set = {"bodies.wall.travel_x" = {times = [0.0, 0.1], values = [0.0, -0.2], ease = 0.5}}' in again.to_toml()
    wrong = {"times": [1.0, 0.5], "values": [0.0, 1.0]}
    refused(lambda: Stage("a", 1.0, set={"bodies.wall.travel_x": wrong}), Exception, r"times\[1\] = 0.5")
    for key, value, words in (
        ("bodies.wall.travel_x", 3.0, "bodies.wall.travel_x = 3.0: must be a Schedule"),
        ("bodies.wall.travel", IN, "bodies.wall.travel: no such key; did you mean 'travel_z'?"),
        ("bodies.bars.turn", IN, "bodies has no 'bars'; known are: 0, wall"),
        ("bodies.1.turn", IN, "bodies has no '1'"),
    ):
        stage = Stage("a", 1.0, set={key: value})
        refused(lambda stage=stage: scene_of(stage), SceneError, words)  # type: ignore[misc]


def test_a_body_that_pushes_in_one_stage_alone(tmp_path: Path) -> None:
    stages = (
        free("wait", 0.05, without=("wall",)),
        free("push", 0.2, set={"bodies.wall.travel_x": Schedule((0.0, 0.1), (-0.6, -0.9), ease=0.5)}),
        free("gone", 0.1, without=("wall",)),
    )
    sim = started(scene_of(*stages), "rk4", 1e-4)
    sim.run(out=tmp_path / "run", frames=4, samples=61, pictures=False)
    table = read_history(tmp_path / "run")
    assert table["work_wall"][-1] != 0.0
    assert (table["work_wall"][table["stage"] == 0] == 0.0).all()
    assert (np.diff(table["work_wall"][table["stage"] == 2]) == 0.0).all()
    assert np.abs(table["energy_error"]).max() < 1e-4
    assert sim.stages[1].changes.get("wall", 0.0) >= 0.0
    assert sim.stages[2].changes.get("wall", 0.0) <= 0.0
    assert sim.body_loads() == {}
    assert resume(tmp_path / "run").time == sim.time


@pytest.mark.parametrize("early", [True, False])
def test_a_body_goes_on_where_a_measure_ends_its_stage_early(early: bool) -> None:
    scene = scene_of(
        free("one", 0.2, measure=lambda sim: sim.time, above=0.07 if early else 1.0),
        free("two", 0.2, set={"bodies.wall.travel_x": Schedule((0.0, 0.1), (0.0, -0.5))}),
    )
    sim = started(scene, "rk4", 1e-3)
    sim.run()
    start = 0.07 if early else 0.2
    assert sim.boundaries == [pytest.approx(start, abs=1e-15)]
    assert sim.stage_scene.bodies[0].travel_x == Schedule((0.0, 0.1), (0.0, -0.5)).delayed(sim.boundaries[0])
    assert sim.time == pytest.approx(start + 0.2, abs=1e-12)


def test_a_moved_node_and_a_hub_that_spins_up_through_stages(tmp_path: Path) -> None:
    drive = Schedule((0.0, 0.2), (0.0, 0.1), ease=0.5)
    part = Tether((0.2, 0.0, 0.0), (1.0, 0.0, 0.0), 1, 1e3, 0.0, tip_mass=1.0, fixed=False, strain_limit=1e6)
    parts = [part, TipMasses(1.0, (0,)), Moved((0,), z=drive, name="driver")]
    stages = (
        Stage("wait", 0.1, set={"parts.driver.z": Schedule((0.0,), (0.0,))}),
        Stage("drive", 0.25, set={"parts.driver.z": drive, "run.dt": 5e-4}),
        Stage("hold", 0.1, set={"run.integrator": "leapfrog"}),
    )
    speed = Schedule((0.0, 0.4), (0.5, 1.0), ease=0.5)
    scene = Scene(None, None, [Spin(schedule=speed)], parts, stages=stages, run=RunSettings(dt=1e-3, snapshots=()))
    sim = Simulation(scene)
    sim.run(0.2, out=tmp_path / "part", frames=3, samples=5, pictures=False)
    whole = Simulation(scene)
    for time in np.linspace(0.01, 0.45, 45):
        whole.reach(float(time))
        rates = np.array([speed.at(float(t)) for t in np.linspace(0.0, time, 2001)])
        turns = time / 2000 * (rates.sum() - 0.5 * (rates[0] + rates[-1]))
        assert whole.hub_angle == pytest.approx(2.0 * np.pi * turns, rel=1e-6)
        assert abs(whole.ledger()["error"]) < 1e-5
    assert whole.positions[0, 2] == pytest.approx(0.1, abs=1e-12)
    assert set(whole.ledger()["changes"]) <= {"drive: kinetic", "hold: kinetic"}
    again = resume(tmp_path / "part", until=0.45)
    assert (again.positions == whole.positions).all()
    assert again.ledger() == whole.ledger()
    assert read_history(tmp_path / "part")["work_moved"][-1] == whole.ledger()["work_by_law"]["moved"]


def test_a_setting_of_a_stage_is_judged_by_that_stage() -> None:
    """Substeps that a stage sets beside a method without them have no effect, in the stage that is at work."""
    scene = scenes.load("spinning-tether")
    stage = Stage("fly", 1e-3, set={"run.integrator": "rk4", "run.substeps": 4})
    staged = replace(scene, stages=[stage])
    found = [finding.message for finding in Simulation(staged).audit().findings]
    assert any("substeps" in message for message in found)
