"""FOLD files as other programs write them: units, frames, polygons, edges without faces, cuts, missing angles."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fold_specification import check_specification, frames_of
from membrane_rs import Mesh, MeshError
from membrane_rs.folding import Disc, SquareSail, Strip
from membrane_rs.mesh import read_fold
from same_mesh import check_same
from small_scenes import refused

Table = dict[str, Any]
SQUARE: Table = {
    "file_spec": 1.1, "file_creator": "A drawing program", "frame_classes": ["creasePattern"], "frame_unit": "mm",
    "vertices_coords": [[0, 0], [455, 0], [455, 455], [0, 455]],
    "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]], "edges_assignment": ["B", "B", "B", "B", "V"],
    "faces_vertices": [[0, 1, 2], [0, 2, 3]], "drawing:page": {"xMin": 0}, "vertices_later": [0, 0, 0, 0],
}  # fmt: skip
FOLDED: Table = {
    "frame_classes": ["foldedForm"], "frame_parent": 0, "frame_inherit": True,
    "vertices_coords": [[0, 0, 0], [455, 0, 0], [455, 455, 0], [227.5, 227.5, 227.5 * 2**0.5]],
}  # fmt: skip
GRID: Table = {
    "vertices_coords": [[i, j] for j in range(3) for i in range(3)],
    "edges_vertices": [
        *([3 * j + i, 3 * j + i + 1] for j in range(3) for i in range(2)),
        *([3 * j + i, 3 * j + i + 3] for j in range(2) for i in range(3)),
    ],
}  # fmt: skip
"""Four squares, without assignments: edges 2 and 3 lie in the middle row."""


def written(folder: Path, table: Table, **values: Any) -> Path:
    """The file of a table, some of whose values are others; None leaves a key out."""
    path = folder / "pattern.fold"
    merged = {key: value for key, value in {**copy.deepcopy(table), **values}.items() if value is not None}
    path.write_text(json.dumps(merged), encoding="utf-8")
    return path


def area(mesh: Mesh) -> float:
    """Of the film [m2]."""
    return float(mesh.areas().sum())


@pytest.mark.parametrize(
    ("unit", "metres"), [("m", 455.0), ("cm", 4.55), ("mm", 0.455), ("um", 455e-6), ("nm", 455e-9), ("in", 11.557)]
)
def test_units_become_metres_to_the_bit(unit: str, metres: float, tmp_path: Path) -> None:
    mesh = Mesh.load(written(tmp_path, SQUARE, frame_unit=unit))
    assert mesh.reference[2].tolist() == [metres, metres, 0.0]
    assert mesh.creases.tolist() == [[0, 2]]
    assert mesh.fold_angles.tolist() == [np.pi]


def test_points_and_scales(tmp_path: Path) -> None:
    assert Mesh.load(written(tmp_path, SQUARE, frame_unit="pt")).reference[1, 0] == pytest.approx(455 / 72 * 0.0254)
    for unit in (None, "unit", "furlong"):
        path = written(tmp_path, SQUARE, frame_unit=unit)
        assert read_fold(path, scale=2e-3).reference[1, 0] == pytest.approx(0.91)
        words = 'frame 0: frame_unit.*; give the unit, scale = "mm", or its length in metres'
        refused(lambda path=path: read_fold(path), MeshError, words)  # type: ignore[misc]
        assert Mesh.read(path, scale="cm").reference[1, 0] == pytest.approx(4.55)


def test_files_of_version_1_have_old_keys(tmp_path: Path) -> None:
    lengths = [455.0, 455.0, 455.0, 455.0, 455.0 * 2**0.5]
    old = {"edges_foldAngles": [0, 0, 0, 0, 170.0], "edges_lengths": lengths}
    assert Mesh.load(written(tmp_path, SQUARE, file_spec=1, **old)).fold_angles[0] == np.radians(170.0)


def test_a_folded_form_gives_positions_and_the_angles_that_they_show(tmp_path: Path) -> None:
    path = written(tmp_path, SQUARE, file_frames=[FOLDED], edges_foldAngle=[0, 0, 0, 0, 180])
    mesh = Mesh.load(path)
    np.testing.assert_allclose(mesh.positions[3], [0.2275, 0.2275, 0.2275 * 2**0.5])
    assert mesh.fold_angles[0] == pytest.approx(np.pi / 2)
    np.testing.assert_allclose(mesh.strain(), 0.0, atol=1e-12)
    assert read_fold(path, frame=0).fold_angles[0] == np.pi


def test_a_folded_form_alone_is_the_film_without_strain(tmp_path: Path) -> None:
    table = {**SQUARE, **FOLDED}
    mesh = Mesh.load(written(tmp_path, table, frame_parent=None, frame_inherit=None))
    assert (mesh.positions == mesh.reference).all()
    assert mesh.fold_angles[0] == pytest.approx(np.pi / 2)
    mesh.save(tmp_path / "again.fold")
    again = frames_of(tmp_path / "again.fold")
    assert len(again) == 1
    check_specification(again[0])
    assert again[0]["frame_classes"] == ["foldedForm"]
    again_read = Mesh.load(tmp_path / "again.fold")
    assert again_read.fold_angles.tobytes() == mesh.fold_angles.tobytes()


def test_the_key_frame_may_be_the_folded_one(tmp_path: Path) -> None:
    own = {key: FOLDED[key] for key in ("frame_classes", "vertices_coords")}
    flat = {key: SQUARE[key] for key in ("frame_classes", "vertices_coords")}
    path = written(tmp_path, {**SQUARE, **own}, file_frames=[{**flat, "frame_parent": 0, "frame_inherit": True}])
    mesh = Mesh.load(path)
    assert (mesh.reference[:, 2] == 0.0).all()
    assert mesh.positions[3, 2] > 0.3
    other = {**FOLDED, "vertices_coords": FOLDED["vertices_coords"][:3]}
    assert (Mesh.load(written(tmp_path, SQUARE, file_frames=[other])).positions[:, 2] == 0.0).all()


@pytest.mark.parametrize("letter", ["U", "F", "J"])
def test_edges_that_are_no_mountain_or_valley(letter: str, tmp_path: Path) -> None:
    mesh = Mesh.load(written(tmp_path, SQUARE, edges_assignment=[*"BBBB", letter]))
    assert mesh.fold_angles.tolist() == ([0.0] if letter == "U" else [])
    mesh.save(tmp_path / "again.fold")
    assert frames_of(tmp_path / "again.fold")[0]["edges_assignment"][0 if letter == "U" else -1] in "UJB"
    alone = Mesh.load(written(tmp_path, SQUARE, edges_assignment=None, edges_foldAngle=[0, 0, 0, 0, -30]))
    assert alone.fold_angles[0] == np.radians(-30)


def test_faces_are_wound_one_way(tmp_path: Path) -> None:
    turned = Mesh.load(written(tmp_path, SQUARE, faces_vertices=[[2, 1, 0], [0, 2, 3]]))
    assert turned.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    clockwise = Mesh.load(written(tmp_path, SQUARE, faces_vertices=[[2, 1, 0], [3, 2, 0]]))
    assert clockwise.triangles.tolist() == [[2, 1, 0], [3, 2, 0]]
    spatial = {**SQUARE, **FOLDED, "frame_parent": None, "frame_inherit": None}
    upright = Mesh.load(written(tmp_path, spatial, faces_vertices=[[0, 1, 2], [3, 2, 0]]))
    assert upright.triangles.tolist() == [[0, 1, 2], [3, 0, 2]]


def test_quadrilaterals_are_cut_along_the_shorter_diagonal_inside(tmp_path: Path) -> None:
    kite: Table = {"vertices_coords": [[0, 0], [4, -1], [5, 0], [4, 1]], "faces_vertices": [[0, 1, 2, 3]]}
    mesh = read_fold(written(tmp_path, kite), scale=1.0)
    assert [1, 3] in mesh.edges.tolist()
    assert (mesh.areas() > 0.0).all()
    arrow: Table = {**kite, "vertices_coords": [[0, 0], [4, -3], [1, 0], [4, 3]]}
    mesh = read_fold(written(tmp_path, arrow), scale=1.0)
    assert [0, 2] in mesh.edges.tolist()
    assert area(mesh) == pytest.approx(3.0)
    assert len(mesh.creases) == 0
    upright: Table = {**kite, "vertices_coords": [[0, 0, 0], [0, 4, -1], [0, 5, 0], [0, 4, 1]]}
    assert [1, 3] in read_fold(written(tmp_path, upright), scale=1.0).edges.tolist()


@pytest.mark.parametrize("turn", [1, -1])
def test_polygons_are_cut_into_triangles_without_area_lost(turn: int, tmp_path: Path) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 41)[:-1]
    radius = np.where(np.arange(40) % 2, 1.0, 0.3)
    star = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    comb = [[0, 0], [3, 0], [6, 0], [6, 4], [5, 4], [5, 1], [4, 1], [4, 4], [2, 4], [2, 1], [0, 1], [0, 0.5]]
    for points, expected in ((star, 0.5 * 40 * 0.3 * np.sin(2 * np.pi / 40)), (np.array(comb), 6 + 3 + 6)):
        face = list(range(len(points)))[::turn]
        table: Table = {"vertices_coords": points.tolist(), "faces_vertices": [face]}
        mesh = read_fold(written(tmp_path, table), scale=1.0)
        assert len(mesh.triangles) == len(points) - 2
        assert area(mesh) == pytest.approx(expected)
        a, b, c = points[mesh.triangles].transpose(1, 0, 2)
        twice = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
        assert (np.sign(twice) == turn).all()


def test_faces_are_made_between_edges(tmp_path: Path) -> None:
    mesh = read_fold(written(tmp_path, GRID), scale=0.5)
    assert len(mesh.triangles) == 8
    assert area(mesh) == pytest.approx(1.0)
    assert len(mesh.boundary_edges) == 8
    mesh.save(tmp_path / "again.fold")
    check_specification(frames_of(tmp_path / "again.fold")[0])
    letters = ["B"] * 12
    for k, letter in ((2, "V"), (3, "V"), (7, "M"), (10, "U")):
        letters[k] = letter
    mesh = read_fold(written(tmp_path, GRID, edges_assignment=letters), scale=1.0)
    assert mesh.creases.tolist() == [[3, 4], [4, 5], [1, 4], [4, 7]]
    assert np.degrees(mesh.fold_angles).tolist() == [180.0, 180.0, -180.0, 0.0]


def test_a_face_that_borders_surround_is_a_hole(tmp_path: Path) -> None:
    outer, inner = [[0, 0], [3, 0], [3, 3], [0, 3]], [[1, 1], [2, 1], [2, 2], [1, 2]]
    edges = [[k, (k + 1) % 4] for k in range(4)] + [[4 + k, 4 + (k + 1) % 4] for k in range(4)]
    table: Table = {
        "vertices_coords": outer + inner, "edges_vertices": edges + [[k, 4 + k] for k in range(4)],
        "edges_assignment": [*"BBBBBBBB", *"MVMV"],
    }  # fmt: skip
    assert area(read_fold(written(tmp_path, table), scale=1.0)) == pytest.approx(8.0)
    assert area(read_fold(written(tmp_path, table, edges_assignment=None), scale=1.0)) == pytest.approx(9.0)


def test_cuts_part_the_film(tmp_path: Path) -> None:
    letters = [*"BBFFBB", *"BFBBFB"]
    letters[2] = "C"
    letters[7], letters[10] = "V", "M"
    mesh = read_fold(written(tmp_path, GRID, edges_assignment=letters), scale=1.0)
    assert mesh.node_count == 10  # vertex 3 is doubled where the cut meets the border, 4 at its end is not
    assert mesh.reference[9].tolist() == mesh.reference[3].tolist()
    assert len(mesh.boundary_edges) == 10
    letters[2], letters[3], letters[10] = "C", "C", "V"
    mesh = read_fold(written(tmp_path, GRID, edges_assignment=letters), scale=1.0)
    assert mesh.node_count == 12
    assert len(mesh.boundary_edges) == 12
    ends = mesh.reference[mesh.creases][:, :, 1]
    assert sorted(map(sorted, ends.tolist())) == [[0.0, 1.0], [1.0, 2.0]]
    assert len(set(mesh.creases.ravel().tolist())) == 4
    mesh.save(tmp_path / "again.fold")
    for frame in frames_of(tmp_path / "again.fold"):
        check_specification(frame)


@pytest.mark.parametrize(
    "pattern", [Disc(0.1, 4), Disc(0.1, 6, 0.05), SquareSail(rows=8), Strip(0.1, 0.02, 4)], ids=str
)
def test_faces_between_the_edges_of_a_mesh_are_its_triangles(pattern: Any, tmp_path: Path) -> None:
    mesh = pattern.mesh()
    mesh.save(tmp_path / "whole.fold")
    table = json.loads((tmp_path / "whole.fold").read_text())
    for key in ("faces_vertices", "faces_edges", "file_frames"):
        table.pop(key, None)
    traced = Mesh.load(written(tmp_path, table))
    turned = [[min(np.roll(row, k).tolist() for k in range(3)) for row in each.triangles] for each in (traced, mesh)]
    assert sorted(turned[0]) == sorted(turned[1])
    assert traced.creases.tobytes() == mesh.creases.tobytes()
    assert traced.fold_angles.tobytes() == mesh.fold_angles.tobytes()


@pytest.mark.parametrize(
    "table",
    [
        {**SQUARE, "file_frames": [FOLDED]},
        {**GRID, "frame_unit": "in", "edges_assignment": [*"BBCVBBBMBBMB"], "edges_foldAngle": [0] * 12},
        {**SQUARE, "edges_foldAngle": [0, 0, 0, 0, 71.3], "faces_vertices": [[0, 2, 1], [3, 0, 2]]},
    ],
    ids=["frames", "cut", "angle"],
)
def test_files_of_others_come_back_as_they_were_read(table: Table, tmp_path: Path) -> None:
    mesh = Mesh.load(written(tmp_path, table))
    mesh.save(tmp_path / "again.fold")
    for frame in frames_of(tmp_path / "again.fold"):
        check_specification(frame)
    check_same(Mesh.load(tmp_path / "again.fold"), mesh)
