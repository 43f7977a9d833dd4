"""Effective moduli of a mesh's net of springs, against known lattices and against forces of the simulator."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from membrane_rs import Fixed, MassDamping, Material, Mesh, MeshError, Scene, Simulation, Springs, scenes
from membrane_rs.check import audit
from membrane_rs.check.net_of_springs import net_lines
from membrane_rs.cli import app
from membrane_rs.folding import Disc, EquilateralLattice, SquareSail, Strip
from membrane_rs.mesh import net_moduli
from small_scenes import FILM, RUBBER, UNBUCKLED, rotation, turned
from typer.testing import CliRunner

THIRD = Material(3.2e9, 1 / 3, 1420.0, 7.5e-6)
ISOSCELES = (0.980, 0.616, 0.551, 0.201)
"""E along 0 and 45 degrees, G and nu of right isosceles triangles with alternating diagonals at nu = 0.34."""


def four(mesh: Mesh, film: Material, *, relaxed: bool = False) -> tuple[float, float, float, float]:
    """E along the mesh's own axis and at 45 degrees to it, G, nu."""
    net = net_moduli(mesh, film, relaxed=relaxed)
    axis = net.axis
    found = net.modulus(axis), net.modulus(axis + 45), net.shear_modulus(axis), net.poisson_ratio(axis)
    along, diagonal, shear, ratio = map(float, found)
    return along, diagonal, shear, ratio


@pytest.mark.parametrize("degrees", [0.0, 20.0, 45.0, 77.3])
def test_right_isosceles_triangles_are_soft_in_shear_by_nearly_half(degrees: float) -> None:
    mesh = turned(Strip(6.0, 6.0, 6, 6).mesh(), rotation([0, 0, 1], math.radians(degrees)))
    assert four(mesh, FILM) == pytest.approx(ISOSCELES, abs=1e-3)
    assert four(mesh, FILM, relaxed=True) == pytest.approx(ISOSCELES, abs=1e-3)
    net = net_moduli(mesh, FILM)
    assert net.is_balanced
    assert not net.is_isotropic
    assert net.axis == pytest.approx(degrees if degrees < 90 else degrees - 90, abs=0.05)
    assert net.extremes == pytest.approx((0.616, 0.980), abs=1e-3)
    assert net.local_extremes == pytest.approx((0.616, 0.980), abs=2e-3)


def test_the_ratio_of_one_third_alone_does_not_help_right_triangles() -> None:
    along, diagonal, shear, ratio = four(Strip(6.0, 6.0, 6, 6).mesh(), THIRD)
    assert (along, diagonal, shear, ratio) == pytest.approx((0.982, 0.614, 0.545, 0.2), abs=1e-3)


def test_the_mesh_of_model_1() -> None:
    mesh = SquareSail().mesh()
    assert four(mesh, FILM)[:3] == pytest.approx((0.980, 0.609, 0.544), abs=1e-3)
    # Where diagonals meet their mirror images, nodes are no centres of symmetry.
    assert four(mesh, FILM, relaxed=True)[:3] == pytest.approx((0.978, 0.604, 0.538), abs=1e-3)


@pytest.mark.parametrize("degrees", [0.0, 13.0])
def test_equilateral_triangles_at_one_third_are_the_film(degrees: float) -> None:
    mesh = turned(EquilateralLattice(0.01, 6, 6).mesh(), rotation([1, 2, 3], math.radians(degrees)))
    net = net_moduli(mesh, THIRD)
    angles = np.linspace(0.0, 180.0, 19)
    assert net.modulus(angles) == pytest.approx(np.ones(19), rel=1e-9)
    assert net.shear_modulus(angles) == pytest.approx(np.ones(19), rel=1e-9)
    assert net.poisson_ratio(angles) == pytest.approx(np.full(19, 1 / 3), rel=1e-9)
    assert net.is_isotropic
    assert net.axis == 0.0


