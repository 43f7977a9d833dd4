"""Stress, tension, and the load on the hub, against known answers and the laws' own forces."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    Fixed,
    Material,
    Mesh,
    Scene,
    Simulation,
    Spin,
    SpoolContact,
    SpringDamping,
    Springs,
    Tether,
    Triangles,
)
from membrane_rs.folding import EquilateralLattice, Strip
from membrane_rs.results import peak_stress
from membrane_rs.scene.laws import Law
from small_scenes import RUBBER, UNBUCKLED, Floats, hanging_strip, rotation

FILM = Material(1e6, 0.3, 1000.0, 1e-4)
UNWRINKLED = [Triangles(compression=1.0), Triangles(buckling=5e4, buckling_on_creases=5e4)]


def strained(law: Law, gradient: Any, material: Material = FILM, mesh: Any = None) -> Simulation:
    mesh = Strip(0.1, 0.1, 4, 4).mesh() if mesh is None else mesh
    sim = Simulation(Scene(mesh, material, [law]))
    sim.positions = mesh.reference @ np.asarray(gradient).T
    return sim


def hooke(larger: float, smaller: float, material: Material = FILM) -> tuple[float, float]:
    """Principal stresses of two principal engineering strains, with Green's strain [Pa]."""
    e1, e2 = ((1.0 + strain) ** 2 / 2.0 - 0.5 for strain in (larger, smaller))
    nu, factor = material.poisson_ratio, material.youngs_modulus / (1.0 - material.poisson_ratio**2)
    return factor * (e1 + nu * e2), factor * (e2 + nu * e1)


@pytest.mark.parametrize("law", UNWRINKLED, ids=["a plate", "a stiff film"])
@pytest.mark.parametrize("strains", [(0.001, -0.001), (0.001, 0.0), (0.0005, -0.004), (-0.001, -0.002)])
def test_a_film_that_does_not_wrinkle_has_hookes_stress_and_is_taut(law: Law, strains: tuple[float, float]) -> None:
    sim = strained(law, np.diag([1.0 + strains[0], 1.0 + strains[1], 1.0]))
    expected = hooke(*strains)
    stress = sim.film_stress()
    assert stress.principal == pytest.approx(np.tile(expected, (len(stress.principal), 1)), rel=1e-9)
    assert stress.von_mises == pytest.approx(math.sqrt(expected[0] ** 2 - math.prod(expected) + expected[1] ** 2))
    assert peak_stress(sim) == sim.largest_film_stress() == pytest.approx(max(expected[0], 0.0), rel=1e-9)
    assert (sim.film_states() == 0).all()
    assert not sim.buckled().any()


def test_a_wrinkled_film_bears_uniaxial_tension_and_a_share_of_compression() -> None:
    def law(compression: float) -> Triangles:
        return Triangles(compression=compression, buckling=0.0, buckling_on_creases=0.0)

    gradient = np.diag([1.001, 0.99, 1.0])
    uniaxial = FILM.youngs_modulus * (1.001**2 - 1.0) / 2.0
    free, plate = strained(law(0.0), gradient), hooke(0.001, -0.01)
    assert free.film_stress().principal == pytest.approx(np.tile([uniaxial, 0.0], (32, 1)), abs=1e-9 * uniaxial)
    assert (free.film_states() == 1).all()
    mixed = strained(law(0.25), gradient).film_stress().principal
    expected = np.sort([0.75 * uniaxial + 0.25 * plate[0], 0.25 * plate[1]])[::-1]
    assert mixed == pytest.approx(np.tile(expected, (32, 1)), rel=1e-9)


@pytest.mark.parametrize("law", [UNBUCKLED, *UNWRINKLED], ids=["springs", "a plate", "a stiff film"])
def test_a_film_on_an_equilateral_lattice_has_the_same_stress_by_every_law(law: Law) -> None:
    mesh = EquilateralLattice(0.01, columns=5, rows=4).mesh()
    gradient = np.array([[1.0002, 1e-4, 0.0], [1e-4, 0.9999, 0.0], [0.0, 0.0, 1.0]])
    turn = rotation([1.0, 2.0, 3.0], 0.7)
    sim, plate = (strained(own, turn @ gradient, RUBBER, mesh) for own in (law, Triangles(compression=1.0)))
    found, expected = sim.film_stress(), plate.film_stress()
    assert found.principal == pytest.approx(expected.principal, rel=1e-3)
    axes = np.linalg.eigh(gradient[:2, :2])[1][:, ::-1]
    for k in range(2):
        along = np.abs(found.directions[:, k] @ (turn[:, :2] @ axes[:, k]))
        assert along == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("material", [FILM, Material(3.2e9, 0.34, 1420.0, 7.5e-6)], ids=["soft", "film"])
