"""Mesh: what it derives, what it refuses."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from membrane_rs.errors import InputError, InputTypeError, MembraneError, MeshError
from membrane_rs.folding import EquilateralLattice, Strip
from membrane_rs.material import Material
from membrane_rs.mesh import Mesh

SQUARE = np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]])
TWO = np.array([[0, 1, 2], [0, 2, 3]])
FILM = Material(3.2e9, 0.34, 1420.0, 7.5e-6)


def moduli(mesh: Mesh, nodes: Any, area: float, film: Material) -> np.ndarray:
    """In-plane stiffness over E h (3, 3), in 11, 22, 12, of a lattice of which `nodes` are a cell.

    Every node is a centre of symmetry, so a uniform strain moves each as it moves the whole.
    """
    constants = mesh.spring_constants(film)
    stiffness = np.zeros((3, 3))
    for node in nodes:
        for e in np.flatnonzero((mesh.edges == node).any(axis=1)):
            x, y, _ = np.subtract(*mesh.reference[mesh.edges[e]])
            shape = np.array([x * x, y * y, x * y])
            stiffness += 0.5 * constants[e] * np.outer(shape, shape) / (x * x + y * y)
    return stiffness / (area * film.youngs_modulus * film.thickness)


def test_derived_arrays() -> None:
    mesh = Mesh(SQUARE, TWO)
    assert mesh.edges.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]]
    assert mesh.triangles_per_edge.tolist() == [1, 2, 1, 1, 1]
    assert mesh.boundary_edges.tolist() == [[0, 1], [0, 3], [1, 2], [2, 3]]
    assert mesh.edges[mesh.triangle_edges[0]].tolist() == [[1, 2], [0, 2], [0, 1]]
    np.testing.assert_allclose(mesh.edge_lengths, [2, math.sqrt(5), 1, 1, 2])
    np.testing.assert_allclose(mesh.areas(), [1, 1])
    np.testing.assert_allclose(mesh.masses(FILM), FILM.density * FILM.thickness * np.array([2, 1, 2, 1]) / 3)
    assert np.abs(mesh.strain()).max() == 0.0
    np.testing.assert_allclose(mesh.strain(1.01 * SQUARE), 0.01, rtol=1e-12)


def test_it_keeps_read_only_copies() -> None:
    points = SQUARE.copy()
    mesh = Mesh(points, TWO, positions=points, node_sets={"corner": [0]})
    points[0] = 7.0
    assert mesh.reference[0, 0] == 0.0
    for array in (mesh.reference, mesh.positions, mesh.triangles, mesh.edges, mesh.node_sets["corner"]):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.1])
def test_equilateral_lattice_is_an_isotropic_film(angle: float) -> None:
    film = Material(3.2e9, 1 / 3, 1420.0, 7.5e-6)
    mesh = EquilateralLattice(0.01, 4, 4).mesh()
    c, s = math.cos(angle), math.sin(angle)
    turned = mesh.reference @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    mesh = Mesh(turned, mesh.triangles, node_sets=mesh.node_sets)
    node = mesh.node_sets["inside"][4]
    compliance = np.linalg.inv(moduli(mesh, [node], 0.01**2 * math.sqrt(0.75), film))
    np.testing.assert_allclose(1 / compliance[0, 0], 1.0, rtol=1e-12)
    np.testing.assert_allclose(-compliance[0, 1] / compliance[0, 0], 1 / 3, rtol=1e-12)
    np.testing.assert_allclose(1 / compliance[2, 2], 0.375, rtol=1e-12)
    inner = mesh.triangles_per_edge == 2
    expected = 2 * film.youngs_modulus * film.thickness * math.sqrt(0.75) / 2
    np.testing.assert_allclose(mesh.spring_constants(film)[inner], expected, rtol=1e-12)


def test_alternating_diagonals_do_not_couple_stretch_and_shear_and_like_ones_do() -> None:
    mesh = Strip(6.0, 6.0, 6, 6).mesh()
    cell = [7 * i + j for i in (2, 3) for j in (2, 3)]
    alternating = np.linalg.inv(moduli(mesh, cell, 4.0, FILM))
    assert 1 / alternating[0, 0] == pytest.approx(0.98, abs=0.005)
    assert abs(alternating[0, 2]) < 1e-12
    index = np.arange(49).reshape(7, 7)
    a, b, c, d = (x.ravel() for x in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    alike = Mesh(mesh.reference, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))
    compliance = np.linalg.inv(moduli(alike, [16], 1.0, FILM))
    assert 1 / compliance[0, 0] == pytest.approx(0.82, abs=0.005)
    assert abs(compliance[0, 2]) > 0.1


BAD: list[tuple[dict[str, Any], type[Exception], str]] = [
    ({"reference": SQUARE[:, :2]}, MeshError, r"reference has shape \(4, 2\)"),
    ({"reference": []}, MeshError, "reference has shape"),
    ({"reference": np.empty((0, 3))}, MeshError, "no nodes"),
    ({"reference": [[0, 0, 0], [1, 0]]}, MeshError, "no regular array"),
    ({"reference": [["a", "b", "c"]]}, InputTypeError, "must hold numbers"),
    ({"reference": None}, InputTypeError, "must hold numbers"),
    ({"reference": SQUARE + 1j}, InputTypeError, "complex"),
    ({"reference": SQUARE > 0}, InputTypeError, "bool"),
    ({"triangles": []}, MeshError, "triangles is empty"),
    ({"triangles": TWO.astype(float)}, InputTypeError, "float64"),
    ({"triangles": [[0, 1]]}, MeshError, r"shape \(1, 2\)"),
    ({"triangles": [[0, 1, 4]]}, MeshError, r"triangles\[0, 2\] = 4 is no node; indices run from 0 to 3"),
    ({"triangles": [[0, 1, -1]]}, MeshError, "= -1 is no node"),
    ({"triangles": np.array([[0, 1, 2**64 - 1]], dtype=np.uint64)}, MeshError, "is no node"),
    ({"triangles": [[0, 1, 2**80]]}, InputTypeError, "object"),
    ({"triangles": [[0, 1, 1]]}, MeshError, "names a node twice"),
    ({"positions": SQUARE[:3]}, MeshError, "positions has 3 nodes and reference 4"),
    ({"positions": np.full((4, 3), np.inf)}, MeshError, "is not finite"),
    ({"creases": [[0, 1]]}, MeshError, "is an edge of 1 triangles"),
    ({"creases": [[1, 3]]}, MeshError, "is an edge of 0 triangles"),
    ({"creases": [[0, 2], [2, 0]]}, MeshError, "given twice"),
    ({"creases": [[0, 2, 1]]}, MeshError, r"shape \(1, 3\)"),
    ({"creases": [[0, 2]], "fold_angles": [1.0, 2.0]}, MeshError, "one angle for each crease"),
    ({"creases": [[0, 2]], "fold_angles": [180.0]}, MeshError, "outside -pi to pi"),
    ({"creases": [[0, 2]], "fold_angles": [np.nan]}, MeshError, "outside -pi to pi"),
    ({"fold_angles": [1.0]}, MeshError, "one angle for each crease"),
    ({"node_sets": {"a": [9]}}, MeshError, r"node_sets\['a'\]\[0\] = 9 is no node"),
    ({"node_sets": {"a": [1, 1]}}, MeshError, "twice"),
    ({"node_sets": {"a": [0.5]}}, InputTypeError, "whole numbers"),
    ({"node_sets": [1]}, InputTypeError, "dict"),
    ({"bridges": [[0, 0]]}, MeshError, "twice"),
    ({"bridges": [[0, 7]]}, MeshError, "is no node"),
]


@pytest.mark.parametrize(("values", "kind", "text"), BAD)
def test_bad_input_is_refused_by_name(values: dict[str, Any], kind: type[Exception], text: str) -> None:
    with pytest.raises(kind, match=text) as caught:
        Mesh(**({"reference": SQUARE, "triangles": TWO} | values))
    assert isinstance(caught.value, MembraneError)
    assert isinstance(caught.value, ValueError)


def test_one_nan_is_found_wherever_it_is() -> None:
    points = SQUARE.copy()
    points[2, 1] = np.nan
    with pytest.raises(MeshError, match=r"reference\[2\] = \[2.0, nan, 0.0\] is not finite \(1 such nodes\)"):
        Mesh(points, TWO)


def test_springs_refuse_a_triangle_without_area() -> None:
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])
    with pytest.raises(MeshError, match="1 of 1 triangles have no area, first triangle 0"):
        mesh.spring_constants(FILM)


def test_wrong_positions_are_refused_where_they_are_used() -> None:
    with pytest.raises(MeshError, match="positions"):
        Mesh(SQUARE, TWO).strain(SQUARE[:2])


SIZES = st.integers(1, 6)


@settings(max_examples=40, deadline=None)
@given(SIZES, SIZES, st.randoms(use_true_random=False), st.floats(1e-3, 10.0))
def test_any_numbering_of_a_sheet(columns: int, rows: int, random: Any, size: float) -> None:
    sheet = Strip(size, size, columns, rows).mesh()
    number = np.array(random.sample(range(sheet.node_count), sheet.node_count))
    points = np.empty_like(sheet.reference)
    points[number] = sheet.reference
    mesh = Mesh(points, number[sheet.triangles])
    edges = mesh.edges
    assert mesh.node_count - len(edges) + len(mesh.triangles) == 1
    assert (edges[:, 0] < edges[:, 1]).all()
    assert (np.diff(edges @ [mesh.node_count, 1]) > 0).all()
    assert len(mesh.boundary_edges) == 2 * (columns + rows)
    assert mesh.masses(FILM).sum() == pytest.approx(FILM.density * FILM.thickness * size**2)
    constants = mesh.spring_constants(FILM)
    swap = [tuple(sorted(number[pair])) for pair in sheet.edges]
    place = {tuple(pair): i for i, pair in enumerate(edges.tolist())}
    moved = constants[[place[int(a), int(b)] for a, b in swap]]
    np.testing.assert_allclose(moved, sheet.spring_constants(FILM), rtol=1e-9)


@settings(max_examples=60, deadline=None)
@given(
    hnp.arrays(np.float64, st.tuples(st.integers(0, 5), st.integers(2, 4)), elements=st.floats(width=64)),
    hnp.arrays(np.int64, st.tuples(st.integers(0, 4), st.integers(2, 4)), elements=st.integers(-2, 6)),
)
def test_any_arrays_make_a_mesh_or_a_clear_error(points: Any, triangles: Any) -> None:
    try:
        mesh = Mesh(points, triangles)
    except InputError as error:
        message = str(error)
    else:
        assert np.isfinite(mesh.reference).all()
        assert mesh.edges.max() < mesh.node_count
        return
    assert len(message) > 20


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("size", [1e70, 1e100, 1e152, 1e160, 1e300])
def test_triangles_too_large_for_an_area_are_refused_by_their_size(size: float) -> None:
    mesh = Mesh(SQUARE * size, TWO)
    found = mesh.audit(FILM).find("singular_springs")
    if size < 1e77:
        assert found is None
        assert mesh.masses(FILM).sum() == pytest.approx(2.0 * size * size * FILM.density * FILM.thickness)
        return
    words = f"too large for a number to hold their area, first triangle 0 .*reaches to {2.0 * size:g} m".replace(
        "+", "."
    )
    assert found is not None
    assert re.search(words, found.message)
    for refused in (mesh.masses, mesh.spring_constants):
        with pytest.raises(MeshError, match=words):
            refused(FILM)
