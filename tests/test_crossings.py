"""Crossings of triangles: known configurations, rational numbers, invariance, bad input."""

from __future__ import annotations

import numpy as np
import pytest
from exact_triangles import relations
from hypothesis import given, settings
from hypothesis import strategies as st
from membrane_rs import InputError, InputTypeError, Mesh, MeshError, Simulation, folding, scenes
from membrane_rs._arrays import Floats

Row = tuple[float, float, float]

FLOOR: list[Row] = [(0, 0, 0), (4, 0, 0), (0, 4, 0)]
"""The triangle that the others meet, nodes 0, 1, 2."""
LEAST = np.nextafter(0.0, 1.0)

CONFIGURATIONS: dict[str, tuple[list[Row], list[int], tuple[int, int, int]]] = {
    # Further nodes, the second triangle, and what is found: crossing, overlapping, touching.
    "an edge through the face": ([(1, 1, -1), (1, 1, 1), (9, 9, 0)], [3, 4, 5], (1, 0, 0)),
    "past an edge": ([(3, 3, -1), (3, 3, 1), (9, 9, 0)], [3, 4, 5], (0, 0, 0)),
    "the other way round": ([(1, 1, -1), (1, 1, 1), (9, 9, 0)], [5, 4, 3], (1, 0, 0)),
    "above": ([(1, 1, 1), (1, 1, 2), (9, 9, 1)], [3, 4, 5], (0, 0, 0)),
    "a node on the face": ([(1, 1, 0), (1, 1, 1), (2, 2, 1)], [3, 4, 5], (0, 0, 1)),
    "a node one ulp through the face": ([(1, 1, -LEAST), (1, 1, 1), (2, 2, 1)], [3, 4, 5], (1, 0, 0)),
    "a node one ulp above the face": ([(1, 1, LEAST), (1, 1, 1), (2, 2, 1)], [3, 4, 5], (0, 0, 0)),
    "a side in the face": ([(1, 1, 0), (1, 2, 0), (1, 1, 1)], [3, 4, 5], (0, 0, 1)),
    "a side in the plane, outside": ([(5, 5, 0), (5, 6, 0), (5, 5, 1)], [3, 4, 5], (0, 0, 0)),
    "through an edge, on to the face": ([(2, -1, -1), (2, -1, 1), (2, 1, 0)], [3, 4, 5], (1, 0, 0)),
    "an edge through an edge": ([(2, 0, -1), (2, 0, 1), (2, -9, 0)], [3, 4, 5], (0, 0, 1)),
    "an edge through an edge, across the face": ([(2, 0, -1), (2, 0, 1), (2, 9, 0)], [3, 4, 5], (1, 0, 0)),
    "an edge through a node": ([(0, 0, -1), (0, 0, 1), (-9, -9, 0)], [3, 4, 5], (0, 0, 1)),
    "a common node, through the face": ([(1, 1, -1), (1, 2, 1)], [0, 3, 4], (1, 0, 0)),
    "a common node, beside the face": ([(-1, 1, -1), (-1, 1, 1)], [0, 3, 4], (0, 0, 0)),
    "a common node, in the plane": ([(-1, 1, 0), (-1, -1, 0)], [0, 3, 4], (0, 0, 0)),
    "a common node, on the face": ([(1, 2, 0), (2, 1, 0)], [0, 3, 4], (0, 1, 0)),
    "a common node, a side on the face": ([(1, 1, 0), (1, 1, 1)], [0, 3, 4], (0, 0, 0)),
    "a common edge, flat": ([(1, -3, 0)], [1, 0, 3], (0, 0, 0)),
    "a common edge, folded": ([(1, 3, 1)], [1, 0, 3], (0, 0, 0)),
    "a common edge, folded by one ulp less": ([(1, 3, LEAST)], [1, 0, 3], (0, 0, 0)),
    "a common edge, shut": ([(1, 3, 0)], [1, 0, 3], (0, 1, 0)),
    "a side on a side, in the plane": ([(1, 0, 0), (3, 0, 0), (2, -1, 0)], [3, 4, 5], (0, 0, 1)),
    "a node on a node, in the plane": ([(4, 0, 0), (5, 0, 0), (5, 1, 0)], [3, 4, 5], (0, 0, 1)),
    "inside, in the plane": ([(1, 1, 0), (1.5, 1, 0), (1, 1.5, 0)], [3, 4, 5], (0, 1, 0)),
    "a star, in the plane": ([(3, 3, 0), (-1, 2, 0), (2, -1, 0)], [3, 4, 5], (0, 1, 0)),
    "outside, in the plane": ([(3, 3, 0), (4, 3, 0), (3, 4, 0)], [3, 4, 5], (0, 0, 0)),
    "the same again": (FLOOR, [3, 4, 5], (0, 1, 0)),
    "the same nodes": ([], [2, 0, 1], (0, 1, 0)),
    "without area, through the face": ([(1, 1, -1), (1, 1, 1), (1, 1, 3)], [3, 4, 5], (0, 0, 0)),
    "a point on the face": ([(1, 1, 0), (1, 1, 0), (1, 1, 0)], [3, 4, 5], (0, 0, 0)),
    "parallel": ([(0, 0, 1), (4, 0, 1), (0, 4, 1)], [3, 4, 5], (0, 0, 0)),
}
SHIFTS = (0.0, 1e6, 2.0**40)
SCALES = (1.0, 2.0**-1070, 1e-200, 1e-100, 1e100, 1e200, 2.0**1019)