def test_the_stress_of_springs_does_the_work_of_their_forces(material: Material) -> None:
    mesh = Strip(0.1, 0.07, 5, 3).mesh()
    sim = strained(Springs(buckling=1.0), np.eye(3), material, mesh)
    rng = np.random.default_rng(1)
    sim.positions = mesh.reference * 1.001 + 1e-5 * rng.normal(size=mesh.reference.shape)
    stress, positions = sim.film_stress(), sim.positions
    # The virial: sum of S : F^T dF over the triangles is the work of the forces on a uniform strain, of each in turn.
    sides = mesh.reference[mesh.triangles[:, 1:]] - mesh.reference[mesh.triangles[:, :1]]
    areas = np.abs(np.linalg.det(sides[:, :, :2])) / 2.0
    volume = areas * material.thickness
    virial = np.einsum("m,mk,mki,mkj->ij", volume, stress.principal, stress.directions, stress.directions)
    of_forces = -np.einsum("ni,nj->ij", sim.forces("springs"), positions)
    assert virial == pytest.approx(of_forces, abs=5e-3 * np.abs(of_forces).max())


def test_the_peak_stress_of_springs_is_that_of_the_film_they_stand_for() -> None:
    for strains in ((0.001, 0.001), (0.001, 0.0)):
        sim = strained(UNBUCKLED, np.diag([1.0 + strains[0], 1.0 + strains[1], 1.0]))
        assert peak_stress(sim) == pytest.approx(hooke(*strains)[0], rel=1e-9)
        stress = sim.film_stress().principal
        assert sim.largest_film_stress() == stress.max()
        # Their own stress is another, as the documentation of both says.
        assert 0.01 < abs(stress.max() / peak_stress(sim) - 1.0) < 0.2


@pytest.mark.parametrize("scale", [1.2, 0.99, 0.6])
@pytest.mark.parametrize("negative", ["keep", "clip"])
def test_the_stress_of_springs_is_the_work_of_a_uniform_stretch_of_any_size(scale: float, negative: Any) -> None:
    # An obtuse triangle has a negative spring, kept or clipped, unless another one shares that side. F = scale 1, so
    # that f . x = -V tr(S F^T F).
    points = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.05, 0.02, 0.0], [0.05, -0.08, 0.0]]
    for mesh in (Mesh(points[:3], [[0, 1, 2]]), Mesh(points, [[0, 1, 2], [0, 3, 1]])):
        sim = strained(Springs(buckling=1e3, negative=negative), scale * np.eye(3), FILM, mesh)
        volume = mesh.areas() * FILM.thickness
        work = scale**2 * float(volume @ sim.film_stress().principal.sum(axis=1))
        assert work == pytest.approx(-float((sim.forces("springs") * sim.positions).sum()), rel=1e-9)


def test_springs_that_buckle_press_with_their_critical_force_alone() -> None:
    sim = strained(Springs(buckling=0.0, buckling_on_creases=0.0), 0.9 * np.eye(3))
    assert (sim.film_stress().principal == 0.0).all()
    assert peak_stress(sim) == sim.largest_film_stress() == 0.0
    assert sim.buckled().all()
    clipped = strained(Springs(negative="clip"), 1.001 * np.eye(3))
    assert np.isfinite(clipped.film_stress().principal).all()


def test_without_a_law_of_the_film_there_is_no_stress() -> None:
    sim = Simulation(Scene(Strip(0.1, 0.1, 1, 1).mesh(), FILM, []), dt=1e-3)
    assert np.isnan(sim.film_stress().principal).all()
    assert np.isnan(sim.film_stress().von_mises).all()
    assert math.isnan(sim.largest_film_stress())


def spinning_tether(segments: int = 1, **changes: Any) -> Simulation:
    values: dict[str, Any] = {"segments": segments, "axial_stiffness": 60.0, "linear_density": 0.0, "tip_mass": 0.01}
    cord = Tether((0.1, 0.0, 0.0), (0.4, 0.0, 0.0), **(values | changes))
    return Simulation(Scene(None, None, [Spin(2.0), SpringDamping(0.1)], [cord]), integrator="rk4")


