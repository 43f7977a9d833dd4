"""Dashpots of slack cords and of buckled film: no force beyond the elastic one, no step, no push; masses of a pair."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest
from membrane_rs import (
    Creases,
    Fixed,
    Gravity,
    InputError,
    Mesh,
    RunSettings,
    Scene,
    Simulation,
    SpringDamping,
    Springs,
    Triangles,
    integrators,
    scenes,
)
from membrane_rs.folding import EquilateralLattice, Strip
from membrane_rs.study import agreeing
from small_scenes import RUBBER, Floats, cord

ZETA, STIFFNESS = 0.02, 100.0
COEFFICIENT = 2 * ZETA * math.sqrt(STIFFNESS * 0.5)
"""Of `cord` [N s/m]: the mean of the held node without mass and of the tip of 1 kg."""
TRIANGLE = np.array([[0.0, 0.0, 0.0], [0.01, 0.0, 0.0], [0.004, 0.009, 0.0]])


def tip(at: tuple[float, float, float], velocity: tuple[float, float, float], **changes: Any) -> Simulation:
    """A cord of 1 m along x and 100 N/m with its tip somewhere, in motion."""
    sim = Simulation(Scene(None, None, [SpringDamping(ZETA, **changes)], [cord()]), dt=1e-4)
    sim.positions = [[0.0, 0.0, 0.0], at]
    sim.velocities = [[0.0, 0.0, 0.0], velocity]
    return sim


def tension(length: float, rate: float, **changes: Any) -> float:
    """Of that cord at this length [m], which changes at this rate [m/s]."""
    return -float(tip((length, 0.0, 0.0), (rate, 0.0, 0.0), **changes).forces()[1, 0])


@pytest.mark.parametrize("velocity", [(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (30.0, -2.0, 5.0), (0.0, 0.0, 0.0)])
@pytest.mark.parametrize("at", [(0.5, 0.0, 0.0), (0.3, -0.2, 0.6), (1.0, 0.0, 0.0), (1e-13, 0.0, 0.0)])
def test_a_slack_cord_has_no_force(at: tuple[float, float, float], velocity: tuple[float, float, float]) -> None:
    sim = tip(at, velocity)
    assert not sim.forces().any()
    assert not sim.forces("spring_damping").any()


def test_the_papers_form_resists_in_a_slack_cord_too() -> None:
    assert tension(0.5, 1.0, limited="none") == pytest.approx(COEFFICIENT)


@pytest.mark.parametrize("rate", [-20.0, -1.0, 0.0, 0.3, 1.0, 20.0])
def test_a_taut_cord_has_the_dashpot_up_to_its_tension(rate: float) -> None:
    for stretch in (1e-9, 1e-4, 0.003, 0.05, 0.4):
        elastic = STIFFNESS * stretch
        resistance = math.copysign(min(abs(COEFFICIENT * rate), elastic), rate)
        assert tension(1.0 + stretch, rate) == pytest.approx(elastic + resistance, rel=1e-6, abs=1e-12)
        assert tension(1.0 + stretch, rate) >= 0.0


def test_motion_across_a_taut_cord_meets_no_resistance() -> None:
    assert np.abs(tip((1.1, 0.0, 0.0), (0.0, 3.0, -2.0)).forces("spring_damping")).max() < 1e-15


@pytest.mark.parametrize("rate", [-1e3, -1.0, 1.0, 1e3])
def test_the_force_has_no_step_at_first_stretch(rate: float) -> None:
    lengths = 1.0 + np.linspace(-1e-3, 1e-3, 101)
    forces = np.array([tension(length, rate) for length in lengths])
    assert np.abs(np.diff(forces)).max() <= 2 * STIFFNESS * np.diff(lengths).max() * (1 + 1e-9)


@pytest.mark.parametrize("method", integrators())
def test_a_tip_thrown_up_falls_freely_until_its_cord_is_taut(method: str) -> None:
    gravity, start, up = 9.81, -0.5, 1.0
    scene = Scene(None, None, [Gravity((0.0, 0.0, -gravity)), SpringDamping(ZETA)], [cord(end=(0.0, 0.0, -1.0))])
    sim = Simulation(scene, method, dt=1e-3)
    sim.positions = [[0.0, 0.0, 0.0], [0.0, 0.0, start]]
    sim.velocities = [[0.0, 0.0, 0.0], [0.0, 0.0, up]]
    sim.step(400)
    time = sim.time
    assert sim.positions[1, 2] == pytest.approx(start + up * time - gravity * time**2 / 2, abs=1e-9)
    assert sim.ledger()["work_by_law"].get("spring_damping", 0.0) == 0.0
    # Over the rest of the second the cord becomes taut, turns the tip round and is slack again.
    sim.step(600)
    ledger = sim.ledger()
    assert ledger["work_by_law"]["spring_damping"] < 0.0
    assert abs(ledger["error"]) < 2e-2
    assert sim.velocities[1, 2] > 0.0


@pytest.mark.parametrize("method", ["rk4", "leapfrog"])
@pytest.mark.parametrize("ratio", [0.02, 0.5])
def test_the_limit_of_the_step_is_that_of_taut_dashpots(method: str, ratio: float) -> None:
    limits = []
    for limited in ("none", "cords"):
        scene = Scene(None, None, [SpringDamping(ratio, limited=limited)], [cord()])
        sim = Simulation(scene, method)
        for length in (1.0, 0.5):
            sim.positions = [[0.0, 0.0, 0.0], [length, 0.0, 0.0]]
            limits.append(sim.stable_dt())
    assert limits == pytest.approx([limits[0]] * 4, rel=1e-9)


@pytest.mark.parametrize("method", ["rk4", "leapfrog"])
def test_a_tip_that_bounces_near_the_limit_of_the_step_gains_no_height(method: str) -> None:
    laws = [Gravity((0.0, 0.0, -9.81)), SpringDamping(0.3)]
    scene = Scene(None, None, laws, [cord(end=(0.0, 0.0, -1.0))], run=RunSettings(energy_loss=1.0))
    sim = Simulation(scene, method, dt=0.7 * Simulation(scene, method).stable_dt())
    sim.positions = [[0.0, 0.0, 0.0], [0.0, 0.0, -0.5]]
    heights = []
    for _ in range(600):
        sim.step(1)
        heights.append(sim.positions[1, 2])
    assert max(heights[100:]) < -0.5
    assert heights[-1] == pytest.approx(-1.0 - 9.81 / STIFFNESS, abs=1e-3)


def triangle(law: SpringDamping, squeeze: float, rate: float) -> Simulation:
    """A triangle of rubber, squeezed and in motion towards or from its first node [1/s]."""
    springs = Springs(buckling=10.0, buckling_on_creases=10.0)
    mesh = Mesh(TRIANGLE, [[0, 1, 2]], positions=TRIANGLE * (1.0 - squeeze))
    sim = Simulation(Scene(mesh, RUBBER, [springs, law]), dt=1e-6)
    sim.velocities = rate * TRIANGLE
    return sim


def tensions(sim: Simulation) -> Floats:
    """The three tensions in its sides, from the forces on its nodes [N]."""
    edges = np.array([[0, 1], [0, 2], [1, 2]])
    span = sim.positions[edges[:, 1]] - sim.positions[edges[:, 0]]
    along = span / np.linalg.norm(span, axis=1)[:, None]
    matrix = np.zeros((9, 3))
    for column, (i, j) in enumerate(edges):
        matrix[3 * i : 3 * i + 3, column], matrix[3 * j : 3 * j + 3, column] = along[column], -along[column]
    return np.asarray(np.linalg.lstsq(matrix, sim.forces().ravel(), rcond=None)[0], dtype=np.float64)


@pytest.mark.parametrize("rate", [-300.0, -1.0, 1.0, 300.0])
def test_no_spring_of_a_limited_film_bears_more_than_its_buckling_force(rate: float) -> None:
    law = SpringDamping(0.5, limited="all")
    buckling = tensions(triangle(law, 0.1, 0.0))
    assert (buckling < 0.0).all()
    assert tensions(triangle(law, 0.1, rate)) == pytest.approx(buckling)
    # Spring and dashpot together change by no more than twice the elastic force.
    previous, step = buckling, 2.1 * np.abs(tensions(triangle(law, -0.021 / 99, 0.0))).max()
    sim = triangle(law, 0.1, rate)
    for squeeze in np.linspace(0.02, -0.001, 100):
        sim.positions, sim.velocities = TRIANGLE * (1.0 - squeeze), rate * TRIANGLE
        found = tensions(sim)
        assert (found >= buckling * (1 + 1e-9)).all()
        assert np.abs(found - previous).max() < step
        previous = found
    full = tensions(triangle(SpringDamping(0.5), 0.1, rate))
    assert np.abs(full - buckling).max() > 0.0


@pytest.mark.parametrize("squeeze", [0.002, 0.001, -0.001])
def test_a_limited_dashpot_of_the_film_resists_with_the_tension_above_that_of_buckling(squeeze: float) -> None:
    law = SpringDamping(0.5, limited="all")
    buckling, elastic = tensions(triangle(law, 0.1, 0.0)), tensions(triangle(law, squeeze, 0.0))
    assert (elastic > buckling).all()
    assert tensions(triangle(law, squeeze, 300.0)) == pytest.approx(2.0 * elastic - buckling, rel=1e-9)
    assert tensions(triangle(law, squeeze, -300.0)) == pytest.approx(buckling, rel=1e-9)


def test_only_the_named_dashpots_are_limited() -> None:
    film = {limited: triangle(SpringDamping(0.5, limited=limited), 0.1, 1.0).forces() for limited in ("none", "cords")}
    assert (film["none"] == film["cords"]).all()
    assert (film["none"] != triangle(SpringDamping(0.5, limited="all"), 0.1, 1.0).forces()).any()


def test_a_limit_for_a_film_without_springs_is_refused() -> None:
    mesh = Mesh(TRIANGLE, [[0, 1, 2]])
    for laws in ([Triangles(), SpringDamping(limited="all")], [SpringDamping(limited="all")]):
        with pytest.raises(InputError, match='the scene has no law "springs"; set limited to "cords"'):
            Simulation(Scene(mesh, RUBBER, laws))
    with pytest.raises(InputError, match="must be 'none', 'cords' or 'all'"):
        SpringDamping(limited="film")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="must be 'mean' or 'reduced'"):
        SpringDamping(mass="harmonic")  # type: ignore[arg-type]


@pytest.mark.parametrize("masses", [(1.0, 1000.0), (1.0, 1.0), (5.0, 0.2)])
def test_a_free_pair_of_reduced_mass_has_the_damping_ratio_zeta(masses: tuple[float, float]) -> None:
    least = min(masses)
    heavy_at_tip = cord(fixed=False, linear_density=2 * least, tip_mass=max(masses) - least)
    found = {}
    for mass in ("mean", "reduced"):
        sim = Simulation(Scene(None, None, [SpringDamping(ZETA, mass=mass)], [heavy_at_tip]), dt=1e-4)
        assert sorted(sim.masses) == pytest.approx(sorted(masses))
        sim.positions = [[0.0, 0.0, 0.0], [1.4, 0.0, 0.0]]
        sim.velocities = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
        coefficient = sim.forces("spring_damping")[0, 0]
        reduced = masses[0] * masses[1] / sum(masses)
        found[mass] = coefficient / (2 * math.sqrt(STIFFNESS * reduced))
    assert found["reduced"] == pytest.approx(ZETA)
    assert found["mean"] == pytest.approx(ZETA * math.sqrt(sum(masses) / 2 / reduced))


def test_a_tip_on_a_held_cord_rings_down_by_the_ratio_zeta() -> None:
    gravity = 9.81
    scene = Scene(
        None,
        None,
        [Gravity((0.0, 0.0, -gravity)), SpringDamping(ZETA, mass="reduced")],
        [cord(end=(0.0, 0.0, -1.0))],
    )
    sim = Simulation(scene, dt=1e-4)
    rest, amplitude = -1.0 - gravity / STIFFNESS, 0.05
    sim.positions = [[0.0, 0.0, 0.0], [0.0, 0.0, rest + amplitude]]
    periods = 10
    damped = math.sqrt(STIFFNESS * (1 - ZETA**2))
    steps = round(periods * 2 * math.pi / damped / sim.dt)
    sim.step(steps)
    decrement = math.log(amplitude / (sim.positions[1, 2] - rest)) / periods
    assert decrement == pytest.approx(2 * math.pi * ZETA / math.sqrt(1 - ZETA**2), rel=1e-3)


def test_two_held_nodes_have_no_dashpot_and_no_fault() -> None:
    held = Fixed("tether-0-end")
    sim = Simulation(Scene(None, None, [SpringDamping(ZETA, mass="reduced")], [cord(), held]), dt=1e-4)
    sim.positions = [[0.0, 0.0, 0.0], [1.2, 0.0, 0.0]]
    assert np.abs(sim.forces()).max() == pytest.approx(0.2 * STIFFNESS)
    sim.step(10)


@pytest.mark.parametrize("length", [None, 0.005])
def test_triangles_of_reduced_mass_have_the_dashpots_of_springs(length: float | None) -> None:
    mesh, forces = EquilateralLattice(0.01, 8, 8).mesh(), []
    velocities = np.random.default_rng(3).normal(size=(mesh.node_count, 3))
    for film, mass in ((Springs(), "reduced"), (Triangles(), "reduced"), (Springs(), "mean")):
        law = SpringDamping(0.1, length=length, mass=mass)  # type: ignore[arg-type]
        sim = Simulation(Scene(mesh, RUBBER, [film, law]))
        sim.velocities = velocities
        forces.append(sim.forces("spring_damping"))
    springs, triangles, mean = (force.reshape(9, 9, 3)[2:-2, 2:-2] for force in forces)  # of nodes of equal mass
    assert springs == pytest.approx(triangles, rel=1e-9, abs=1e-12 * np.abs(springs).max())
    assert mean == pytest.approx(math.sqrt(2) * springs, rel=1e-9, abs=1e-12 * np.abs(springs).max())


def test_the_reduced_mass_lengthens_the_step_of_a_heavy_tip_on_a_light_cord() -> None:
    scene = scenes.load("spinning-tether")
    limits = {}
    for law in (SpringDamping(0.0), SpringDamping(ZETA), SpringDamping(ZETA, mass="reduced")):
        laws = [law if own.kind == law.kind else own for own in scene.laws]
        limits[law] = Simulation(replace(scene, laws=laws), "leapfrog").stable_dt()
    none, mean, reduced = limits.values()
    assert mean < 0.6 * none
    assert 0.9 * none < reduced < none


@pytest.mark.parametrize("mass", ["mean", "reduced"])
def test_the_agreeing_length_has_the_dissipation_of_the_nodes_masses(mass: Literal["mean", "reduced"]) -> None:
    mesh, law = Strip(0.08, 0.06, 8, 6, creases=(0.5,)).mesh(), SpringDamping(mass=mass)
    scene = Scene(mesh, RUBBER, [Springs(), Creases(), law])
    flat = Mesh(mesh.reference, mesh.triangles)
    losses = []
    for damping in (law, replace(law, length=agreeing(scene).damping)):
        sim = Simulation(Scene(flat, RUBBER, [Springs(), damping]), dt=1e-7)
        sim.velocities = sim.positions
        losses.append(np.sum(sim.forces("spring_damping") * sim.velocities))
    assert losses[0] == pytest.approx(losses[1], rel=1e-9)
