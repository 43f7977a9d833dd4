"""The square sail: its counts, its mesh, and a stowed shape without strain, in layers that do not cross."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from membrane_rs.errors import InputError, InputTypeError, MeshError
from membrane_rs.folding import SquareSail
from membrane_rs.material import Material
from membrane_rs.mesh import Mesh, net_moduli

TABLE_2 = {"masses": 1980, "springs": 5432, "elements": 3456}
TETHERS = {"masses": 4 * 19, "springs": 4 * 19, "elements": 0}
FILM = Material(3.2e9, 0.34, 1420.0, 7.5e-6)


def rate(sail: SquareSail, mesh: Mesh) -> float:
    corners = mesh.positions[mesh.node_sets["corners"]]
    return float(np.hypot(corners[:, 0], corners[:, 1]).mean() / sail.flat_corner_radius)


def fold_angles(mesh: Mesh) -> np.ndarray:
    """Fold angle of each crease in the stowed positions [rad], in the sign of the FOLD format."""
    sides = {tuple(t[[i, (i + 1) % 3]].tolist()): k for k, t in enumerate(mesh.triangles) for i in range(3)}
    x, t = mesh.positions, mesh.triangles
    normal = np.cross(x[t[:, 1]] - x[t[:, 0]], x[t[:, 2]] - x[t[:, 0]])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    angles = []
    for a, b in mesh.creases.tolist():
        left, right = normal[sides[a, b]], normal[sides[b, a]]
        along = (x[b] - x[a]) / np.linalg.norm(x[b] - x[a])
        angles.append(-math.atan2(np.cross(left, right) @ along, left @ right))
    return np.array(angles)


@pytest.mark.parametrize("fold_lines", [7, 3])
def test_counts_of_the_two_models(fold_lines: int) -> None:
    counts = SquareSail(fold_lines=fold_lines).counts()
    assert {name: counts[name] + TETHERS[name] for name in counts} == TABLE_2
    assert counts == {"masses": 4 * 476, "springs": 4 * 1339, "elements": 4 * 864}


@pytest.mark.parametrize("layout", ["ruled", "equilateral"])
def test_a_flat_sail_starts_as_it_is_cut(layout: Any) -> None:
    stowed, sail = SquareSail(layout=layout), SquareSail(layout=layout, stowage="flat")
    flat = sail.mesh()
    assert (flat.positions == stowed.mesh().reference).all()
    assert (flat.creases == stowed.mesh().creases).all()
    assert not flat.fold_angles.any()
    assert "guide_bars" not in flat.node_sets
    assert (sail.facts(), sail.turns, sail.corner_turn, sail.cord_path(flat.reference[0])) == ({}, None, 0.0, None)


@pytest.mark.parametrize("layout", ["fan", "even"])
def test_counts_of_the_other_layouts(layout: Any) -> None:
    assert SquareSail(layout=layout).counts() == TABLE_2


@pytest.mark.parametrize("layout", ["ruled", "equilateral", "fan", "even"])
def test_counts_are_those_of_the_mesh(layout: Any) -> None:
    columns = None if layout == "equilateral" else 7
    sail = SquareSail(layout=layout, join="bridge", fold_lines=4, columns=columns)
    mesh = sail.mesh()
    found = {"masses": mesh.node_count, "springs": len(mesh.edges), "elements": len(mesh.triangles)}
    assert found == sail.counts()


def test_joined_petals() -> None:
    merged, bridged = SquareSail().mesh(), SquareSail(join="bridge").mesh()
    assert (merged.node_count, len(merged.edges), len(merged.creases)) == (1904 - 68, 5356 - 64, 756)
    assert len(merged.bridges) == 0
    assert len(bridged.bridges) == 68
    for points in (bridged.reference, bridged.positions):
        assert (points[bridged.bridges[:, 0]] == points[bridged.bridges[:, 1]]).all()
    on_diagonals = np.abs(np.abs(merged.reference[:, 0]) - np.abs(merged.reference[:, 1])) < 1e-12
    assert set(np.flatnonzero(on_diagonals)) == set(merged.node_sets["diagonals"])
    assert len(merged.boundary_edges) == 4 * (11 + 11 + 2 * 16)


def test_the_flat_mesh_is_sound() -> None:
    mesh = SquareSail().mesh()
    x, t = mesh.reference, mesh.triangles
    assert (np.cross(x[t[:, 1]] - x[t[:, 0]], x[t[:, 2]] - x[t[:, 0]])[:, 2] > 0).all()
    assert mesh.areas().sum() == pytest.approx(0.455**2 - 0.103**2, rel=1e-12)
    assert mesh.audit().find("obtuse") is None
    assert mesh.spring_constants(FILM).min() > 0
    assert (x[:, 2] == 0).all()


def test_node_sets() -> None:
    sail = SquareSail()
    mesh = sail.mesh()
    for name, radius in (("corners", 0.455 / math.sqrt(2)), ("inner_corners", 0.103 / math.sqrt(2))):
        for points in (mesh.reference, mesh.positions):
            nodes = points[mesh.node_sets[name]]
            azimuth = np.degrees(np.arctan2(nodes[:, 1], nodes[:, 0])) % 360
            np.testing.assert_allclose(azimuth, [45, 135, 225, 315], atol=1e-9)
        nodes = mesh.reference[mesh.node_sets[name]]
        np.testing.assert_allclose(np.hypot(nodes[:, 0], nodes[:, 1]), radius, rtol=1e-12)
    petals = [mesh.node_sets[f"petal-{p}"] for p in range(4)]
    assert [len(petal) for petal in petals] == [476] * 4
    assert len(np.unique(np.concatenate(petals))) == mesh.node_count
    middle = mesh.reference[petals[1]].mean(axis=0)
    assert middle[1] > 0.1
    assert abs(middle[0]) < 1e-12
    held = mesh.positions[mesh.node_sets["guide_bars"]]
    assert np.hypot(held[:, 0], held[:, 1]).max() < 0.035
    assert len(held) == 4 * 17 * 4


@pytest.mark.parametrize(
    ("dimensions", "bound"),
    [
        ({}, 2e-4),
        ({"fold_lines": 3}, 1e-4),
        ({"fold_lines": 0}, 1e-4),
        ({"fold_lines": 1}, 2e-4),
        ({"fold_lines": 5}, 2e-4),
        ({"fold_lines": 9}, 3e-4),
        ({"fold_lines": 15}, 4e-4),
        ({"fold_lines": 31}, 6e-4),
        ({"rows": 8}, 2e-4),
        ({"rows": 32}, 2e-4),
        ({"rows": 64}, 2e-4),
        ({"layer_gap": 20e-6, "diagonal_gap": 10e-6}, 5e-4),
        ({"layer_gap": 0.0, "diagonal_gap": 0.0}, 1e-12),
        ({"outer_width": 10.0, "inner_width": 1.0, "spool_radius": 0.2, "fillet_radius": 0.02}, 5e-4),
        ({"columns": 12}, 2e-4),
        ({"columns": 40}, 1e-3),
    ],
)
def test_the_stowed_sail_is_nearly_free_of_strain(dimensions: dict[str, Any], bound: float) -> None:
    sail = SquareSail(**dimensions)
    assert np.abs(sail.mesh().strain()).max() < bound


def test_strain_is_that_of_the_layers() -> None:
    most = [np.abs(SquareSail(layer_gap=g, diagonal_gap=g / 2).mesh().strain()).max() for g in (5e-6, 1e-5)]
    assert most[1] / most[0] == pytest.approx(2.0, rel=0.01)


@pytest.mark.parametrize("fold_lines", [7, 3])
def test_corners_start_where_the_cross_ends(fold_lines: int) -> None:
    sail = SquareSail(fold_lines=fold_lines)
    assert rate(sail, sail.mesh()) == pytest.approx(0.734, abs=0.001)


@pytest.mark.parametrize("layout", ["fan", "even"])
def test_the_other_layouts_start_below_the_strain_limit(layout: Any) -> None:
    strain = SquareSail(layout=layout).mesh().strain()
    assert strain.min() > -0.035
    assert strain.max() < 5e-4


@pytest.mark.parametrize("dimensions", [{}, {"fold_lines": 3}, {"rows": 8}, {"rows": 24}, {"rows": 32}])
def test_equilateral_triangles_but_for_the_slanted_sides(dimensions: dict[str, Any]) -> None:
    sail = SquareSail(layout="equilateral", **dimensions)
    mesh = sail.mesh()
    x, t = mesh.reference, mesh.triangles
    assert (np.cross(x[t[:, 1]] - x[t[:, 0]], x[t[:, 2]] - x[t[:, 0]])[:, 2] > 0).all()
    assert mesh.areas().sum() == pytest.approx(0.455**2 - 0.103**2, rel=1e-12)
    assert mesh.spring_constants(FILM).min() > 0
    side = 2.0 / math.sqrt(3.0) * sail.row_height
    lengths = mesh.edge_lengths[mesh.triangle_edges]
    is_regular = (np.abs(lengths - side) < 1e-9 * side).all(axis=1)
    assert is_regular.mean() > 1.0 - 8.0 / sail.rows_per_strip / sail.strips
    # No edge is stretched; those along the rows cut the turns short.
    strain = mesh.lengths_in(mesh.positions) / mesh.edge_lengths - 1.0
    assert strain.max() < 2e-4
    assert strain.min() > -0.2
    # Fold lines lie on rows: all creases of a petal, two rows on the inner half and so on.
    assert len(np.unique(mesh.creases)) > 4 * sail.fold_lines


@pytest.mark.parametrize("rows", [1, 2, 3, 9])
@pytest.mark.parametrize("inner", [0.01, 0.05, 0.1, 0.2])
def test_equilateral_rows_may_be_higher_than_the_inner_edge_is_long(inner: float, rows: int) -> None:
    sail = SquareSail(
        0.4,
        inner,
        fold_lines=rows - 1,
        rows=rows,
        layout="equilateral",
        spool_radius=inner / 9,
        fillet_radius=inner / 50,
    )
    mesh = sail.mesh()
    x, t = mesh.reference, mesh.triangles
    assert (np.cross(x[t[:, 1]] - x[t[:, 0]], x[t[:, 2]] - x[t[:, 0]])[:, 2] > 0).all()
    assert mesh.areas().sum() == pytest.approx(0.4**2 - inner**2, rel=1e-12)


def test_the_equilateral_sail_is_the_film_where_the_papers_is_soft_in_shear() -> None:
    plain, equilateral = (net_moduli(SquareSail(layout=layout).mesh(), FILM) for layout in ("ruled", "equilateral"))
    assert float(plain.shear_modulus()) == pytest.approx(0.544, abs=1e-3)
    assert float(equilateral.shear_modulus()) == pytest.approx(0.99, abs=0.01)
    assert min(equilateral.extremes) > 0.97


def test_stowed_heights_and_clearance() -> None:
    mesh = SquareSail().mesh()
    distance = np.abs(mesh.reference[:, :2]).max(axis=1)
    line = (distance - 0.0515) / 0.022
    expected = 0.022 * (1 - np.abs(line % 2 - 1))
    np.testing.assert_allclose(mesh.positions[:, 2], expected, atol=1e-15)
    assert np.hypot(mesh.positions[:, 0], mesh.positions[:, 1]).min() >= 0.025 - 1e-12


@pytest.mark.parametrize("layout", ["ruled", "equilateral"])
@pytest.mark.parametrize("join", ["merge", "bridge"])
def test_four_fold_and_mirror_symmetry_to_the_last_bit(join: Any, layout: Any) -> None:
    mesh = SquareSail(join=join, layout=layout, fold_lines=3).mesh()
    place = {tuple(r): tuple(p) for r, p in zip(mesh.reference, mesh.positions, strict=True)}
    for (x, y, z), (u, v, w) in place.items():
        assert place[-y, x, z] == (-v, u, w)
        assert place[x, -y, z] == (u, -v, w)


@pytest.mark.parametrize("fold_lines", [7, 3, 2])
def test_mountains_and_valleys_are_those_of_the_stowed_shape(fold_lines: int) -> None:
    mesh = SquareSail(fold_lines=fold_lines, layer_gap=2e-4).mesh()
    angles = fold_angles(mesh)
    assert (np.sign(angles) == np.sign(mesh.fold_angles)).all()
    assert (np.abs(angles) > 3.0).all()
    assert (np.abs(mesh.fold_angles) == math.pi).all()
    line = np.rint((np.abs(mesh.reference[mesh.creases[:, 0], :2]).max(axis=1) - 0.0515) / 0.176 * (fold_lines + 1))
    assert (mesh.fold_angles[line % 2 == 1] < 0).all()
    assert (mesh.fold_angles[line % 2 == 0] > 0).all()


@pytest.mark.parametrize("dimensions", [{}, {"fold_lines": 3}, {"rows": 32}, {"fold_lines": 15}])
def test_layers_lie_in_order_and_inside_their_half(dimensions: dict[str, Any]) -> None:
    """In each column rows lie outward of the one before, from the spool and from the diagonal plane."""
    mesh = SquareSail(**dimensions).mesh()
    petal = mesh.node_sets["petal-0"]
    flat, stowed = mesh.reference[petal], mesh.positions[petal]
    held = np.isin(petal, mesh.node_sets["guide_bars"])
    upper = flat[:, 1] > 0
    across = (stowed[:, 0] - stowed[:, 1]) / math.sqrt(2)
    assert across[upper].min() >= 0.0
    for y in np.unique(flat[upper, 1]):
        column = np.flatnonzero(flat[:, 1] == y)
        column = column[np.argsort(flat[column, 0])]
        if held[column].all():
            assert (np.diff(np.hypot(stowed[column, 0], stowed[column, 1])) > 0).all()
        elif not held[column].any():
            assert (np.diff(across[column]) > 0).all()


def test_the_same_sail_twice_is_the_same_to_the_last_bit() -> None:
    assert (SquareSail().mesh().positions == SquareSail().mesh().positions).all()


BAD: list[tuple[dict[str, Any], type[Exception], str]] = [
    (
        {"outer_width": 0.1},
        MeshError,
        "SquareSail.outer_width = 0.1: must be greater than inner_width = 0.103",
    ),
    ({"outer_width": -1.0}, InputError, "must be greater than 0"),
    ({"inner_width": float("nan")}, InputError, "must be finite"),
    ({"fold_lines": -1}, InputError, "must be at least 0"),
    ({"fold_lines": 2.5}, InputTypeError, "must be a whole number"),
    ({"fold_lines": True}, InputTypeError, "must be a whole number"),
    ({"fold_lines": 10**9}, MeshError, "do not fit"),
    ({"rows": 15}, MeshError, "rows = 15: must be a multiple of 8 .* take 16"),
    ({"columns": 0}, InputError, "must be at least 1"),
    ({"columns": 1}, MeshError, "take more columns"),
    ({"layout": "equilateral", "columns": 9}, MeshError, 'columns = 9: the layout "equilateral" has none to choose'),
    ({"layout": "spiral"}, InputError, "layout"),
    ({"inner_width": 0.03}, MeshError, "half of inner_width, 0.015 m, is too short to go round the spool"),
    ({"spool_radius": 0.1}, MeshError, "half of inner_width, 0.0515 m"),
    ({"fillet_radius": 5e-5}, MeshError, "no room for layers that take 6e-05 m"),
    ({"fillet_radius": 0.1}, MeshError, "leaves no arc"),
    ({"layer_gap": -1e-6}, InputError, "must be at least 0"),
    ({"colums": 11}, InputTypeError, "did you mean 'columns'"),
]


@pytest.mark.parametrize(("dimensions", "kind", "text"), BAD)
def test_dimensions_that_do_not_go_together(dimensions: dict[str, Any], kind: type[Exception], text: str) -> None:
    with pytest.raises(kind, match=text):
        SquareSail(**dimensions).mesh()


@st.composite
def sails(draw: st.DrawFn) -> dict[str, Any]:
    inner = draw(st.floats(0.06, 0.3))
    return {
        "outer_width": inner + draw(st.floats(0.01, 0.4)),
        "inner_width": inner,
        "fold_lines": draw(st.integers(0, 9)),
        "layout": draw(st.sampled_from(["ruled", "equilateral", "fan", "even"])),
        "join": draw(st.sampled_from(["merge", "bridge"])),
        "spool_radius": draw(st.floats(0.01, 0.04)),
    }


@settings(max_examples=40, deadline=None)
@given(sails())
def test_any_dimensions_make_a_sail_or_a_clear_error(dimensions: dict[str, Any]) -> None:
    message = ""
    try:
        sail = SquareSail(**dimensions)
        mesh = sail.mesh()
    except MeshError as error:
        message = str(error)
    if message:
        assert "make" in message or "take" in message
        return
    assert mesh.areas().sum() == pytest.approx(sail.outer_width**2 - sail.inner_width**2)
    assert np.isfinite(mesh.positions).all()
    assert mesh.triangles_per_edge.max() == 2
    if sail.join == "merge":
        assert sail.counts()["masses"] - mesh.node_count == len(mesh.node_sets["diagonals"])
    if sail.layout == "ruled" and sail.outer_width - sail.inner_width > 0.1:
        assert np.abs(mesh.strain()).max() < 1e-3
