"""Natural strain of regions: no stress at it, Hooke's law where the film is held, edges between two films, stages."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
import pytest
from membrane_rs import Fixed, Material, Mesh, Rectangles, Region, Scene, Simulation, Springs, Stage, Triangles
from membrane_rs.errors import MeshError
from membrane_rs.folding import Strip
from membrane_rs.results import peak_stress
from numpy.testing import assert_allclose
from small_scenes import FILM, UNBUCKLED, irregular, refused

FILMS: list[Any] = [Springs(10.0, 30.0), Springs(10.0, 30.0, crease_length=0.01), Triangles(0.1, 10.0, 30.0)]


@pytest.mark.parametrize("film", FILMS)
def test_a_film_at_its_natural_strain_is_free_of_stress(film: Any) -> None:
    """On an irregular mesh, stretched as the strain says, in any direction; and held flat it bears Hooke's stress."""
    flat, strain, direction = irregular(), (0.012, -0.004), 0.6
    cosine, sine = math.cos(direction), math.sin(direction)
    turn = np.array([[cosine, -sine], [sine, cosine]])
    stretch = np.eye(2) + turn @ np.diag(strain) @ turn.T
    positions = np.array(flat.reference)
    positions[:, :2] = positions[:, :2] @ stretch.T
    region = Region("all", natural_strain=strain, direction=direction)
    slack, held = (
        Simulation(Scene(Mesh(flat.reference, flat.triangles, positions=at), FILM, [film], [Fixed([0]), region]))
        for at in (positions, flat.reference)
    )
    assert np.abs(slack.forces()).max() < 1e-9 * np.abs(held.forces()).max()
    assert slack.energies()[film.kind] < 1e-15 * held.energies()[film.kind]


def test_a_held_film_that_shrinks_is_taut_by_hookes_law() -> None:
    """sigma = E e / (1 - nu) of a shrinkage e in both directions; thermal strain and prestress are the same."""
    mesh, shrinkage = irregular(), 1e-4
    parts = [Fixed(np.unique(mesh.boundary_edges).tolist()), Region("all", natural_strain=(-shrinkage, -shrinkage))]
    stress = Simulation(Scene(mesh, FILM, [Triangles(1.0)], parts)).film_stress().principal
    assert_allclose(stress, 3.2e9 * shrinkage / (1.0 - 0.34), rtol=2e-4)


@pytest.mark.parametrize("film", FILMS)
def test_a_film_that_shrinks_pulls_as_one_that_is_stretched(film: Any) -> None:
    """By similarity: at a natural strain -e as one of (1 - e) its size, stretched to the same shape."""
    mesh, shrinkage = irregular(), 0.01
    region = Region("all", natural_strain=(-shrinkage, -shrinkage))
    own = Simulation(Scene(mesh, FILM, [film], [Fixed([0]), region])).forces()
    larger = Mesh(mesh.reference, mesh.triangles, positions=mesh.reference / (1.0 - shrinkage))
    stretched = Simulation(Scene(larger, FILM, [film], [Fixed([0])])).forces()
    assert_allclose(own, (1.0 - shrinkage) * stretched, atol=1e-9 * np.abs(stretched).max())


def test_a_prestressed_strip_vibrates_as_a_string() -> None:
    """f = sqrt(sigma/rho)/(2 L) of a strip held at its ends that would shrink; here sigma = E e."""
    length, shrinkage = 0.2, 1e-4
    mesh = Strip(length, 0.01, 40, 2).mesh()
    x = mesh.reference[:, 0] - mesh.reference[:, 0].min()
    bent = np.array(mesh.reference)
    bent[:, 2] = 1e-5 * np.sin(math.pi * x / length)
    ends = np.flatnonzero((x < 1e-9) | (x > length - 1e-9)).tolist()
    region = Region("all", natural_strain=(-shrinkage, 0.34 * shrinkage))
    start = Mesh(mesh.reference, mesh.triangles, positions=bent)
    sim = Simulation(Scene(start, FILM, [Triangles(1.0)], [Fixed(ends), region]))
    expected = math.sqrt(3.2e9 * shrinkage / 1420.0) / (2.0 * length)
    middle = int(np.argmin(np.abs(x - 0.5 * length)))
    sim.reach(0.25 / expected)
    assert abs(sim.positions[middle, 2]) < 0.03e-5
    sim.reach(0.5 / expected)
    assert sim.positions[middle, 2] == pytest.approx(-1e-5, rel=0.01)