def test_a_disc_is_judged_by_the_surroundings_of_its_nodes() -> None:
    # Cells in rings: all directions are alike on the whole, but not from place to place.
    angle, radius = np.meshgrid(np.linspace(0, 2 * np.pi, 48, endpoint=False), np.linspace(0.5, 1.0, 9), indexing="ij")
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * radius], axis=-1).reshape(-1, 3)
    index = np.arange(48 * 9).reshape(48, 9)
    index = np.concatenate([index, index[:1]])
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    flip = (np.add.outer(np.arange(48), np.arange(8)) % 2 == 1)[..., None]
    one = np.where(flip, np.stack([a, b, d], -1), np.stack([a, b, c], -1))
    two = np.where(flip, np.stack([d, b, c], -1), np.stack([a, c, d], -1))
    net = net_moduli(Mesh(points, np.concatenate([one.reshape(-1, 3), two.reshape(-1, 3)])), FILM)
    least, greatest = net.extremes
    assert greatest - least < 0.01
    least, greatest = net.local_extremes
    assert greatest - least > 0.3
    assert not net.is_isotropic


def test_relaxed_moduli_are_those_of_the_simulator() -> None:
    # A ragged patch, its boundary held on a uniform shear, relaxed to rest: the energy is G/2 per strain^2 and area.
    mesh = Strip(0.6, 0.6, 6, 6).mesh()
    points = mesh.reference.copy()
    inner = np.setdiff1d(np.arange(mesh.node_count), mesh.boundary_edges)
    points[inner, :2] += np.random.default_rng(1).uniform(-0.02, 0.02, (len(inner), 2))
    ragged, strain = Mesh(points, mesh.triangles), 1e-5
    net = net_moduli(ragged, RUBBER, relaxed=True)
    assert not net.is_balanced
    held = tuple(int(node) for node in np.unique(ragged.boundary_edges))
    sim = Simulation(Scene(ragged, RUBBER, [UNBUCKLED, MassDamping(60.0)], [Fixed(held)]))
    sheared = points.copy()
    sheared[:, 0] += strain * points[:, 1]
    sim.positions = sheared
    start = sim.energies()["springs"]
    sim.step(round(2.0 / sim.dt))
    scale = 0.5 * RUBBER.youngs_modulus * RUBBER.thickness * float(ragged.areas().sum()) * strain**2
    assert sim.energies()["springs"] / scale == pytest.approx(net.stiffness[2, 2], rel=1e-3)
    assert start / scale == pytest.approx(net_moduli(ragged, RUBBER).stiffness[2, 2], rel=1e-3)
    assert start > 1.01 * sim.energies()["springs"]


def obtuse(kind: str) -> Mesh:
    """A square of four triangles with one negative spring on its boundary, or a strip that is sheared throughout."""
    if kind == "boundary":
        points = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.1, 0.0], [0.0, 0.1, 0.0], [0.05, 0.02, 0.0]]
        return Mesh(points, [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    strip = Strip(0.08, 0.08, 8, 8).mesh()
    sheared = strip.reference @ np.array([[1.0, 0.0, 0.0], [0.9, 1.0, 0.0], [0.0, 0.0, 1.0]])
    return Mesh(sheared, strip.triangles)


@pytest.mark.parametrize("kind", ["boundary", "throughout"])
@pytest.mark.parametrize("negative", ["keep", "clip"])
def test_moduli_are_those_of_the_springs_that_the_scene_uses(kind: str, negative: Literal["keep", "clip"]) -> None:
    # The energy of a uniform strain, by the simulator, in three states of strain.
    mesh, clip = obtuse(kind), negative == "clip"
    net = net_moduli(mesh, RUBBER, clip=clip)
    scene = Scene(mesh, RUBBER, [replace(UNBUCKLED, negative=negative)], [Fixed((0, 1, 2))])
    scale = 0.5 * RUBBER.youngs_modulus * RUBBER.thickness * float(mesh.areas().sum())
    for strain in 1e-5 * np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.3, 1.0]]):
        xx, yy, xy = strain
        sim = Simulation(scene)
        sim.positions = mesh.reference @ (np.eye(3) + np.array([[xx, xy / 2, 0], [xy / 2, yy, 0], [0, 0, 0]]))
        expected = strain @ net.stiffness @ strain
        assert sim.energies()["springs"] / scale == pytest.approx(expected, rel=1e-3)
    least, greatest = net.local_extremes
    assert least <= net.extremes[0] + 0.1
    assert greatest >= net.extremes[1] - 0.1


