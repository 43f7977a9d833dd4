"""Every law of force, from the one list of them, in one scene that holds them all, at random positions."""

from __future__ import annotations

import numpy as np
import pytest
from example_of import example_of
from membrane_rs import (
    AirDrag,
    Bridges,
    Creases,
    Gravity,
    MassDamping,
    Mesh,
    PointForces,
    Pressure,
    Rectangles,
    Scene,
    Simulation,
    SolarPressure,
    Spin,
    SpoolContact,
    SpringDamping,
    Springs,
    Tether,
    Tethers,
    Triangles,
)
from membrane_rs.folding import Strip
from membrane_rs.scene.laws import LAWS, Law
from membrane_rs.scene.parts import Part
from small_scenes import RUBBER, Floats, rotation

FILMS: list[Law] = [
    Springs(buckling=1.0, buckling_on_creases=2.0),
    Triangles(compression=0.1, buckling_on_creases=300.0),
    Rectangles(buckling=1.0, buckling_on_creases=2.0),
]
"""A scene takes one of them."""


def crowd(seed: int, film: Law = FILMS[0], *, contact: float = 100.0) -> Simulation:
    """All laws and all parts with a potential, on a creased sheet of two pieces, crumpled at random."""
    sheet = Strip(0.12, 0.06, 4, 2, creases=(0.25, 0.5), fold_angle=1.0).mesh()
    count = sheet.node_count
    mesh = Mesh(
        np.vstack([sheet.reference, sheet.reference + np.array([0.13, 0.0, 0.0])]),
        np.vstack([sheet.triangles, sheet.triangles + count]),
        creases=np.vstack([sheet.creases, sheet.creases + count]),
        fold_angles=np.concatenate([sheet.fold_angles, -sheet.fold_angles]),
        bridges=np.stack([sheet.node_sets["end"], sheet.node_sets["start"] + count], axis=1),
    )
    chosen: list[Law] = [
        film,
        Creases(stiffness=1e3, contact_penalty=contact, natural_angle=1.0),
        AirDrag(pressure=1e4),
        Spin(frequency=2.0),
        Gravity((1.0, 2.0, -9.0)),
        SpoolContact(radius=0.06, stiffness=50.0, half_height=0.03, membrane=True),
        PointForces((4, 7), (0.1, -0.2, 0.3), "inertial"),
        Pressure(2.0),
        SolarPressure(0.7, 0.1, sun=(0.3, -0.5, 1.2), distance=1e9, back_diffuse=0.3, back_emissivity=0.2),
        MassDamping(rate=3.0),
    ]
    strong = {law.kind: law for law in chosen}
    others = {other.kind for other in FILMS} - {film.kind}
    laws = [
        strong.get(kind) or example_of(law)
        for kind, law in LAWS.items()
        if kind not in others and law.methods is None  # impulses are no force
    ]
    parts: list[Part] = [
        Bridges(stiffness=40.0),
        Tethers(nodes=[0, 2], anchor_radius=0.01, length=0.05, segments=3),
        Tether((0.0, 0.1, 0.0), (0.1, 0.1, 0.0), segments=2, axial_stiffness=5.0, linear_density=1e-3),
    ]
    sim = Simulation(Scene(mesh, RUBBER, laws, parts))
    random = np.random.default_rng(seed)
    sim.positions = sim.positions + random.normal(scale=0.01, size=(sim.node_count, 3))
    return sim


def slopes(sim: Simulation, step: float) -> dict[str, Floats]:
    """-dU/dx of each law with a potential, (N, 3) [N], by differences of fourth order."""
    start = sim.positions
    weights = {1: 8 / 12, -1: -8 / 12, 2: -1 / 12, -2: 1 / 12}
    found = {name: np.zeros_like(start) for name in sim.energies() if name != "kinetic"}
    for place in np.ndindex(*start.shape):
        for offset, weight in weights.items():
            moved = start.copy()
            moved[place] += offset * step
            sim.positions = moved
            for name, energy in sim.energies().items():
                if name != "kinetic":
                    found[name][place] -= weight * energy / step
    sim.positions = start
    return found


def law_names(sim: Simulation) -> list[str]:
    """All laws of the scene and of its parts."""
    return sorted(({law.kind for law in sim.scene.laws} | set(sim.energies())) - {"kinetic"})


@pytest.mark.parametrize("film", FILMS)
def test_each_law_exerts_a_force(film: Law) -> None:
    sim = crowd(0, film)
    sim.velocities = np.random.default_rng(0).normal(size=(sim.node_count, 3))
    for name in law_names(sim):
        assert np.abs(sim.forces(name)).max() > 0, f"{name} exerts no force here; the scene must be crumpled more"


@pytest.mark.parametrize("film", FILMS)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_force_is_minus_the_slope_of_the_energy(seed: int, film: Law) -> None:
    # Differences of fourth order with 1e-6 m on triangles of 30 mm: truncation (1e-6/1e-2)^4, rounding
    # 1e-16/1e-4, in all 1e-10 or so of the largest force; a kink (buckling, slack, contact) within 2e-6 m
    # of a random start is unlikely.
    sim = crowd(seed, film)
    for name, slope in slopes(sim, 1e-6).items():
        force = sim.forces(name)
        assert force == pytest.approx(slope, abs=1e-6 * np.abs(force).max()), name


def test_total_force_is_the_sum_over_the_laws() -> None:
    sim = crowd(4)
    sim.velocities = np.random.default_rng(4).normal(size=(sim.node_count, 3))
    total = sum(sim.forces(name) for name in law_names(sim))
    assert sim.forces() == pytest.approx(total, rel=1e-12, abs=1e-12 * np.abs(total).max())


