"""A hub that turns freely, as scenes and stages give it: its fields, files, stages and what is doubted of it."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from membrane_rs import Gravity, InputError, InputTypeError, Scene, SceneError, Schedule, Spin, Stage, scenes
from membrane_rs.check import audit, facts
from membrane_rs.scene.schema import schema
from membrane_rs.scene.toml import write_scene
from membrane_rs.simulation.continuation import scene_digest
from membrane_rs.simulation.core_input import laws_of
from membrane_rs.simulation.relaxation import held_scene
from small_scenes import cord, refused
from test_schema import faults

UP = Schedule((0.0, 0.1), (0.0, 2.0), 0.2)
PUSH = Schedule((0.0, 1.0), (0.0, 0.01))
KEY = "laws.spin."
FREE = Spin(2.0, inertia=0.5)


def turned(spin: Spin, *of_stages: dict[str, Any], **stage: Any) -> Scene:
    """A mass on a cord in stages of 0.1 s."""
    stages = [
        Stage(str(k), 0.1, set={KEY + name: value for name, value in values.items()}, **stage)
        for k, values in enumerate(of_stages)
    ]
    return Scene(None, None, [spin], [cord()], stages=stages)


def text_digest(scene: Scene) -> str:
    """Of the part of a scene's digest that is the same on all machines, without the coordinates of its mesh."""
    return hashlib.sha256(write_scene(cast(Any, scene), with_later=False).encode()).hexdigest()[:32]


def spins(scene: Scene) -> list[Any]:
    return [scene.staged(k).law("spin") for k in range(len(scene.stages))]


KNOWN = json.loads((Path(__file__).parent / "scene_digests.json").read_text())
"""Digests of the texts of scenes, before they had a free hub."""


@pytest.mark.parametrize("name", KNOWN)
def test_the_digest_of_a_scene_is_that_of_before(name: str) -> None:
    """So states and runs of earlier versions go on: fields by keyword alone are no part of a scene without them."""
    assert text_digest(scenes.load(name)) == KNOWN[name]


def test_the_digest_is_another_one_with_each_new_field() -> None:
    found = [
        scene_digest(Scene(None, None, [spin], [cord()]))
        for spin in (Spin(2.0), FREE, replace(FREE, inertia=0.6), replace(FREE, torque=PUSH))
    ]
    assert len(set(found)) == len(found)


@pytest.mark.parametrize(
    ("values", "kind", "words"),
    [
        ({"inertia": 0.0}, InputError, r"Spin.inertia = 0.0: must be greater than 0 \(kg m2\)"),
        ({"inertia": -1.0}, InputError, r"Spin.inertia = -1.0: must be greater than 0 \(kg m2\)"),
        ({"inertia": math.nan}, InputError, "Spin.inertia = nan: must be finite"),
        ({"inertia": "1 kg m2"}, InputTypeError, "Spin.inertia = '1 kg m2': must be a number"),
        (
            {"inertia": 1.0, "acceleration": 0.5},
            InputError,
            r"acceleration = 0.5: is not used with an inertia.*leave it",
        ),
        ({"inertia": 1.0, "schedule": UP}, InputError, r"Spin.schedule = Sch.*: is not used with an inertia.*leave it"),
        ({"torque": PUSH}, InputError, r"Spin.torque = Sch.*: acts on a free hub alone; give its inertia \(kg m2\)"),
        ({"inertia": 1.0, "torque": 1.0}, InputTypeError, "Spin.torque = 1.0: must be a Schedule"),
    ],
)
def test_what_contradicts_itself_is_refused(values: dict[str, Any], kind: type[Exception], words: str) -> None:
    refused(lambda: Spin(**values), kind, words)


def test_the_core_is_given_what_is_set() -> None:
    scene = Scene(None, None, [replace(FREE, torque=PUSH)], [cord()])
    ((kind, given),) = laws_of(scene)
    expected = {"times": (0.0, 1.0), "values": (0.0, 0.01), "ease": 0.0}
    assert (kind, given["frequency"], given["inertia"], given["torque"]) == ("spin", 2.0, 0.5, expected)
    assert (given["acceleration"], given["schedule"]) == (0.0, None)
    assert not {"inertia", "torque"} & Spin(2.0).core_parameters().keys()
    assert Spin(inertia=1.0).frequency == 3.0


