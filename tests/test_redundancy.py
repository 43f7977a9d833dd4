"""What `check` says before a run: laws without effect, and the part that sets the step."""

from __future__ import annotations

import math
from typing import Any

import pytest
from membrane_rs import (
    AirDrag,
    Bridges,
    Creases,
    CreaseSet,
    Fixed,
    Gravity,
    MassDamping,
    Mesh,
    Region,
    Scene,
    SceneError,
    Spin,
    SpoolContact,
    SpringDamping,
    Springs,
    scenes,
)
from membrane_rs.check.redundancy import idle_laws, step_savings, values_without_effect
from membrane_rs.cli import app
from membrane_rs.errors import InputError
from membrane_rs.folding import Disc, Strip
from small_scenes import FILM, RUBBER, cord, hanging_strip, refused
from typer.testing import CliRunner

DISC = Disc(0.1, rings=2).mesh()
CREASED = Strip(0.1, 0.04, 4, 2, creases=(0.5,), fold_angle=1.0).mesh()


@pytest.mark.parametrize(
    ("law", "why"),
    [
        (AirDrag(pressure=0.0), "no air"),
        (Creases(), "no creases"),
        (SpringDamping(ratio=0.0), "ratio is 0"),
        (Gravity((0.0, 0.0, 0.0)), "acceleration is 0"),
        (MassDamping(rate=0.0), "rate is 0"),
        (Spin(0.0, 0.0), "does not turn"),
        (SpoolContact(), "no tether's node"),
    ],
)
def test_laws_that_cannot_matter(law: Any, why: str) -> None:
    found = idle_laws(Scene(DISC, RUBBER, [Springs(), law]))
    assert [kind for kind, _ in found] == [law.kind]
    assert why in found[0][1]


def test_creases_without_stiffness_and_drag_without_membrane() -> None:
    assert idle_laws(Scene(CREASED, FILM, [Springs(), Creases(stiffness=0.0)]))[0][0] == "creases"
    assert idle_laws(Scene(None, None, [AirDrag(), Springs(), Spin()], [cord()])) == [
        ("air_drag", "the scene has no membrane"),
        ("springs", "the scene has no membrane"),
    ]


def test_contact_that_is_out_of_reach() -> None:
    far = [cord(start=(1.0, 0, 0), end=(1.5, 0, 0), strain_limit=0.1)]
    assert "nearer to the axis than 0.45 m" in idle_laws(Scene(None, None, [SpoolContact()], far))[0][1]
    near = [cord(start=(0.3, 0, 0), end=(0.8, 0, 0), strain_limit=0.1)]
    assert idle_laws(Scene(None, None, [SpoolContact()], near)) == []
    free = [cord(start=(1.0, 0, 0), end=(1.5, 0, 0), fixed=False, linear_density=0.1)]
    assert idle_laws(Scene(None, None, [SpoolContact()], free)) == []


@pytest.mark.parametrize("name", scenes.names())
def test_built_in_scenes_hold_nothing_idle(name: str) -> None:
    assert idle_laws(scenes.load(name)) == []


def test_idle_laws_change_nothing() -> None:
    from membrane_rs import Simulation

    bare, idle = hanging_strip(), hanging_strip()
    with_idle = Scene(idle.mesh, RUBBER, [*idle.laws, Spin(0.0), Creases(stiffness=0.0), AirDrag(0.0)], idle.parts)
    one, other = Simulation(bare, dt=1e-4), Simulation(with_idle, dt=1e-4)
    one.step(200)
    other.step(200)
    assert (one.positions == other.positions).all()


def test_a_stiff_law_is_named_with_what_would_take_it_out() -> None:
    scene = Scene(CREASED, RUBBER, [Springs(), Creases(contact_penalty=1e6)], [Fixed("start")])
    best = next(saving for saving in step_savings(scene) if not saving.part.startswith("the triangles"))
    assert best.part == "creases"
    softer = scene.with_values({"laws.creases.contact_penalty": 1e6 / best.gain**2})
    assert all(saving.part != "creases" or saving.gain < 1.5 for saving in step_savings(softer))
    points = CREASED.reference
    assert step_savings(Scene(Mesh(points, CREASED.triangles), RUBBER, [Springs(), MassDamping(1e6)]))[0].part == (
        "mass_damping"
    )


