"""Bending of the film: beams and plates with closed forms, what has no stiffness, and what is said of it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from bending_cases import (
    Form,
    clamped_square,
    elastica,
    exact_elastica,
    narrow_strip,
    order,
    plate_stiffness,
    sheet,
    supported_disc,
    supported_square,
    turned_cantilever,
)
from membrane_rs import Bending, Fixed, InputError, Mesh, Scene, Simulation, Springs, scenes
from membrane_rs.check import audit
from membrane_rs.check.redundancy import idle_laws
from membrane_rs.folding import Disc, Strip
from small_scenes import FILM, RUBBER, UNBUCKLED, refused, rotation

FORMS: tuple[Form, ...] = ("hinges", "curvature")
NU = 1 / 3


def test_the_elastica_by_hinges_converges_to_second_order() -> None:
    for load in (1.0, 10.0):
        exact = exact_elastica(load)
        found = [elastica("hinges", cells, load) for cells in (10, 20)]
        across = [each.across - exact.across for each in found]
        along = [each.along - exact.along for each in found]
        assert max(abs(across[-1]), abs(along[-1])) < 6e-4
        assert order(across) == pytest.approx(2.0, abs=0.2)
        assert order(along) == pytest.approx(2.0, abs=0.2)


def test_the_exact_elastica_is_that_of_the_tables() -> None:
    assert (exact_elastica(1.0).across, exact_elastica(1.0).along) == pytest.approx((0.30172, 0.05643), abs=1e-5)
    assert (exact_elastica(10.0).across, exact_elastica(10.0).along) == pytest.approx((0.81061, 0.55500), abs=1e-5)


def test_a_narrow_strip_bends_with_its_own_stiffness() -> None:
    # 8/9 of D by the hinges: that of the film, 1 - nu^2, at nu = 1/3. By triangles 1 - nu^2/(3 - 2 nu).
    errors = [narrow_strip("hinges", cells, NU) - 1.0 for cells in (8, 16)]
    assert abs(errors[-1]) < 3e-3
    assert order(errors) == pytest.approx(2.0, abs=0.2)
    for nu in (0.0, NU, 0.45):
        known = math.sqrt((1.0 - nu**2 / (3.0 - 2.0 * nu)) / (1.0 - nu**2))
        assert narrow_strip("curvature", 16, nu) == pytest.approx(known, abs=5e-3)


@pytest.mark.parametrize("angle", [2.0, 4.0])
def test_a_lattice_a_little_askew_bends_as_a_straight_one(angle: float) -> None:
    """Where `check` does not warn of hinges, their constants are those of right triangles."""
    strip = Strip(0.1, 0.1, 8, 8).mesh()
    energies = []
    for skew in (0.0, math.tan(math.radians(angle))):
        flat = strip.reference @ np.array([[1.0, 0.0, 0.0], [skew, 1.0, 0.0], [0.0, 0.0, 1.0]])
        sim = Simulation(Scene(Mesh(flat, strip.triangles), RUBBER, [UNBUCKLED, Bending()]))
        x, y, _ = flat.T
        sim.positions = np.stack([0.2 * np.sin(x / 0.2), y, 0.2 * (1.0 - np.cos(x / 0.2))], axis=1)
        energies.append(sim.energies()["bending"])
    assert energies[1] == pytest.approx(energies[0], rel=0.05)


@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3])
def test_a_square_on_simple_supports_converges_to_second_order(poisson_ratio: float) -> None:
    errors = [supported_square("hinges", cells, poisson_ratio) - 1.0 for cells in (6, 12)]
    assert abs(errors[-1]) < 0.01
    assert order(errors) == pytest.approx(2.0, abs=0.2)


def test_a_clamped_square_is_within_a_hundredth() -> None:
    assert clamped_square("hinges", 12, NU) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("form", FORMS)
def test_a_drum_without_tension_has_its_note(form: Form) -> None:
    coarse, fine = (supported_disc(form, rings, 0.3) - 1.0 for rings in (4, 8))
    assert abs(fine) < 4e-3
    assert abs(fine) < abs(coarse)


def test_two_directions_of_one_lattice_agree() -> None:
    along, across = (turned_cantilever("hinges", 12, angle) for angle in (0.0, 45.0))
    assert across == pytest.approx(along, rel=0.02)


@pytest.mark.parametrize("form", FORMS)
def test_a_flat_film_and_a_rigid_motion_have_no_force(form: Form) -> None:
    mesh = Disc(0.1, 5).mesh()
    sim = Simulation(Scene(mesh, sheet(0.3), [UNBUCKLED, Bending(form=form)]))
    assert np.abs(sim.forces("bending")).max() < 1e-18
    sim.positions = mesh.reference @ rotation([1.0, 2.0, 0.5], 2.0).T + [0.3, -0.2, 0.1]
    assert np.abs(sim.forces("bending")).max() < 1e-18
    assert sim.energies()["bending"] < 1e-30


def folded(angle: float, **extra: object) -> Simulation:
    """A strip that is folded across its middle."""
    strip = Strip(0.1, 0.02, columns=10, rows=2, creases=(0.5,), fold_angle=angle).mesh()
    mesh = Mesh(strip.reference, strip.triangles, positions=strip.positions)
    return Simulation(Scene(mesh, RUBBER, [Springs(), Bending(**extra)]))  # type: ignore[arg-type]


def test_edges_that_are_folded_at_the_start_have_no_stiffness() -> None:
    assert folded(1.9).energies()["bending"] > 0.0
    assert folded(2.1).energies()["bending"] < 1e-30
    assert folded(2.1, fold_limit=math.pi).energies()["bending"] > 0.0


@pytest.mark.parametrize("form", FORMS)
def test_a_fold_has_the_energy_of_its_hinges(form: Form) -> None:
    # Two squares across: k = 4/3 D of each hinge; by triangles kappa = phi/c in four of area c^2/2.
    angle, stiffness = 0.5, plate_stiffness(RUBBER)
    known = {"hinges": 2 * 4 / 3 * stiffness * angle**2 / 2, "curvature": 4 * stiffness * angle**2 / 4}
    assert folded(angle, form=form).energies()["bending"] == pytest.approx(known[form], rel=1e-9)


@pytest.mark.parametrize("form", FORMS)
def test_creases_are_left_to_their_law(form: Form) -> None:
    mesh = Strip(0.1, 0.02, columns=10, rows=2, creases=(0.5,), fold_angle=0.5).mesh()
    assert Simulation(Scene(mesh, RUBBER, [Springs(), Bending(form=form)])).energies()["bending"] < 1e-30


@pytest.mark.parametrize("form", FORMS)
def test_energy_goes_on_where_a_hinge_is_shut_from_either_side(form: Form) -> None:
    energies = []
    for angle in (math.pi - 1e-6, -math.pi + 1e-6):
        sim = folded(0.0, form=form)
        sim.positions = Strip(0.1, 0.02, columns=10, rows=2, creases=(0.5,), fold_angle=angle).mesh().positions
        energies.append(sim.energies()["bending"])
    assert energies[1] == pytest.approx(energies[0], rel=1e-9)


@pytest.mark.parametrize("form", FORMS)
def test_energy_goes_on_at_a_shut_edge_beside_one_that_is_bent(form: Form) -> None:
    side, height = 0.1, 0.05 * math.sqrt(3.0)
    points = np.array([[0.0, 0.0], [side, 0.0], [side / 2, height], [side / 2, -height], [1.5 * side, height]])
    points = np.column_stack([points, np.zeros(5)])
    sim = Simulation(Scene(Mesh(points, [[0, 1, 2], [1, 0, 3], [2, 1, 4]]), RUBBER, [UNBUCKLED, Bending(form=form)]))
    axis = points[2] - points[1]
    energies = []
    for angle in (math.pi - 1e-6, math.pi + 1e-6):
        moved = points.copy()
        moved[3] = rotation([1.0, 0.0, 0.0], angle) @ points[3]
        moved[4] = points[1] + rotation(axis.tolist(), 1.0) @ (points[4] - points[1])
        sim.positions = moved
        energies.append(sim.energies()["bending"])
    assert energies[1] == pytest.approx(energies[0], rel=1e-5)


def test_a_softened_film_bends_as_before() -> None:
    scene = scenes.load("okuizumi-model-1")
    assert Bending().with_softened_film(10.0) == Bending(stiffness=10.0)
    soft = scene.with_values({"material.softening": 10.0, "laws.bending.stiffness": 1.0})
    stiff = scene.with_values({"laws.bending.stiffness": 1.0})
    energies = [Simulation(each).energies()["bending"] for each in (soft, stiff)]
    assert energies[0] == pytest.approx(energies[1], rel=1e-12)


def test_what_is_wrong_is_said() -> None:
    refused(lambda: Bending(form="plates"), InputError, "form")  # type: ignore[arg-type]
    refused(lambda: Bending(stiffness=-1.0), InputError, "stiffness")
    refused(lambda: Bending(fold_limit=4.0), InputError, "fold_limit")
    refused(lambda: Bending(collapse=2.0), InputError, "collapse")
    mesh = Strip(0.1, 0.1, 4, 4).mesh()
    assert any("stiffness is 0" in text for text in map(str, idle_laws(Scene(mesh, FILM, [Bending(stiffness=0.0)]))))


def found_in(mesh: Mesh, *laws: object) -> str:
    """What the audit says of a film that bends."""
    return str(audit(Scene(mesh, FILM, list(laws), [Fixed(nodes=[0, 1, 2])]), costly=False))  # type: ignore[arg-type]


def test_a_form_that_does_not_suit_the_mesh_is_named() -> None:
    plate = Springs(buckling=1.0, buckling_on_creases=1.0)
    squares, discs = Strip(0.1, 0.1, 8, 8).mesh(), Disc(0.1, 6).mesh()
    skewed = Mesh(squares.reference @ np.array([[1.0, 0.0, 0.0], [0.4, 0.9, 0.0], [0.0, 0.0, 1.0]]), squares.triangles)
    alike = [[i, i + 1, i + 10, i + 9] for i in range(9 * 8) if i % 9 < 8]
    diagonals = Mesh(squares.reference, [row for a, b, c, d in alike for row in ([a, b, c], [a, c, d])])
    for mesh, form, words in (
        (squares, "hinges", None), (discs, "hinges", None), (discs, "curvature", None),
        (squares, "curvature", 'form = "hinges"'), (skewed, "hinges", 'form = "curvature"'),
        (diagonals, "hinges", "alternat"),
    ):  # fmt: skip
        text = found_in(mesh, plate, Bending(form=form))  # type: ignore[arg-type]
        assert ("bending" in text) == (words is not None), (form, text)
        assert words is None or words in text


def test_a_film_that_buckles_twice_is_warned_of() -> None:
    squares = Strip(0.1, 0.1, 8, 8).mesh()
    assert "laws.springs.buckling = 100" in found_in(squares, Springs(), Bending())