def found(positions: Floats, triangles: list[list[int]]) -> tuple[int, int, int]:
    mesh = Mesh(np.random.default_rng(0).normal(size=positions.shape), triangles)
    crossings = mesh.crossings(positions)
    assert crossings.count == len(crossings.pairs)
    return crossings.count, crossings.overlapping, crossings.touching


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_known_configurations(name: str) -> None:
    nodes, second, expected = CONFIGURATIONS[name]
    positions = np.array(FLOOR + nodes)
    for axes in ([0, 1, 2], [1, 2, 0], [2, 0, 1]):
        turned = positions[:, axes]
        for k in range(3):
            rolled = [second[k:] + second[:k], [k % 3, (k + 1) % 3, (k + 2) % 3]]
            assert found(turned, rolled) == expected
            assert found(turned, [row[::-1] for row in rolled[::-1]]) == expected


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("name", [name for name in CONFIGURATIONS if "ulp" not in name])
def test_scale_does_not_matter(name: str, scale: float) -> None:
    nodes, second, expected = CONFIGURATIONS[name]
    # A power of two keeps whole numbers whole, and halves.
    scale = 2.0 ** np.round(np.log2(scale))
    assert found(np.array(FLOOR + nodes) * scale, [[0, 1, 2], second]) == expected


@pytest.mark.parametrize("shift", SHIFTS)
@pytest.mark.parametrize("name", [name for name in CONFIGURATIONS if "ulp" not in name])
def test_place_does_not_matter(name: str, shift: float) -> None:
    nodes, second, expected = CONFIGURATIONS[name]
    assert found(np.array(FLOOR + nodes) + np.array([1.0, -1.0, 3.0]) * shift, [[0, 1, 2], second]) == expected


COORDINATES = {
    "whole numbers": st.integers(-3, 3).map(float),
    "neighbours of whole numbers": st.builds(
        lambda k, to: float(np.nextafter(k, to)), st.integers(-2, 2), st.sampled_from([-9.0, 9.0])
    ),
    "tenths": st.integers(-5, 5).map(lambda k: k * 0.1 + 1e3),
    "far apart in size": st.builds(
        lambda k, power: float(np.ldexp(k, power)), st.integers(-2, 2), st.sampled_from([-1074, -600, -300, 0, 1000])
    ),
    "all numbers": st.floats(-1e150, 1e150),
}


@pytest.mark.parametrize("kind", COORDINATES)
@settings(deadline=None)
@given(data=st.data())
def test_as_in_rational_numbers(kind: str, data: st.DataObject) -> None:
    points = data.draw(st.lists(st.tuples(*[COORDINATES[kind]] * 3), min_size=4, max_size=9))
    rows = st.permutations(range(len(points))).map(lambda order: list(order[:3]))
    triangles = data.draw(st.lists(rows, min_size=2, max_size=8))
    crossing, counts = relations(points, triangles)
    crossings = Mesh(np.zeros((len(points), 3)), triangles).crossings(points)
    assert crossings.pairs.tolist() == crossing
    assert (crossings.count, crossings.overlapping) == (counts["crossing"], counts["overlapping"])
    assert crossings.touching == counts["touching"]