def is_internal(sim: Simulation, name: str) -> bool:
    """Whether a law leaves no net force and no net torque, within the rounding of some hundred terms."""
    force, size = sim.forces(name), np.abs(sim.forces(name)).sum()
    net, torque = force.sum(axis=0), np.cross(sim.positions, force).sum(axis=0)
    return bool(np.abs(net).max() < 1e-12 * size and np.abs(torque).max() < 1e-12 * size)


@pytest.mark.parametrize("film", FILMS)
def test_internal_laws_turn_with_a_rigid_motion(film: Law) -> None:
    sim = crowd(6, film)
    start = sim.positions
    sim.velocities = np.random.default_rng(6).normal(size=(sim.node_count, 3))
    # Fixed nodes keep no velocity, so take what the simulation made of it.
    velocities, energies = sim.velocities, sim.energies()
    forces = {name: sim.forces(name) for name in law_names(sim) if is_internal(sim, name)}
    assert {film.kind, "creases"} <= set(forces)
    turn = rotation([1.0, -2.0, 0.5], 2.1)
    sim.positions = start @ turn.T + [0.3, -0.1, 0.7]
    sim.velocities = velocities @ turn.T
    for name, force in forces.items():
        # Positions of 1 m carry rounding of 1e-16 m into strains of 1e-16/0.03.
        assert sim.forces(name) == pytest.approx(force @ turn.T, abs=1e-11 * np.abs(force).max()), name
        if name in energies:
            assert sim.energies()[name] == pytest.approx(energies[name], rel=1e-11), name


@pytest.mark.parametrize("film", [Springs(), Triangles(), Rectangles()])
def test_no_force_from_a_rigid_motion_of_the_flat_sheet(film: Law) -> None:
    mesh = Strip(0.12, 0.06, 4, 2, creases=(0.5,)).mesh()
    laws: list[Law] = [film, SpringDamping(), Creases(natural_angle=np.pi)]
    sim = Simulation(Scene(mesh, RUBBER, laws))
    turn = rotation([1.0, 1.0, 0.2], 1.0)
    sim.positions = mesh.reference @ turn.T + [1.0, 2.0, 3.0]
    stiffest = mesh.spring_constants(RUBBER).max() * 0.03
    for name in (film.kind, "creases"):
        # Coordinates of 3 m carry rounding of 4e-16 m: 1e-14 of a strain, or of an angle.
        assert np.abs(sim.forces(name)).max() < 1e-13 * stiffest
    # A rigid rotation changes no length, so no dashpot feels it.
    spin = np.array([3.0, -1.0, 2.0])
    sim.velocities = np.cross(spin, sim.positions) + np.array([5.0, 0.0, -2.0])
    moving = np.abs(sim.forces("spring_damping")).max()
    sim.velocities = sim.positions
    assert moving < 1e-13 * np.abs(sim.forces("spring_damping")).max()


def test_drag_and_friction_only_take_energy() -> None:
    sim = crowd(7)
    sim.velocities = np.random.default_rng(7).normal(size=(sim.node_count, 3))
    v = sim.velocities
    assert np.sum(sim.forces("spring_damping") * v) < 0
    assert sim.forces("mass_damping") == pytest.approx(-3.0 * sim.masses[:, None] * v)
    wind = v + 2 * np.pi * 2.0 * np.cross([0, 0, 1], sim.positions)
    drag = sim.forces("air_drag")
    assert np.abs(np.cross(drag, wind)).max() < 1e-12 * np.abs(drag).max() * np.abs(wind).max()
    assert (np.sum(drag * wind, axis=1) <= 0).all()


def test_drag_of_a_plate_across_the_wind() -> None:
    # D = rho V^2 S/6 on each node of each triangle (eq. 5): rho V^2 S/2 on the whole plate.
    mesh = Strip(0.3, 0.2, 3, 2).mesh()
    sim = Simulation(Scene(mesh, RUBBER, [Springs(), AirDrag(pressure=4.5, temperature=293.0)]))
    sim.velocities = np.tile([0.0, 0.0, 2.0], (sim.node_count, 1))
    density = 4.5 / (287 * 293)
    assert density == pytest.approx(5.35e-5, rel=1e-3)
    assert sim.forces("air_drag").sum(axis=0) == pytest.approx([0, 0, -0.5 * density * 4.0 * 0.06])
    sim.velocities = np.tile([2.0, 1.0, 0.0], (sim.node_count, 1))
    assert np.abs(sim.forces("air_drag")).max() == 0.0  # along its plane a plate has no area


def test_centrifugal_and_coriolis_force() -> None:
    sim = crowd(8)
    sim.velocities = np.random.default_rng(8).normal(size=(sim.node_count, 3))
    (x, y, _), (u, v, _) = sim.positions.T, sim.velocities.T
    omega, m = 4 * np.pi, sim.masses
    expected = m * [omega**2 * x + 2 * omega * v, omega**2 * y - 2 * omega * u, 0 * x]
    assert sim.forces("spin") == pytest.approx(expected.T)


@pytest.mark.parametrize("film", FILMS)
def test_a_spring_of_no_length_and_a_facet_of_no_area_stay_finite(film: Law) -> None:
    sim = crowd(9, film)
    positions = sim.positions.copy()
    positions[1] = positions[0]  # an edge of the sheet
    positions[4] = positions[3]
    sim.positions = positions
    assert np.isfinite(sim.forces()).all()
    sim.positions = np.zeros_like(positions)
    assert np.isfinite(sim.forces()).all()
    assert np.isfinite(list(sim.energies().values())).all()
    assert np.isfinite(sim.stable_dt())
