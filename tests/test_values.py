"""Scenes with other values, by dotted keys."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any

import pytest
from example_of import needed
from membrane_rs import Cylinder, Scene, Schedule, Spin, Stage, TipMasses, scenes
from membrane_rs.errors import InputError, InputTypeError, SceneError
from membrane_rs.scene.laws import LAWS
from small_scenes import cord, hanging_strip, patch, refused
from staged_scenes import oscillator

BAR = Cylinder("bar", 0.01, centre=(0.0, 0.0, -1.0), travel_z=Schedule((0.0, 1.0), (0.0, 0.1)))


def staged_scene() -> Scene:
    stages = Stage("one", 0.1, set={"laws.mass_damping.rate": 5.0}), Stage("two.a", 0.2)
    return replace(oscillator(), bodies=[BAR], stages=stages)


def value_of(scene: Scene, key: str) -> Any:
    """The value of a key, read without the mechanism that sets it."""
    section, _, rest = key.partition(".")
    if section == "stages":
        stage, name = next((stage, rest.removeprefix(f"{stage.name}.")) for stage in scene.stages if stage.name in rest)
        return stage.set[name.removeprefix("set.")] if name.startswith("set.") else getattr(stage, name)
    owner: Any = scene
    for name in ["mesh", "source", rest] if section == "mesh" else key.split("."):
        if isinstance(owner, tuple):
            by_name = {getattr(item, "name", None) or item.kind: item for item in owner}
            owner = by_name[name] if name in by_name else owner[int(name)]
        else:
            owner = getattr(owner, name)
    return owner


@pytest.mark.parametrize(
    ("scene", "key", "value"),
    [
        (hanging_strip(), "laws.springs.buckling", 7.0),
        (hanging_strip(), "laws.creases.stiffness", 20),
        (hanging_strip(), "material.thickness", 1e-5),
        (hanging_strip(), "mesh.columns", 8),
        (hanging_strip(), "mesh.rows", 3.0),
        (hanging_strip(), "run.dt", 1e-6),
        (hanging_strip(), "parts.0.nodes", "end"),
        (hanging_strip(), "name", "other"),
        (staged_scene(), "laws.mass_damping.rate", 3.0),
        (staged_scene(), "parts.1.mass", 4.0),
        (staged_scene(), "parts.spring.tip_mass", 4.0),
        (staged_scene(), "bodies.bar.radius", 0.02),
        (staged_scene(), "bodies.bar.travel_z.ease", 0.2),
        (staged_scene(), "stages.one.duration", 0.3),
        (staged_scene(), "stages.two.a.duration", 0.4),
        (staged_scene(), "stages.one.set.laws.mass_damping.rate", 6.0),
        (staged_scene(), "stages.two.a.set.parts.1.mass", 6.0),
        (staged_scene(), "run.integrator", "leapfrog"),
    ],
)
def test_a_value_is_set_and_no_other(scene: Scene, key: str, value: Any) -> None:
    before, text = scene.to_toml(), scene.with_values({key: value}).to_toml()
    made = scene.with_values({key: value})
    assert value_of(made, key) == value == made.value(key)
    assert scene.to_toml() == before
    old, new = before.splitlines(), text.splitlines()
    if key != "laws.creases.stiffness":  # which adds the law
        changed = [(a, b) for a, b in zip(old, new, strict=True) if a != b]
        assert len(changed) == 1, changed
    assert [type(law) for law in made.laws][: len(scene.laws)] == [type(law) for law in scene.laws]


def test_several_values_at_once() -> None:
    scene = hanging_strip()
    both = scene.with_values({"mesh": {"columns": 8, "rows": 1}, "laws.creases": {"stiffness": 5, "collapse": 0.1}})
    assert both.mesh is not None
    assert len(both.mesh.reference) == 9 * 2
    law = both.law("creases")
    assert (law.stiffness, law.collapse) == (5, 0.1)  # type: ignore[union-attr]
    assert scene.with_values({}).to_toml() == scene.to_toml()


def test_laws_are_added_and_left_out() -> None:
    scene = hanging_strip()
    film = scene.with_values({"laws.springs": False, "laws.triangles": True})
    assert [law.kind for law in film.laws] == ["spring_damping", "gravity", "triangles"]
    assert film.with_values({"laws.triangles": {}}).to_toml() == film.to_toml()
    assert scene.with_values({"laws.creases": False}).to_toml() == scene.to_toml()
    assert scene.with_values({"parts.0": False}).parts == ()
    for kind, law in LAWS.items():
        own = {name: value for name, value in needed(law).items() if not isinstance(value, Schedule)}
        rest = {"laws.springs": False} if law.is_film else {}
        added = scene.with_values({**rest, f"laws.{kind}": own or True}).law(kind)
        assert added == law(**own)


def test_a_value_stands_in_place_of_others() -> None:
    ramp = Spin(schedule=Schedule((0.0, 1.0), (3.0, 1.0)))
    scene = Scene(None, None, [ramp], [cord()])
    assert scene.with_values({"laws.spin.frequency": 2.0}).law(Spin) == Spin(2.0)
    table = {"times": [0.0, 1.0], "values": [1.0, 2.0]}
    again = scene.with_values({"laws.spin.frequency": 2.0}).with_values({"laws.spin.schedule": table})
    assert again.law(Spin) == Spin(schedule=Schedule((0.0, 1.0), (1.0, 2.0)))
    assert again.with_values({"laws.spin.schedule": None}).law(Spin) == Spin()
    assert again.with_values({"laws.spin.schedule": {}}).law(Spin) == Spin()


@pytest.mark.parametrize(
    ("values", "kind", "words"),
    [
        ({"law.springs.buckling": 1}, SceneError, r"^law\.springs\.buckling = 1: this .* mean 'laws.springs.buckling'"),
        ({"buckling": 1}, SceneError, "buckling = 1: this scene .*'laws.springs.buckling'"),
        ({"rpm": 25}, SceneError, "rpm = 25: this scene has no value of that name; did you mean 'laws.spin.frequency'"),
        (
            {"laws.spin.omega": 1},
            SceneError,
            r"omega = 1: no such key; did you mean 'laws.spin.frequency' \(in Hz: omega",
        ),
        ({"laws.springs.bucklin": 1}, SceneError, "bucklin = 1: no such key; did you mean 'laws.springs.buckling'"),
        ({"laws.springs.buckling": -1}, InputError, "^laws.springs.buckling = -1: must be at least 0"),
        ({"material.thickness": True}, InputTypeError, r"thickness = True: must be a number, greater than 0 \(m\)"),
        ({"material.thickness": {}}, InputTypeError, r"^material.thickness = \{\}: must be a number, greater than 0"),
        ({"material.softening": {}}, InputTypeError, r"^material.softening = \{\}: must be a number, at least 1"),
        ({"run.dt": {}}, InputTypeError, r"^run.dt = \{\}: must be a number, greater than 0 \(s\)"),
        ({"run.integrator": {}}, InputTypeError, r"^run.integrator = \{\}: must be a text"),
        ({"laws.springs": 3}, SceneError, "laws.springs = 3: must be a table of its keys, true or false; or set"),
        ({"material": False}, SceneError, "material = False: must be a table of its keys; or set one key"),
        ({"parts": 3}, SceneError, "parts = 3: this scene has no value of that name; did you mean 'parts.0"),
        ({"laws.spn": 3}, SceneError, "laws.spn = 3: this scene has no value of that name; did you mean 'laws.spin'"),
        ({"": 3}, SceneError, "^'' = 3: this scene has no value of that name; give one such as"),
        ({"a\nb": 3}, SceneError, r"^'a\\nb' = 3: this scene has no value"),
        ({"x" * 2000: 3}, InputTypeError, "^key 'xxx.*: must be a name such as"),
        ({3: 3}, InputTypeError, "^key 3: must be a name such as"),
        ([], InputTypeError, r"^values = \[\]: must be a table"),
        ({"laws.triangles": True}, SceneError, "^with laws.triangles = True: laws.springs and laws.triangles: each is"),
        ({"laws.springs": False, "laws.springs.buckling": 1}, SceneError, "laws.springs = False: keys of it are set"),
        ({"laws.springs": {"buckling": 2}, "laws.springs.buckling": 1}, SceneError, "sets the same value; leave out"),
        ({"laws.springs.buckling.x": 1}, SceneError, "laws.springs.buckling is no table; leave .x out"),
        ({"mesh.columns": 0}, InputError, "mesh.columns = 0: must be at least 1"),
        ({"mesh.columns": 7}, InputError, "falls inside one of 7 columns"),
        ({"parts.0.nodes": "top"}, SceneError, "^with parts.0.nodes = 'top': .*no such node set"),
        ({"run.frames": "8"}, InputTypeError, "must be a whole number"),
        (
            {"run.integrator": "leapfrogs"},
            InputError,
            "run.integrator = 'leapfrogs': is no method; did you mean 'leapfr",
        ),
        ({"run.integrator": "nope"}, InputError, "run.integrator = 'nope': is no method; known are: .*leapfrog.*rk4"),
        ({"run.integrator": 4}, InputTypeError, "run.integrator = 4: must be"),
        ({"name": "a/b"}, SceneError, "with name = 'a/b': Scene.name"),
    ],
)
def test_wrong_keys_and_values(values: Any, kind: type[Exception], words: str) -> None:
    refused(lambda: hanging_strip().with_values(values), kind, words)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"run.until": 1.0}, "run.until = 1.0: the run ends with the last of the stages; set stages.two.a.duration"),
        ({"parts.0.tip_mass": 2.0, "parts.spring.tip_mass": 3.0}, "parts.0.tip_mass sets the same value"),
        ({"stages.three.duration": 1.0}, "did you mean 'stages.one.duration'"),
        ({"laws.mass_damping": False}, r"^with laws.mass_damping = False: stages\[0\].*laws has no 'mass_damping'"),
        ({"stages.one.set.laws.x.y": 1.0}, r"^with stages.one.set.laws.x.y = 1.0: stages\[0\]\.set: 'laws.x.y'"),
        ({"stages.one": False}, "stages.one = False: must be a table of its keys; or set one key"),
        ({"bodies.bar.travel_z.eas": 0.1}, "eas = 0.1: no such key; did you mean 'bodies.bar.travel_z.ease'"),
    ],
)
def test_wrong_keys_and_values_of_stages(values: dict[str, Any], words: str) -> None:
    refused(lambda: staged_scene().with_values(values), SceneError, words)


def test_values_and_units_by_keys() -> None:
    scene = staged_scene()
    assert scene.value("bodies.bar.travel_z.values") == (0.0, 0.1)
    assert scene.value("stages.one.set.laws.mass_damping.rate") == 5.0
    units = {
        "name": "",
        "parts.1.mass": "kg",
        "parts.1.nodes": "",
        "laws.spin.frequency": "Hz",
        "laws.creases.stiffness": "",
        "bodies.bar.travel_z": "m",
        "bodies.bar.travel_z.values": "m",
        "bodies.bar.travel_z.times": "s",
        "bodies.bar.turn.values": "rad",
        "stages.one.duration": "s",
        "stages.one.set.bodies.bar.radius": "m",
        "stages.one.scale.bodies.bar.radius": "",
    }
    assert {key: scene.unit(key) for key in units} == units
    ended = scene.with_values({"stages.one.measure": "hub_torque", "stages.one.above": "3 mN m"})
    assert (ended.unit("stages.one.above"), ended.value("stages.one.above")) == ("N m", 3e-3)
    for key, words in {
        "laws.creases.stiffness": "laws.creases.stiffness: the scene has no laws.creases",
        "laws.creases": "'laws.creases': no such key; name one, such as laws.creases.stiffness",
        "stages.two.a.set.run.dt": "stages.two.a.set.run.dt: is not set",
        "bodies.bar.turn.ease": "bodies.bar.turn.ease: is not set; bodies.bar.turn is None",
        "bodies.bar.radios": "no such key; did you mean 'bodies.bar.radius'",
        "body.bar.radius": "did you mean 'bodies.bar.radius'",
    }.items():
        refused(lambda key=key: scene.value(key), SceneError, words)  # type: ignore[misc]
    refused(lambda: scene.unit(3), InputTypeError, "key = 3: must be a dotted key")  # type: ignore[arg-type]


def test_a_mesh_of_no_pattern_has_no_keys() -> None:
    scene = replace(hanging_strip(), mesh=patch(), parts=[TipMasses(1e-3)])
    refused(lambda: scene.with_values({"mesh.rows": 3}), SceneError, "mesh.rows = 3: this scene has no value of that")


@pytest.mark.parametrize("name", scenes.names())
def test_every_key_of_a_scene_takes_its_own_value(name: str) -> None:
    scene = scenes.load(name)
    values = {f"run.{entry.name}": getattr(scene.run, entry.name) for entry in fields(scene.run)}
    if scene.stages:
        del values["run.until"]
    sections: list[tuple[str, Sequence[Any]]] = [("laws", scene.laws), ("parts", scene.parts), ("bodies", scene.bodies)]
    for section, items in sections:
        for k, item in enumerate(items):
            own = getattr(item, "name", None) or (item.kind if section == "laws" else k)
            values |= {f"{section}.{own}.{entry.name}": getattr(item, entry.name) for entry in fields(item)}
    if scene.material is not None:
        values |= {f"material.{entry.name}": getattr(scene.material, entry.name) for entry in fields(scene.material)}
    for stage in scene.stages:
        values |= {f"stages.{stage.name}.{entry.name}": getattr(stage, entry.name) for entry in fields(stage)}
    assert scene.with_values(values).to_toml() == scene.to_toml()


def test_a_scene_without_film_says_so() -> None:
    words = r"^material\.thickness = 1: this scene has no value of that name; it has no material$"
    refused(lambda: scenes.load("spinning-tether").with_values({"material.thickness": 1}), SceneError, words)
