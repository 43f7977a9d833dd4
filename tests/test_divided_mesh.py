"""Meshes whose triangles are divided into smaller ones."""

from __future__ import annotations

import numpy as np
import pytest
from folding_cases import sheet, square_twist
from membrane_rs import InputError, InputTypeError, Mesh, MeshError
from membrane_rs.folding import SquareSail
from same_mesh import check_same


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_shape_strain_and_fold_angles_stay(count: int) -> None:
    mesh = sheet(1.2).mesh()
    fine = mesh.divided(count)
    assert len(fine.triangles) == count**2 * len(mesh.triangles)
    assert len(fine.edges) == count * len(mesh.edges) + 3 * len(mesh.triangles) * count * (count - 1) // 2
    assert np.abs(fine.strain()).max() < 1e-12
    np.testing.assert_allclose(fine.areas(), np.repeat(mesh.areas() / count**2, count**2), rtol=1e-12)
    assert fine.fold_angles.tolist() == np.repeat(mesh.fold_angles, count).tolist()
    assert fine.reference[: mesh.node_count].tobytes() == mesh.reference.tobytes()
    assert fine.audit().ok


def test_one_part_is_the_mesh_itself() -> None:
    mesh = sheet(1.2).mesh()
    check_same(mesh.divided(1), mesh)


def test_divided_twice_is_divided_by_the_product() -> None:
    mesh = square_twist()
    once, twice = mesh.divided(6), mesh.divided(2).divided(3)
    for one, two in ((once.reference, twice.reference), (once.reference[once.creases].mean(1),
                                                        twice.reference[twice.creases].mean(1))):  # fmt: skip
        order, other = (np.lexsort(np.round(points, 9).T) for points in (one, two))
        np.testing.assert_allclose(one[order], two[other], atol=1e-15)


def test_sets_take_what_lies_between() -> None:
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    sets = {"lower": [0, 1], "far": [1, 3]}
    mesh = Mesh(corners, [[0, 1, 2], [0, 2, 3]], creases=[[0, 2]], node_sets=sets, triangle_sets={"upper": [1]})
    fine = mesh.divided(4)
    assert fine.reference[fine.node_sets["lower"]][:, 0].tolist() == [0.0, 1.0, 0.25, 0.5, 0.75]
    assert fine.node_sets["far"].tolist() == [1, 3]
    inside = fine.reference[fine.triangles[fine.triangle_sets["upper"]]].mean(axis=1)
    assert len(inside) == 16
    assert (inside[:, 1] > inside[:, 0]).all()


def test_what_cannot_be_divided() -> None:
    mesh = sheet(1.2).mesh()
    with pytest.raises(InputError, match="count = 0: must be from 1 to 1,000"):
        mesh.divided(0)
    with pytest.raises(InputTypeError, match=r"count = 2\.5: must be a whole number"):
        mesh.divided(2.5)  # type: ignore[arg-type]
    with pytest.raises(MeshError, match=r"count = 1000.*take a smaller count"):
        sheet(1.2, 100, 100).mesh().divided(1000)
    with pytest.raises(MeshError, match="bridges, which join nodes"):
        SquareSail(rows=8, join="bridge").mesh().divided(2)