def test_a_bridge_that_is_too_stiff_is_named() -> None:
    from limit_cases import bridged

    best = step_savings(bridged())[0]
    assert best.part == "bridges"
    soft = [Bridges(1e5 / best.gain**2)]
    parted = Scene(bridged().mesh, RUBBER, bridged().laws, soft)
    assert all(saving.part != "bridges" or saving.gain < 1.5 for saving in step_savings(parted))


def test_a_sliver_is_found_where_it_is() -> None:
    points = CREASED.reference.copy()
    points[4] += 0.8 * (points[5] - points[4])
    savings = step_savings(Scene(Mesh(points, CREASED.triangles), RUBBER, [Springs(negative="clip")]))
    assert any(saving.part.startswith("the triangles around node") for saving in savings)


def test_check_prints_both() -> None:
    shown = CliRunner().invoke(app, ["check", "okuizumi-model-1", "--until", "0.01"]).output
    assert "without effect" not in shown
    assert "savings      none" in shown


@pytest.mark.parametrize(
    ("parameter", "value", "kind", "words"),
    [
        ("laws.crease.stiffness", 1.0, SceneError, "did you mean 'laws.creases.stiffness'"),
        ("laws.springs.bucklin", 1.0, SceneError, "did you mean 'laws.springs.buckling'"),
        ("springs", 1.0, SceneError, "this scene has no value of that name; did you mean 'laws.springs"),
        ("laws.springs.buckling", -1.0, InputError, "buckling = -1"),
        ("parts.7.nodes", 1.0, SceneError, "no value of that name; did you mean 'parts.0.nodes'"),
    ],
)
def test_wrong_parameters(parameter: str, value: float, kind: type[Exception], words: str) -> None:
    refused(lambda: hanging_strip().with_values({parameter: value}), kind, words)


def test_parameters_of_every_part_of_a_scene() -> None:
    whole = scenes.load("okuizumi-model-1")
    assert whole.with_values({"parts.1.segments": 5.0}).parts[1].segments == 5  # type: ignore[attr-defined]
    assert whole.with_values({"material.thickness": 1e-5}).material.thickness == 1e-5  # type: ignore[union-attr]
    assert whole.with_values({"run.until": 0.5}).run.until == 0.5
    coarse = whole.with_values({"mesh.rows": 8})
    assert coarse.mesh is not None
    assert coarse.mesh.node_count < 1000
    assert math.isclose(hanging_strip().with_values({"laws.spin.frequency": 2.0}).law("spin").frequency, 2.0)  # type: ignore[union-attr]


def test_values_of_parts_that_no_law_feels_are_told() -> None:
    """Each with the law that would feel it; material and thickness are felt by all."""
    parts = [
        Region([0], curvature=(1.0, 0.0), bending_stiffness=1e-6, natural_strain=(1e-4, 0.0)),
        Region([1], front_specular=0.5, front_diffuse=0.1, thickness=1e-5),
        CreaseSet(stiffness=3.0),
    ]
    found = [finding.message for finding in values_without_effect(Scene(CREASED, FILM, [Springs()], parts))]
    places = ("0].bending_stiffness", "0].curvature", "1].front_specular", "1].front_diffuse", "2].stiffness")
    assert [message.split(" is ")[0] for message in found] == [f"parts[{place}" for place in places]
    for row, law in ((0, "bending"), (2, "solar_pressure"), (4, "creases")):
        assert found[row].endswith(f"no law {law}")


def test_a_region_of_its_own_modulus_softens_with_the_film() -> None:
    """What the film limits is measured with its regions, whose modulus is given beside that of the film."""
    plain, own = Region("all"), Region("all", youngs_modulus=RUBBER.youngs_modulus)
    scenes_of = [Scene(DISC, RUBBER, [Springs(), SpringDamping()], [region]) for region in (plain, own)]
    film = [next(s.gain for s in step_savings(scene) if s.part == "springs") for scene in scenes_of]
    assert film[0] == pytest.approx(film[1])
