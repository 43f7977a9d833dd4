"""Films of two moduli: against Hooke's law of one, closed forms in any direction, energy, refusals."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import Bending, Fixed, Material, Mesh, Region, Scene, Simulation, SpringDamping, Springs, Triangles
from membrane_rs.errors import InputError
from membrane_rs.folding import Strip
from numpy.testing import assert_allclose
from small_scenes import forces_are_slopes, refused

FILM = Material(3.2e9, 0.3, 1420.0, 7.5e-6)
FIBRES = replace(FILM, youngs_modulus_across=0.8e9, shear_modulus=0.5e9, direction=0.4)
PLATE = Triangles(1.0)


def irregular() -> Mesh:
    """A flat rectangle whose inner nodes are displaced in its plane."""
    mesh = Strip(0.12, 0.06, 8, 4).mesh()
    points = np.array(mesh.reference)
    inner = np.setdiff1d(np.arange(len(points)), np.unique(mesh.boundary_edges))
    points[inner, :2] += 0.003 * np.random.default_rng(5).uniform(-1.0, 1.0, (len(inner), 2))
    return Mesh(points, mesh.triangles)


def crumpled(size: float = 2e-4) -> Mesh:
    mesh = irregular()
    moved = mesh.reference + np.random.default_rng(3).normal(0.0, size, mesh.reference.shape)
    return Mesh(mesh.reference, mesh.triangles, positions=moved)


def simulation(mesh: Mesh, material: Material, *laws: Any) -> Simulation:
    return Simulation(Scene(mesh, material, [PLATE, *laws], [Fixed([0])]))


def test_equal_moduli_are_an_isotropic_film() -> None:
    mesh, laws = crumpled(), (Bending("curvature"), SpringDamping(0.1))
    equal = replace(FILM, youngs_modulus_across=3.2e9, shear_modulus=3.2e9 / 2.6, direction=0.7)
    one, two = (simulation(mesh, material, *laws) for material in (FILM, equal))
    velocities = np.random.default_rng(1).normal(0.0, 0.1, mesh.reference.shape)
    for kind in ("triangles", "bending", "spring_damping"):
        one.velocities = two.velocities = velocities
        assert_allclose(two.forces(kind), one.forces(kind), atol=1e-12 * np.abs(one.forces(kind)).max())
    assert_allclose(two.film_stress().principal, one.film_stress().principal, rtol=1e-9, atol=1.0)
    assert two.stable_dt() == pytest.approx(one.stable_dt(), rel=1e-6)


@pytest.mark.parametrize("angle", [0.0, 0.5, 1.1, math.pi / 2])
def test_youngs_modulus_in_any_direction(angle: float) -> None:
    """1/E = c^4/E_1 + s^4/E_2 + (1/G - 2 nu/E_1) s^2 c^2 at an angle to the fibres."""
    mesh, stress = irregular(), 1e4
    e1, e2, g, nu = 3.2e9, 0.8e9, 0.5e9, 0.3
    cosine, sine = math.cos(angle), math.sin(angle)
    s1, s2, s12 = stress * cosine**2, stress * sine**2, stress * sine * cosine
    strain = np.array([[(s1 - nu * s2) / e1, s12 / (2.0 * g)], [s12 / (2.0 * g), s2 / e2 - nu * s1 / e1]])
    turn = np.array([[math.cos(0.4), -math.sin(0.4)], [math.sin(0.4), math.cos(0.4)]])
    positions = np.array(mesh.reference)
    positions[:, :2] += positions[:, :2] @ (turn @ strain @ turn.T)
    sim = simulation(Mesh(mesh.reference, mesh.triangles, positions=positions), FIBRES)
    assert_allclose(sim.film_stress().principal[:, 0], stress, rtol=1e-4)
    assert_allclose(sim.film_stress().principal[:, 1], 0.0, atol=1e-4 * stress)
    along = np.array([math.cos(0.4 + angle), math.sin(0.4 + angle)])
    measured = stress / float(along @ turn @ strain @ turn.T @ along)
    expected = 1.0 / (cosine**4 / e1 + sine**4 / e2 + (1.0 / g - 2.0 * nu / e1) * sine**2 * cosine**2)
    assert measured == pytest.approx(expected, rel=1e-12)
    volume = 7.5e-6 * float(mesh.areas().sum())
    assert sim.energies()["triangles"] == pytest.approx(0.5 * stress**2 / expected * volume, rel=1e-4)


@pytest.mark.parametrize("angle", [0.0, 0.7, math.pi / 2])
def test_bending_stiffness_in_any_direction(angle: float) -> None:
    """A cylinder stores h^3/24 n n : C : n n of its curvature squared: here on a lattice that has it exactly."""
    mesh = Strip(0.12, 0.12, 12, 12).mesh()
    bent = np.array(mesh.reference)
    bent[:, 2] = 0.5 * 0.01 * mesh.reference[:, 0] ** 2
    fibres = replace(FIBRES, direction=angle)
    sim = simulation(Mesh(mesh.reference, mesh.triangles, positions=bent), fibres, Bending("curvature"))
    isotropic = simulation(Mesh(mesh.reference, mesh.triangles, positions=bent), FILM, Bending("curvature"))
    cosine, sine = math.cos(angle), math.sin(angle)
    q = 1.0 / (1.0 - 0.09 * 0.25)
    c = cosine**4 * q + sine**4 * 0.25 * q + sine**2 * cosine**2 * (2.0 * 0.3 * 0.25 * q + 4.0 * 0.5 / 3.2)
    ratio = c * (1.0 - 0.09)
    assert sim.energies()["bending"] / isotropic.energies()["bending"] == pytest.approx(ratio, rel=2e-3)


def test_forces_are_the_slope_of_the_energy() -> None:
    mesh = crumpled()
    region = Region("all", thickness=12e-6, natural_strain=(0.01, -0.01), direction=0.2)
    sim = Simulation(Scene(mesh, FIBRES, [PLATE, Bending("curvature")], [Fixed([0]), region]))
    forces_are_slopes(sim, ("triangles", "bending"), 1e-4)


@pytest.mark.parametrize("method", ["rk4", "leapfrog", "generalized_alpha"])
def test_a_softened_film_keeps_its_moments_and_runs(method: str) -> None:
    mesh = crumpled(1e-5)
    laws = [PLATE, Bending("curvature"), SpringDamping()]
    plain, soft = (
        Simulation(Scene(mesh, replace(FIBRES, softening=factor), laws, [Fixed([0])]), method, 2e-7)
        for factor in (None, 8.0)
    )
    assert_allclose(soft.forces("bending"), plain.forces("bending"), atol=1e-12 * np.abs(plain.forces("bending")).max())
    assert_allclose(soft.forces("triangles"), plain.forces("triangles") / 8.0, rtol=1e-9, atol=1e-15)
    plain.step(20)
    assert abs(plain.ledger()["error"]) < 1e-3


def test_scene_files_hold_both_moduli(tmp_path: Path) -> None:
    irregular().save(tmp_path / "mesh.npz")
    (tmp_path / "scene.toml").write_text(
        '[mesh]\nfile = "mesh.npz"\n[material]\nyoungs_modulus = "3.2 GPa"\npoisson_ratio = 0.3\ndensity = 1420\n'
        'thickness = "7.5 um"\nyoungs_modulus_across = "0.8 GPa"\nshear_modulus = "500 MPa"\ndirection = 0.4\n'
        '[laws.triangles]\ncompression = 1.0\n[[parts]]\nkind = "fixed"\nnodes = [0]\n'
    )
    assert Scene.from_toml(tmp_path / "scene.toml").material == FIBRES


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: replace(FILM, shear_modulus=1e9), "Material.shear_modulus = 1e.09: needs youngs_modulus_across"),
        (lambda: replace(FILM, youngs_modulus_across=1e9), "youngs_modulus_across = 1e.09: needs shear_modulus"),
        (lambda: replace(FILM, direction=1.0), "Material.direction = 1: is that of a film of two moduli"),
        (lambda: replace(FIBRES, youngs_modulus_across=4e10), "must be below youngs_modulus/poisson_ratio"),
        (lambda: replace(FIBRES, shear_modulus=-1.0), "must be greater than 0"),
        (lambda: Simulation(Scene(irregular(), FIBRES, [Springs()], [Fixed([0])])), "springs represent a film of one"),
        (lambda: Simulation(Scene(irregular(), FIBRES, [Triangles()], [Fixed([0])])), "compression of the triangles"),
        (lambda: simulation(irregular(), FIBRES, Bending("hinges")), 'take the form "curvature"'),
    ],
)  # fmt: skip
def test_mistakes_are_named(make: Any, words: str) -> None:
    refused(make, InputError, words)
