"""Meshes in FOLD files: the specification, the way round of folds, the same bits after a round trip."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from example_of import example_of
from fold_specification import apart, check_specification, folded, frames_of, points_of
from membrane_rs import InputError, Mesh, MeshError, OutputError, Scene, SceneError, scenes
from membrane_rs.folding import PATTERNS, SquareSail
from membrane_rs.mesh import MeshOrigin, read_fold, write_fold
from same_mesh import check_same
from small_scenes import patch, refused
from test_cli import call

SAILS = (SquareSail(join="bridge"), SquareSail(stowage="wound"), SquareSail(stowage="wound", join="bridge"))
WITH_MESH = [name for name in scenes.names() if scenes.load(name).mesh is not None]


def mesh_of(name: str) -> Mesh:
    """The mesh of a built-in scene."""
    mesh = scenes.load(name).mesh
    assert mesh is not None
    return mesh


@pytest.mark.parametrize("name", WITH_MESH)
def test_exported_scenes_keep_the_specification_and_all_their_bits(name: str, tmp_path: Path) -> None:
    mesh, path = mesh_of(name), tmp_path / "mesh.fold"
    mesh.save(path)
    frames = frames_of(path)
    for frame in frames:
        check_specification(frame)
    assert [frame["frame_classes"] for frame in frames] == [["creasePattern"], ["foldedForm"]][: len(frames)]
    assert len(frames) == (1 if (mesh.positions == mesh.reference).all() else 2)
    np.testing.assert_array_equal(points_of(frames[0]), mesh.reference)
    np.testing.assert_array_equal(points_of(frames[-1]), mesh.positions)
    letters = frames[0]["edges_assignment"]
    assert letters.count("B") == len(mesh.boundary_edges)
    assert letters.count("V") == (mesh.fold_angles > 0.0).sum()
    assert letters.count("M") == (mesh.fold_angles < 0.0).sum()
    check_same(Mesh.load(path), mesh)


@pytest.mark.parametrize(
    "pattern", [*map(example_of, PATTERNS.values()), *SAILS], ids=lambda pattern: type(pattern).__name__
)
def test_every_pattern_comes_back_to_the_bit(pattern: Any, tmp_path: Path) -> None:
    mesh = pattern.mesh()
    write_fold(tmp_path / "mesh.fold", mesh, title="a title")
    for frame in frames_of(tmp_path / "mesh.fold"):
        check_specification(frame)
        assert frame["file_title"] == "a title"
    check_same(read_fold(tmp_path / "mesh.fold"), mesh)


def test_bridges_sets_angles_and_spatial_shapes_come_back_to_the_bit(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    bent = np.array([[0, 0, 0.0], [1, 0, 0], [1, 1, 0.3], [0, 1, 0]]) + rng.normal(size=(4, 3)) * 1e-3
    triangles, crease = [[0, 1, 2], [0, 2, 3]], [[2, 0]]
    flat = bent * (1.0, 1.0, 0.0)
    for mesh in (
        patch(bridges=[[1, 3]]),
        Mesh(bent, triangles, creases=crease),
        Mesh(bent, triangles, positions=bent[:, [1, 2, 0]], creases=crease),
        Mesh(flat, triangles, positions=bent, creases=crease, node_sets={'ä "b"': [2, 0], "none": []}),
        Mesh(flat, triangles, triangle_sets={"second": [1], "both": [1, 0]}),
        Mesh(flat, triangles, creases=crease, fold_angles=[-2.1]),
        Mesh(flat, triangles, creases=crease, fold_angles=[0.0]),
        Mesh(flat + np.array([0.0, 0.0, 0.1]), triangles, positions=bent),
    ):
        mesh.save(tmp_path / "mesh.fold")
        for frame in frames_of(tmp_path / "mesh.fold"):
            check_specification(frame)
        check_same(Mesh.load(tmp_path / "mesh.fold"), mesh)


def test_angles_that_degrees_do_not_hold_keep_their_bits_until_another_program_changes_them(tmp_path: Path) -> None:
    flat, triangles = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]
    angles = np.linspace(1.1, 2.1, 101)
    lost = next(angle for angle in angles if np.radians(np.degrees(angle)) != angle)
    path = tmp_path / "mesh.fold"
    Mesh(flat, triangles, creases=[[0, 2]], fold_angles=[lost]).save(path)
    assert Mesh.load(path).fold_angles[0] == lost
    table = json.loads(path.read_text())
    table["edges_foldAngle"][0] = 90.0
    path.write_text(json.dumps(table))
    assert Mesh.load(path).fold_angles[0] == np.pi / 2


def test_the_routine_that_folds_turns_valleys_to_where_normals_point() -> None:
    """The definition of the specification, on two faces: a valley points their normals into each other."""
    pattern = {
        "vertices_coords": [[0, 0], [1, 0], [1, 1], [0, 1]], "faces_vertices": [[0, 1, 2], [0, 2, 3]],
        "edges_vertices": [[2, 0]],
    }  # fmt: skip
    valley, mountain = (folded(pattern, [angle]) for angle in (90.0, -90.0))
    np.testing.assert_allclose(valley[3], [0.5, 0.5, np.sqrt(0.5)], atol=1e-15)
    np.testing.assert_allclose(mountain[3], [0.5, 0.5, -np.sqrt(0.5)], atol=1e-15)


@pytest.mark.parametrize("name", ["single-crease", "hanging-strip", "miura"])
def test_a_pattern_folds_by_its_angles_to_the_stowed_shape(name: str, tmp_path: Path) -> None:
    mesh_of(name).save(tmp_path / "mesh.fold")
    pattern, stowed = frames_of(tmp_path / "mesh.fold")
    shape = folded(pattern, pattern["edges_foldAngle"])
    assert apart(shape, points_of(stowed)) < 1e-15
    assert apart(shape, points_of(stowed), mirrored=True) > 5e-3


@pytest.mark.parametrize("name", ["okuizumi-model-1", "okuizumi-model-2", "okuizumi-whole"])
def test_a_sail_folds_by_the_angles_of_its_stowed_frame_the_same_way_round(name: str, tmp_path: Path) -> None:
    """Face by face, with the bends of the film between creases: it is strained by 0.25 % and rows lie apart."""
    mesh_of(name).save(tmp_path / "sail.fold")
    pattern, stowed = frames_of(tmp_path / "sail.fold")
    shape = folded(pattern, stowed["edges_foldAngle"])
    assert apart(shape, points_of(stowed)) < 5e-4
    assert apart(shape, points_of(stowed), mirrored=True) > 0.02


def test_the_layers_of_model_1_lie_to_each_other_as_its_mountains_and_valleys_say(tmp_path: Path) -> None:
    mesh_of("okuizumi-model-1").save(tmp_path / "sail.fold")
    pattern, stowed = frames_of(tmp_path / "sail.fold")
    points, faces = points_of(stowed), pattern["faces_vertices"]
    beside = {tuple(side): face for face in faces for side in zip(face, face[1:] + face[:1], strict=True)}
    sides = {"V": 1.0, "M": -1.0}
    for (u, v), letter in zip(pattern["edges_vertices"], pattern["edges_assignment"], strict=True):
        if letter in sides:
            left, right = beside[u, v], beside[v, u]
            normal = np.cross(points[left[1]] - points[left[0]], points[left[2]] - points[left[0]])
            apex = points[next(vertex for vertex in right if vertex not in (u, v))]
            assert normal @ (apex - points[u]) * sides[letter] > 0.0


def test_film_that_is_bent_where_no_crease_is_folds_in_the_stowed_frame_alone(tmp_path: Path) -> None:
    mesh = mesh_of("okuizumi-whole")
    mesh.save(tmp_path / "sail.fold")
    pattern, stowed = frames_of(tmp_path / "sail.fold")
    hairpins = set(mesh.node_sets["hairpins"].tolist())
    of_hairpins = [
        k
        for k, edge in enumerate(pattern["edges_vertices"])
        if hairpins.issuperset(edge) and pattern["edges_assignment"][k] not in "BMV"
    ]
    assert of_hairpins
    assert {pattern["edges_assignment"][k] for k in of_hairpins} == {"F"}
    assert all(pattern["edges_foldAngle"][k] == 0 for k in of_hairpins)
    assert all(abs(stowed["edges_foldAngle"][k]) > 90.0 for k in of_hairpins)
    assert len(Mesh.load(tmp_path / "sail.fold").creases) == len(mesh.creases)


def test_frames_are_chosen(tmp_path: Path) -> None:
    mesh, path = mesh_of("single-crease"), tmp_path / "mesh.fold"
    mesh.save(path)
    check_same(read_fold(path, frame=1), mesh)
    origin = "frame 0 is the film without strain, frame 1 the shape at the start"
    skipped = "4 orders of faces skipped: those that the shape tells are written again"
    assert Mesh.read(path).source == MeshOrigin(str(path), 1.0, (origin, skipped))
    assert Mesh.load(path).source is None
    flat = read_fold(path, frame=0)
    assert flat.positions.tobytes() == mesh.reference.tobytes()
    assert flat.fold_angles.tobytes() == mesh.fold_angles.tobytes()
    refused(lambda: read_fold(path, frame=2), MeshError, "frame = 2: is no frame of this file; they run from 0 to 1")
    refused(lambda: read_fold(path, frame=True), InputError, "read_fold.frame = True: must be")


def test_a_scene_file_names_a_fold_file(tmp_path: Path) -> None:
    mesh = mesh_of("single-crease")
    mesh.save(tmp_path / "sheet.fold")
    film = "youngs_modulus = 3.2e9\npoisson_ratio = 0.34\ndensity = 1420.0\nthickness = 7.5e-6\n"
    text = f'[mesh]\nfile = "sheet.fold"\n[material]\n{film}'
    (tmp_path / "scene.toml").write_text(text)
    scene = Scene.from_toml(tmp_path / "scene.toml")
    assert scene.mesh is not None
    check_same(scene.mesh, mesh)
    (tmp_path / "scene.toml").write_text(text.replace('fold"\n', 'fold"\nframe = 0\n'))
    scene = Scene.from_toml(tmp_path / "scene.toml")
    assert scene.mesh is not None
    assert (scene.mesh.positions == mesh.reference).all()
    for line, words in (
        ("frame = 9", "sheet.fold: frame = 9: is no frame"),
        ("scale = 2.0", "frame_unit = 'm': says the unit, beside scale = 2; leave scale out"),
        ("scale = true", "mesh.scale = True: must be"),
        ("rows = 2", "mesh.rows: no such key"),
    ):
        (tmp_path / "scene.toml").write_text(text.replace('fold"\n', f'fold"\n{line}\n'))
        refused(lambda: Scene.from_toml(tmp_path / "scene.toml"), SceneError, words)


def test_what_a_fold_file_cannot_hold_is_not_written(tmp_path: Path) -> None:
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1]]
    turned = Mesh(square, [[0, 1, 2], [0, 3, 2]])
    refused(lambda: turned.save(tmp_path / "mesh.fold"), MeshError, "wound in opposite senses at 1 edges")
    three = Mesh(square, [[0, 1, 2], [0, 2, 3], [0, 2, 4]])
    refused(lambda: three.save(tmp_path / "mesh.fold"), MeshError, r"triangles\[2\] is the third .* vertices 0 and 2")
    sound = Mesh(square, [[0, 1, 2]])
    refused(lambda: write_fold(tmp_path / "mesh.fold", square), InputError, "mesh = .*must be a Mesh")  # type: ignore[arg-type]
    refused(lambda: write_fold(tmp_path / "x.fold", sound, title=3), InputError, "title = 3")  # type: ignore[arg-type]
    refused(lambda: sound.save(tmp_path / "no" / "mesh.fold"), OutputError, "cannot write")
    assert list(tmp_path.iterdir()) == []
    sound.save(tmp_path / "mesh.npz")
    refused(lambda: Mesh.read(tmp_path / "mesh.npz", frame=0), InputError, "frame: no such key beside file")


def test_an_exported_mesh_replaces_no_file_unasked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("hanging-strip.fold").write_text("the pattern of somebody")
    code, shown = call("export", "hanging-strip")
    assert (code, Path("hanging-strip.fold").read_text()) == (2, "the pattern of somebody")
    assert "hanging-strip.fold: is there already; choose another name by --out, or replace it by --overwrite" in shown
    assert call("export", "hanging-strip", "--overwrite")[0] == 0
    check_same(Mesh.load("hanging-strip.fold"), mesh_of("hanging-strip"))
