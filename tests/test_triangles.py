"""The film of triangles against closed forms: moduli at any Poisson's ratio on any mesh, wrinkles, damping."""

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
    RunSettings,
    Scene,
    SceneError,
    Simulation,
    SpringDamping,
    Springs,
    Triangles,
    UnstableError,
)
from membrane_rs.folding import EquilateralLattice, SquareSail, Strip
from membrane_rs.scene.laws import Law
from small_scenes import FILM, RUBBER, Floats, hanging_strip, rates, refused, rest

PLATE = Triangles(compression=1.0)
"""Never wrinkles: linear in compression too."""
TENSION_ONLY = Triangles(buckling=0.0, buckling_on_creases=0.0)
TINY = 1e-6
"""A strain at which what is not linear lies below 1e-5."""


def film(nu: float) -> Material:
    return Material(3.2e9, nu, 1420.0, 1e-5)


def ragged(cells: int, size: float = 1.0) -> Mesh:
    """A square whose inner nodes were moved at random by up to 0.3 of a cell: obtuse triangles too."""
    sheet = Strip(size, size, cells, cells).mesh()
    points = sheet.reference.copy()
    inner = inside(sheet)
    points[inner, :2] += np.random.default_rng(cells).uniform(-0.3, 0.3, (len(inner), 2)) * size / cells
    return Mesh(points, sheet.triangles)


def inside(mesh: Mesh) -> Any:
    return np.setdiff1d(np.arange(mesh.node_count), mesh.boundary_edges)


def stress(sim: Simulation, name: str = "triangles") -> Floats:
    """(2, 2) mean stress [Pa]: that of the forces on the body, -(1/(A h)) sum f x."""
    mesh, material = sim.scene.mesh, sim.scene.material
    assert mesh is not None
    assert material is not None
    found: Floats = -(sim.forces(name).T @ mesh.reference)[:2, :2] / (mesh.areas().sum() * material.thickness)
    return found


def strained(mesh: Mesh, law: Law, gradient: list[list[float]], nu: float = 0.34) -> Simulation:
    sim = Simulation(Scene(mesh, film(nu), [law]))
    turn = np.eye(3)
    turn[:2, :2] = gradient
    sim.positions = mesh.reference @ turn.T
    return sim


@pytest.mark.parametrize("nu", [-0.99, -0.5, 0.0, 1 / 3, 0.34, 0.499])
@pytest.mark.parametrize("mesh", [Strip(4.0, 4.0, 4, 4).mesh(), ragged(5)], ids=["regular", "ragged"])
def test_any_mesh_is_the_film_at_any_poissons_ratio(mesh: Mesh, nu: float) -> None:
    columns = []
    for e11, e22, g12 in np.eye(3) * TINY:
        sim = strained(mesh, PLATE, [[1 + e11, g12 / 2], [g12 / 2, 1 + e22]], nu)
        s = stress(sim)
        columns.append([s[0, 0], s[1, 1], s[0, 1]])
        # The patch test: a uniform strain leaves no force inside.
        assert np.abs(sim.forces()[inside(mesh)]).max() < 1e-8 * np.abs(sim.forces()).max()
        work = 0.5 * (s[0, 0] * e11 + s[1, 1] * e22 + s[0, 1] * g12) * mesh.areas().sum() * 1e-5
        assert sim.energies()["triangles"] == pytest.approx(work, rel=1e-4)
    found = np.array(columns).T / (3.2e9 * TINY)
    exact = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]]) / (1 - nu**2)
    assert found == pytest.approx(exact, rel=1e-4, abs=2e-6 * exact.max())
    compliance = np.linalg.inv(found)
    assert 1 / compliance[0, 0] == pytest.approx(1.0, rel=1e-3)
    assert -compliance[0, 1] / compliance[0, 0] == pytest.approx(nu, abs=1e-3)
    assert 1 / compliance[2, 2] == pytest.approx(0.5 / (1 + nu), rel=1e-4)


def bending_error(cells: int, law: Law) -> float:
    """In-plane bending, sigma_xx = E y, of a ragged square whose boundary is held where it belongs."""
    nu, size = 0.34, 1e-6
    mesh = ragged(cells)
    x, y, _ = mesh.reference.T
    exact = size * np.stack([x * y, -0.5 * (x * x + nu * y * y), 0 * x], axis=1)
    sim = Simulation(Scene(mesh, film(nu), [law]))
    inner = inside(mesh)
    positions = mesh.reference + exact
    positions[inner] = mesh.reference[inner]
    sim.positions = positions
    rest(sim, inner, [0, 1], 1e-7, iterations=2)
    apart = sim.positions - mesh.reference - exact
    return float(np.sqrt(np.mean(apart[inner] ** 2)) / np.abs(exact).max())


def test_triangles_converge_where_springs_do_not() -> None:
    springs = Springs(buckling=1e12, buckling_on_creases=1e12, negative="keep")
    triangles = [bending_error(cells, PLATE) for cells in (4, 8, 16)]
    nets = [bending_error(cells, springs) for cells in (4, 8, 16)]
    assert rates(triangles) == pytest.approx(2.0, abs=0.5)
    assert triangles[-1] < 2e-3
    assert nets[-1] > 5 * triangles[-1]
    assert rates(nets)[-1] < 1.5


