"""The audit finds what was done to a sound mesh, and nothing in the sound mesh."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from membrane_rs.errors import InputTypeError
from membrane_rs.folding import SquareSail, Strip
from membrane_rs.material import Material
from membrane_rs.mesh import Mesh
from membrane_rs.mesh.findings import Audit, Finding

SHEET = Strip(1.0, 0.5, 4, 2, creases=(0.5,)).mesh()


def test_a_sound_mesh_has_no_errors_and_no_warnings() -> None:
    audit = SHEET.audit()
    assert audit.ok
    assert [finding.kind for finding in audit.findings] == ["strain"]
    assert str(audit).startswith("no errors, no warnings\ninfo: strain at the start from 0 % to 0 %")


def found_in(audit: Audit, kind: str) -> Finding:
    finding = audit.find(kind)
    assert finding is not None
    return finding


def wedge(angle: float) -> Mesh:
    """One triangle with two sides of 1 m and this angle between them [degrees]."""
    half = np.radians(angle / 2)
    return Mesh(np.array([[np.sin(half), 0, 0], [0, np.cos(half), 0], [-np.sin(half), 0, 0]]), [[0, 1, 2]])


def kinds(mesh: Mesh) -> dict[str, tuple[str, int]]:
    return {finding.kind: (finding.severity, finding.count) for finding in mesh.audit().findings}


def test_a_material_that_is_none() -> None:
    with pytest.raises(InputTypeError, match="material = 3: must be a Material"):
        Strip(0.1, 0.02, 4, 1).mesh().audit(3)  # type: ignore[arg-type]


def test_unused_nodes() -> None:
    mesh = Mesh(np.vstack([SHEET.reference, [[9, 9, 9], [8, 8, 8]]]), SHEET.triangles)
    assert kinds(mesh)["unused_nodes"] == ("error", 2)
    assert found_in(mesh.audit(), "unused_nodes").where == (15, 16)
    assert "pieces" not in kinds(mesh)


def test_duplicate_nodes_unless_bridged_and_pieces() -> None:
    points = np.vstack([SHEET.reference, SHEET.reference + np.array([1.0 + 1e-13, 0, 0])])
    triangles = np.vstack([SHEET.triangles, SHEET.triangles + 15])
    found = kinds(Mesh(points, triangles))
    assert found["duplicate_nodes"] == ("warning", 3)
    assert found["pieces"] == ("warning", 2)
    bridges = np.stack([SHEET.node_sets["end"], SHEET.node_sets["start"] + 15], axis=1)
    assert kinds(Mesh(points, triangles, bridges=bridges)).keys() == {"strain"}


def test_duplicate_triangles_and_shared_edges() -> None:
    mesh = Mesh(SHEET.reference, np.vstack([SHEET.triangles, SHEET.triangles[:1, [1, 2, 0]]]))
    assert kinds(mesh)["duplicate_triangles"] == ("error", 1)
    assert kinds(mesh)["shared_edges"][0] == "warning"


def test_winding_is_an_error_at_a_crease_only() -> None:
    triangles = SHEET.triangles.copy()
    triangles[0] = triangles[0, ::-1]
    assert kinds(Mesh(SHEET.reference, triangles))["winding"][0] == "warning"
    on_crease = np.flatnonzero(np.isin(SHEET.triangles, SHEET.creases[0]).sum(axis=1) == 2)[0]
    triangles = SHEET.triangles.copy()
    triangles[on_crease] = triangles[on_crease, ::-1]
    assert kinds(Mesh(SHEET.reference, triangles, creases=SHEET.creases))["winding"][0] == "error"


def test_triangles_without_area_and_slivers() -> None:
    line = Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])
    assert kinds(line)["degenerate"] == ("error", 1)
    same = Mesh(np.zeros((3, 3)), [[0, 1, 2]])
    assert kinds(same)["degenerate"] == ("error", 1)
    thin = Mesh([[0.0, 0, 0], [1.0, 0, 0], [0.0, 0.01, 0]], [[0, 1, 2]])
    assert kinds(thin)["degenerate"] == ("warning", 1)


def test_strain_at_the_start() -> None:
    assert found_in(SHEET.audit(positions=1.001 * SHEET.reference), "strain").severity == "info"
    assert found_in(SHEET.audit(positions=1.02 * SHEET.reference), "strain").severity == "warning"
    assert not SHEET.audit(positions=1.2 * SHEET.reference).ok


def test_obtuse_triangles_with_a_negative_spring() -> None:
    for angle, negative in ((91.0, False), (126.0, True)):
        mesh = wedge(angle)
        found = found_in(mesh.audit(), "obtuse")
        assert f"{angle:.1f} degrees" in found.message
        assert (mesh.audit().find("negative_springs") is not None) == negative


def test_signs_depend_on_poissons_ratio() -> None:
    mesh = wedge(110.0)
    constants = {nu: mesh.spring_constants(Material(1.0, nu, 1.0, 1.0)).min() for nu in (0.1, 0.45)}
    for nu, least in constants.items():
        found = mesh.audit(Material(1.0, nu, 1.0, 1.0)).find("negative_springs")
        assert (found is not None) == (least < 0)


@pytest.mark.parametrize(
    ("layout", "join", "negative", "boundary"),
    [("fan", "merge", 664, 0), ("even", "merge", 32, 0), ("even", "bridge", 64, 64)],
)
def test_the_unsound_layouts(layout: Any, join: Any, negative: int, boundary: int) -> None:
    audit = SquareSail(layout=layout, join=join).mesh().audit()
    assert not audit.ok
    springs = found_in(audit, "negative_springs")
    assert springs.count == negative
    assert f"{boundary} of them on the boundary" in springs.message
    growing = found_in(audit, "growing_mode")
    if layout == "even":
        assert growing.count == 1
        assert "in 0.543 ms" in growing.message
    else:
        assert growing.count == 178


def test_growing_modes_agree_with_a_dense_solver() -> None:
    from membrane_rs.mesh import growing_modes

    mesh = SquareSail(layout="fan", rows=4, columns=20, fold_lines=3).mesh()
    film = Material(3.2e9, 0.34, 1420.0, 7.5e-6)
    values = (mesh.reference, mesh.edges, mesh.spring_constants(film), mesh.masses(film))
    sparse = growing_modes.growing_modes(*values)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(growing_modes, "_DENSE", 10**6)
        dense = growing_modes.growing_modes(*values)
    assert sparse[0] == pytest.approx(dense[0], rel=1e-6)
    assert sparse[1] == dense[1] > 1


def test_the_default_sail_is_sound() -> None:
    audit = SquareSail().mesh().audit()
    assert [finding.kind for finding in audit.findings] == ["strain"]
    assert found_in(audit, "strain").severity == "info"


@settings(max_examples=80, deadline=None)
@given(
    hnp.arrays(np.float64, (6, 3), elements=st.sampled_from([0.0, 0.5, 1.0, 3.0, 1e-200, 1e9])),
    st.lists(st.permutations(range(6)), min_size=1, max_size=8),
)
def test_the_audit_of_any_mesh_tells_and_never_fails(points: Any, orders: Any) -> None:
    audit = Mesh(points, [order[:3] for order in orders]).audit()
    for finding in audit.findings:
        assert finding.message
        assert finding.remedy or finding.severity == "info"
        assert len(finding.where) <= 10
    assert audit.ok == ("error:" not in str(audit))