def test_a_steady_spinning_tether_pulls_by_its_centrifugal_force() -> None:
    sim = spinning_tether()
    square, stiffness = (4.0 * np.pi) ** 2, 60.0 / 0.3
    radius = 0.4 * stiffness / (stiffness - 0.01 * square)
    sim.positions = np.array([[0.1, 0.0, 0.0], [radius, 0.0, 0.0]])
    tension = 0.01 * square * radius
    assert sim.cord_tensions() == pytest.approx([tension], rel=1e-12)
    assert sim.hub_force() == pytest.approx([tension, 0.0, 0.0], rel=1e-12)
    assert sim.hub_torque() == pytest.approx(np.zeros(3), abs=1e-15)
    sim.positions = np.array([[0.1, 0.0, 0.0], [0.3, 0.0, 0.0]])
    assert sim.cord_tensions() == pytest.approx([0.0])


def momentum(sim: Simulation, omega: float) -> tuple[Floats, Floats]:
    """Momentum and angular momentum in an inertial frame, by the axes of the turning one."""
    x, mass = sim.positions, sim.masses[:, None]
    velocity = sim.velocities + np.cross([0.0, 0.0, omega], x)
    return (mass * velocity).sum(axis=0), np.cross(x, mass * velocity).sum(axis=0)


@pytest.mark.parametrize("spool", [None, 0.12], ids=["free", "round the spool"])
@pytest.mark.parametrize("acceleration", [0.0, 3.0])
def test_the_load_on_the_hub_balances_the_momentum_of_the_sail(spool: float | None, acceleration: float) -> None:
    laws: list[Law] = [Spin(2.0, acceleration), SpringDamping(0.1)]
    laws += [SpoolContact(spool, stiffness=500.0)] if spool else []
    cords = [Tether((0.1, 0.0, 0.0), (0.125, 0.3, 0.05), 6, 60.0, 0.01, tip_mass=0.02)]
    sim = Simulation(Scene(None, None, laws, cords), integrator="rk4", dt=1e-5)
    speeds = sim.velocities.copy()
    speeds[1:] += np.random.default_rng(2).normal(size=speeds[1:].shape) * 0.5 + [-0.5, 0.0, 0.0]
    sim.velocities = speeds
    touched = 0.0
    for _ in range(40):
        sim.step(200)
        states = []
        for _ in range(3):
            omega = 2.0 * np.pi * (2.0 + acceleration * sim.time)
            states.append((*momentum(sim, omega), sim.hub_load(), omega))
            sim.step(1)
        (before, spin_before, *_), (now, spin_now, load, omega), (after, spin_after, *_) = states
        touched = max(touched, load.contact)
        # Rates in an inertial frame: those of the components, and of the axes.
        turning = [0.0, 0.0, omega]
        force = -((after - before) / (2.0 * sim.dt) + np.cross(turning, now))
        torque = -((spin_after - spin_before) / (2.0 * sim.dt) + np.cross(turning, spin_now))
        # A slack cord has no force: there the differences of the momentum leave their own error.
        assert load.force == pytest.approx(force, abs=2e-3 * np.abs(force).max() + 1e-8)
        assert load.torque == pytest.approx(torque, abs=2e-3 * np.abs(torque).max() + 1e-8)
        assert sim.hub_force().shape == sim.hub_torque().shape == (3,)
    assert (touched > 0.01) == bool(spool)


def test_the_load_of_a_hanging_strip_at_rest_is_its_weight() -> None:
    sim = Simulation(hanging_strip())
    sim.relax(0.5, 20.0)
    weight = 9.81 * sim.masses.sum()
    assert sim.hub_force() == pytest.approx([0.0, 0.0, -weight], abs=0.02 * weight)


def test_contact_forces_are_those_of_the_law_and_press_on_the_hub() -> None:
    cord = Tether((0.1, 0.0, 0.0), (0.05, 0.08, 0.0), 2, 60.0, 0.01, tip_mass=0.02)
    sim = Simulation(Scene(None, None, [SpoolContact(0.1, 300.0)], [cord, Fixed([0])]))
    forces = sim.contact_forces()
    depth = 0.1 - np.hypot(*sim.positions[:, :2].T)
    size = np.where(depth > 1e-12, 300.0 * depth, 0.0)
    assert np.linalg.norm(forces, axis=1) == pytest.approx(size)
    assert (forces == sim.forces("spool_contact")).all()
    assert sim.hub_load().contact == pytest.approx(size.sum())
    assert (Simulation(hanging_strip()).contact_forces() == 0.0).all()


def test_readings_change_no_bit_of_the_motion() -> None:
    seen, whole = spinning_tether(4, linear_density=0.01), spinning_tether(4, linear_density=0.01)
    for _ in range(20):
        seen.step(5)
        for reading in (seen.hub_load, seen.contact_forces, seen.film_stress, seen.cord_tensions):
            reading()
    whole.step(100)
    assert (seen.positions == whole.positions).all()
