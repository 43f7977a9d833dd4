"""The film of rectangles against plane stress: moduli, shares of the energy, limits, readings, and what is refused."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    Material,
    Mesh,
    MeshError,
    Rectangles,
    RunSettings,
    Scene,
    Simulation,
    SpringDamping,
    Springs,
    Triangles,
    UnstableError,
    scenes,
)
from membrane_rs.check import audit
from membrane_rs.check.net_of_springs import net_lines
from membrane_rs.cli import app
from membrane_rs.folding import EquilateralLattice, SquareSail, Strip
from membrane_rs.mesh import net_moduli, rectangle_moduli
from membrane_rs.scene.laws import Law
from small_scenes import FILM, Floats, hanging_strip, refused, rotation, turned
from typer.testing import CliRunner

STIFF = Rectangles(buckling=1e12, buckling_on_creases=1e12)
"""Never buckles."""
THICKNESS = 1e-5
STRAINS = {"along": (1, 0, 0), "across": (0, 1, 0), "shear": (0, 0, 1), "cap": (1, 1, 0), "saddle": (1, -1, 0)}
TINY = 1e-6


def film(nu: float) -> Material:
    return Material(3.2e9, nu, 1420.0, THICKNESS)


def strained(mesh: Mesh, law: Law, gradient: Any, nu: float = 0.34) -> Simulation:
    sim = Simulation(Scene(mesh, film(nu), [law]))
    turn = np.eye(3)
    turn[:2, :2] = gradient
    sim.positions = mesh.reference @ turn.T
    return sim


def under(mesh: Mesh, strain: tuple[float, float, float], nu: float, law: Law = STIFF) -> Simulation:
    e1, e2, g = (TINY * component for component in strain)
    return strained(mesh, law, [[1 + e1, g / 2], [g / 2, 1 + e2]], nu)


def plane_stress(strain: tuple[float, float, float], nu: float) -> float:
    """Energy per volume [Pa]."""
    e1, e2, g = (TINY * component for component in strain)
    return 3.2e9 * ((e1 * e1 + e2 * e2 + 2 * nu * e1 * e2) / (1 - nu**2) + g * g / (2 + 2 * nu)) / 2


def share(mesh: Mesh, strain: tuple[float, float, float], nu: float, law: Law = STIFF) -> float:
    """Of the energy of the film."""
    energy = under(mesh, strain, nu, law).energies()[law.kind]
    return float(energy / (mesh.areas().sum() * THICKNESS * plane_stress(strain, nu)))


def graded(ratio: float = 1.4) -> Mesh:
    """Rectangles whose sides grow from one to the next, at most `ratio` apart, with diagonals at random."""
    mesh = Strip(4.0, 4.0, 4, 4).mesh()
    places = np.cumsum([0.0, *np.linspace(1.0, ratio, 4)])
    return Mesh(np.interp(mesh.reference + np.array([0.0, 2.0, 0.0]), np.arange(5.0), places), mesh.triangles)


MESHES = [
    Strip(4.0, 4.0, 4, 4).mesh(),
    Strip(4.0, 5.0, 4, 4).mesh(),
    graded(),
]


@pytest.mark.parametrize("nu", [-0.3, 0.0, 0.2, 1 / 3, 0.34, 0.45])
@pytest.mark.parametrize("mesh", MESHES, ids=["squares", "rectangles", "graded"])
def test_stretch_and_shear_are_the_films_and_cap_and_saddle_differ_by_the_coupling(mesh: Mesh, nu: float) -> None:
    if math.sqrt(2 / (1 - nu)) < 1.4:
        mesh = MESHES[0]
    for name in ("along", "across", "shear"):
        assert share(mesh, STRAINS[name], nu) == pytest.approx(1.0, rel=1e-5), name
    assert share(mesh, STRAINS["cap"], nu) == pytest.approx((3 - nu) / (2 + 2 * nu), rel=1e-5)
    assert share(mesh, STRAINS["saddle"], nu) == pytest.approx((1 + nu) / (2 - 2 * nu), rel=1e-5)


@pytest.mark.parametrize("nu", [0.0, 0.2, 1 / 3, 0.45])
@pytest.mark.parametrize("mesh", MESHES, ids=["squares", "rectangles", "graded"])
def test_forces_are_those_of_a_uniform_stress(mesh: Mesh, nu: float) -> None:
    columns = []
    for strain in np.eye(3):
        sim = under(mesh, tuple(strain), nu)
        forces = sim.forces("rectangles")
        stress = -(forces.T @ mesh.reference)[:2, :2] / (mesh.areas().sum() * THICKNESS)
        inner = np.setdiff1d(np.arange(mesh.node_count), mesh.boundary_edges)
        # The patch test.
        assert np.abs(forces[inner]).max() < 1e-5 * np.abs(forces).max()
        columns.append([stress[0, 0], stress[1, 1], stress[0, 1]])
    found = np.array(columns).T / (3.2e9 * TINY)
    assert found == pytest.approx(rectangle_moduli(film(nu)).stiffness, rel=1e-4, abs=1e-5)


def test_moduli_and_the_film() -> None:
    third = rectangle_moduli(film(1 / 3))
    assert third.is_isotropic
    assert third.extremes == pytest.approx((1.0, 1.0))
    net = rectangle_moduli(FILM)
    assert net.is_isotropic
    assert float(net.poisson_ratio(0.0)) == pytest.approx((1 - 0.34) / 2)
    assert float(net.shear_modulus(0.0)) == pytest.approx(1.0)
    fifth = rectangle_moduli(film(0.2))
    assert not fifth.is_isotropic
    assert float(fifth.modulus(0.0)) == pytest.approx((1 - 0.4**2) / (1 - 0.2**2))
    # Springs along the edges of the same mesh: soft in shear.
    assert float(net_moduli(MESHES[0], FILM).shear_modulus(0.0)) < 0.6


@pytest.mark.parametrize("degrees", [0.0, 33.0])
def test_moduli_belong_to_the_sides_whatever_their_direction(degrees: float) -> None:
    turn = rotation([0, 0, 1], math.radians(degrees))
    sim = Simulation(Scene(turned(MESHES[1], turn), film(0.2), [STIFF]))
    stretch = turn @ np.diag([1 + TINY, 1.0, 1.0]) @ turn.T
    mesh = sim.scene.mesh
    assert mesh is not None
    sim.positions = mesh.reference @ stretch.T
    expected = plane_stress((1, 0, 0), 0.2) * mesh.areas().sum() * THICKNESS
    assert sim.energies()["rectangles"] == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("nu", [0.0, 1 / 3, 0.34, 0.45])
def test_the_largest_ratio_of_sides(nu: float) -> None:
    most = math.sqrt(2 / (1 - nu))
    for rows, columns in ((1, 1), (3, 2)):
        assert Strip(0.999 * most * columns, 1.0 * rows, columns, rows).mesh().rectangle_constants(film(nu)).min() > 0
        slender = Strip(1.001 * most * columns, 1.0 * rows, columns, rows).mesh()
        words = rf"constants of rectangles are negative.*sqrt\(2/\(1 - nu\)\) = {most:.4f} times.*squarer"
        refused(lambda mesh=slender: mesh.rectangle_constants(film(nu)), MeshError, words)  # type: ignore[misc]
        refused(lambda mesh=slender: Simulation(Scene(mesh, film(nu), [STIFF])), MeshError, words)  # type: ignore[misc]


def test_meshes_that_are_no_rectangles_are_refused_with_the_place_by_all_that_asks() -> None:
    mesh = EquilateralLattice(0.01, 4, 4).mesh()
    words = r"of \d+ triangles are no halves of rectangles, first triangle 0 \(nodes .*\): it has no right angle"
    refused(mesh.find_rectangles, MeshError, words)
    scene = Scene(mesh, FILM, [Rectangles()], name="lattice")
    refused(lambda: Simulation(scene), MeshError, words)
    found = audit(scene).find("rectangles")
    assert found is not None
    assert found.severity == "error"
    assert "no right angle" in found.message
    assert "springs or triangles" in found.remedy
    assert audit(replace(scene, mesh=MESHES[0])).find("rectangles") is None
    # A crease on a diagonal.
    square = Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]], creases=[[0, 2]])
    refused(square.find_rectangles, MeshError, "has a crease along its longest side")
    refused(SquareSail(layout="equilateral").mesh().find_rectangles, MeshError, "no halves of rectangles")


def test_springs_are_edges_and_second_diagonals() -> None:
    mesh = MESHES[0]
    corners = mesh.find_rectangles()
    assert corners.shape == (16, 4)
    assert sorted(np.bincount(corners.ravel())) == [1] * 4 + [2] * 12 + [4] * 9
    sides = mesh.reference[np.roll(corners, -1, axis=1)] - mesh.reference[corners]
    assert np.linalg.norm(sides, axis=2) == pytest.approx(np.ones((16, 4)))
    # Wound as the triangles.
    assert (np.cross(sides[:, 0], sides[:, 1])[:, 2] > 0.0).all()
    pairs = {tuple(sorted(pair)) for pair in mesh.edges.tolist()}
    for diagonal, is_edge in ((corners[:, ::2], False), (corners[:, 1::2], True)):
        assert all((tuple(sorted(pair)) in pairs) is is_edge for pair in diagonal.tolist())
    sim = strained(mesh, Rectangles(buckling=0.0), [[1.0, 0.02], [0.0, 1.0]])
    assert len(sim.spring_pairs) == len(mesh.edges) + 16
    # Diagonals along the shear are stretched by half of it, those across shortened and buckled.
    ends = mesh.reference[sim.spring_pairs, :2]
    along = np.prod(ends[:, 1] - ends[:, 0], axis=1)
    assert sim.spring_strains()[along > 0.5] == pytest.approx(0.01, rel=0.02)
    diagonal = np.abs(along) > 0.5
    assert diagonal.sum() == 2 * 16
    assert (sim.buckled()[diagonal] == (along[diagonal] < 0.0)).all()


@pytest.mark.parametrize("strain", STRAINS.values(), ids=STRAINS)
def test_the_stress_of_a_uniform_strain_is_uniform(strain: tuple[float, float, float]) -> None:
    nu = 0.2
    for mesh in MESHES:
        sim = under(mesh, strain, nu)
        s11, s22, s12 = rectangle_moduli(film(nu)).stiffness @ strain * 3.2e9 * TINY
        expected = np.linalg.eigvalsh([[s11, s12], [s12, s22]])[::-1]
        stress = sim.film_stress()
        rows = np.tile(expected, (len(mesh.triangles), 1))
        assert stress.principal == pytest.approx(rows, rel=1e-4, abs=1e-5 * np.abs(expected).max())
        assert sim.largest_film_stress() == pytest.approx(max(expected[0], 0.0), rel=1e-4)
        if expected[0] > 1.01 * expected[1]:
            direction = np.linalg.eigh([[s11, s12], [s12, s22]])[1][:, 1]
            assert np.abs(stress.directions[:, 0, :2] @ direction) == pytest.approx(1.0, rel=1e-4)


def test_stress_is_work_conjugate_to_strain() -> None:
    # The film's power at a random velocity is that of its mean stress where each rectangle is strained uniformly.
    mesh = Strip(1.2, 1.0, 1, 1).mesh()
    sim = strained(mesh, Rectangles(buckling=1e5), [[1.01, 0.03], [-0.02, 0.97]])
    rate = np.array([[0.3, -0.2], [0.5, 0.1]])
    stress, gradient = sim.film_stress(), np.array([[1.01, 0.03], [-0.02, 0.97]])
    power = -np.sum(sim.forces()[:, :2] * (mesh.reference[:, :2] @ rate.T))
    green_rate = 0.5 * (rate.T @ gradient + gradient.T @ rate)
    pushed = stress.directions[0, :, :2]
    pulled = np.linalg.solve(gradient, pushed.T).T  # along the principal directions in the reference
    pulled /= np.linalg.norm(pulled, axis=1)[:, None]
    # At right angles in the reference, where the principal directions are those of S.
    first = pulled[0]
    second = np.array([-first[1], first[0]])
    tensor = stress.principal[0, 0] * np.outer(first, first) + stress.principal[0, 1] * np.outer(second, second)
    assert power == pytest.approx(1.2 * THICKNESS * np.sum(tensor * green_rate), rel=1e-9)


def test_second_diagonals_buckle_as_the_first_ones() -> None:
    # Pressed in all directions beyond buckling, both diagonals push with the force of eq. (2).
    mesh = Strip(0.02, 0.02, 2, 2).mesh()
    law = Rectangles(buckling=50.0)
    sim = strained(mesh, law, 0.9 * np.eye(2))
    assert sim.buckled().all()
    energy = sim.energies()["rectangles"]
    constants = mesh.rectangle_constants(film(0.34))
    ends = mesh.reference[sim.spring_pairs]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    shortening = 50.0 * math.pi**2 * THICKNESS**2 / (12 * length)
    expected = np.sum(constants * shortening * (0.1 * length - 0.5 * shortening))
    assert energy == pytest.approx(expected, rel=1e-9)
    critical = replace(law, buckling_length=0.01)
    pressed = [strained(Strip(0.02, 0.02, n, n).mesh(), critical, 0.9 * np.eye(2)) for n in (1, 4)]
    assert [sim.largest_film_stress() for sim in pressed] == [0.0, 0.0]
    coarse, fine = (sim.film_stress().principal.min() for sim in pressed)
    assert coarse == pytest.approx(fine, rel=1e-9)
    assert coarse < 0.0


def test_a_rigid_motion_has_no_force_and_no_energy() -> None:
    mesh = MESHES[2]
    sim = Simulation(Scene(mesh, FILM, [Rectangles(), SpringDamping(0.1)]))
    turn = rotation([1.0, 2.0, 3.0], 1.1)
    sim.positions = mesh.reference @ turn.T + [0.3, -0.2, 5.0]
    sim.velocities = np.cross([3.0, -1.0, 2.0], sim.positions)
    largest = float(mesh.rectangle_constants(FILM).max())
    assert np.abs(sim.forces()).max() < 1e-13 * largest
    assert sim.energies()["rectangles"] < 1e-26 * largest


def test_masses_are_those_of_the_mesh() -> None:
    by_law = [Simulation(Scene(MESHES[1], FILM, [law])).masses for law in (Springs(), Triangles(), Rectangles())]
    assert (by_law[0] == by_law[1]).all()
    assert (by_law[0] == by_law[2]).all()


def test_dashpots_along_second_diagonals() -> None:
    ratio = 0.1
    mesh = MESHES[0]
    sim = Simulation(Scene(mesh, FILM, [Rectangles(), SpringDamping(ratio)]))
    sim.velocities = np.random.default_rng(1).normal(size=(mesh.node_count, 3))
    ends = mesh.reference[sim.spring_pairs]
    d = ends[:, 1] - ends[:, 0]
    unit = d / np.linalg.norm(d, axis=1)[:, None]
    v, m = sim.velocities[sim.spring_pairs], sim.masses[sim.spring_pairs].mean(axis=1)
    opening = np.sum(unit * (v[:, 1] - v[:, 0]), axis=1)
    resistance = 2 * ratio * np.sqrt(mesh.rectangle_constants(FILM) * m) * opening
    expected = np.zeros((mesh.node_count, 3))
    np.add.at(expected, sim.spring_pairs[:, 0], resistance[:, None] * unit)
    np.add.at(expected, sim.spring_pairs[:, 1], -resistance[:, None] * unit)
    assert sim.forces("spring_damping") == pytest.approx(expected, rel=1e-9, abs=1e-12 * np.abs(expected).max())
    # Limited by the tension of their springs: none at rest.
    slack = Simulation(Scene(mesh, FILM, [Rectangles(buckling=0.0), SpringDamping(ratio, limited="all")]))
    slack.velocities = sim.velocities
    assert np.abs(slack.forces("spring_damping")).max() < 1e-12 * np.abs(expected).max()


def test_the_measured_step_limit_is_the_predicted_one() -> None:
    scene = replace(hanging_strip(), laws=[STIFF], run=RunSettings(energy_loss=2.0))
    limit = Simulation(scene).stable_dt()
    kick = 1e-9 * np.random.default_rng(1).normal(size=(scene.assemble().node_count, 3))
    kick[:, 2] = 0.0
    growth = []
    for part in (0.99, 1.01):
        sim = Simulation(scene, dt=part * limit)
        sim.positions = sim.positions + kick
        before = sim.energies()["rectangles"]
        with np.errstate(all="ignore"):
            try:
                sim.step(3000)
                growth.append(sim.energies()["rectangles"] / before)
            except UnstableError:
                growth.append(math.inf)
    assert growth[0] < 3
    assert growth[1] > 10


@pytest.mark.parametrize("method", ["leapfrog", "generalized_alpha"])
def test_a_falling_film_keeps_its_energy_balance(method: str) -> None:
    scene = hanging_strip()
    scene = replace(scene, laws=[Rectangles(), *scene.laws[1:]])
    sim = Simulation(scene, method, dt=None if method == "leapfrog" else 2e-5)
    sim.run(until=0.02)
    assert abs(sim.ledger()["error"]) < 0.02
    explicit = Simulation(scene, "rk4")
    explicit.run(until=0.02)
    apart = np.abs(sim.positions - explicit.positions).max()
    assert apart < 1e-3 * np.abs(explicit.positions - scene.assemble().positions).max()


def test_a_second_diagonal_over_its_bound_stops_the_run() -> None:
    scene = hanging_strip()
    scene = replace(scene, laws=[Rectangles(strain_limit=1e-4), *scene.laws[1:]])
    with pytest.raises(UnstableError, match=r"spring of .* is stretched by .* %, over its bound of 0\.010 %"):
        Simulation(scene).run(until=0.2)


def in_plane_bending(law: Law, rows: int) -> float:
    """Largest displacement inside a square whose boundary is moved as in pure bending, relative to the exact one."""
    mesh = Strip(1.0, 1.0, rows, rows).mesh()
    x, y, _ = mesh.reference.T
    exact: Floats = 1e-6 * np.stack([x * y, -0.5 * (x * x + y * y / 3), 0 * x], axis=1)
    sim = Simulation(Scene(mesh, film(1 / 3), [law]))
    sim.positions = mesh.reference + exact
    inner = np.setdiff1d(np.arange(mesh.node_count), mesh.boundary_edges)
    # Forces inside, over those that a displacement of the size of the exact one would cause.
    return float(np.abs(sim.forces()[inner]).max() / (3.2e9 * THICKNESS * 1e-6 / rows))


def test_rectangles_converge_in_bending_at_one_third_where_springs_do_not() -> None:
    rectangles = [in_plane_bending(STIFF, rows) for rows in (4, 8, 16)]
    springs = [in_plane_bending(Springs(buckling=1e12, buckling_on_creases=1e12), rows) for rows in (4, 8, 16)]
    assert max(rectangles) < 1e-4
    assert min(springs) > 1e3 * max(rectangles)


@pytest.mark.parametrize("name", ["okuizumi-model-1", "hanging-strip", "ikaros", "single-crease"])
def test_the_sails_are_rectangles_but_for_the_slender_ones(name: str) -> None:
    scene = scenes.load(name)
    mesh, material = scene.mesh, scene.material
    assert mesh is not None
    assert material is not None
    assert 2 * len(mesh.find_rectangles()) == len(mesh.triangles)
    laws = [Rectangles() if law.is_film else law for law in scene.laws]
    lines = dict(net_lines(replace(scene, laws=laws)))
    assert "a side of the rectangles" in lines["direction"]
    assert "G 1.000" in lines["uniform"]


def test_a_sail_of_rectangles_from_a_file_runs_by_the_command_line(tmp_path: Any) -> None:
    scene = scenes.load("hanging-strip")
    laws = [Rectangles(buckling=7.0) if law.is_film else law for law in scene.laws]
    replace(scene, name="rectangles", laws=laws).save(tmp_path / "scene")
    path = tmp_path / "scene" / "scene.toml"
    assert "[laws.rectangles]" in path.read_text()
    read = Scene.from_toml(path)
    law = read.law("rectangles")
    assert law == Rectangles(buckling=7.0)
    runner = CliRunner()
    checked = runner.invoke(app, ["check", str(path)])
    assert checked.exit_code == 0, checked.output
    assert "0 degrees is a side of the rectangles" in checked.output
    for words in (
        ["run", str(path), "--until", "0.01", "--out", str(tmp_path / "run")],
        ["ablate", str(path), "--until", "0.01", "--out", str(tmp_path / "ablate")],
    ):
        result = runner.invoke(app, words)
        assert result.exit_code == 0, result.output
    sim = Simulation.restore(sorted((tmp_path / "run").glob("*.npz"))[-1])
    assert sim.scene.law("rectangles") == law
