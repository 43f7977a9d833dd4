"""LengthScales of the film in place of the mesh's own: dashpots and creases that are the same on every mesh."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    Bending,
    InputError,
    Mesh,
    Scene,
    Simulation,
    SpringDamping,
    Springs,
    TipMasses,
    Triangles,
    scenes,
)
from membrane_rs.folding import EquilateralLattice, SquareSail, Strip
from membrane_rs.scene.laws import Creases, Law
from membrane_rs.study import FORMS, LengthScales, agreeing
from small_scenes import FILM, RUBBER, cord, refused

SIDE = 0.01
FILMS = [Springs(), Triangles()]
RATE = np.array([[3.0, 1.0, 0.0], [-0.5, -2.0, 0.0], [0.0, 0.0, 0.0]])
"""A velocity gradient [1/s]."""


def sheet(cells: int, size: float = 8 * SIDE, creases: tuple[float, ...] = ()) -> Mesh:
    return Strip(size, size, cells, cells, creases=creases).mesh()


def damped(mesh: Mesh, film: Law, damping: SpringDamping, *parts: TipMasses) -> Simulation:
    return Simulation(Scene(mesh, FILM, [film, damping], parts))


def loss(sim: Simulation) -> float:
    """Power that the dashpots take at one rate of strain."""
    sim.velocities = sim.positions @ RATE.T
    return -float(np.sum(sim.forces("spring_damping") * sim.velocities))


@pytest.mark.parametrize("film", FILMS, ids=lambda film: film.kind)
def test_a_damping_length_agrees_with_the_papers_form(film: Law) -> None:
    # Where each node has the mass of a square of film of that side: on an equilateral lattice, sqrt(3)/2 of its own.
    mesh, forces = EquilateralLattice(SIDE, 8, 8).mesh(), []
    for damping in (SpringDamping(0.1), SpringDamping(0.1, length=SIDE * (3**0.5 / 2) ** 0.5)):
        sim = damped(mesh, film, damping)
        sim.velocities = np.random.default_rng(2).normal(size=(mesh.node_count, 3))
        forces.append(sim.forces("spring_damping"))
    inside = np.arange(81).reshape(9, 9)[2:-2, 2:-2].ravel()  # all their neighbours have full mass
    assert forces[1][inside] == pytest.approx(forces[0][inside], rel=1e-9, abs=1e-12 * np.abs(forces[0]).max())


def test_what_triangles_lose_at_one_rate_of_strain_is_the_same_on_every_mesh() -> None:
    losses = [loss(damped(sheet(n), Triangles(), SpringDamping(0.1, length=SIDE))) for n in (2, 4, 8, 16)]
    assert losses == pytest.approx([losses[0]] * 4, rel=1e-10)
    fading = [loss(damped(sheet(n), Triangles(), SpringDamping(0.1))) for n in (8, 16, 32)]
    assert [a / b for a, b in pairwise(fading)] == pytest.approx([2.0, 2.0], rel=0.05)


def test_what_springs_lose_tends_to_a_limit_at_first_order_of_the_boundary() -> None:
    # On the boundary a spring belongs to one triangle, and the root of its constant is not half of an inner one's.
    losses = [loss(damped(sheet(n), Springs(), SpringDamping(0.1, length=SIDE))) for n in (4, 8, 16, 32)]
    steps = np.abs(np.diff(losses))
    assert steps[0] < 0.1 * losses[0]
    assert steps[:-1] / steps[1:] == pytest.approx([2.0, 2.0], rel=0.05)


@pytest.mark.parametrize("film", FILMS, ids=lambda film: film.kind)
def test_a_rigid_motion_is_spared(film: Law) -> None:
    sim = damped(sheet(6), film, SpringDamping(0.5, length=SIDE))
    measure = loss(sim)
    turning = np.array([[0.0, -3.0, 2.0], [3.0, 0.0, -1.0], [-2.0, 1.0, 0.0]])
    sim.velocities = sim.positions @ turning.T + [1.0, -2.0, 3.0]
    force = sim.forces("spring_damping")
    assert abs(float(np.sum(force * sim.velocities))) < 1e-12 * measure
    assert np.abs(force).max() < 1e-11 * measure  # at speeds of 1 m/s


def test_masses_at_a_corner_do_not_stiffen_its_dashpots() -> None:
    mesh = sheet(6)
    heavy = TipMasses(1e-3, (0, 6))
    plain, loaded = (damped(mesh, Springs(), SpringDamping(0.1, length=SIDE), *parts) for parts in ((), (heavy,)))
    assert loss(loaded) == pytest.approx(loss(plain), rel=1e-12)
    plain, loaded = (damped(mesh, Springs(), SpringDamping(0.1), *parts) for parts in ((), (heavy,)))
    assert loss(loaded) > 1.5 * loss(plain)


def test_tethers_keep_the_masses_of_their_nodes() -> None:
    forces = []
    for length in (None, 0.3):
        sim = Simulation(Scene(None, None, [SpringDamping(0.1, length=length)], [cord()]))
        sim.positions = np.array([[0.0, 0.0, 0.0], [1.1, 0.0, 0.0]])  # taut
        sim.velocities = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
        forces.append(sim.forces("spring_damping"))
    assert np.abs(forces[0]).max() > 0.1
    np.testing.assert_array_equal(forces[0], forces[1])


def end_force(film: type[Springs] | type[Triangles], cells: int, **lengths: Any) -> float:
    """Push along a crease of the shrunken sheet, on the crease's end, where the film alone bears nothing."""
    mesh = sheet(cells, creases=(0.5,))
    sim = Simulation(Scene(mesh, RUBBER, [film(buckling=0.0, buckling_on_creases=5.0, **lengths)]))
    sim.positions = 0.9 * mesh.reference
    a, b = mesh.creases[0]
    ends = [node for node in mesh.creases.ravel() if np.count_nonzero(mesh.creases == node) == 1]
    along = np.argmax(np.abs(mesh.reference[a] - mesh.reference[b]))
    return float(np.abs(sim.forces(film.kind)[ends, along]).max())


