"""The audit finds where a mesh is not joined, is folded over, or lies on itself; sound meshes have none of that."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from membrane_rs import Fixed, Mesh, Scene, SceneError, Springs
from membrane_rs.analysis.deployment import corner_nodes
from membrane_rs.folding import Disc, EquilateralLattice, SquareSail, Strip
from membrane_rs.material import Material
from small_scenes import RUBBER, Floats, rotation

NEW = {"duplicate_nodes", "hanging_nodes", "pinched_nodes", "long_bridges", "upside_down", "overlaps", "thick_film"}
SHEET = Strip(0.1, 0.04, 10, 4).mesh()


def kinds(mesh: Mesh, material: Material | None = None) -> dict[str, tuple[str, int]]:
    """Severity and count of each of the kinds that this file is about."""
    found = mesh.audit(material, springs=False).findings
    return {finding.kind: (finding.severity, finding.count) for finding in found if finding.kind in NEW}


def beside(shift: Any, triangles: Any = SHEET.triangles) -> Mesh:
    """Two sheets, the second of them moved by `shift` [m]."""
    points = np.vstack([SHEET.reference, SHEET.reference + np.asarray(shift)])
    return Mesh(points, np.vstack([SHEET.triangles, np.asarray(triangles) + SHEET.node_count]))


def turned(points: Floats) -> Floats:
    """The points turned and moved."""
    moved: Floats = np.asarray(points) @ rotation([1.0, 2.0, 3.0], 0.7).T + np.array([0.3, -0.2, 5.0])
    return moved


@pytest.mark.parametrize(
    "mesh",
    [
        SHEET,
        Disc(0.1, rings=6).mesh(),
        EquilateralLattice(0.01, columns=9, rows=7).mesh(),
        SquareSail().mesh(),
        SquareSail(rows=32).mesh(),
        SquareSail(layout="fan").mesh(),
        SquareSail(layout="even", join="bridge").mesh(),
    ],
    ids=str,
)
def test_sound_meshes_have_none_of_these(mesh: Mesh) -> None:
    assert kinds(mesh, Material(3.2e9, 0.34, 1420.0, 7.5e-6)) == {}
    assert kinds(Mesh(turned(mesh.reference), mesh.triangles, bridges=mesh.bridges)) == {}


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("off", [0.0, 1e-9, 3e-6])
def test_a_node_in_the_middle_of_an_edge(off: float, scale: float) -> None:
    points = [[0, 0, 0], [0.1, 0, 0], [0.05, 0.08, 0], [0.05, -off, 0], [0.02, -0.05, 0], [0.08, -0.05, 0]]
    triangles = [[0, 1, 2], [0, 4, 3], [3, 4, 5], [3, 5, 1]]
    mesh = Mesh(turned(scale * np.array(points)), triangles)
    assert kinds(mesh)["hanging_nodes"] == ("warning", 1)
    found = mesh.audit().find("hanging_nodes")
    assert found is not None
    assert found.where == (3,)
    assert "the edge of nodes [0, 1]" in found.message
    split = Mesh(mesh.reference, [[0, 3, 2], [3, 1, 2], *triangles[1:]])
    assert "hanging_nodes" not in kinds(split)


@pytest.mark.parametrize("width", [0.0, 1e-13, 1e-10, 1e-8, 1e-6])
def test_a_slit_of_any_width(width: float) -> None:
    found = kinds(beside([0.1 + width, 0.0, 0.0]))
    assert found["duplicate_nodes"] == ("warning", 5)
    assert "pinched_nodes" not in found
    assert "duplicate_nodes" not in kinds(beside([0.11, 0.0, 0.0]))


def test_a_bow_tie() -> None:
    points = [[0.0, 0, 0], [0.1, 0.1, 0], [0.1, -0.1, 0], [-0.1, 0.1, 0], [-0.1, -0.1, 0]]
    mesh = Mesh(points, [[0, 2, 1], [0, 3, 4]])
    assert kinds(mesh) == {"pinched_nodes": ("warning", 1)}
    found = mesh.audit().find("pinched_nodes")
    assert found is not None
    assert found.where == (0,)
    joined = Mesh(points, [[0, 2, 1], [0, 3, 4], [0, 1, 3]])
    assert "pinched_nodes" not in kinds(joined)


def test_a_pinched_node_among_triangles_wound_in_both_senses() -> None:
    mixed = SHEET.triangles.copy()
    mixed[::3] = mixed[::3, ::-1]
    assert "pinched_nodes" not in kinds(Mesh(SHEET.reference, mixed))
    points = np.vstack([SHEET.reference, SHEET.reference[1] + [[0.0, 0.0, 1.0], [0.0, 0.01, 1.0]]])
    one = SHEET.triangles.copy()
    one[2] = one[2, ::-1]
    assert 1 in one[2]
    found = Mesh(points, np.vstack([one, [[1, 55, 56]]])).audit().find("pinched_nodes")
    assert found is not None
    assert found.where == (1,)


def test_triangles_upside_down_in_a_flat_reference() -> None:
    apart = beside([0.2, 0.0, 0.0], SHEET.triangles[:, ::-1])
    assert kinds(apart) == {"upside_down": ("warning", len(SHEET.triangles))}
    one = SHEET.triangles.copy()
    one[7] = one[7, ::-1]
    assert kinds(Mesh(turned(SHEET.reference), one)) == {"upside_down": ("warning", 1)}
    # Among triangles of both senses, one that lies under others is not thereby folded over.
    both = beside([0.0303, 0.0071, 0.0])
    mixed = both.triangles.copy()
    covered = both.audit(springs=False).find("overlaps")
    assert covered is not None
    k = covered.where[0]
    mixed[k] = mixed[k, ::-1]
    assert kinds(Mesh(both.reference, mixed))["upside_down"] == ("warning", 1)
    points = SHEET.reference.copy()
    inner = np.flatnonzero(np.isclose(points[:, 0], 0.05) & np.isclose(points[:, 1], 0.0))[0]
    points[inner, 0] += 0.014
    found = kinds(Mesh(points, SHEET.triangles))
    assert found["upside_down"][0] == "error"


def test_sheets_that_lie_on_each_other() -> None:
    found = kinds(beside([0.0303, 0.0071, 0.0]))
    assert found["overlaps"][0] == "warning"
    assert found["overlaps"][1] > 40
    lifted = beside([0.0303, 0.0071, 0.01])
    assert "overlaps" not in kinds(lifted)


def test_bridges_between_nodes_that_lie_apart() -> None:
    for gap, count in ((1e-12, 0), (1e-5, 0), (0.01, 5)):
        mesh = beside([0.1 + gap, 0.0, 0.0])
        ends = np.flatnonzero(np.isclose(SHEET.reference[:, 0], 0.1))
        starts = np.flatnonzero(np.isclose(SHEET.reference[:, 0], 0.0)) + SHEET.node_count
        bridged = Mesh(mesh.reference, mesh.triangles, bridges=np.stack([ends, starts], axis=1))
        assert kinds(bridged) == ({"long_bridges": ("warning", count)} if count else {})


def test_a_film_thicker_than_its_edges_are_long() -> None:
    thick = Material(1e6, 0.3, 1000.0, 0.012)
    found = kinds(SHEET, thick)["thick_film"]
    assert found == ("warning", int((SHEET.edge_lengths < 0.012).sum()))
    assert "thick_film" not in kinds(SHEET, RUBBER)


def test_an_unused_node_is_no_corner_and_the_remedy_says_how_to_remove_it() -> None:
    mesh = Mesh(np.vstack([SHEET.reference, [[9.0, 9.0, 0.0]]]), SHEET.triangles, node_sets=SHEET.node_sets)
    with pytest.raises(SceneError, match="belongs to no triangle; remove it from the mesh"):
        Scene(mesh, RUBBER, [Springs()])
    held = Scene(mesh, RUBBER, [Springs()], [Fixed((SHEET.node_count,))])
    assert corner_nodes(held.assemble()).tolist() == corner_nodes(SHEET).tolist()
    found = mesh.audit().find("unused_nodes")
    assert found is not None
    assert "numpy.searchsorted(used, triangles)" in found.remedy
    used = np.unique(mesh.triangles)
    mended = Mesh(mesh.reference[used], np.searchsorted(used, mesh.triangles))
    assert mended.audit().find("unused_nodes") is None


@settings(max_examples=150, deadline=None)
@given(
    hnp.arrays(np.float64, (7, 3), elements=st.sampled_from([0.0, 0.5, 1.0, 3.0, 1e-200, 1e9, 1e160])),
    st.lists(st.permutations(range(7)), min_size=1, max_size=12),
    st.lists(st.permutations(range(7)), max_size=6),
)
def test_no_mesh_with_bridges_makes_the_audit_fail(points: Any, orders: Any, links: Any) -> None:
    bridges = np.array([link[:2] for link in links], dtype=np.int64).reshape(-1, 2)
    with np.errstate(all="ignore"):
        audit = Mesh(points, [order[:3] for order in orders], bridges=bridges).audit()
    assert audit.ok == ("error:" not in str(audit))