def test_a_file_holds_them_with_units(tmp_path: Path) -> None:
    text = """
[laws.spin]
frequency = "120 rpm"
inertia = "5000 kg cm2"
torque = {times = [0.0, 1.0], values = [0.0, "10 mN m"]}
[[parts]]
kind = "tether"
start = [0, 0, 0]
end = [1, 0, 0]
segments = 1
axial_stiffness = 100
linear_density = 0
tip_mass = 1.0
"""
    assert faults(text) == []
    (tmp_path / "scene.toml").write_text(text)
    scene = Scene.from_toml(tmp_path / "scene.toml")
    assert scene.law("spin") == replace(FREE, torque=PUSH)
    scene.save(tmp_path / "again")
    again = Scene.from_toml(tmp_path / "again" / "scene.toml")
    assert (again.laws, again.to_toml()) == (scene.laws, scene.to_toml())
    assert "inertia = 0.5  # kg m2" in scene.to_toml()
    assert "# inertia: not set  # kg m2\n# torque: not set  # N m" in Scene(None, None, [Spin()], [cord()]).to_toml()


@pytest.mark.parametrize(
    "line",
    [
        "inertia = 0", "inertia = 1\nacceleration = 1", "inertia = 1\nschedule = {times = [0], values = [1]}",
        "torque = {times = [0], values = [1]}", 'inertia = "-1 kg m2"',
    ],
)  # fmt: skip
def test_the_schema_refuses_what_the_law_does(line: str) -> None:
    assert faults(f'[laws.spin]\n{line}\n[mesh]\npattern = "disc"\nradius = 0.1\nrings = 2\n') != []
    assert schema()["properties"]["laws"]["properties"]["spin"]["properties"]["inertia"]["description"]


def test_a_hub_set_free_by_a_stage_stays_so() -> None:
    """At the rate that it has, as far as that is known before the run; driven again, it stays that."""
    scene = turned(Spin(1.0), {"schedule": UP}, {"inertia": 0.5, "torque": PUSH}, {}, {"torque": None}, {})
    held, later = PUSH.delayed(0.1), Spin(2.0, inertia=0.5)
    assert spins(scene) == [Spin(schedule=UP), *[replace(later, torque=held)] * 2, later, later]
    again = turned(Spin(schedule=UP), {"inertia": 0.5, "frequency": 1.0}, {"inertia": None, "frequency": 4.0}, {})
    assert spins(again) == [Spin(1.0, inertia=0.5), Spin(4.0), Spin(4.0)]
    ramp = turned(FREE, {}, {"inertia": None, "schedule": UP}, {}, {"inertia": 0.25}, {})
    assert spins(ramp) == [FREE, *[Spin(schedule=UP.delayed(0.1))] * 2, *[Spin(2.0, inertia=0.25)] * 2]


def test_an_inertia_replaces_acceleration_and_schedule_alone() -> None:
    assert spins(turned(Spin(2.0, 0.5), {"inertia": 0.5})) == [FREE]
    assert spins(turned(Spin(2.0, 0.5), {}, {"inertia": 0.5})) == [Spin(2.0, 0.5), Spin(2.0 + 0.05, inertia=0.5)]
    assert spins(turned(FREE, {}, {"inertia": 0.7})) == [FREE, replace(FREE, inertia=0.7)]
    assert spins(turned(FREE, {"frequency": 3.0}, {})) == [replace(FREE, frequency=3.0)] * 2


def test_a_hub_that_was_not_at_work_begins_at_rest() -> None:
    scene = turned(FREE, {}, {})
    stages = [replace(scene.stages[0], without=("spin",)), scene.stages[1]]
    assert replace(scene, stages=stages).staged(1).law("spin") == replace(FREE, frequency=0.0)


@pytest.mark.parametrize("of_stages", [({}, {"frequency": 3.0}), ({}, {"frequency": 3.0, "inertia": 0.5})])
def test_a_frequency_without_effect_is_refused(of_stages: tuple[dict[str, Any], ...]) -> None:
    words = r"stages\[1\]: laws.spin.frequency = 3.0: has no effect: a free hub goes on at the rate that it has; leave"
    refused(lambda: turned(FREE, *of_stages), SceneError, words)
    scaled = [Stage("a", 0.1), Stage("b", 0.1, scale={KEY + "frequency": 2.0})]
    refused(lambda: replace(turned(FREE), stages=scaled), SceneError, "has no effect: a free hub goes on")


