"""Nets of springs against the film they stand for: in-plane moduli of regular lattices, from forces and
energies.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from membrane_rs import Material, Mesh, Scene, Simulation, Springs
from membrane_rs.folding import EquilateralLattice, Strip
from small_scenes import UNBUCKLED, Floats, rotation, turned

STRAIN = 1e-6
"""Small enough that what is not linear, some STRAIN in all, lies below the tolerance of 1e-5; rounding adds
1e-10.
"""


def film(nu: float) -> Material:
    return Material(3.2e9, nu, 1420.0, 1e-5)


def moduli(mesh: Mesh, material: Material) -> Floats:
    """In-plane stiffness (3, 3) over E h for strains 11, 22, 2 x 12, from the forces at a uniform strain.

    The mean stress of a body is that of the forces on it, S = -(1/A) sum f x. A uniform strain moves the
    nodes of these lattices as it moves the whole, for each is a centre of symmetry.
    """
    sim = Simulation(Scene(mesh, material, [UNBUCKLED]))
    area = float(mesh.areas().sum())
    scale = material.youngs_modulus * material.thickness * area * STRAIN
    columns = []
    for strain in ([[1, 0], [0, 0]], [[0, 0], [0, 1]], [[0, 0.5], [0.5, 0]]):
        gradient = np.eye(3)
        gradient[:2, :2] += STRAIN * np.array(strain)
        sim.positions = mesh.reference @ gradient
        stress = -(sim.forces().T @ mesh.reference)
        columns.append([stress[0, 0], stress[1, 1], stress[0, 1]])
        # The energy is half of stress times strain: the same numbers by the other way.
        work = 0.5 * STRAIN * np.sum(stress[:2, :2] * np.array(strain))
        assert sim.energies()["springs"] == pytest.approx(work, rel=1e-4)
    result: Floats = np.array(columns).T / scale
    return result


@pytest.mark.parametrize("angle", np.radians([0.0, 7.0, 15.0, 30.0, 41.0, 90.0]).tolist())
def test_an_equilateral_lattice_is_an_isotropic_film_in_any_direction(angle: float) -> None:
    mesh = turned(EquilateralLattice(0.01, 6, 6).mesh(), rotation([0, 0, 1], angle))
    compliance = np.linalg.inv(moduli(mesh, film(1 / 3)))
    assert 1 / compliance[0, 0] == pytest.approx(1.0, rel=1e-5)
    assert -compliance[0, 1] / compliance[0, 0] == pytest.approx(1 / 3, rel=1e-5)
    assert 1 / compliance[2, 2] == pytest.approx(0.375, rel=1e-5)
    assert compliance[0, 2] == pytest.approx(0.0, abs=1e-5)


def isosceles_shares(nu: float) -> tuple[float, float]:
    """Eq. (1) solved by hand for a right isosceles triangle: (A^-1 1) of a leg and of the hypotenuse.

    Legs see each other as 1 - (1 + nu) = -nu, squared; a leg and the hypotenuse as (1 - nu)/2, squared, q.
    """
    q = 0.25 * (1 - nu) ** 2
    leg = (1 - q) / (1 + nu * nu - 2 * q * q)
    return leg, 1 - 2 * q * leg


def alike(size: int) -> Mesh:
    """A square grid with all diagonals in one direction."""
    sheet = Strip(float(size), float(size), size, size).mesh()
    index = np.arange((size + 1) ** 2).reshape(size + 1, -1)
    a, b, c, d = (x.ravel() for x in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    return Mesh(sheet.reference, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def test_alternating_diagonals_keep_the_modulus_along_the_cells_and_half_of_the_shear() -> None:
    leg, hypotenuse = isosceles_shares(0.34)
    # Per unit square: two legs of k = leg E h, one diagonal of k = hypotenuse E h / 2 whose strain is (e11
    # + e22)/2.
    c11, c12 = leg + hypotenuse / 4, hypotenuse / 4
    expected = c11 - c12 * c12 / c11
    found = moduli(Strip(4.0, 4.0, 4, 4).mesh(), film(0.34))
    assert np.abs(found - found.T).max() < 1e-5
    compliance = np.linalg.inv(found)
    assert 1 / compliance[0, 0] == pytest.approx(expected, rel=1e-5)
    assert 1 / compliance[0, 0] == pytest.approx(0.98, abs=0.005)
    # Across the cells' corners, and in shear, relative to the film's 1/(2 (1 + nu)): soft by nearly half.
    assert 4 / compliance.sum() == pytest.approx(0.616, abs=0.001)
    assert 2 * 1.34 / compliance[2, 2] == pytest.approx(0.551, abs=0.001)
    assert np.abs(compliance[2, :2]).max() < 1e-5  # no coupling of stretch and shear


def test_like_diagonals_are_softer_and_couple_shear() -> None:
    leg, hypotenuse = isosceles_shares(0.34)
    diagonal = hypotenuse / 4 * np.ones((3, 3))  # strain (e11 + e22 + 2 e12)/2 on every diagonal
    expected = np.linalg.inv(np.diag([leg, leg, 0.0]) + diagonal)
    compliance = np.linalg.inv(moduli(alike(4), film(0.34)))
    assert compliance == pytest.approx(expected, rel=1e-4, abs=1e-5)
    assert 1 / compliance[0, 0] == pytest.approx(0.82, abs=0.005)
    assert abs(compliance[0, 2]) > 0.1


def test_buckled_springs_push_no_harder_than_their_critical_strain() -> None:
    # Compressed to half, each spring pushes with alpha times Euler's strain, pi^2 h^2/(12 L^2).
    mesh = EquilateralLattice(0.01, 1, 1).mesh()
    material = film(1 / 3)
    sim = Simulation(Scene(mesh, material, [Springs(buckling=100.0)]))
    sim.positions = 0.5 * mesh.reference
    critical = 100.0 * math.pi**2 * material.thickness**2 / (12 * 0.01**2)
    push = mesh.spring_constants(material) * 0.01 * critical
    assert sim.buckled().all()
    force = sim.forces("springs")
    d = sim.positions[mesh.edges[:, 1]] - sim.positions[mesh.edges[:, 0]]
    expected = np.zeros_like(force)
    along = push[:, None] * d / np.linalg.norm(d, axis=1)[:, None]
    np.add.at(expected, mesh.edges[:, 1], along)
    np.add.at(expected, mesh.edges[:, 0], -along)
    assert force == pytest.approx(expected, rel=1e-9, abs=1e-12)