def test_a_wrinkled_strip_bears_tension_along_it_alone() -> None:
    # Stretched by 1 %, and narrowed by more than nu times as much.
    sim = strained(ragged(4), TENSION_ONLY, [[1.01, 0.0], [0.0, 0.98]])
    green = 0.5 * (1.01**2 - 1)
    s = stress(sim)
    assert (sim.film_states() == 1).all()
    assert s[0, 0] == pytest.approx(1.01 * 3.2e9 * green, rel=1e-12)  # first Piola-Kirchhoff: F S
    assert np.abs(s[[0, 1, 1], [1, 0, 1]]).max() < 1e-9 * s[0, 0]
    volume = 1e-5 * 1.0
    assert sim.energies()["triangles"] == pytest.approx(0.5 * 3.2e9 * green**2 * volume, rel=1e-9)
    # Where it narrows by less it is taut.
    assert (strained(ragged(4), TENSION_ONLY, [[1.01, 0.0], [0.0, 0.999]]).film_states() == 0).all()


def test_a_sheared_film_is_a_tension_field_at_45_degrees() -> None:
    # Wagner's: the principal strain g/2 pulls along the diagonal, tau = E g/4, and pulls both pairs of sides together.
    g = 1e-5
    sim = strained(Strip(1.0, 0.25, 8, 2).mesh(), TENSION_ONLY, [[1.0, g], [0.0, 1.0]])
    assert (sim.film_states() == 1).all()
    assert stress(sim) == pytest.approx(3.2e9 * g / 4 * np.ones((2, 2)), rel=1e-4)
    plate = stress(strained(Strip(1.0, 0.25, 8, 2).mesh(), PLATE, [[1.0, g], [0.0, 1.0]]))
    assert plate[0, 1] == pytest.approx(3.2e9 * g / (2 * 1.34), rel=1e-4)


def test_a_slack_film_bears_nothing() -> None:
    sim = strained(ragged(4), TENSION_ONLY, [[0.99, 0.0], [0.002, 0.97]])
    assert (sim.film_states() == 2).all()
    assert np.abs(sim.forces()).max() < 1e-15 * 3.2e9 * 1e-5
    assert abs(sim.energies()["triangles"]) < 1e-14 * 3.2e9 * 1e-5  # the taut energy less what wrinkles save
    left = strained(ragged(4), replace(TENSION_ONLY, compression=0.2), [[1 - TINY, 0.0], [0.0, 1 - TINY]])
    assert stress(left)[0, 0] == pytest.approx(-0.2 * 3.2e9 * TINY / (1 - 0.34), rel=1e-4)


@pytest.mark.parametrize("kind", [Springs, Triangles])
def test_a_buckling_length_gives_one_critical_strain_on_every_mesh(kind: type[Springs] | type[Triangles]) -> None:
    def push(side: float, length: float | None) -> float:
        law = kind(buckling=1.0, buckling_length=length)
        mesh = EquilateralLattice(side, 8, 8).mesh()
        sim = Simulation(Scene(mesh, film(1 / 3), [law]))
        sim.positions = 0.99 * mesh.reference
        return float(sim.forces(kind.kind)[0, 0] / side)

    own = [push(side, None) for side in (0.02, 0.01, 0.005)]
    assert own[1] / own[0] == pytest.approx(4.0, rel=1e-6)
    assert own[2] / own[1] == pytest.approx(4.0, rel=1e-6)
    shared = [push(side, 0.01) for side in (0.02, 0.01, 0.005)]
    assert shared == pytest.approx([own[1]] * 3, rel=1e-6)


def test_uniaxial_compression_is_eq_2() -> None:
    # Pressed along x, free to widen: the stress stays at E times Euler's strain of a column.
    critical = math.pi**2 * 1e-10 / (12 * 0.01**2)
    law = Triangles(buckling=1.0, buckling_length=0.01)
    for share in (0.5, 1.5, 20.0):
        shortened = min(share, 1.0) * critical
        sim = strained(ragged(4), law, [[1 - share * critical, 0.0], [0.0, 1 + 0.34 * shortened]])
        assert (sim.film_states() > 0).all() == (share > 1)
        assert stress(sim)[0, 0] == pytest.approx(-3.2e9 * shortened, rel=1e-4)
        assert abs(stress(sim)[1, 1]) < 1e-3 * 3.2e9 * shortened


def test_a_crease_stiffens_the_film_along_itself_alone() -> None:
    # Pressed from all sides the stress is that of buckling: creases run along y beside six of eight triangles.
    unit = math.pi**2 * 1e-10 / (12 * 0.01**2)
    mesh = Strip(0.04, 0.04, 4, 4, creases=(0.25, 0.5, 0.75)).mesh()
    sim = strained(mesh, Triangles(buckling=1.0, buckling_on_creases=9.0, buckling_length=0.01), [[0.9, 0], [0, 0.9]])
    assert (sim.film_states() == 2).all()
    expected = -0.9 * 3.2e9 * unit * np.array([[1.0, 0.0], [0.0, 0.75 * 9 + 0.25]])  # first Piola-Kirchhoff
    assert stress(sim) == pytest.approx(expected, rel=1e-9, abs=1e-9 * abs(expected[1, 1]))


