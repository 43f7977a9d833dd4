"""Bodies in scenes and their files: what they refuse, and what they are called."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from example_of import example_of
from membrane_rs import Cylinder, InputError, Plane, Scene, SceneError, Schedule, Simulation, Stage
from membrane_rs.check import audit
from membrane_rs.results.history_table import FIRST_COLUMNS, OF_STAGES, RENAMED
from membrane_rs.scene.bodies import BODIES
from small_scenes import cord

BARS = """
[[parts]]
kind = "tether"
start = [0.0, 0.0, 0.0]
end = [1.0, 0.0, 0.0]
segments = 4
axial_stiffness = 10.0
linear_density = 0.01

[[bodies]]
kind = "cylinder"
name = "bars"
radius = 0.003
centre = [0.034, 0.0, 0.0]
copies = 4
turn = {times = [0.0, 4.0], values = [0.0, -6.81], ease = 0.1}
friction = 0.3
"""


def scene_of(*bodies: Any) -> Scene:
    return Scene(None, None, [], [cord()], bodies=bodies)


def test_a_scene_file_holds_bodies_and_gives_them_back(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(BARS)
    scene = Scene.from_toml(tmp_path / "scene.toml")
    turn = Schedule((0.0, 4.0), (0.0, -6.81), ease=0.1)
    assert scene.bodies == (Cylinder("bars", 0.003, centre=(0.034, 0, 0), copies=4, turn=turn, friction=0.3),)
    (tmp_path / "again.toml").write_text(scene.to_toml())
    assert Scene.from_toml(tmp_path / "again.toml").bodies == scene.bodies
    sim = Simulation(scene)
    assert set(sim.body_loads()) == {"bars"}
    assert sim.forces("bars_friction").shape == (5, 3)


@pytest.mark.parametrize("kind", BODIES)
def test_each_body_is_written_and_read(kind: str, tmp_path: Path) -> None:
    cls: Any = BODIES[kind]
    body = example_of(cls, damping=0.1)
    assert body.turn is not None
    (tmp_path / "scene.toml").write_text(scene_of(body).to_toml())
    assert Scene.from_toml(tmp_path / "scene.toml").bodies == (body,)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"radius": 0}, r"radius = 0: must be greater than 0 \(m\)"),
        ({"radius": math.nan}, "radius = nan: must be finite"),
        ({"half_length": 0}, "half_length = 0: must be greater than 0"),
        ({"copies": 0}, "copies = 0: must be at least 1 and at most 1000"),
        ({"copies": 10**9}, "at most 1000"),
        ({"copies": 2.5}, "whole number"),
        ({"direction": (0, 0, 0)}, "direction = .*must not be 0"),
        ({"direction": (0, math.inf, 0)}, "must be finite"),
        ({"centre": (0, 0)}, "three numbers"),
        ({"centre": (0, 0, math.nan)}, "must be finite"),
        ({"stiffness": -1}, r"greater than 0 \(N/m\)"),
        ({"damping": -0.1}, "at least 0"),
        ({"friction": -0.1}, "at least 0"),
        ({"friction_speed": 0}, r"greater than 0 \(m/s\)"),
        ({"felt_by": "film"}, "'edges', 'nodes' or 'triangles'"),
        ({"turn": 3.0}, "must be a Schedule"),
        ({"membrane": False, "cords": False}, "nothing feels the body"),
        ({"name": ""}, "letters, digits and underscores"),
        ({"name": "1bar"}, "a letter first"),
        ({"name": "b" * 41}, "40 at most"),
        ({"name": "guide bar"}, "letters"),
        ({"name": "b\u00e4r"}, "letters"),
    ],
)
def test_bad_values(values: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        example_of(Cylinder, **({"name": "bar", "radius": 0.01} | values))


def test_no_body_takes_another_column_of_the_history() -> None:
    columns = [*FIRST_COLUMNS, *OF_STAGES, *RENAMED]
    for column in columns:
        for begin in ("energy_", "work_"):
            if column.startswith(begin):
                with pytest.raises(SceneError, match="a term of the energy too; rename it"):
                    scene_of(Plane(column.removeprefix(begin)))
    assert "energy_error" in columns


@pytest.mark.parametrize(
    ("bodies", "words"),
    [
        ([Plane("a"), Cylinder("a", 0.1)], r"bodies\[1\].name = 'a': a is the name of bodies\[0\] too"),
        ([Plane("springs")], "springs is the name of a law too"),
        ([Plane("tethers")], "a law"),
        ([Plane("kinetic")], "kinetic"),
        ([Plane("moved")], "moved is the name of a law too; rename it"),
        ([Plane("a", friction=0.1), Plane("a_friction")], "a_friction is the name of"),
    ],
)
def test_names_are_unique(bodies: list[Any], words: str) -> None:
    with pytest.raises(SceneError, match=words):
        scene_of(*bodies)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[[bodies]]\nname = 'a'", r"bodies\[0\].kind: is missing; must be one of cylinder, plane"),
        ("[[bodies]]\nkind = 'sphere'", "bodies.0..kind = 'sphere': is not known"),
        ("[[bodies]]\nkind = 'cylinder'\nname = 'a'", r"bodies\[0\].radius: is missing"),
        ("[bodies]\nkind = 'cylinder'", r"write \[\[bodies\]\] above each"),
        ("[[bodies]]\nkind = 'plane'\nname = 'a'\nturn = {times = [0.0, -1.0], values = [0.0, 1.0]}", "turn.*times"),
        ("[[bodies]]\nkind = 'plane'\nname = 'a'\nradius = 1.0", "radius: no such key"),
    ],
)
def test_bad_files(text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(BARS.partition("[[bodies]]")[0] + text)
    with pytest.raises(SceneError, match=words):
        Scene.from_toml(tmp_path / "scene.toml")


def test_the_directions_of_a_body_are_of_any_length() -> None:
    forces = []
    for size in (1e-300, 1.0, 1e300):
        body = Plane("wall", centre=(0.99, 0, 0), direction=(-size, -size, 0.0))
        forces.append(Simulation(scene_of(body)).forces("wall"))
    assert np.abs(forces[0]).max() > 0.1
    assert forces[0] == pytest.approx(forces[1])
    assert forces[2] == pytest.approx(forces[1])


def test_a_stage_moves_a_body_and_the_next_one_is_without_it() -> None:
    still = Stage("wait", 0.1)
    push = Stage("push", 0.2, set={"bodies.wall.travel_x": Schedule((0.0, 0.2), (0.0, -0.1), ease=0.5)})
    gone = Stage("gone", 0.1, without=("wall",))
    wall = Plane("wall", centre=(1.05, 0, 0), direction=(-1, 0, 0), stiffness=1e3)
    scene = replace(scene_of(wall), stages=(still, push, gone))
    (moved,) = scene.staged(1).bodies
    assert moved.travel_x is not None
    assert moved.travel_x.times == pytest.approx((0.1, 0.3))
    assert replace(moved, travel_x=None) == wall
    assert scene.staged(2).bodies == ()
    sim = Simulation(scene, dt=1e-4)
    sim.run(0.1)
    assert sim.body_loads()["wall"].contact == 0.0
    sim.run(0.29)
    assert sim.positions[1, 0] < 0.95
    sim.run(0.4)
    assert sim.body_loads() == {}
    assert sim.ledger()["work_by_law"]["wall"] > 0.1
    assert abs(sim.ledger()["error"]) < 1e-5


@pytest.mark.parametrize(
    ("body", "kind", "severity", "words"),
    [
        (Cylinder("bar", 0.1, centre=(0.5, 0.02, 0.0)), "start_inside", "error", "deep into the body bar"),
        (
            Cylinder("bar", 0.1, centre=(0.5, 0.09, 0.0)),
            "start_inside",
            "warning",
            "2 nodes .* bar.* 0.01 m at most",
        ),
        (Plane("wall", centre=(0.0, 0.0, 0.001)), "start_inside", "warning", "1 nodes .* wall"),
        (Cylinder("bar", 3.0, centre=(9.0, 0.0, 0.0)), "implausible_value", "warning", "radius = 3 m"),
        (
            Cylinder("bar", 0.1, stiffness=1e9, centre=(0, 1, 0)),
            "implausible_value",
            "warning",
            "stiffness = 1e.09",
        ),
    ],
)
def test_the_audit_finds(body: Any, kind: str, severity: str, words: str) -> None:
    found = [one for one in audit(scene_of(body), costly=False).findings if one.kind == kind]
    assert any(one.severity == severity and re.search(words, one.message) for one in found), found


def test_the_audit_finds_nothing_wrong_with_a_bar_beside_a_cord() -> None:
    found = audit(scene_of(Cylinder("bar", 0.1, centre=(0.5, 0.2, 0.0))), costly=False)
    assert not found.without_facts().findings
