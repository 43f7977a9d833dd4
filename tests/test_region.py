"""Regions of the film and sets of creases: against a film of that material throughout, closed forms, refusals."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    Bending,
    Creases,
    CreaseSet,
    Fixed,
    Material,
    Mesh,
    Region,
    Scene,
    Simulation,
    SolarPressure,
    SpringDamping,
    Springs,
    Triangles,
)
from membrane_rs.check import facts
from membrane_rs.errors import InputError, InputTypeError, MeshError, SceneError
from membrane_rs.folding import Disc, SquareSail, Strip
from membrane_rs.scene.scales import film_mass, node_masses
from numpy.testing import assert_allclose
from small_scenes import forces_are_slopes, irregular, refused

FILM = Material(3.2e9, 0.34, 1420.0, 7.5e-6)
THICK = Material(5.0e9, 0.34, 1700.0, 25e-6)
WAVY = Strip(0.12, 0.04, 8, 4, creases=(0.25, 0.5, 0.75), fold_angle=1.0).mesh()
ALL = tuple(range(len(WAVY.triangles)))
FILMS: list[Any] = [Springs(10.0, 30.0), Springs(10.0, 30.0, crease_length=0.01), Triangles(0.1, 10.0, 30.0)]
BAD: Any = [(0.0, 0.0, 0.0)]
OF_THICK: dict[str, Any] = {"youngs_modulus": 5.0e9, "density": 1700.0, "thickness": 25e-6}


def crumpled(mesh: Mesh, size: float = 1e-4) -> Mesh:
    """The mesh with nodes displaced at random."""
    moved = mesh.positions + np.random.default_rng(3).normal(0.0, size, mesh.positions.shape)
    return Mesh(mesh.reference, mesh.triangles, positions=moved, creases=mesh.creases, node_sets=dict(mesh.node_sets))


@pytest.mark.parametrize("film", FILMS)
@pytest.mark.parametrize("form", ["hinges", "curvature"])
def test_a_region_of_all_triangles_is_a_film_of_that_material(film: Any, form: Any) -> None:
    mesh = crumpled(WAVY)
    laws = [film, Creases(5.0), Bending(form), SpringDamping(0.1), SolarPressure(0.8, 0.1)]
    whole = Simulation(Scene(mesh, THICK, laws, [Fixed([0, 1])]))
    region = Simulation(Scene(mesh, FILM, laws, [Fixed([0, 1]), Region(ALL, **OF_THICK)]))
    assert_allclose(region.masses, whole.masses, rtol=1e-14)
    for law in laws[:3]:
        scale = np.abs(whole.forces(law.kind)).max()
        assert scale > 0.0
        assert_allclose(region.forces(law.kind), whole.forces(law.kind), atol=1e-12 * scale)
        assert region.energies()[law.kind] == pytest.approx(whole.energies()[law.kind], rel=1e-12)
    stress = whole.film_stress().principal
    assert_allclose(region.film_stress().principal, stress, atol=1e-10 * np.abs(stress).max())
    assert region.stable_dt() == pytest.approx(whole.stable_dt(), rel=1e-9)


def test_other_buckling_and_bending_stiffness_are_those_of_their_laws() -> None:
    mesh = crumpled(WAVY, 1e-3)
    for film in FILMS:
        other = replace(film, buckling=70.0)
        own, given = (
            Simulation(Scene(mesh, FILM, [law], [Fixed([0]), *parts]))
            for law, parts in ((other, ()), (film, (Region(ALL, buckling=70.0),)))
        )
        assert not np.array_equal(Simulation(Scene(mesh, FILM, [film], [Fixed([0])])).forces(), own.forces())
        assert_allclose(given.forces(), own.forces(), atol=1e-13 * np.abs(own.forces()).max())
    stiff, given = (
        Simulation(Scene(mesh, FILM, [Springs(), law], [Fixed([0]), *parts]))
        for law, parts in (
            (Bending("curvature", 7.0), ()),
            (Bending("curvature"), (Region(ALL, bending_stiffness=7.0 * FILM.bending_stiffness),)),
        )
    )
    assert_allclose(given.forces("bending"), stiff.forces("bending"), rtol=1e-9, atol=1e-18)


def test_masses_are_those_of_the_areas() -> None:
    mesh = Strip(0.1, 0.02, 10, 2).mesh()
    half = [(-1.0, -1.0), (0.05, -1.0), (0.05, 1.0), (-1.0, 1.0)]
    left = mesh.reference[:, 0].min() == 0.0
    polygon = half if left else [(x - 0.05, y) for x, y in half]
    parts = [Fixed([0]), Region(polygon=polygon, thickness=25e-6, areal_mass=0.05)]
    scene = Scene(mesh, FILM, [Springs()], parts)
    area = 0.5 * float(mesh.areas().sum())
    expected = area * 1420.0 * (7.5e-6 + 25e-6) + area * 0.05
    assert film_mass(scene) == pytest.approx(expected, rel=1e-12)
    assert node_masses(scene).sum() == pytest.approx(expected, rel=1e-12)
    assert_allclose(Simulation(scene).masses, node_masses(scene), rtol=1e-12)
    assert f"film {expected:.4g} kg" in facts(scene)["mass"]


@pytest.mark.parametrize("film", FILMS)
def test_forces_are_the_slope_of_the_energy_where_films_meet(film: Any) -> None:
    mesh = crumpled(WAVY)
    parts = [
        Fixed([0]),
        Region(ALL[: len(ALL) // 3], **OF_THICK, curvature=(20.0, -5.0), direction=0.3),
        Region(ALL[len(ALL) // 2 :], buckling=3.0, bending_stiffness=3e-6, curvature=(-8.0, 30.0)),
        CreaseSet(fold="valley", stiffness=50.0, contact_penalty=7.0, natural_angle=2.0),
    ]
    for form in ("hinges", "curvature"):
        sim = Simulation(Scene(mesh, FILM, [film, Creases(5.0), Bending(form)], parts))
        forces_are_slopes(sim, (film.kind, "creases", "bending"), 2e-4)


@pytest.mark.parametrize("form", ["hinges", "curvature"])
@pytest.mark.parametrize(("curvature", "direction"), [((3.0, 0.0), 0.0), ((2.0, -1.0), 0.7), ((1.5, 1.5), 0.0)])
def test_a_film_on_the_surface_of_its_natural_curvature_bears_no_moment(
    form: Any, curvature: tuple[float, float], direction: float
) -> None:
    """Up to third order in the slope; a film without natural curvature bears moments there."""
    flat = irregular()
    x, y = (flat.reference[:, :2] - flat.reference[:, :2].mean(axis=0)).T
    along, across = x * math.cos(direction) + y * math.sin(direction), y * math.cos(direction) - x * math.sin(direction)
    moments = []
    for scale in (1.0, 0.1):
        lifted = np.array(flat.reference)
        lifted[:, 2] = 0.5 * scale * (curvature[0] * along**2 + curvature[1] * across**2)
        mesh = Mesh(flat.reference, flat.triangles, positions=lifted)
        of_region = Region(
            tuple(range(len(flat.triangles))), curvature=(scale * curvature[0], scale * curvature[1]),
            direction=direction if curvature[0] != 0.0 else 0.0,
        )  # fmt: skip
        bare, curled = (
            Simulation(Scene(mesh, FILM, [Springs(), Bending(form)], [Fixed([0]), *parts]))
            for parts in ((), (of_region,))
        )
        moments.append(curled.energies()["bending"] / bare.energies()["bending"])
    assert moments[0] < 1e-3
    assert moments[1] < 2e-4 * moments[0] or moments[1] < 1e-12


def test_a_strip_curls_to_its_natural_radius() -> None:
    """Relaxed from flat, a narrow strip along x of natural curvature k along x is an arc of radius 1/k."""
    length, curvature = 0.1, 8.0
    mesh = Strip(length, 0.01, 40, 4).mesh()
    triangles = tuple(range(len(mesh.triangles)))
    film = Material(3.2e9, 0.34, 1420.0, 50e-6, softening=10.0)
    middle = np.flatnonzero(np.abs(mesh.reference[:, 0] - mesh.reference[:, 0].mean()) < 2e-3)
    scene = Scene(
        mesh, film, [Triangles(1.0), Bending("curvature"), SpringDamping(0.1)],
        [Fixed(middle.tolist()), Region(triangles, curvature=(curvature, 0.0))],
    )  # fmt: skip
    sim = Simulation(scene)
    sim.relax(duration=0.4)
    x, _, z = np.array(sim.positions).T
    ends = np.abs(mesh.reference[:, 0] - mesh.reference[:, 0].mean()) > 0.5 * length - 1e-9
    half = 0.5 * length
    expected_x = math.sin(curvature * half) / curvature
    expected_z = (1.0 - math.cos(curvature * half)) / curvature
    assert np.abs(x - x[middle].mean())[ends].mean() == pytest.approx(expected_x, rel=0.02)
    assert (z[ends] - z[middle].mean()).mean() == pytest.approx(expected_z, rel=0.05)


def test_copies_of_a_polygon_turn_with_their_curvature() -> None:
    mesh = Disc(0.1, rings=6).mesh()
    sector = [(0.0311, -0.0175), (0.1211, -0.0417), (0.1211, 0.0417), (0.0311, 0.0175)]
    scene = Scene(mesh, FILM, [Springs()], [Fixed("rim"), Region(polygon=sector, copies=6, curvature=(4.0, 0.0))])
    regions = scene.assemble().regions
    assert len(regions) == 6
    counts = [len(region.triangles) for region in regions]
    assert max(counts) - min(counts) <= 2
    for k, region in enumerate(regions):
        xx, yy, xy = region.curvature
        tensor = np.array([[xx, xy], [xy, yy]])
        along = np.array([math.cos(k * math.pi / 3), math.sin(k * math.pi / 3)])
        assert_allclose(tensor, 4.0 * np.outer(along, along), atol=1e-12)
        centre = mesh.reference[mesh.triangles[region.triangles]].mean(axis=(0, 1))[:2]
        assert_allclose(centre / np.linalg.norm(centre), along, atol=0.05)


def test_light_falls_on_each_region_as_on_a_film_of_its_own() -> None:
    mesh = crumpled(WAVY)
    own: dict[str, Any] = {"back_specular": 0.2, "back_diffuse": 0.3, "front_emissivity": 0.05, "back_emissivity": 0.6}
    sun = (0.3, -0.5, 1.2)
    half = ALL[len(ALL) // 2 :]
    mirror, other = SolarPressure(0.8, 0.1, sun), SolarPressure(0.1, 0.2, sun, **own)
    region = Region(half, front_specular=0.1, front_diffuse=0.2, **own)
    mixed, of_mirror, of_other = (
        Simulation(Scene(mesh, FILM, [Springs(), law], [Fixed([0]), *parts])).forces("solar_pressure")
        for law, parts in ((mirror, (region,)), (mirror, ()), (other, ()))
    )
    inner = np.setdiff1d(np.unique(mesh.triangles[list(half)]), np.unique(mesh.triangles[: half[0]]))
    outer = np.setdiff1d(np.unique(mesh.triangles[: half[0]]), np.unique(mesh.triangles[list(half)]))
    assert inner.size
    assert outer.size
    assert_allclose(mixed[inner], of_other[inner], atol=1e-20)
    assert_allclose(mixed[outer], of_mirror[outer], atol=1e-20)
    assert not np.allclose(of_mirror, of_other, atol=0.0)


def test_creases_have_properties_of_their_own() -> None:
    mesh = crumpled(WAVY)
    valleys = np.flatnonzero(mesh.fold_angles > 0.0)
    law = Creases(5.0, 10.0, natural_angle=1.0)

    def forces(law: Creases, *parts: Any) -> Any:
        return Simulation(Scene(mesh, FILM, [Springs(), law], [Fixed([0]), *parts])).forces("creases")

    own: dict[str, Any] = {"stiffness": 9.0, "contact_penalty": 4.0, "natural_angle": 2.5}
    of_all = forces(law, CreaseSet(**own))
    assert_allclose(of_all, forces(Creases(9.0, 4.0, natural_angle=2.5)), rtol=1e-12)
    none = forces(law, CreaseSet(fold="mountain", stiffness=0.0))
    assert np.abs(none).max() > 0.0
    touched = np.unique(mesh.creases[valleys])
    by_rows = forces(law, CreaseSet(np.setdiff1d(np.arange(len(mesh.creases)), valleys).tolist(), stiffness=0.0))
    assert np.array_equal(by_rows, none)
    by_nodes = forces(law, CreaseSet(nodes=touched.tolist(), natural_angle=2.5))
    by_fold = forces(law, CreaseSet(fold="valley", natural_angle=2.5))
    assert_allclose(by_nodes, by_fold)


def test_a_fraction_of_the_fold_is_the_natural_state() -> None:
    flat, folded = (Strip(0.12, 0.04, 8, 4, creases=(0.25, 0.5, 0.75), fold_angle=angle).mesh() for angle in (0.0, 1.2))
    mesh = Mesh(flat.reference, flat.triangles, positions=folded.positions, creases=folded.creases)
    assert_allclose(np.abs(mesh.fold_angles), 1.2)
    laws = {fraction: Creases(5.0, fold_fraction=fraction) for fraction in (0.0, 0.5, 1.0)}
    energies = {
        fraction: Simulation(Scene(mesh, FILM, [Springs(), law], [Fixed([0])])).energies()["creases"]
        for fraction, law in laws.items()
    }
    assert energies[1.0] == pytest.approx(0.0, abs=1e-20)
    assert energies[0.5] == pytest.approx(0.25 * energies[0.0], rel=1e-9)
    refused(lambda: Creases(natural_angle=1.0, fold_fraction=0.5), InputError, "leave one of them out")


def test_a_softened_scene_keeps_the_moments_of_its_regions() -> None:
    mesh = crumpled(WAVY)
    parts = [Fixed([0]), Region(ALL[::2], **OF_THICK, bending_stiffness=2e-6), Region(ALL[1::2], buckling=5.0)]
    parts.append(CreaseSet(fold="valley", stiffness=8.0))
    plain, soft = (
        Simulation(Scene(mesh, replace(FILM, softening=factor), [Springs(), Creases(), Bending()], parts))
        for factor in (None, 8.0)
    )
    for kind in ("creases", "bending"):
        assert_allclose(soft.forces(kind), plain.forces(kind), atol=1e-12 * np.abs(plain.forces(kind)).max())
    assert_allclose(soft.masses, plain.masses)
    assert soft.stable_dt() > 2.0 * plain.stable_dt()


def test_scene_files_hold_regions(tmp_path: Path) -> None:
    text = """
        [mesh]
        pattern = "strip"
        length = "12 cm"
        width = "4 cm"
        columns = 8
        rows = 4
        creases = [0.5]
        fold_angle = 1.0
        [material]
        youngs_modulus = "3.2 GPa"
        poisson_ratio = 0.34
        density = 1420
        thickness = "7.5 um"
        [laws.springs]
        [laws.creases]
        [[parts]]
        kind = "fixed"
        nodes = [0]
        [[parts]]
        kind = "region"
        polygon = [[-1, -1], [0.06, -1], [0.06, 1], [-1, 1]]
        thickness = "25 um"
        areal_mass = "50 g/m2"
        curvature = ["2 1/m", 0]
        direction = 0.5
        [[parts]]
        kind = "crease_set"
        fold = "valley"
        natural_angle = "90 deg"
    """
    (tmp_path / "scene.toml").write_text(text)
    scene = Scene.from_toml(tmp_path / "scene.toml")
    region = scene.parts[1]
    assert isinstance(region, Region)
    assert region == Region(
        polygon=[(-1, -1), (0.06, -1), (0.06, 1), (-1, 1)], thickness=25e-6, areal_mass=0.05, curvature=(2.0, 0.0),
        direction=0.5,
    )  # fmt: skip
    (tmp_path / "again.toml").write_text(scene.to_toml())
    assert Scene.from_toml(tmp_path / "again.toml").parts == scene.parts
    assert scene.assemble().regions[0].thickness == 25e-6


def scene_with(*parts: Any, mesh: Mesh | None = WAVY) -> Scene:
    return Scene(mesh, FILM, [Springs(), Creases(), Bending()], [Fixed([0]), *parts])


@pytest.mark.parametrize(
    ("make", "kind", "words"),
    [
        (Region, InputError, "no triangles are named; give one of triangles, nodes and polygon"),
        (lambda: Region([0], nodes=[1, 2]), InputError, "triangles and nodes are given together"),
        (lambda: Region(polygon=[(0, 0), (1, 0)]), InputError, "must have three corners or more"),
        (lambda: Region(polygon=BAD), InputTypeError, "a list of points"),
        (lambda: Region([0], copies=3), InputError, "a polygon is repeated, and none is given"),
        (lambda: Region([0], direction=0.3), InputError, "give curvature or natural_strain"),
        (lambda: Region([0], thickness=-1.0), InputError, "Region.thickness = -1.0: must be greater than 0 (m)"),
        (lambda: Region([0], curvature=BAD), InputTypeError, "two numbers"),
        (lambda: Region([0], back_specular=0.3), InputError, "needs front_specular beside it"),
        (lambda: Region([0], front_specular=0.8, front_diffuse=0.3), InputError, "must be at most 0.2"),
        (lambda: scene_with(Region("cells")), SceneError, "parts[1].triangles = 'cells': no such triangle set"),
        (lambda: scene_with(Region([999])), SceneError, "parts[1].triangles: triangle 999 is not there"),
        (lambda: scene_with(Region(nodes="corner")), SceneError, "parts[1].nodes = 'corner': no such node set"),
        (lambda: scene_with(Region(nodes=[0, 1])), SceneError, "there is no triangle of the mesh in it"),
        (
            lambda: scene_with(Region([0, 1]), Region([1, 2])),
            SceneError, "parts[2]: triangle 1 (1 such) belongs to parts[1]",
        ),
        (CreaseSet, InputError, "no property is given"),
        (lambda: CreaseSet([0], nodes=[1], stiffness=1.0), InputError, "creases are given too"),
        (lambda: CreaseSet([0, 0], stiffness=1.0), InputError, "twice"),
        (lambda: scene_with(CreaseSet([99], stiffness=1.0)), SceneError, "parts[1].creases: crease 99 is not there"),
        (lambda: scene_with(CreaseSet(nodes=[0], stiffness=1.0)), SceneError, "no crease of the mesh is meant"),
        (
            lambda: scene_with(CreaseSet(stiffness=1.0), CreaseSet(fold="valley", stiffness=2.0)),
            SceneError, "has one of parts[1] too",
        ),
        (
            lambda: Simulation(scene_with(Region(ALL, curvature=(1e4, 0.0)))),
            MeshError, "make it finer there, or the curvature smaller",
        ),
        (
            lambda: scene_with(CreaseSet(stiffness=1.0), mesh=Strip(0.1, 0.02, 4, 2).mesh()),
            SceneError, "the scene has no creases",
        ),
    ],
)  # fmt: skip
def test_mistakes_are_named(make: Any, kind: type[Exception], words: str) -> None:
    refused(make, kind, re.escape(words))


def test_a_sail_with_devices_spins() -> None:
    """End to end on a folded sail, in both laws of the film: bits repeat, and the energy balance holds."""
    sail = SquareSail(rows=8, columns=8).mesh()
    cells = Region(polygon=[(0.1, -0.1), (1.0, -0.3), (1.0, 0.3), (0.1, 0.1)], copies=4, thickness=15e-6)
    for film in (Springs(), Triangles()):
        scene = Scene(sail, FILM, [film, Creases(), Bending()], [Fixed("inner_corners"), cells])
        first, second = (Simulation(scene) for _ in range(2))
        for sim in (first, second):
            sim.step(50)
        assert np.array_equal(first.positions, second.positions)
        assert abs(first.ledger()["error"]) < 0.01