def test_damping_is_that_of_dashpots_on_an_equilateral_lattice() -> None:
    mesh = EquilateralLattice(0.01, 8, 8).mesh()
    pairs: list[list[Law]] = [[Springs(), SpringDamping(0.1)], [Triangles(), SpringDamping(0.1)]]
    forces = []
    for laws in pairs:
        sim = Simulation(Scene(mesh, RUBBER, laws))
        sim.velocities = np.random.default_rng(3).normal(size=(mesh.node_count, 3))
        forces.append(sim.forces("spring_damping"))
    deep = np.arange(81).reshape(9, 9)[2:-2, 2:-2].ravel()  # all their neighbours have full mass
    assert forces[0][deep] == pytest.approx(forces[1][deep], rel=1e-9, abs=1e-12 * np.abs(forces[0]).max())


def test_a_mesh_that_springs_refuse() -> None:
    mesh = SquareSail(layout="fan").mesh()
    laws: list[Law] = [Triangles(), SpringDamping()]
    refused(lambda: Simulation(Scene(mesh, FILM, [Springs(), SpringDamping()])), MeshError, "negative")
    sim = Simulation(Scene(mesh, FILM, laws))
    sim.velocities = np.random.default_rng(1).normal(size=(sim.node_count, 3))
    assert np.sum(sim.forces("spring_damping") * sim.velocities) < 0
    kinds = {finding.kind for finding in mesh.audit(FILM, springs=False).findings}
    assert "negative_springs" not in kinds
    assert "negative_springs" in {finding.kind for finding in mesh.audit(FILM).findings}
    refused(
        lambda: Scene(mesh, FILM, [Springs(), Triangles()]), SceneError, "laws.springs and laws.triangles: each is the"
    )


def test_edges_across_the_wrinkles_count_as_buckled() -> None:
    mesh = Strip(1.0, 1.0, 2, 2).mesh()
    sim = strained(mesh, TENSION_ONLY, [[1.01, 0.0], [0.0, 0.98]])
    along = np.abs(mesh.reference[mesh.edges[:, 1]] - mesh.reference[mesh.edges[:, 0]])
    assert (sim.buckled() == (along[:, 1] > 0)).all()
    assert sim.spring_strains()[along[:, 1] == 0] == pytest.approx(0.01)
    assert not strained(mesh, TENSION_ONLY, [[1.01, 0.0], [0.0, 1.0]]).buckled().any()
    springs = Simulation(Scene(mesh, RUBBER, [Springs()]))
    assert (springs.film_states() == -1).all()


def test_a_falling_film_keeps_its_energy_balance() -> None:
    scene = hanging_strip()
    scene = replace(scene, laws=[TENSION_ONLY, *scene.laws[1:]])
    sim = Simulation(scene)
    sim.run(until=0.05)
    assert (sim.film_states() > 0).any()
    assert abs(sim.ledger()["error"]) < 1e-3
    assert sim.ledger()["work_by_law"]["spring_damping"] < 0


def test_the_measured_step_limit_is_the_predicted_one() -> None:
    # So near the limit RK4 takes most of what white noise holds.
    scene = replace(hanging_strip(), laws=[PLATE], run=RunSettings(energy_loss=2.0))
    limit = Simulation(scene).stable_dt()
    kick = 1e-9 * np.random.default_rng(1).normal(size=(scene.assemble().node_count, 3))
    kick[:, 2] = 0.0
    growth = []
    for share in (0.99, 1.01):
        sim = Simulation(scene, dt=share * limit)
        sim.positions = sim.positions + kick
        before = sim.energies()["triangles"]
        with np.errstate(all="ignore"):
            try:
                sim.step(3000)
                growth.append(sim.energies()["triangles"] / before)
            except UnstableError:
                growth.append(math.inf)
    assert growth[0] < 3
    assert growth[1] > 10


def test_a_triangle_over_its_bound_stops_the_run() -> None:
    scene = hanging_strip()
    scene = replace(scene, laws=[Triangles(strain_limit=1e-4), *scene.laws[1:]])
    with pytest.raises(UnstableError, match=r"triangle is stretched by .* %, over its bound of 0\.010 %") as caught:
        Simulation(scene).run(until=0.2)
    assert caught.value.law == "triangles"


def test_a_collapsed_triangle_stays_finite() -> None:
    for law in (PLATE, Triangles(), TENSION_ONLY):
        sim = Simulation(Scene(ragged(3), RUBBER, [law, SpringDamping()]))
        for squeeze in ([1, 0, 1], [0, 0, 0]):
            sim.positions = sim.positions * squeeze
            assert np.isfinite(sim.forces()).all()
            assert np.isfinite(list(sim.energies().values())).all()