def test_a_schedule_without_a_rate_in_its_place_is_refused() -> None:
    words = "inertia = 0.5: stands in place of the schedule of the scene, and no rate is given; set the frequency too"
    refused(lambda: turned(Spin(schedule=UP), {"inertia": 0.5}), SceneError, words)
    whole = Scene(None, None, [Spin(schedule=UP)], [cord()])
    refused(lambda: whole.with_values({KEY + "inertia": 0.5}), InputError, words)
    refused(
        lambda: turned(Spin(schedule=UP), {}, {"inertia": 0.5}, {"inertia": None}), SceneError, "set a frequency or"
    )
    free = whole.with_values({KEY + "inertia": 0.5, KEY + "frequency": 2.0})
    assert free.law("spin") == FREE
    assert free.with_values({KEY + "inertia": None}).law("spin") == Spin(2.0)
    torque = r"stages\[1\]: laws.spin.torque = .* leave the torque out, \{\} in a stage"
    refused(lambda: turned(replace(FREE, torque=PUSH), {}, {"inertia": None}), SceneError, torque)


def test_relaxation_drives_the_hub_at_its_rate() -> None:
    scene = Scene(None, None, [replace(FREE, torque=PUSH), Gravity()], [cord()])
    held = held_scene(scene, 5.0, 3.0 * math.tau)
    assert held.law("spin") == Spin(3.0)
    assert held_scene(Scene(None, None, [Spin(schedule=UP)], [cord()]), 5.0, 1.0).law("spin") == Spin(schedule=UP)


def test_an_inertia_that_is_hardly_meant_is_doubted() -> None:
    """The sail, 1 kg at 1 m, has a moment of inertia of 1 kg m2."""

    def doubts(inertia: float, **spin: Any) -> list[str]:
        scene = Scene(None, None, [Spin(0.5, inertia=inertia, **spin)], [cord()])
        return [
            finding.message for finding in audit(scene, costly=False).findings if finding.kind == "implausible_value"
        ]

    assert [doubts(value) for value in (1e-5, 1.0, 1e8)] == [[], [], []]
    assert "laws.spin.inertia = 1e-07 kg m2: that is 1e-07 times the moment of inertia of the sail" in doubts(1e-7)[0]
    assert "times the moment of inertia of the sail at the start, 1 kg m2" in doubts(1e10)[0]
    assert "laws.spin.torque (at most)" in doubts(1.0, torque=Schedule((0.0,), (1e4,)))[0]
    assert doubts(1e-3, torque=Schedule((0.0,), (1.0,))) == []


def test_a_free_hub_at_rest_is_not_idle() -> None:
    scene = Scene(None, None, [Spin(0.0, inertia=0.5)], [cord()])
    (spin,) = scene.laws
    assert spin.why_idle(scene) is None
    assert Spin(0.0).why_idle(scene) == "the hub does not turn"


def test_it_is_named_in_the_facts() -> None:
    assert facts(Scene(None, None, [FREE], [cord()]))["spin"] == "2 Hz at the start, then freely: a hub of 0.5 kg m2"
    assert "under a torque" in facts(Scene(None, None, [replace(FREE, torque=PUSH)], [cord()]))["spin"]
    assert facts(Scene(None, None, [Spin(2.0)], [cord()]))["spin"] == "2 Hz"


@pytest.mark.parametrize("ease", [0.0, 0.2, 0.5])
def test_the_integral_of_a_schedule_is_that_of_its_values(ease: float) -> None:
    steps = Schedule((0.0, 1.0, 1.0, 3.0), (1.0, 2.0, 5.0, -1.0), ease)
    for start, end in ((-1.0, 0.3), (0.3, 0.99), (1.01, 2.4), (2.4, 4.0), (2.9, 1.2)):
        times = np.linspace(start, end, 20_001)
        values = np.array([steps.at(time) for time in times])
        expected = float((values[1:] + values[:-1]).sum() * 0.5 * (times[1] - times[0]))
        assert steps.integral(start, end) == pytest.approx(expected, abs=1e-7)
    assert steps.integral(-1.0, 4.0) == pytest.approx(1.0 + 1.5 + 4.0 - 1.0, abs=1e-14)
    assert Spin(inertia=2.0, torque=steps).fastest_turning(4.0) == pytest.approx(3.0 + 5.5 / (2.0 * math.tau))
