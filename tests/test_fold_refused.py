"""Wrong FOLD files: each is refused by an error that names the file, the frame, the key and a remedy."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import InputError, Mesh, MeshError, MissingFileError
from membrane_rs.mesh import read_fold
from small_scenes import refused
from test_fold_patterns import FOLDED, GRID, SQUARE, written

NAN = float("nan")


COORDS, EDGES, LETTERS, ANGLES, FACES = (
    "vertices_coords", "edges_vertices", "edges_assignment", "edges_foldAngle", "faces_vertices",
)  # fmt: skip
THREE = [[0, 0], [1, 0], [1, 1]]
FOUR = [[0, 1], [1, 2], [2, 3], [3, 0]]


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"file_spec": 2}, "file_spec = 2: is no version of FOLD that is read; these are 1, 1.1, 1.2"),
        ({"file_spec": True}, "file_spec = True: is no version"),
        ({"file_spec": "1.1"}, "file_spec = '1.1': is no version"),
        ({"file_frames": {}}, "file_frames = {}: must be a list"),
        ({"file_frames": [3]}, r"file_frames\[0\] = 3: must be an object"),
        ({"frame_classes": "creasePattern"}, "frame 0: frame_classes = 'creasePattern': must be a list of texts"),
        ({"frame_unit": 3}, "frame 0: frame_unit = 3: must be a text"),
        ({COORDS: []}, "frame 0: vertices_coords: is missing"),
        ({COORDS: {}}, "frame 0: vertices_coords = {}: must be a list"),
        ({COORDS: [*THREE, 3]}, r"frame 0: vertices_coords\[3\] = 3: must be a list of two or three"),
        ({COORDS: [*THREE, [0]]}, r"frame 0: vertices_coords\[3\] = \[0\]: must be a list of two or three"),
        ({COORDS: [*THREE, [0, "1"]]}, r"frame 0: vertices_coords\[3\]\[1\] = '1': must be a number"),
        ({COORDS: [*THREE, [0, True]]}, r"frame 0: vertices_coords\[3\]\[1\] = True: must be a number"),
        ({COORDS: [*THREE, [0, None]]}, r"frame 0: vertices_coords\[3\]\[1\] = None: must be a number"),
        ({COORDS: [*THREE, [0, 10**400]]}, "frame 0: vertices_coords: holds a number of hundreds of digits"),
        ({COORDS: [*THREE, [0, 1e101]]}, r"vertices_coords\[3\] = \[0, 1e\+101\]: must be within -1e\+100 and 1e\+100"),
        ({EDGES: [*FOUR, [0, 4]]}, r"edges_vertices\[4\]\[1\] = 4: is no vertex; indices run from 0 to 3"),
        ({EDGES: [*FOUR, [0, -1]]}, r"edges_vertices\[4\]\[1\] = -1: is no vertex"),
        ({EDGES: [*FOUR, [0, 2.0]]}, r"edges_vertices\[4\]\[1\] = 2.0: must be a whole number"),
        ({EDGES: [*FOUR, [False, 2]]}, r"edges_vertices\[4\]\[0\] = False: must be a whole number"),
        ({EDGES: [*FOUR, [0]]}, r"edges_vertices\[4\] = \[0\]: an edge has two different vertices"),
        ({EDGES: [*FOUR, [2, 2]]}, r"edges_vertices\[4\] = \[2, 2\]: an edge has two different vertices"),
        ({EDGES: [*FOUR, [1, 0]]}, r"edges_vertices\[4\] = \[1, 0\]: is the edge edges_vertices\[0\] again"),
        ({EDGES: [*FOUR, [1, 3]]}, r"edges_vertices\[4\] = \[1, 3\]: is no side of a face; leave it out"),
        ({EDGES: "all"}, "edges_vertices = 'all': must be a list"),
        ({LETTERS: ["B", "V"]}, "edges_assignment: has 2 entries, and edges_vertices 5; give one for each edge"),
        ({LETTERS: [*"BBBBX"]}, r"edges_assignment\[4\] = 'X': must be one of B, M, V, F, U, C, J"),
        ({LETTERS: [*"BBBB", None]}, r"edges_assignment\[4\] = None: must be one of"),
        ({LETTERS: [*"BBBBB"]}, r"edges_assignment\[4\] = 'B': the edge \[0, 2\] has 2 faces beside it"),
        ({LETTERS: [*"BBBMV"]}, r"edges_assignment\[3\] = 'M': the edge \[3, 0\] has one face beside it"),
        ({ANGLES: [0, 0, 0, 0, -90]}, r"edges_foldAngle\[4\] = -90: edges_assignment\[4\] = 'V'; a valley V is"),
        ({ANGLES: [0, 0, 0, 90, 90]}, r"edges_foldAngle\[3\] = 90: edges_assignment\[3\] = 'B', which is not"),
        ({ANGLES: [0, 0, 0, 0, 181]}, r"edges_foldAngle\[4\] = 181: must be from -180 to 180 degrees"),
        ({ANGLES: [0, 0, 0, 0, "90"]}, r"edges_foldAngle\[4\] = '90': must be a number"),
        ({ANGLES: [0]}, "edges_foldAngle: has 1 entries, and edges_vertices 5"),
        ({"edges_length": [1, 455, 455, 455, 643.5]}, r"edges_length\[0\] = 1: the vertices \[0, 1\] are 455 apart"),
        ({"edges_length": [0, 455, 455, 455, 643.5]}, r"edges_length\[0\] = 0: must be above 0"),
        ({FACES: [[0, 1, 2], [0, 2, 9]]}, r"faces_vertices\[1\]\[2\] = 9: is no vertex"),
        ({FACES: [[0, 1, 2], [0, 2]]}, r"faces_vertices\[1\] = \[0, 2\]: a face has three vertices"),
        ({FACES: [[0, 1, 2], [0, 2, 3, 2]]}, r"faces_vertices\[1\] = .*: names a vertex twice"),
        ({FACES: [[0, 1, 2], [0, 2, 3], [0, 3, 2]]}, r"faces_vertices\[2\] = .*: is the third beside the edge"),
        ({FACES: [[0, 1, 2], 3]}, r"faces_vertices\[1\] = 3: must be a list of vertices"),
        (
            {FACES: [[0, 2, 1, 3]], EDGES: None, LETTERS: None},
            r"faces_vertices\[0\] = .*: crosses itself, or has no area",
        ),
        ({"membrane_rs:bridges": [[0, 1.5]]}, "frame 0: membrane_rs:bridges = .*must hold whole numbers"),
        ({"membrane_rs:bridges": [[0, 9]]}, "bridges.* = 9 is no node"),
        ({"membrane_rs:bridges": 3}, "membrane_rs:bridges = 3: must hold whole numbers"),
        ({"membrane_rs:node_sets": [0]}, "membrane_rs:node_sets = .0.: must be an object of names"),
        ({"membrane_rs:node_sets": {"a": [True]}}, r"membrane_rs:node_sets\['a'\] = \[True\]: must hold whole"),
        ({"membrane_rs:node_sets": {"a": [7]}}, r"node_sets\['a'\].* = 7 is no node"),
        ({"membrane_rs:triangle_sets": {"a": [2]}}, r"triangle_sets\['a'\].* = 2 is no triangle"),
    ],
)
def test_a_wrong_value_is_refused_with_its_place(values: dict[str, Any], words: str, tmp_path: Path) -> None:
    refused(lambda: Mesh.load(written(tmp_path, SQUARE, **values)), MeshError, f"pattern.fold: .*{words}")


@pytest.mark.parametrize(
    ("frame", "words"),
    [
        ({"frame_parent": 7}, "frame 1: frame_parent = 7: is no frame; frames run from 0 to 1"),
        ({"frame_parent": True}, "frame 1: frame_parent = True: is no frame"),
        ({"frame_parent": None}, "frame 1: frame_parent: is missing beside frame_inherit"),
        ({"frame_parent": 1}, "frame 1: frame_parent = 1: frame 1 inherits from itself"),
        ({"frame_inherit": 1}, "frame 1: frame_inherit = 1: must be true or false"),
        ({"frame_classes": 3}, "frame 1: frame_classes = 3: must be a list of texts"),
        ({"vertices_coords": [[0, 0], [455, 0], [455, 455], [0, "a"]]}, r"frame 1: vertices_coords\[3\]\[1\] = 'a'"),
        ({"edges_foldAngle": [0, 0, 0, 0, 30]}, "frame 1: edges_foldAngle: .* contradicts positions"),
        ({"edges_assignment": 3, "edges_foldAngle": [0]}, "frame 1: edges_foldAngle: has 1 entries"),
        (
            {"vertices_coords": [[0, 0, 0], [455, 0, 0], [455, 455, 0], [227.5, 227.5, -321.7]]},
            r"frame 1: edges_assignment\[4\]: .* the vertices show a mountain of 90 degrees there",
        ),
    ],
)
def test_a_wrong_frame_is_refused_with_its_number(frame: dict[str, Any], words: str, tmp_path: Path) -> None:
    path = written(tmp_path, SQUARE, file_frames=[{**FOLDED, **frame}])
    refused(lambda: Mesh.load(path), MeshError, f"pattern.fold: {words}")


def test_a_shut_crease_needs_a_side(tmp_path: Path) -> None:
    shut = {**FOLDED, "vertices_coords": [[0, 0], [455, 0], [455, 455], [455, 0]]}
    path = written(tmp_path, SQUARE, file_frames=[shut], edges_assignment=[*"BBBBU"])
    refused(lambda: Mesh.load(path), MeshError, r"frame 1: edges_assignment\[4\]: the crease is shut, and nothing says")
    assert Mesh.load(written(tmp_path, SQUARE, file_frames=[shut])).fold_angles.tolist() == [np.pi]


def test_frames_that_inherit_from_one_another_in_a_circle(tmp_path: Path) -> None:
    ring = [{"frame_parent": 2, "frame_inherit": True}, {"frame_parent": 1, "frame_inherit": True}]
    refused(lambda: Mesh.load(written(tmp_path, SQUARE, file_frames=ring)), MeshError, "frame 1 inherits from itself")
    line = [{"frame_parent": k, "frame_inherit": True} for k in range(1100)]
    words = "inherits from more than 1000 frames"
    refused(lambda: Mesh.load(written(tmp_path, SQUARE, file_frames=line)), MeshError, words)
    many = written(tmp_path, SQUARE, file_frames=[{}] * 10_000)
    refused(lambda: Mesh.load(many), MeshError, "must be a list of at most 9999 frames")


@pytest.mark.parametrize(
    ("points", "edges", "words"),
    [
        (
            [[0, 0], [2, 0], [2, 2], [0, 2]], [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2], [1, 3]],
            r"edges_vertices\[4\] = \[0, 2\] and edges_vertices\[5\] = \[1, 3\] cross or touch",
        ),
        (
            [[0, 0], [2, 0], [2, 2], [0, 2], [1, 0]], [[0, 1], [1, 2], [2, 3], [3, 0], [4, 2]],
            r"edges_vertices\[0\] = \[0, 1\] and edges_vertices\[4\] = \[4, 2\] cross or touch",
        ),
        (
            [[0, 0], [2, 0], [2, 2], [1, 0]], [[0, 1], [1, 2], [2, 0], [0, 3]],
            r"edges_vertices\[0\] = \[0, 1\] and edges_vertices\[3\] = \[0, 3\] cross or touch",
        ),
        (
            [[0, 0], [3, 0], [1, 0], [2, 0]], [[0, 1], [2, 3]],
            r"edges_vertices\[0\] = \[0, 1\] and edges_vertices\[1\] = \[2, 3\] cross or touch",
        ),
        (
            [[0, 0], [2, 0], [2, 2], [0.5, 0.25]], [[0, 1], [1, 2], [2, 0], [0, 3]],
            r"edges_vertices\[3\] = \[0, 3\] has the same face, or the outside, on both sides",
        ),
        ([[0, 0], [1, 0]], [[0, 1]], r"edges_vertices\[0\] = \[0, 1\] has the same face, or the outside"),
        (
            [[0, 0], [4, 0], [4, 4], [2, 1], [3, 1], [3, 2]], [[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3]],
            r"edges_vertices\[3\] = \[3, 4\] lies inside a face of another piece",
        ),
        (
            [[0, 0], [4, 0], [4, 4], [3, 1], [3.5, 2]], [[0, 1], [1, 2], [2, 0], [0, 3], [3, 4], [4, 0]],
            "is part of a face whose boundary meets itself in vertex 0",
        ),
        ([[0, 0], [1, 0], [1, 1]], [], "is missing, and there are no edges_vertices"),
        ([[0, 0, 0], [1, 0, 0], [1, 1, 1]], [[0, 1], [1, 2], [2, 0]], "the vertices do not lie in a plane"),
    ],
)  # fmt: skip
def test_edges_that_make_no_faces(points: list[Any], edges: list[Any], words: str, tmp_path: Path) -> None:
    table = {"vertices_coords": points, "edges_vertices": edges}
    refused(lambda: read_fold(written(tmp_path, table), scale=1.0), MeshError, f"pattern.fold: frame 0: .*{words}")


def test_crossings_are_found_exactly(tmp_path: Path) -> None:
    """The third vertex lies on the diagonal, or off it by the last bit."""
    for third, is_on in ((0.1, True), (np.nextafter(0.1, 1.0), False)):
        table = {
            "vertices_coords": [[0, 0], [1, 1], [1, 0], [0.1, third], [0, 1]],
            "edges_vertices": [[0, 1], [0, 2], [2, 1], [0, 4], [4, 1], [3, 4], [3, 0]],
        }
        path = written(tmp_path, table)
        if is_on:
            refused(lambda path=path: read_fold(path, scale=1.0), MeshError, "cross or touch")  # type: ignore[misc]
        else:
            mesh = read_fold(path, scale=1.0)
            assert len(mesh.triangles) == 4
            assert mesh.areas().min() < 1e-16


def test_a_band_of_one_side_is_no_film(tmp_path: Path) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 7)[:-1]
    middle = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    across = np.stack([np.cos(angle) * np.cos(angle / 2), np.sin(angle) * np.cos(angle / 2), np.sin(angle / 2)], axis=1)
    points = np.concatenate([middle - 0.3 * across, middle + 0.3 * across])
    faces = [[k, k + 1, k + 7, k + 6] for k in range(5)] + [[5, 6, 0, 11]]
    table = {"vertices_coords": points.tolist(), "faces_vertices": faces}
    words = r"faces_vertices\[\d\] = .*cannot run the same way as all its neighbours"
    refused(lambda: read_fold(written(tmp_path, table), scale=1.0), MeshError, words)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is no JSON, as a FOLD file is: .* in line 1, column 1"),
        ("solid cube", "is no JSON"),
        ('{"file_spec": 1.1,\n "vertices_coords": [[0, 0] [1, 0]]}', "in line 2, column 29: .*1, 0"),
        ("[1, 2]", r"is no FOLD file, whose JSON is an object; it holds \[1, 2\]"),
        ("[" * 10**5, "nested too deeply"),
        ('{"a":' * 10**5, "nested too deeply"),
        ('{"vertices_coords": [[NaN, 0]]}', "holds NaN, which JSON does not have"),
        ('{"vertices_coords": [[-Infinity, 0]]}', "holds -Infinity, which JSON does not have"),
        ('{"vertices_coords": [[1e999, 0]]}', r"vertices_coords\[0\]\[0\] = inf: is beyond the numbers"),
        ('{"vertices_coords": [[' + "9" * 5000 + ", 0]]}", "whole number of thousands of digits|hundreds of digits"),
        ('{"edges_vertices": [], "edges_vertices": [[0, 1]]}', "'edges_vertices' stands twice in one object"),
        ('{"file_frames": [{"frame_parent": 0, "frame_parent": 1}]}', "'frame_parent' stands twice"),
        ("{}", "frame 0: vertices_coords: is missing"),
    ],
)
def test_text_that_is_no_fold_file(text: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "wrong.fold"
    path.write_text(text)
    refused(lambda: Mesh.load(path), MeshError, f"wrong.fold: .*{words}")


def test_bytes_and_sizes_that_are_no_fold_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "wrong.fold"
    path.write_bytes(b"\xff\xfe{")
    refused(lambda: Mesh.load(path), MeshError, "wrong.fold: is no UTF-8 text")
    with path.open("wb") as file:
        file.truncate(2**28 + 1)
    refused(lambda: Mesh.load(path), MeshError, "bytes, and at most 268435456 are read")
    refused(lambda: Mesh.load(tmp_path / "none.fold"), MissingFileError, "there is no such FOLD file")
    path = written(tmp_path, GRID)
    for wrong, words in ((0.0, "read_fold.scale = 0.0: must be"), (NAN, "scale = nan"), ("1 kg", "scale = '1 kg'")):
        refused(lambda wrong=wrong: read_fold(path, scale=wrong), InputError, words)  # type: ignore[misc]
    monkeypatch.setattr("membrane_rs._bounds.MOST_NODES", 3)
    refused(lambda: Mesh.load(written(tmp_path, SQUARE)), MeshError, "frame 0: vertices_coords: makes about 4.* nodes")
    face = {"vertices_coords": [[np.cos(k), np.sin(k)] for k in range(10_001)], "faces_vertices": [[*range(10_001)]]}
    monkeypatch.undo()
    words = r"faces_vertices\[0\] = .*: has 10001 sides, and at most 10000"
    refused(lambda: read_fold(written(tmp_path, face), scale=1.0), MeshError, words)
    faces = {**face, "faces_vertices": [[*range(9_000)]] * 3}
    words = r"faces_vertices\[2\] = .*: is one of too many with more than 100 sides"
    refused(lambda: read_fold(written(tmp_path, faces), scale=1.0), MeshError, words)


def test_a_file_may_begin_with_a_byte_order_mark(tmp_path: Path) -> None:
    (tmp_path / "marked.fold").write_text(json.dumps(SQUARE), encoding="utf-8-sig")
    assert Mesh.load(tmp_path / "marked.fold").node_count == 4