def tangle(count: int) -> tuple[Floats, list[list[int]]]:
    """Triangles at random, some with common nodes."""
    rng = np.random.default_rng(count)
    return rng.normal(size=(count, 3)), [list(rng.choice(count, 3, replace=False)) for _ in range(count)]


def test_pairs_are_ascending_and_as_in_rational_numbers_for_many_triangles() -> None:
    positions, triangles = tangle(60)
    crossing, _ = relations(positions.tolist(), triangles)
    assert len(crossing) > 100
    assert Mesh(positions, triangles).crossings().pairs.tolist() == crossing


def test_the_order_of_triangles_and_nodes_does_not_matter() -> None:
    positions, triangles = tangle(300)
    crossings = Mesh(positions, triangles).crossings()
    rng = np.random.default_rng(1)
    order, renumbered = rng.permutation(300), rng.permutation(300)
    others = [[int(renumbered[k]) for k in rng.permutation(triangles[row])] for row in order]
    moved = np.empty_like(positions)
    moved[renumbered] = positions[:, [1, 0, 2]] * [-1, 1, 1]
    again = Mesh(moved, others).crossings()
    assert crossings.count > 10_000
    assert (again.count, again.candidates) == (crossings.count, crossings.candidates)
    assert np.unique(np.sort(order[again.pairs], axis=1), axis=0).tolist() == crossings.pairs.tolist()


@pytest.mark.parametrize("limit", [0, 1, 7, 10**30])
def test_the_first_pairs_are_listed_and_all_are_counted(limit: int) -> None:
    positions, triangles = tangle(100)
    mesh = Mesh(positions, triangles)
    every = mesh.crossings()
    some = mesh.crossings(limit=limit)
    assert every.count == len(every.pairs) == some.count
    assert some.pairs.tolist() == every.pairs[:limit].tolist()
    assert not some.pairs.flags.writeable


@pytest.mark.parametrize(
    ("positions", "limit", "error", "words"),
    [
        (np.zeros((2, 3)), 1, MeshError, "positions has 2 nodes and reference 3"),
        (np.zeros((3, 2)), 1, MeshError, r"positions has shape \(3, 2\)"),
        (np.full((3, 3), np.nan), 1, MeshError, r"positions\[0\] .* is not finite"),
        ([[0, 0, np.inf]] * 3, 1, MeshError, "not finite"),
        ("positions", 1, InputTypeError, "dtype"),
        (None, -1, InputError, "limit = -1: must be at least 0"),
        (None, 1.0, InputTypeError, "limit = 1.0: must be a whole number"),
        (None, True, InputTypeError, "limit = True"),
        (None, None, InputTypeError, "limit = None"),
    ],
)
def test_bad_input(positions: object, limit: object, error: type[Exception], words: str) -> None:
    mesh = Mesh(FLOOR, [[0, 1, 2]])
    with pytest.raises(error, match=words):
        mesh.crossings(positions, limit=limit)  # type: ignore[arg-type]


@pytest.mark.parametrize("layout", ["ruled", "equilateral"])
def test_a_stowed_sail_crosses_itself_nowhere(layout: str) -> None:
    mesh = folding.SquareSail(layout=layout).mesh()  # type: ignore[arg-type]
    for positions in (None, mesh.reference):
        crossings = mesh.crossings(positions)
        assert (crossings.count, crossings.overlapping, crossings.touching) == (0, 0, 0)
        assert crossings.candidates > 0


def test_a_simulation_counts_them_where_it_is() -> None:
    sim = Simulation(scenes.load("okuizumi-model-1"))
    mesh = sim.scene.mesh
    assert mesh is not None
    sim.step(500)
    crossings, same = sim.crossings(limit=5), mesh.crossings(sim.positions[: mesh.node_count])
    assert crossings.pairs.tolist() == same.pairs[:5].tolist()
    assert crossings.count == same.count > 1000
    assert Simulation(scenes.load("spinning-tether")).crossings().count == 0
