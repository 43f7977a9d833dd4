"""Contact between layers as a scene has it: its fields, the triangles that it takes, its files, and its audit."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    Bridges,
    Fixed,
    Gravity,
    InputError,
    InputTypeError,
    Mesh,
    RunSettings,
    Scene,
    SceneError,
    SelfContact,
    Simulation,
    Spin,
    Springs,
    Stage,
    integrators,
    scenes,
)
from membrane_rs.check import Finding, audit, unaccepted_errors
from membrane_rs.check.redundancy import idle_laws
from membrane_rs.folding import Strip
from membrane_rs.simulation.core_input import laws_of, model_of
from membrane_rs.simulation.relaxation import held_scene
from membrane_rs.study.common.density import denser
from membrane_rs.study.common.methods import methods_of
from membrane_rs.study.variants import variants
from small_scenes import RUBBER, cord, refused
from test_scene_audit import call
from test_schema import VALIDATOR, tomllib

SAIL = scenes.load("okuizumi-model-1")
HEIGHT = RUBBER.thickness
SHEET = Strip(0.04, 0.02, 2, 2).mesh()
UPPER = len(SHEET.triangles)
"""The first triangle of the upper layer."""


def layers(height: float = 10 * HEIGHT) -> Mesh:
    """Two sheets, the upper one at a height [m]."""
    count = SHEET.node_count
    upper = SHEET.reference + np.array([0.0, 0.0, height])
    sets = {
        "lower": np.arange(count),
        "upper": np.arange(count, 2 * count),
        "upper_start": SHEET.node_sets["start"] + count,
        "both_starts": np.concatenate([SHEET.node_sets["start"], SHEET.node_sets["start"] + count]),
    }
    flat = np.vstack([SHEET.reference, SHEET.reference + np.array([0.1, 0.0, 0.0])])
    triangles = np.vstack([SHEET.triangles, SHEET.triangles + count])
    return Mesh(flat, triangles, positions=np.vstack([SHEET.reference, upper]), node_sets=sets)


def stack(law: SelfContact | None = None, mesh: Mesh | None = None, **run: Any) -> Scene:
    """Two sheets that fall, by leapfrog."""
    settings = RunSettings(**{"until": 1e-3, "integrator": "leapfrog", **run})
    laws = [Springs(), Gravity(), law or SelfContact()]
    return Scene(mesh or layers(), RUBBER, laws, [Fixed("lower")], name="stack", run=settings)


def crossed() -> Mesh:
    """The upper sheet is turned about x, so that it passes through the lower one along its middle."""
    mesh = layers(0.0)
    positions = np.array(mesh.positions)
    upper = mesh.node_sets["upper"]
    y = positions[upper, 1] - positions[upper, 1].mean() + 0.0013
    positions[upper, 2] = 0.3 * y
    return Mesh(mesh.reference, mesh.triangles, positions=positions, node_sets=dict(mesh.node_sets))


def of_kind(scene: Scene, kind: str) -> list[Finding]:
    """Findings of the audit."""
    return [finding for finding in audit(scene, costly=False).findings if finding.kind == kind]


@pytest.mark.parametrize(
    ("values", "kind", "words"),
    [
        ({"thickness": 0}, InputError, r"^SelfContact.thickness = 0: must be greater than 0 \(m\)"),
        ({"thickness": "thick"}, InputTypeError, "thickness = 'thick': must be a number"),
        ({"cord_thickness": -1e-4}, InputError, r"cord_thickness = -0.0001: must be at least 0 \(m\)"),
        ({"cords": 1}, InputTypeError, "cords = 1: must be true or false"),
        ({"friction": -0.1}, InputError, "friction = -0.1: must be at least 0"),
        ({"restitution": 1.1}, InputError, "restitution = 1.1: must be at least 0 and at most 1"),
        ({"crossing_interval": 0}, InputError, "crossing_interval = 0: must be at least 1"),
        ({"crossing_interval": 1.5}, InputTypeError, "crossing_interval = 1.5: must be a whole number"),
        ({"only": ""}, InputError, "only = '': must be the name of a node set, not an empty text"),
        ({"only": []}, InputError, "only = .*must hold at least one node"),
        ({"only": ["a", ""]}, InputError, "must hold names of node sets, not an empty text"),
        ({"only": ["a", "a"]}, InputError, "must not name a node set twice"),
        ({"without": ["a", 1]}, InputTypeError, "without = .*a list of such names or a list of node indices"),
        ({"without": [1, 1]}, InputError, "must not name a node twice"),
        ({"without": [-1]}, InputError, "none below 0"),
        ({"stiffness": 1.0}, InputTypeError, "SelfContact.stiffness: no such key"),
    ],
)
def test_values_that_are_refused(values: dict[str, Any], kind: type[InputError], words: str) -> None:
    refused(lambda: SelfContact(**values), kind, words)


def test_the_core_is_given_no_node_sets() -> None:
    law = SelfContact(1e-5, 2e-4, False, 0.3, 0.5, 200, only="upper", without=[3])
    assert law.core_parameters() == {
        "thickness": 1e-5, "cord_thickness": 2e-4, "cords": False, "friction": 0.3, "restitution": 0.5,
        "crossing_interval": 200,
    }  # fmt: skip
    assert SelfContact().core_parameters()["thickness"] is None


@pytest.mark.parametrize(
    ("choice", "wanted"),
    [
        ({}, range(2 * UPPER)),
        ({"only": "upper"}, range(UPPER, 2 * UPPER)),
        ({"without": "upper"}, range(UPPER)),
        ({"only": ["lower", "upper"]}, range(2 * UPPER)),
        ({"only": ["upper"], "without": "upper"}, ()),
        ({"without": "upper_start"}, range(2 * UPPER)),
        ({"only": SHEET.triangles[3]}, (3,)),
        ({"only": "lower", "without": tuple(SHEET.triangles[3].tolist())}, [k for k in range(UPPER) if k != 3]),
    ],
)
def test_triangles_belong_to_a_set_by_all_their_nodes(choice: dict[str, Any], wanted: Any) -> None:
    scene = stack(SelfContact(**choice))
    found = scene.assemble().layers
    assert found.triangles.tolist() == [*wanted]
    assert found.triangles.dtype == np.int64
    assert not found.triangles.flags.writeable
    assert (model_of(scene, scene.assemble()).layers.triangles == found.triangles).all()
    assert ("self_contact", scene.laws[2].core_parameters()) in laws_of(scene)


def test_a_triangle_between_two_sets_belongs_to_neither() -> None:
    x = SHEET.reference[:, 0]
    sets = {"left": np.flatnonzero(x < 0.01), "right": np.flatnonzero(x > 0.01)}
    mesh = Mesh(SHEET.reference, SHEET.triangles, node_sets=sets)
    chosen: list[tuple[Any, int]] = [(["left", "right"], UPPER // 2), (np.arange(mesh.node_count), UPPER)]
    for only, count in chosen:
        scene = Scene(mesh, RUBBER, [Springs(), SelfContact(only=only)])
        assert len(scene.assemble().layers) == count


def test_without_the_law_no_layers_feel_each_other() -> None:
    assert len(SAIL.assemble().layers) == 0
    petals = replace(SAIL, laws=[*SAIL.laws, SelfContact(only=["petal-0", "petal-2"])])
    assert SAIL.mesh is not None
    assert len(petals.assemble().layers) == len(SAIL.mesh.triangles) // 2


@pytest.mark.parametrize("field", ["only", "without"])
@pytest.mark.parametrize(
    ("wanted", "words"),
    [
        ("uper", r"= 'uper': no such node set; did you mean 'upper'\?"),
        (["upper", "none"], "= 'none': no such node set; known are: both_starts, lower, "),
        ([0, 99], r"= \(0, 99\): node 99 is not there; must be from 0 to 17"),
        ("tether-0", r"= 'tether-0': node 19 is not there"),
    ],
)
def test_sets_that_are_not_there(field: str, wanted: Any, words: str) -> None:
    laws = [Springs(), SelfContact(**{field: wanted})]
    parts = [cord(start=(0.0, 0.0, 0.1), end=(0.0, 0.1, 0.1))]
    refused(lambda: Scene(layers(), RUBBER, laws, parts), SceneError, f"^laws.self_contact.{field} {words}")


def test_a_scene_of_cords_has_no_sets() -> None:
    refused(lambda: Scene(None, None, [SelfContact(only="a")], [cord()]), SceneError, "no such node set")


def test_scene_files_hold_all_fields(tmp_path: Path) -> None:
    law = SelfContact(1e-5, 2e-4, False, 0.3, 0.5, 200, only=("lower", "upper"), without=(0, 1, 2))
    stack(law).save(tmp_path)
    text = (tmp_path / "scene.toml").read_text()
    table = text.split("[laws.self_contact]\n")[1].split("\n\n")[0].splitlines()
    assert table == [
        "thickness = 1e-05  # m", "cord_thickness = 0.0002  # m", "cords = false", "friction = 0.3",
        "restitution = 0.5", "crossing_interval = 200", 'only = ["lower", "upper"]', "without = [0, 1, 2]",
    ]  # fmt: skip
    read = Scene.from_toml(tmp_path / "scene.toml")
    assert read.laws == stack(law).laws
    assert read.to_toml() == stack(law).to_toml()
    assert "# only: not set" in stack().to_toml()
    table_of = tomllib.loads(text)
    assert [*VALIDATOR.iter_errors(table_of)] == []
    table_of["laws"]["self_contact"]["only"] = ["lower", 1]
    assert [error.json_path for error in VALIDATOR.iter_errors(table_of)] == ["$.laws.self_contact.only"]


def test_a_scene_file_takes_units_and_an_empty_table(tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    SAIL.save(tmp_path)
    plain = file.read_text()
    file.write_text(plain.replace("[laws.spin]", '[laws.self_contact]\nthickness = "50 um"\n\n[laws.spin]'))
    assert Scene.from_toml(file).law(SelfContact) == SelfContact(thickness=5e-5)
    file.write_text(plain.replace("[laws.spin]", '[laws.self_contact]\nonly = "petal-9"\n\n[laws.spin]'))
    refused(lambda: Scene.from_toml(file), SceneError, "laws.self_contact.only = 'petal-9': no such node set")


def test_values_by_dotted_keys() -> None:
    made = SAIL.with_values({"laws.self_contact.friction": 0.3, "laws.self_contact.only": ["petal-0", "petal-1"]})
    assert made.law(SelfContact) == SelfContact(friction=0.3, only=("petal-0", "petal-1"))
    assert made.with_values({"laws.self_contact.only": None}).law(SelfContact) == SelfContact(friction=0.3)
    assert made.with_values({"laws.self_contact": False}).law(SelfContact) is None
    assert made.unit("laws.self_contact.cord_thickness") == "m"


@pytest.mark.parametrize(("wanted", "field"), [([0, 1, 2], "only"), ("upper", None), (["lower", "upper"], None)])
def test_node_numbers_belong_to_one_mesh(wanted: Any, field: str | None) -> None:
    law = SelfContact(only=wanted)
    assert law.numbering_field == field
    assert SelfContact(only="upper", without=[0]).numbering_field == "without"
    sail = SAIL.with_values({"laws.self_contact.only": [0, 1, 2]})
    refused(lambda: denser(sail, 2.0), InputError, r"laws\.self_contact\.only of scene .* names nodes by number")


def test_crossings_at_the_start_are_errors() -> None:
    mesh = crossed()
    (finding,) = of_kind(stack(mesh=mesh), "crossings")
    total = mesh.crossings()
    assert (finding.severity, finding.count) == ("error", total.count)
    first, second = total.pairs[0]
    assert f"{total.count} pairs of triangles that feel each other pass through" in finding.message
    assert f"first triangles {first} and {second}" in finding.message
    assert "`without` or `only`" in finding.remedy
    assert finding.where[0] == first
    assert finding in unaccepted_errors(stack(mesh=mesh))


def test_crossings_of_triangles_that_do_not_feel_each_other_are_warnings() -> None:
    mesh = crossed()
    (finding,) = of_kind(stack(SelfContact(only="upper"), mesh), "crossings")
    assert finding.severity == "warning"
    (plain,) = of_kind(replace(stack(mesh=mesh), laws=[Springs()]), "crossings")
    assert finding == plain


def test_numbers_of_crossings_are_those_of_the_mesh() -> None:
    mesh = crossed()
    # The upper layer and one triangle of the lower one, which is found by its number in the mesh.
    lower = int(mesh.crossings().pairs[-1, 0])
    assert 0 < lower < UPPER
    nodes = np.union1d(mesh.node_sets["upper"], mesh.triangles[lower]).tolist()
    found = of_kind(stack(SelfContact(only=nodes), mesh), "crossings")
    error = next(one for one in found if one.severity == "error")
    assert error.where[0] == lower
    assert 0 < error.count < mesh.crossings().count
    assert {one.severity for one in found} == {"error", "warning"}


def test_layers_without_distance_at_the_start_are_errors() -> None:
    (finding,) = of_kind(stack(mesh=layers(0.0)), "touching_layers")
    assert finding.severity == "error"
    assert "have no distance at the start" in finding.message
    assert of_kind(stack(SelfContact(only="upper"), layers(0.0)), "touching_layers") == []
    assert of_kind(stack(mesh=layers(1e-9)), "touching_layers") == []


def test_petals_that_bridges_join_do_not_touch() -> None:
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    mesh = Mesh(points, [[0, 1, 2], [3, 4, 5]], bridges=[[1, 3], [2, 5]])
    assert mesh.crossings().touching == 1
    scenes_of = [stack_of_petals(mesh), stack_of_petals(Mesh(points, [[0, 1, 2], [3, 4, 5]]))]
    assert [len(of_kind(scene, "touching_layers")) for scene in scenes_of] == [0, 1]


def stack_of_petals(mesh: Mesh) -> Scene:
    """Two triangles, with their bridges."""
    parts = [Bridges(100.0)] if len(mesh.bridges) else []
    return Scene(mesh, RUBBER, [Springs(), SelfContact()], parts)


@pytest.mark.parametrize("method", integrators())
def test_a_method_without_kicks_is_an_error(method: str) -> None:
    found = of_kind(stack(integrator=method), "method")
    assert len(found) == (method != "leapfrog")
    for finding in found:
        assert finding.severity == "error"
        assert f"run.integrator = {method!r}: laws.self_contact goes with 'leapfrog' alone" in finding.message
        assert "set run.integrator to 'leapfrog'" in finding.remedy
    assert of_kind(replace(stack(integrator=method), laws=[Springs()]), "method") == []


def test_a_free_hub_is_an_error() -> None:
    driven = stack()
    scene = replace(driven, laws=[*driven.laws, Spin(1.0, inertia=1e-3)])
    (finding,) = of_kind(scene, "free_hub")
    assert finding.severity == "error"
    assert finding.message == "laws.self_contact: does not go with a free hub"
    assert of_kind(replace(driven, laws=[*driven.laws, Spin(1.0)]), "free_hub") == []


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"thickness": 0.2}, "laws.self_contact.thickness = 0.2 m: the film is 0.0002 m thick"),
        ({"thickness": 1e-6}, "laws.self_contact.thickness = 1e-06 m"),
        ({"friction": 30.0}, "laws.self_contact.friction = 30: more than 10 is hardly met"),
        ({"cord_thickness": 2.0}, "cord_thickness = 2 m: the segments of the cords are no longer than 1 m"),
    ],
)
def test_values_that_are_hardly_meant(values: dict[str, Any], words: str) -> None:
    parts = [Fixed("lower"), cord(start=(0.0, 0.0, 0.1), end=(1.0, 0.0, 0.1), tip_mass=1e-3)]
    found = of_kind(replace(stack(SelfContact(**values)), parts=parts), "implausible_value")
    assert [words in finding.message for finding in found] == [True]
    sound = replace(stack(SelfContact(5 * HEIGHT, 1e-3, friction=0.5)), parts=parts)
    assert of_kind(sound, "implausible_value") == []


def test_a_slip_of_a_unit_is_named() -> None:
    (finding,) = of_kind(stack(SelfContact(thickness=0.3)), "implausible_value")
    assert "was 0.3 mm meant? That is 0.0003 m" in finding.remedy


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (Scene(None, None, [SelfContact()], [cord()]), "there is no film"),
        (stack(SelfContact(only="upper", without="upper")), "no triangle .*only = 'upper', without = 'upper'"),
        (stack(SelfContact(only="upper_start")), "no triangle belongs to it, with only = 'upper_start'"),
        (stack(SelfContact(only=SHEET.triangles[0])), "a single triangle has nothing to meet"),
        (stack(), None),
    ],
)
def test_a_law_that_is_idle_says_why(scene: Scene, reason: str | None) -> None:
    found = dict(idle_laws(scene)).get("self_contact")
    assert (found is None) == (reason is None)
    if reason is not None:
        assert found is not None
        assert re.search(reason, found)


def test_studies_know_it_by_its_name() -> None:
    names = [variant.name for variant in variants(stack())]
    assert "law self_contact" in names, names
    held = held_scene(stack(), 100.0)
    assert "self_contact" not in [law.kind for law in held.laws]


def test_stages_may_be_without_it() -> None:
    stages = [
        Stage("apart", 1e-3, without=("self_contact",), set={"run.integrator": "rk4"}),
        Stage("together", 1e-3, set={"laws.self_contact.friction": 0.2, "laws.self_contact.only": ["upper"]}),
    ]
    scene = replace(stack(), stages=stages)
    assert [len(scene.staged(k).assemble().layers) for k in range(2)] == [0, UPPER]
    assert scene.staged(1).law(SelfContact) == SelfContact(friction=0.2, only=("upper",))
    assert of_kind(scene, "method") == []
    wrong = replace(scene, stages=[stages[0], replace(stages[1], set={"run.integrator": "rk4"})])
    (finding,) = of_kind(wrong, "method")
    assert finding.message.startswith("stage 'together': run.integrator = 'rk4'")


def test_what_it_does_not_go_with_is_named_by_its_key() -> None:
    words = "^run.integrator = 'rk4': does not go with self_contact, .*; take leapfrog, or leave it out$"
    refused(lambda: Simulation(stack(integrator="rk4")), InputError, words)
    refused(
        lambda: Simulation(stack(), "dopri5"), InputError, "^run.integrator = 'dopri5': does not go with self_contact"
    )
    free = replace(stack(), laws=[*stack().laws, Spin(1.0, inertia=1e-3)])
    words = "^laws.self_contact: does not go with a free hub; leave it out, .*leave laws.spin.inertia out$"
    refused(lambda: Simulation(free), InputError, words)


def test_studies_leave_out_methods_that_it_does_not_go_with() -> None:
    fitting, left_out = methods_of(stack(), integrators())
    assert fitting == ["leapfrog"]
    assert {*left_out} == {*integrators()} - {"leapfrog"}
    assert all("does not go with self_contact" in reason for reason in left_out.values())


def test_a_start_with_crossings_does_not_run() -> None:
    mesh = crossed()
    words = f"at the start triangles .* cross, {mesh.crossings().count} pairs in all"
    refused(lambda: Simulation(stack(mesh=mesh)), InputError, words)


def test_only_triangles_that_feel_each_other_must_not_cross_at_the_start() -> None:
    mesh = crossed()
    assert Simulation(stack(SelfContact(only="upper"), mesh)).time == 0.0
    assert Simulation(stack(SelfContact(without="lower"), mesh)).time == 0.0


def test_commands_take_its_fields(tmp_path: Path) -> None:
    SAIL.save(tmp_path)
    words = ["check", str(tmp_path / "scene.toml"), "--set", "laws.self_contact.friction=0.3"]
    code, shown = call(*words)
    assert (code, "error: run.integrator = 'rk4': laws.self_contact goes with 'leapfrog' alone" in shown) == (2, True)
    chosen = ["--set", "run.integrator=leapfrog", "--set", "laws.self_contact.only=['petal-0', 'petal-1']"]
    assert call(*words, *chosen)[0] == 0
    assert "no such node set; did you mean 'petal-0'" in call(*words[:2], "--set", "laws.self_contact.only=petal0")[1]