@pytest.mark.parametrize("film", [Springs, Triangles])
def test_a_crease_length_makes_one_buckling_force_on_every_mesh(film: type[Springs] | type[Triangles]) -> None:
    own = [end_force(film, n, buckling_length=SIDE, crease_length=SIDE) for n in (4, 8, 16)]
    assert own == pytest.approx([own[0]] * 3, rel=1e-9)
    assert own[1] == pytest.approx(end_force(film, 8), rel=1e-9)  # on cells of that side all forms agree
    strain = [end_force(film, n, buckling_length=SIDE) for n in (4, 8, 16)]
    assert strain == pytest.approx([2 * own[0], own[0], 0.5 * own[0]], rel=1e-9)
    paper = [end_force(film, n) for n in (4, 8, 16)]
    assert paper == pytest.approx([0.5 * own[0], own[0], 2 * own[0]], rel=1e-9)


def test_a_crease_weaker_than_the_film_bears_no_less_than_nothing() -> None:
    mesh = sheet(4, creases=(0.5,))
    sim = Simulation(
        Scene(mesh, RUBBER, [Springs(buckling=1.0, buckling_on_creases=0.0, buckling_length=1.0, crease_length=1e-3)])
    )
    sim.positions = (1 - 1e-9) * mesh.reference
    creases = {(int(min(pair)), int(max(pair))) for pair in mesh.creases}
    rows = [row for row, edge in enumerate(mesh.edges.tolist()) if tuple(edge) in creases]
    assert sim.buckled()[rows].all()
    assert np.isfinite(sim.forces()).all()


def test_lengths_go_through_scene_files(tmp_path: Path) -> None:
    scene = FORMS["physical"].of(scenes.load("okuizumi-model-1"))
    films: list[Law] = [scene.laws[0], Triangles(buckling_length=0.012, crease_length=0.01)]
    for film in films:
        one = replace(scene, laws=[law for law in scene.laws if law.kind != "springs"] + [film])
        one.save(tmp_path / film.kind)
        again = Scene.from_toml(tmp_path / film.kind / "scene.toml")
        assert again.laws == one.laws
    assert scene.law("spring_damping") == SpringDamping(0.02, length=0.011)
    text = (tmp_path / "springs" / "scene.toml").read_text()
    (tmp_path / "wrong.toml").write_text(text.replace("crease_length = 0.01", "crease_length = -0.01"))
    with pytest.raises(InputError, match=r"laws.springs.crease_length = -0.01: must be greater than 0 \(m\)"):
        Scene.from_toml(tmp_path / "wrong.toml")


def test_agreeing_lengths() -> None:
    found = agreeing(scenes.load("okuizumi-model-1"))
    chosen = FORMS["physical"]
    for name in ("buckling", "crease", "facet", "damping"):
        assert getattr(found, name) == pytest.approx(getattr(chosen, name), rel=0.015)
    # On cells of another size the length scales are proportional to it.
    other = SquareSail(rows=32)
    finer = agreeing(replace(scenes.load("okuizumi-model-1"), mesh=other.mesh()))
    for name in ("buckling", "crease", "facet", "damping"):
        assert getattr(finer, name) == pytest.approx(0.5 * getattr(found, name), rel=0.03)
    disc = scenes.load("spinning-disc")
    refused(lambda: agreeing(disc), InputError, "need a film of springs, with creases and damping")
    weak = replace(scenes.load("okuizumi-model-1"), laws=[Springs(100.0, 100.0), SpringDamping(), Creases()])
    refused(
        lambda: agreeing(weak), InputError, "buckling_on_creases = 100.0: must be greater than laws.springs.buckling"
    )


def test_lengths_set_what_each_law_takes() -> None:
    lengths = LengthScales(buckling=0.1, crease=0.2, facet=0.3, damping=0.4)
    film = replace(scenes.load("okuizumi-model-1"), laws=[Triangles(), Creases(), SpringDamping()])
    triangles, creases, damping = lengths.of(film).laws
    assert isinstance(triangles, Triangles)
    assert (triangles.buckling_length, triangles.crease_length) == (0.1, 0.2)
    assert creases == Creases(length_scale=0.3)
    assert damping == SpringDamping(length=0.4)
    assert LengthScales().of(lengths.of(film)).laws == film.laws
    slack = FORMS["tension"].of(film).laws[0]
    assert isinstance(slack, Triangles)
    assert (slack.buckling, slack.buckling_on_creases) == (0.0, 0.0)
    plate, *_, bending = FORMS["bending"].of(film).laws
    assert isinstance(plate, Triangles)
    assert (plate.buckling, plate.buckling_on_creases) == (1.0, 1.0)
    assert bending == Bending()
    own = replace(film, laws=[*film.laws, Bending(stiffness=2.0)])
    assert FORMS["bending"].of(own).law(Bending) == Bending(stiffness=2.0)
