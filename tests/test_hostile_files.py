"""Files that would hang a reader or fill memory, and arrays that declare more than they hold: refused by name."""

from __future__ import annotations

import io
import os
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import InputError, MembraneError, Mesh, MeshError, MissingFileError, Scene, SceneError, Simulation
from membrane_rs.mesh import read_fold
from membrane_rs.plotting import compare_runs
from membrane_rs.results import read_frame, read_history, read_pvd
from small_scenes import hanging_strip, patch, refused

READERS: list[Callable[[Any], object]] = [
    Scene.from_toml, Mesh.load, read_fold, Simulation.restore, read_history, read_frame, read_pvd,
]  # fmt: skip
TRIANGLE = np.array([[0, 1, 2]])


def header(shape: tuple[int, ...], data: bytes = b"", descr: str = "<f8") -> bytes:
    """An array in numpy's format that declares `shape` and holds `data`."""
    file = io.BytesIO()
    np.lib.format.write_array_header_1_0(file, {"shape": shape, "fortran_order": False, "descr": descr})
    return file.getvalue() + data


def archive(path: Path, **members: Any) -> Path:
    """A numpy archive of arrays, or of members as they are."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, value in members.items():
            content = io.BytesIO()
            if not isinstance(value, bytes):
                np.save(content, value)
            file.writestr(f"{name}.npy", value if isinstance(value, bytes) else content.getvalue())
    return path


@pytest.mark.parametrize("reader", READERS, ids=lambda reader: reader.__qualname__)
def test_no_reader_waits_for_a_pipe_or_reads_a_device_or_a_folder(
    reader: Callable[[Any], object], tmp_path: Path
) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", tmp_path, "/dev/zero", "/dev/null", "a" * 5000, tmp_path / "none"):
        refused(lambda path=path: reader(path), MembraneError, str(path)[:40])  # type: ignore[misc]
    for wrong in (3, None, b"scene.toml", "", "a\0b", ["x"]):
        refused(lambda wrong=wrong: reader(wrong), InputError, "path = ")  # type: ignore[misc]


@pytest.mark.parametrize("reader", READERS, ids=lambda reader: reader.__qualname__)
def test_no_reader_reads_a_file_without_end(reader: Callable[[Any], object], tmp_path: Path) -> None:
    with (tmp_path / "long").open("wb") as file:
        file.truncate(10**12)  # takes no space on the disk
    refused(lambda: reader(str(tmp_path / "long")), MembraneError, "1000000000000 bytes, and at most")


@pytest.mark.parametrize(
    "shape", [(10**12, 3), (10**30,), (10**400, 3), (0, 10**30), (2**62, 4), (-1, 3), (1,) * 70, (4, 3)]
)
def test_arrays_that_declare_more_than_they_hold(shape: tuple[int, ...], tmp_path: Path) -> None:
    path = archive(tmp_path / "mesh.npz", reference=header(shape, bytes(24)), triangles=TRIANGLE)
    assert path.stat().st_size < 3000
    refused(lambda: Mesh.load(path), MeshError, r"mesh.npz: .*'reference' (has|declares) the shape \(")
    refused(lambda: Simulation.restore(path), InputError, r"mesh.npz: .*'reference' (has|declares) the shape \(")


@pytest.mark.parametrize("shape", [(0, 10**30), (10**30, 0), (0, 10**8)])
def test_arrays_that_hold_nothing_and_declare_rows_beyond_count(shape: tuple[int, ...], tmp_path: Path) -> None:
    path = archive(tmp_path / "mesh.npz", reference=header(shape), triangles=TRIANGLE)
    refused(lambda: Mesh.load(path), MeshError, r"'reference' has the shape .* numbers is not read")


def test_a_file_of_more_nodes_than_fit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = patch()
    mesh.save(tmp_path / "mesh.npz")
    monkeypatch.setattr("membrane_rs._bounds.MOST_NODES", mesh.node_count)
    Mesh.load(tmp_path / "mesh.npz")
    monkeypatch.setattr("membrane_rs._bounds.MOST_NODES", mesh.node_count - 1)
    refused(lambda: Mesh.load(tmp_path / "mesh.npz"), MeshError, r"mesh.npz: makes about .* nodes; .*take fewer")


def test_a_saved_state_with_an_array_of_another_size(tmp_path: Path) -> None:
    Simulation(hanging_strip()).save(tmp_path / "state.npz")
    whole = dict(np.load(tmp_path / "state.npz"))
    for name in ("positions", "velocities", "work"):
        path = archive(tmp_path / "bad.npz", **{**whole, name: header((10**12, 3))})
        refused(lambda path=path: Simulation.restore(path), InputError, f"bad.npz: .*'{name}' has the shape")  # type: ignore[misc]


def test_an_archive_that_inflates_without_end(tmp_path: Path) -> None:
    path = archive(tmp_path / "mesh.npz", reference=header((4 * 10**7, 3), bytes(10**6)), triangles=TRIANGLE)
    refused(lambda: Mesh.load(path), MeshError, "more than 60000000 numbers is not read")


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("reference", np.array([{}], dtype=object), "neither numbers nor text"),
        ("reference", np.zeros(3, [("x", float)]), "neither numbers nor text"),
        ("reference", np.zeros((3, 3), "M8[s]"), "neither numbers nor text"),
        ("reference", np.zeros((3, 3), complex), "complex128; it must hold numbers"),
        ("reference", np.zeros((3, 3), bool), "bool; it must hold numbers"),
        ("reference", np.zeros((3, 3), str), "it must hold numbers|neither numbers nor text"),
        ("reference", b"\x93NUMPY\x01\x00\xff\xff" + b"(" * 70000, "no header of an array"),
        ("position", np.eye(3), "'position' is no array of a mesh; did you mean 'positions'?"),
        ("crease", np.zeros((0, 2), int), "did you mean 'creases'?"),
        ("node_sets:a", np.array([0]), "did you mean 'node_set:NAME'?"),
    ],
)
def test_arrays_that_are_none_of_a_mesh(name: str, value: Any, words: str, tmp_path: Path) -> None:
    path = archive(tmp_path / "mesh.npz", **({"reference": np.eye(3), "triangles": TRIANGLE} | {name: value}))
    refused(lambda: Mesh.load(path), MeshError, words)
    with pytest.raises(MeshError) as caught:
        Mesh.load(path)
    assert "pickle" not in str(caught.value)


def test_a_mesh_is_saved_and_loaded_with_all_its_bits(tmp_path: Path) -> None:
    mesh = patch(bridges=[[1, 3]])
    mesh.save(str(tmp_path / "mesh.npz"))
    again = Mesh.load(tmp_path / "mesh.npz")
    for name in ("reference", "triangles", "positions", "creases", "fold_angles", "bridges"):
        np.testing.assert_array_equal(getattr(again, name), getattr(mesh, name))
    assert {name: list(nodes) for name, nodes in again.node_sets.items()} == {"corners": [1, 3]}
    refused(lambda: mesh.save(tmp_path / "mesh.txt"), InputError, "must end in .npz")
    refused(lambda: Mesh.load(tmp_path / "none.npz"), MissingFileError, "there is no such mesh file")


def test_meshes_of_another_byte_order_are_the_same(tmp_path: Path) -> None:
    path = archive(tmp_path / "mesh.npz", reference=np.eye(3, dtype=">f8"), triangles=TRIANGLE.astype(">i4"))
    mesh = Mesh.load(path)
    assert mesh.reference.dtype == np.float64
    np.testing.assert_array_equal(mesh.reference, np.eye(3))
    assert mesh.triangles.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (".".join("a" * 10**5) + " = 1", "a key of 100000 parts"),
        ("[" + ".".join("a" * 10**5) + "]", "a key of 100000 parts"),
        ("x = {b = 1, " + ".".join("a" * 10**5) + " = 1}", "a key of 100000 parts"),
        ("x = " + "[" * 10**5, "nested too deeply"),
        ("x = " + "9" * 10**5, "integer of thousands of digits"),
    ],
)
def test_scene_files_that_would_take_for_ever(text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(text)
    refused(lambda: Scene.from_toml(tmp_path / "scene.toml"), SceneError, words)


def test_a_scene_file_may_begin_with_a_byte_order_mark(tmp_path: Path) -> None:
    text = "[[parts]]\nkind = 'tether'\nstart = [0, 0, 0]\nend = [1, 0, 0]\nsegments = 1\n"
    text += "axial_stiffness = 1.0\nlinear_density = 1.0\n"
    (tmp_path / "scene.toml").write_bytes(text.encode("utf-8-sig"))
    assert Scene.from_toml(tmp_path / "scene.toml").name == "scene"


@pytest.mark.parametrize(
    ("content", "reader"),
    [
        (b"\xff\xfe\x00", read_history),
        (b"time,deployment_rate\n1,2\n", read_history),
        (b"<?xml version='1.0' encoding='no-such'?><VTKFile/>", read_pvd),
        (b"<VTKFile><DataSet timestep='x' file='a'/></VTKFile>", read_pvd),
        (b"\xff\xff", read_pvd),
        (b"<VTKFile type='UnstructuredGrid'/>", read_frame),
        (b"\x00" * 100, read_frame),
        (b"<?xml version='1.0' encoding='no-such'?><VTKFile/>", read_frame),
    ],
)
def test_damaged_results_name_file_and_remedy(content: bytes, reader: Callable[[Any], object], tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(content)
    refused(lambda: reader(str(tmp_path / "file")), MembraneError, f"{tmp_path}/file .*")


def test_charts_are_written_in_the_format_that_their_name_says(tmp_path: Path) -> None:
    folder = tmp_path / "_a$b_{"  # no formula of matplotlib
    Simulation(hanging_strip()).run(until=0.002, frames=2, samples=3, out=folder, pictures=False)
    for name, start in (("a.png", b"\x89PNG"), ("a.pdf", b"%PDF"), ("a.svg", b"<?xml")):
        compare_runs([folder, str(folder)], tmp_path / name)
        assert (tmp_path / name).read_bytes().startswith(start)
    words = "is no format of a figure; must be one of .png, .pdf, .svg"
    refused(lambda: compare_runs([folder], tmp_path / "a.jpg"), InputError, words)