def test_a_stage_warms_the_film() -> None:
    """What a stage sets holds from its start on: a strip between two held ends loses its tension."""
    mesh = Strip(0.1, 0.01, 10, 2).mesh()
    x = mesh.reference[:, 0]
    ends = np.flatnonzero((x < x.min() + 1e-9) | (x > x.max() - 1e-9)).tolist()
    cold = Region("all", natural_strain=(-1e-3, 0.34e-3), name="film")
    warm = Stage("warm", 1e-4, set={"parts.film.natural_strain": (0.0, 0.0)})
    scene = Scene(mesh, FILM, [Triangles(1.0)], [Fixed(ends), cold], stages=[Stage("cold", 1e-4), warm])
    sim = Simulation(scene)
    assert sim.energies()["triangles"] > 0.0
    before = sim.energies()["triangles"]
    sim.reach(1.01e-4)
    assert sim.energies()["triangles"] < 1e-3 * before


@pytest.mark.parametrize("film", [UNBUCKLED, Rectangles(1e12, 1e12)])
def test_two_films_pull_on_their_border_as_each_by_itself(film: Any) -> None:
    """Forces on a held strip of two films are the sums of those of its halves, each with its film and its strain."""
    mesh = Strip(0.1, 0.04, 10, 4).mesh()
    middle = mesh.reference[:, 1].mean()
    is_upper = mesh.reference[mesh.triangles].mean(axis=1)[:, 1] > middle
    upper = Region(np.flatnonzero(is_upper).tolist(), youngs_modulus=3.2e10, natural_strain=(-0.01, 0.004))
    lower = Region(np.flatnonzero(~is_upper).tolist(), natural_strain=(0.002, 0.003))
    held = Fixed([0])
    both = Simulation(Scene(mesh, FILM, [film], [held, upper, lower])).forces()
    summed = np.zeros_like(both)
    for mask, region in ((is_upper, upper), (~is_upper, lower)):
        nodes, triangles = np.unique(mesh.triangles[mask], return_inverse=True)
        half = Mesh(mesh.reference[nodes], triangles.reshape(-1, 3))
        own = Region("all", youngs_modulus=region.youngs_modulus, natural_strain=region.natural_strain)
        summed[nodes] += Simulation(Scene(half, FILM, [film], [held, own])).forces()
    assert_allclose(both, summed, atol=1e-9 * np.abs(both).max())


@pytest.mark.parametrize("film", [Springs(0.0), Rectangles(0.0), Triangles()])
def test_the_peak_stress_is_that_beyond_the_natural_strain(film: Any) -> None:
    """E e / (1 - nu) of a held film that shrinks by e in both directions."""
    mesh, shrinkage = Strip(0.1, 0.02, 10, 2).mesh(), 1e-4
    parts = [Fixed(np.unique(mesh.boundary_edges).tolist()), Region("all", natural_strain=(-shrinkage, -shrinkage))]
    sim = Simulation(Scene(mesh, FILM, [film], parts))
    assert peak_stress(sim) == pytest.approx(3.2e9 * shrinkage / (1.0 - 0.34), rel=3e-4)


def test_directions_need_a_flat_shape_in_the_plane() -> None:
    """Natural strain, natural curvature and two moduli, given in x and y, are refused on a film in the xz plane."""
    flat = Strip(0.1, 0.02, 10, 2).mesh()
    upright = Mesh(flat.reference[:, [0, 2, 1]], flat.triangles)
    fibres = Material(3.2e9, 0.34, 1420.0, 7.5e-6, youngs_modulus_across=1e9, shear_modulus=1e9)
    cases: list[tuple[Material, list[Region]]] = [
        (FILM, [Region("all", natural_strain=(0.0, 1e-3))]),
        (FILM, [Region([3], curvature=(1.0, 0.0))]),
        (fibres, []),
    ]
    for material, parts in cases:
        scene = Scene(upright, material, [Triangles(1.0)], [Fixed([0]), *parts])
        refused(partial(Simulation, scene), MeshError, r"triangle [03] of the flat shape is tilted .* turn")
    Simulation(Scene(upright, FILM, [Triangles(1.0)], [Fixed([0]), Region([3], thickness=1e-5)]))
