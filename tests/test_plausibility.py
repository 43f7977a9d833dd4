"""The audit names values that are hardly meant, with the unit that probably was; sound scenes hold none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from membrane_rs import (
    Creases,
    Fixed,
    Gravity,
    MassDamping,
    Material,
    Mesh,
    Pressure,
    RunSettings,
    Scene,
    Spin,
    SpoolContact,
    SpringDamping,
    Springs,
    Tether,
    Tethers,
    TipMasses,
    scenes,
)
from membrane_rs.check import audit, facts
from membrane_rs.cli import app
from membrane_rs.folding import Disc, SquareSail, Strip
from membrane_rs.mesh import Finding
from membrane_rs.scene.law import Law
from small_scenes import RUBBER, cord, hanging_strip
from typer.testing import CliRunner

MODEL = scenes.load("okuizumi-model-1")


def warnings_of(scene: Scene) -> dict[str, Finding]:
    """Warnings of a scene by kind, or by place for values."""
    found = audit(scene, costly=False)
    assert not found.errors, str(found)
    return {f.message.split(" = ")[0] if f.kind == "implausible_value" else f.kind: f for f in found.warnings}


@pytest.mark.parametrize(
    ("parameter", "value", "meant"),
    [
        ("material.thickness", 12.5, "was 12.5 um meant? That is 1.25e-05 m"),
        ("material.thickness", 0.0075, "was 0.0075 mm meant? That is 7.5e-06 m"),
        ("material.thickness", 50.0, "was 50 um meant? That is 5e-05 m"),
        ("material.youngs_modulus", 3.2, "was 3.2 GPa meant? That is 3.2e+09 Pa"),
        ("material.thickness", 7.5e-9, "check the value and its unit (m)"),
        ("material.youngs_modulus", 3.2e15, "check the value and its unit (Pa)"),
        ("material.density", 1.42e6, "was 1.42e+06 g/m3 meant? That is 1420 kg/m3"),
        ("material.density", 1.42, "was 1.42 g/cm3 meant? That is 1420 kg/m3"),
        ("laws.spin.frequency", 180.0, "was 180 turns per minute meant? That is 3 Hz"),
        ("laws.air_drag.pressure", 101325.0, "check the value and its unit (Pa)"),
        ("laws.air_drag.temperature", 20.0, "were 20 degrees Celsius meant? That is 293.1 K"),
        ("laws.air_drag.temperature", 1000.0, "check the value and its unit (K)"),
        ("laws.spring_damping.ratio", 2.0, "was 2 % meant? That is 0.02"),
        ("run.until", 5000.0, "was 5000 ms meant? That is 5 s"),
        ("run.until", 600.0, "was 600 ms meant? That is 0.6 s"),
        ("laws.spin.frequency", 25.1, "meant? That is 0.4183 Hz; or 25.1 rad/s? That is 3.995 Hz; else cords of "),
        ("laws.spool_contact.stiffness", 2e8, "was 2e+08 mN/m meant? That is 2e+05 N/m"),
        ("laws.spool_contact.stiffness", 2e-4, "check the value and its unit (N/m)"),
        ("laws.spool_contact.stiffness", 0.02, "was 0.02 kN/m meant? That is 20 N/m"),
        ("laws.spool_contact.radius", 20.0, "was 20 mm meant? That is 0.02 m"),
        ("laws.creases.length_scale", 4.0, "was 4 mm meant? That is 0.004 m"),
        ("parts.0.mass", 1e-10, "check the value and its unit (kg)"),
        ("parts.1.anchor_radius", 2.5e-5, "check the value and its unit (m)"),
        ("parts.0.mass", 300.0, "was 300 mg meant? That is 0.0003 kg"),
        ("parts.0.mass", 0.36, "was 0.36 g meant? That is 0.00036 kg"),
        ("parts.1.linear_density", 0.1, "was 0.1 g/m meant? That is 0.0001 kg/m"),
        ("parts.1.axial_stiffness", 0.017, "was 0.017 kN meant? That is 17 N"),
    ],
)
def test_a_slip_of_a_unit_is_named(parameter: str, value: float, meant: str) -> None:
    found = warnings_of(MODEL.with_values({parameter: value}))
    place = parameter.replace("parts.0", "parts[0]").replace("parts.1", "parts[1]")
    assert place in found, found
    assert f"{place} = {value:g}" in found[place].message
    assert meant in found[place].remedy


@pytest.mark.parametrize(
    ("law", "place", "meant"),
    [
        (Gravity((0.0, 0.00981, 0.0)), "laws.gravity.acceleration", "was 0.00981 km/s2 meant? That is 9.81 m/s2"),
        (Pressure(-1e5), "laws.pressure.pressure", "was 100000 mPa meant? That is 100 Pa"),
        (MassDamping(1e6), "laws.mass_damping.rate", "check the value and its unit (1/s)"),
    ],
)
def test_values_of_further_laws(law: Law, place: str, meant: str) -> None:
    found = warnings_of(replace(MODEL, laws=[*MODEL.laws, law]))
    assert list(found) == [place]
    assert meant in found[place].remedy


@pytest.mark.parametrize(
    ("parameter", "value", "place"),
    [
        ("parts.0.mass", 0.3, "parts[0].mass"),
        ("material.youngs_modulus", 3.2, "material.youngs_modulus"),
        ("material.youngs_modulus", 3200.0, "material.youngs_modulus"),
        ("material.density", 1.42, "material.density"),
        ("material.thickness", 0.0075, "material.thickness"),
        ("laws.spin.frequency", 180.0, "laws.spin.frequency"),
        ("laws.spin.frequency", 25.1, "laws.spin.frequency"),
        ("parts.1.axial_stiffness", 0.017, "parts[1].axial_stiffness"),
        ("laws.spool_contact.radius", 25.0, "laws.spool_contact.radius"),
    ],
)
def test_values_that_are_judged_by_one_in_doubt_are_not_doubted_too(parameter: str, value: float, place: str) -> None:
    for parts in (MODEL.parts, MODEL.parts[::-1]) if parameter.startswith("material") else (MODEL.parts,):
        scene = replace(MODEL, parts=parts).with_values({parameter: value})
        found = [one for one in audit(scene, costly=False).warnings if one.kind != "thick_film"]
        assert [one.message.split(" = ")[0] for one in found] == [place], found


def test_a_hub_that_is_wider_than_the_sail_is_told_with_its_unit() -> None:
    found = warnings_of(MODEL.with_values({"parts.1.anchor_radius": 25.0}))
    assert set(found) == {"parts[1].anchor_radius", "spool", "chord_sag"}
    assert "was 25 mm meant? That is 0.025 m" in found["parts[1].anchor_radius"].remedy


def test_sails_of_all_sizes_are_free_of_warnings() -> None:
    large = SquareSail(outer_width=14.0, inner_width=3.0, spool_radius=0.8).mesh()
    film = Material(youngs_modulus=3e9, poisson_ratio=0.3, density=1420.0, thickness=7.5e-6)
    held = Tethers(anchor_radius=0.8, axial_stiffness=2e4, linear_density=1e-2)
    small = SquareSail(outer_width=4e-3, inner_width=9e-4, spool_radius=2e-4, fillet_radius=3e-5, layer_gap=1e-6).mesh()
    thread = Tethers(anchor_radius=2e-4, axial_stiffness=1e-4, linear_density=1e-9)
    leaf = replace(film, thickness=2e-7)
    for rate, slowing, until in ((25.0, 0.0, 600.0), (25.0, -24.0, 3600.0), (1.0, 0.0, 3600.0)):
        spin = Spin(rate / 60.0, slowing / 60.0 / until)
        laws = [Springs(), SpringDamping(), Creases(), spin, SpoolContact(0.8), MassDamping(0.1), Pressure(9e-6)]
        scene = Scene(large, film, laws, [TipMasses(0.5), held], run=RunSettings(until=until))
        assert warnings_of(scene) == {}
    for rate in (1.0, 100.0):
        laws = [Springs(), SpringDamping(), Creases(), Spin(rate), SpoolContact(2e-4), MassDamping(1e3)]
        scene = Scene(small, leaf, laws, [TipMasses(1e-10), thread], run=RunSettings(until=0.1))
        assert warnings_of(scene) == {}
    along = Tether((0.0, 0.0, 0.0), (0.0, 0.0, -2.0), 200, 1e4, 0.01, tip_mass=1.0)
    assert "laws.spool_contact.radius" not in warnings_of(Scene(None, None, [SpoolContact(0.05), Gravity()], [along]))


def test_strong_gravity_and_a_wide_mesh() -> None:
    strong = replace(hanging_strip(), laws=[Springs(), Gravity((0.0, 0.0, -98.1))])
    assert "no planet" in warnings_of(strong)["laws.gravity.acceleration"].message
    wide = Scene(Strip(455.0, 103.0, 4, 2).mesh(), RUBBER, [Springs()], [Fixed("start")])
    assert "was 455 mm meant? That is 0.455 m" in warnings_of(wide)["mesh (its width)"].remedy
    narrow = Scene(Strip(4.5e-5, 1e-5, 4, 2).mesh(), RUBBER, [Springs()], [Fixed("start")])
    assert "was 4.5e-05 km meant? That is 0.045 m" in warnings_of(narrow)["mesh (its width)"].remedy


def test_a_film_is_torn_before_a_rotor_bursts() -> None:
    # Rubber of 1 MPa and 1000 kg/m3 is stretched by a tenth at 10 m/s, which a rim of 0.1 m has at 15.9 Hz.
    def turning(spin: Spin, until: float = 0.1) -> Scene:
        scene = hanging_strip()
        return replace(scene, laws=[*scene.laws, spin], run=replace(scene.run, until=until))

    assert not {"laws.spin.frequency", "run.until"} & warnings_of(turning(Spin(15.5))).keys()
    assert "beyond 10 m/s it is torn" in warnings_of(turning(Spin(16.5)))["laws.spin.frequency"].message
    at_end = warnings_of(turning(Spin(1.0, 155.0)))["laws.spin.acceleration (at the end)"]
    assert "= 16.5 Hz" in at_end.message
    slow = warnings_of(turning(Spin(1e-4), until=0.5))["run.until"]
    assert "the hub turns by 5e-05 turns in this run" in slow.message
    wheel = Tether((0.1, 0, 0), (1.0, 0, 0), 1, 50.0, 0.0, tip_mass=0.01)
    assert "rotors burst" in warnings_of(Scene(None, None, [Spin(50.0)], [wheel]))["laws.spin.frequency"].message


def test_spools_that_disagree() -> None:
    found = warnings_of(MODEL.with_values({"parts.1.anchor_radius": 0.05, "laws.spool_contact.radius": 0.02}))
    assert "parts[1] starts its cords 0.05 m from the axis" in found["spool"].message
    assert "laws.spool_contact has a radius of 0.02 m" in found["spool"].message
    for radius in (0.06, 2.5):
        both = MODEL.with_values({"parts.1.anchor_radius": radius, "laws.spool_contact.radius": radius})
        assert "inside the spool" in warnings_of(both)["spool"].message
    assert "spool" not in warnings_of(MODEL.with_values({"parts.1.anchor_radius": 0.0255}))


def test_a_spool_that_the_hole_of_the_sail_does_not_clear() -> None:
    # A square frame: its inner corners are 7 cm from the axis, and the middles of its inner sides 5 cm.
    inner = 0.05 * np.array([[1, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]])
    reference = np.vstack([inner, 3.0 * inner])
    sides = [(k, (k + 1) % 4) for k in range(4)]
    triangles = [corners for a, b in sides for corners in ((a, a + 4, b + 4), (a, b + 4, b))]

    def found(radius: float, shift: float = 0.0) -> list[str]:
        shape = reference + np.array([shift, 0.0, 0.0])
        mesh = Mesh(reference, triangles, positions=shape, node_sets={"corners": [4, 5, 6, 7]})
        cords = Tethers(segments=2, axial_stiffness=17.0, nodes="corners", anchor_radius=radius)
        scene = Scene(mesh, RUBBER, [Springs(), Spin(1.0), SpoolContact(radius, 300.0)], [cords])
        return [f.message for f in audit(scene, costly=False).findings if f.kind == "spool"]

    assert found(0.045) == []
    flat, stowed = found(0.06)
    assert flat.startswith("the flat sail comes as near to the axis as 0.05 m, inside the spool of")
    assert stowed.startswith("the stowed sail")
    (moved,) = found(0.045, 0.02)
    assert moved.startswith("the stowed sail comes as near to the axis as 0.03 m")


def test_a_sail_without_a_law_of_the_film() -> None:
    bare = replace(MODEL, laws=[law for law in MODEL.laws if not law.is_film and not isinstance(law, SpringDamping)])
    found = warnings_of(bare)["film_law"]
    assert found.remedy == "add [laws.springs] or [laws.triangles] or [laws.rectangles]"


def test_a_scene_that_nothing_holds() -> None:
    disc = Disc(0.1, rings=2).mesh()
    for laws, words in (
        ([Springs()], "any push moves it"),
        ([Springs(), Gravity()], "it falls"),
        ([Springs(), Spin(1.0), Gravity()], "it falls"),
        ([Springs(), Pressure(1.0)], "any push moves it"),
    ):
        assert words in warnings_of(Scene(disc, RUBBER, laws))["supports"].message
    assert "supports" not in warnings_of(Scene(disc, RUBBER, [Springs(), Spin(1.0)]))
    assert "supports" not in warnings_of(Scene(disc, RUBBER, [Springs(), Gravity()], [Fixed((0,))]))
    aside = Mesh(disc.reference + np.array([0.05, 0.0, 0.0]), disc.triangles)
    found = warnings_of(Scene(aside, RUBBER, [Springs(), Spin(1.0)]))["supports"]
    assert "centre of mass lies 0.05 m from the axis" in found.message
    # A folded sail is one that its hub holds, however well it is balanced.
    sail = Scene(MODEL.mesh, MODEL.material, [Springs(), Spin(1.0)])
    assert "nothing holds the sail" in warnings_of(sail)["supports"].message
    free = cord(fixed=False, linear_density=0.1)
    assert "nothing holds the scene" in warnings_of(Scene(None, None, [SpringDamping()], [free]))["supports"].message


def test_a_free_body_that_turns_in_balance_is_a_fact() -> None:
    found = audit(Scene(Disc(0.1, rings=2).mesh(), RUBBER, [Springs(), Spin(1.0)])).find("supports")
    assert found is not None
    assert (found.severity, found.count) == ("info", 1)
    assert "nothing holds the sail: it flies freely" in found.message
    folded = Strip(0.1, 0.04, 6, 2, creases=(0.5,)).mesh()
    middle = Mesh(folded.reference - folded.positions.mean(axis=0), folded.triangles, creases=folded.creases)
    assert "supports" in warnings_of(Scene(middle, RUBBER, [Springs(), Spin(1.0)]))


def test_a_piece_that_nothing_holds_beside_one_that_is_held() -> None:
    disc = Disc(0.1, rings=2).mesh()
    nodes = np.concatenate([disc.reference, disc.reference + np.array([0.0, 0.0, 0.1])])
    triangles = np.concatenate([disc.triangles, disc.triangles + disc.node_count])
    for shift, laws, severity, words in (
        (0.0, [Springs(), Spin(1.0)], "info", "it flies freely"),
        (0.0, [Springs(), Gravity()], "warning", "it falls"),
        (0.3, [Springs(), Spin(1.0)], "warning", "centre of mass lies 0.3 m from the axis"),
    ):
        moved = nodes + np.where(np.arange(len(nodes)) < disc.node_count, 0.0, shift)[:, None] * [1.0, 0.0, 0.0]
        found = audit(Scene(Mesh(moved, triangles), RUBBER, laws, [Fixed((0,))])).find("supports")
        assert found is not None
        assert (found.severity, found.count) == (severity, 1)
        free = f"nothing holds {disc.node_count} of {len(nodes)} nodes, node {disc.node_count} among them"
        assert free in found.message
        assert words in found.message
    parts = [cord(fixed=True, linear_density=0.1), cord(fixed=False, linear_density=0.1)]
    found = audit(Scene(None, None, [SpringDamping()], parts)).find("supports")
    assert found is not None
    assert found.count == 1


def test_a_heavy_tip_without_a_film() -> None:
    heavy = Tether((0.1, 0, 0), (0.4, 0, 0), 1, 50.0, 0.0, tip_mass=300.0)
    found = warnings_of(Scene(None, None, [Spin(1.0)], [heavy]))
    assert "was 300 g meant?" in found["parts[0].tip_mass"].remedy


def test_sound_variations_are_free_of_warnings() -> None:
    for parameter, value in (
        ("laws.spin.frequency", 10.0),
        ("material.thickness", 2e-6),
        ("material.youngs_modulus", 7e10),
        ("run.until", 1e-3),
        ("run.until", 60.0),
        ("laws.air_drag.pressure", 100.0),
        ("parts.0.mass", 1e-2),
        ("parts.1.segments", 8.0),
    ):
        assert warnings_of(MODEL.with_values({parameter: value})) == {}, parameter
    assert warnings_of(replace(hanging_strip(), parts=[Fixed("start"), TipMasses(0.05, nodes=(5,))])) == {}


def test_check_prints_size_masses_and_spin() -> None:
    shown = CliRunner().invoke(app, ["check", "okuizumi-model-1", "--until", "0.001"]).output
    for name, words in facts(MODEL).items():
        assert f"  {name:<10} {words}\n" in shown
    values = facts(MODEL)
    area = 0.455**2 - 0.103**2
    film = area * 1420.0 * 7.5e-6
    assert values["size"].startswith("0.455 x 0.455 x 0 m")
    assert values["area"] == f"{area:.4g} m2"
    assert values["thickness"] == "7.5e-06 m"
    assert values["material"] == "3.2e+09 Pa, 1420 kg/m3 (waves at 1501 m/s)"
    assert f"film {film:.4g} kg" in values["mass"]
    assert values["spin"] == "3 Hz"
    assert facts(hanging_strip())["spin"] == "none"