def test_check_tells_the_moduli_of_clipped_springs_and_no_growing_mode() -> None:
    mesh = obtuse("throughout")
    found = {
        negative: audit(Scene(mesh, RUBBER, [Springs(negative=negative)], [Fixed((0, 1))]))
        for negative in ("keep", "clip")
    }
    kept, clipped = (found[negative].find("net_of_springs") for negative in ("keep", "clip"))
    assert kept is not None
    assert clipped is not None
    assert kept.message != clipped.message
    assert "springs, whose constants were negative, to zero" in clipped.message
    assert "to zero" not in kept.message
    assert found["clip"].find("growing_mode") is None


def test_springs_that_leave_a_strain_free_have_no_moduli() -> None:
    # Two needles: their long side is the only spring that clipping leaves.
    points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.1, 0.0]]
    with pytest.raises(MeshError, match="no stiffness in one direction"):
        net_moduli(Mesh(points, [[0, 1, 2]]), FILM, clip=True)


def test_what_has_no_moduli_is_refused() -> None:
    bent = Mesh([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]], [[0, 1, 2], [0, 2, 3]])
    with pytest.raises(MeshError, match="flat reference"):
        net_moduli(bent, FILM)
    obtuse = Mesh([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [-0.8, 0.6, 0.0]], [[0, 1, 2]])
    with pytest.raises(MeshError, match="no stiffness in one direction; make no triangle obtuse"):
        net_moduli(obtuse, FILM)


def test_a_net_of_the_films_modulus_may_be_another_material_in_shear() -> None:
    # An isotropic net has nu = 1/3. At nu = 0.3 it has E within 0.2 %, and G = E/(2 (1 + 1/3)), 2.6 % too small.
    net = net_moduli(EquilateralLattice(0.01, 6, 6).mesh(), Material(3.2e9, 0.3, 1420.0, 7.5e-6))
    assert net.extremes == pytest.approx((1.0, 1.0), abs=0.002)
    assert float(net.shear_modulus()) == pytest.approx(0.974, abs=1e-3)
    assert not net.is_isotropic


@pytest.mark.parametrize("name", scenes.names())
def test_check_says_what_the_net_of_springs_represents(name: str) -> None:
    scene = scenes.load(name)
    lines = dict(net_lines(scene))
    fact = audit(scene).find("net_of_springs")
    assert bool(lines) == (fact is not None)
    assert fact is None or (fact.severity == "info" and lines["uniform"] in fact.message)
    if scene.mesh is None or scene.negative_springs == "unused":
        assert not lines
    else:
        assert "along 45 degrees" in lines["uniform"]
        is_film = net_moduli(scene.mesh, scene.material).is_isotropic  # type: ignore[arg-type]
        assert ("of the film in every direction" in lines["meaning"]) == is_film
        assert ("softer in shear" in lines["meaning"]) != is_film


def test_check_prints_it() -> None:
    out = CliRunner().invoke(app, ["check", "hanging-strip"]).output
    assert "E 0.982 along 0 degrees, 0.614 along 45 degrees; G 0.545; nu 0.200" in out
    assert "45 % softer in shear than the film" in out
    assert "relaxed " not in out  # each inner node is a centre of symmetry
    relaxed = dict(net_lines(scenes.load("okuizumi-model-1")))["relaxed"]
    assert relaxed.startswith("E 0.978 along 0 degrees, 0.604 along 45 degrees; G 0.538")
    assert "net of springs" not in CliRunner().invoke(app, ["check", "spinning-tether"]).output


def test_the_scene_of_the_disc_is_a_film() -> None:
    assert net_moduli(Disc(0.1, 8).mesh(), THIRD).is_isotropic
