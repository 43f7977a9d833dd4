"""Mesh files of other programs that are damaged, hostile or hold what is no film: refused by name, within bounds."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import Mesh, MeshError, MissingFileError
from membrane_rs.mesh.meshio_process import BY_SUFFIX, WORDS, Read
from mesh_files import GMSH_22, GMSH_41, OBJ, STL, grid, text_file, write
from small_scenes import refused

POINTS, QUADS = grid(2, 2)
HEADER = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"


def read(path: Path) -> Mesh:
    return Mesh.read(path, scale=1.0)


@pytest.mark.parametrize("suffix", BY_SUFFIX)
def test_no_kind_of_file_is_waited_for_or_read_without_end(suffix: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / f"pipe{suffix}")
    (tmp_path / f"device{suffix}").symlink_to("/dev/zero")
    (tmp_path / f"folder{suffix}").mkdir()
    (tmp_path / f"empty{suffix}").touch()
    with (tmp_path / f"long{suffix}").open("wb") as file:
        file.truncate(10**12)  # takes no space on the disk
    for name, words in (
        ("pipe", "a pipe, a socket or a device"),
        ("device", "a pipe, a socket or a device"),
        ("folder", "it is a folder"),
        ("empty", "it is empty"),
        ("long", "1000000000000 bytes, and at most"),
    ):
        refused(lambda name=name: read(tmp_path / f"{name}{suffix}"), MeshError, f"{name}{suffix}: .*{words}")  # type: ignore[misc]
    refused(lambda: read(tmp_path / f"none{suffix}"), MissingFileError, f"none{suffix}: there is no such mesh file")


@pytest.mark.parametrize(
    "content",
    [b"\x00" * 3000, np.random.default_rng(1).bytes(3000), b"solid v f $ # 1 2 3\n" * 30],
    ids=["zeros", "random", "words"],
)
@pytest.mark.parametrize("suffix", BY_SUFFIX)
def test_what_is_no_mesh(suffix: str, content: bytes, tmp_path: Path) -> None:
    path = tmp_path / f"file{suffix}"
    path.write_bytes(content)
    refused(
        lambda: read(path), MeshError, rf"file\{suffix}: (is no {WORDS[BY_SUFFIX[suffix]]} file that can be read|holds)"
    )


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.msh", GMSH_22[:-1].removesuffix("$EndElements")),
        ("a.msh", GMSH_22[:250]),
        ("a.msh", GMSH_41[: GMSH_41.index("5 1 2 5")]),
        ("a.msh", GMSH_22.replace("2.2 0 8", "2.2 1 8")),
        ("a.msh", GMSH_22.replace("$Nodes", "$Knots")),
        ("a.stl", STL[: STL.index("facet", 60)]),
        ("a.stl", STL[:60] + "endsolid"),
        ("a.obj", "v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3\n"),
        ("a.obj", "v a b c\n"),
        ("a.obj", OBJ.replace("f 1/1/1", "f x")),
    ],
)
def test_files_that_are_cut_off_or_contradict_themselves(name: str, text: str, tmp_path: Path) -> None:
    path = text_file(tmp_path / name, text)
    refused(lambda: read(path), MeshError, f"{name}: (is no .* file that can be read .*; write it|holds no points)")


@pytest.mark.parametrize(
    "text",
    [
        GMSH_41.replace("1 7 1 7", f"1 {10**12} 1 7", 1),
        GMSH_41.replace("\n7\n0 0 0", f"\n{10**11}\n0 0 0", 1),
        GMSH_41.replace("2 1 2 2\n", f"2 1 2 {10**15}\n", 1),
        GMSH_22.replace("7\n1 0 0 0", f"{10**13}\n1 0 0 0"),
    ],
    ids=["nodes", "number of a node", "elements", "nodes of 2.2"],
)
def test_files_that_declare_more_than_memory_holds(text: str, tmp_path: Path) -> None:
    assert text not in (GMSH_22, GMSH_41)
    began = time.monotonic()
    refused(lambda: read(text_file(tmp_path / "a.msh", text)), MeshError, r"a.msh: is no Gmsh file that can be read \(")
    assert time.monotonic() - began < 25.0


def test_time_goes_with_the_size_of_a_file_and_not_with_the_square_of_its_groups(tmp_path: Path) -> None:
    lines, names, last = [], [f"part {k}" for k in range(2000)], 0
    for k, name in enumerate(names):
        lines += [f"o {name}", f"v {k} 0 0", f"v {k}.5 0 0", f"v {k}.5 1 0", f"v {k} 1 0"]
        lines += [
            f"f {last + 1} {last + 2} {last + 3} {last + 4}",
            f"g side {k % 2}",
            f"f {last + 2} {last + 1} {last + 4}",
        ]
        last += 4
    path = text_file(tmp_path / "a.obj", "\n".join(lines) + "\n")
    mesh = read(path)  # within its bound of time
    assert {name: len(rows) for name, rows in mesh.triangle_sets.items()} == {
        **dict.fromkeys(names, 2), **dict.fromkeys(("side 0", "side 1"), 1000),
    }  # fmt: skip
    assert mesh.triangle_sets["part 7"].tolist() == [21, 22]
    assert mesh.triangle_sets["side 1"][:2].tolist() == [5, 11]


@pytest.mark.parametrize(
    "system",
    ["sys.modules['resource'] = None", "import resource\ndef no(*_): raise ValueError\nresource.setrlimit = no"],
    ids=["Windows", "macOS"],
)
def test_systems_without_bounds_of_memory(system: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from membrane_rs.mesh import meshio_process

    command = meshio_process._COMMAND.replace("; ", "\n")
    monkeypatch.setattr(meshio_process, "_COMMAND", command.replace("import sys", f"import sys\n{system}", 1))
    assert read(text_file(tmp_path / "a.obj", OBJ)).node_count == 4


def test_nothing_is_imported_from_the_folder_of_the_file(tmp_path: Path) -> None:
    (tmp_path / "meshio.py").write_text("raise SystemExit('imported')\n")
    text_file(tmp_path / "a.obj", OBJ)
    code = "from membrane_rs import Mesh; Mesh.read('a.obj', scale=1.0)"
    subprocess.run([sys.executable, "-c", code], check=True, cwd=tmp_path)


def test_a_file_that_is_not_read_in_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("membrane_rs.mesh.meshio_process.SECONDS", 1)
    endless = GMSH_22 + f"$NodeData\n0\n{10**14}\n$EndNodeData\n"
    refused(lambda: read(text_file(tmp_path / "a.msh", endless)), MeshError, r"a.msh: .*it was not read within 1 s")


def test_a_file_that_names_another_one(tmp_path: Path) -> None:
    path = text_file(tmp_path / "a.inp", "*NODE\n1, 0, 0, 0\n*INCLUDE, INPUT=/dev/zero\n")
    refused(lambda: read(path), MeshError, "a.inp: is no Abaqus file that can be read")


def test_a_process_that_ends_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = text_file(tmp_path / "a.obj", OBJ)
    monkeypatch.setattr("membrane_rs.mesh.meshio_process._COMMAND", "import os; os._exit(3)")
    refused(
        lambda: read(path), MeshError, r"a.obj: is no OBJ file that can be read \(the process that reads it has ended\)"
    )
    monkeypatch.setattr(sys, "executable", str(tmp_path / "no-python"))
    refused(lambda: read(path), MeshError, "a.obj: cannot be read")


@pytest.mark.parametrize(("name", "text"), [("a.msh", GMSH_22), ("b.msh", GMSH_41), ("c.stl", STL), ("d.obj", OBJ)])
def test_random_damage(name: str, text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("membrane_rs.mesh.meshio_process.SECONDS", 5)
    rng, path = np.random.default_rng(len(text)), tmp_path / name
    refusals: list[str] = []
    for _ in range(12):
        content = bytearray(text.encode())
        at, kind = int(rng.integers(len(content))), int(rng.integers(3))
        content[at : at + int(rng.integers(1, 9))] = (b"", rng.bytes(1), b"-99999999999")[kind]
        path.write_bytes(content)
        try:
            read(path)
        except MeshError as error:
            refusals.append(str(error))
    assert refusals
    assert all(str(path) in each for each in refusals)


CELLS: list[tuple[list[tuple[str, Any]], str]] = [
    (
        [("tetra", [[0, 1, 3, 4]]), ("triangle", [[0, 1, 3]])],
        "1 cells of type 'tetra', which fill a volume; write the surface",
    ),
    ([("hexahedron", [[0, 1, 2, 3, 4, 5, 6, 7]])], "which fill a volume"),
    (
        [("triangle6", [[0, 1, 2, 3, 4, 5]])],
        "'triangle6', with nodes between their corners; write cells of first order",
    ),
    ([("quad8", [[0, 1, 2, 3, 4, 5, 6, 7]])], "'quad8', with nodes between their corners"),
    ([("line", [[0, 1], [1, 2]])], "holds neither triangles nor quadrilaterals, but 2 cells of type 'line'"),
    ([("vertex", [[0]])], "but 1 cells of type 'vertex'"),
    ([("polygon", [[0, 1, 2, 5, 4]])], "1 cells of type 'polygon'; write triangles and quadrilaterals"),
    ([("triangle", [[0, 1, 3], [0, 1, 9]])], "corner 2 of the cell 1 of type 'triangle', .* is none of its 9 points"),
    ([("quad", [[0, 1, 4, -3]])], "corner 3 of the cell 0 of type 'quad'"),
    ([("triangle", [[0, 1, 1]])], r"points \[0, 1, 1\], counted from 0, names one twice .*give merge"),
    ([("quad", [[0, 1, 3, 4]])], r"quadrilateral of nodes \[0, 1, 3, 4\] crosses itself"),
    ([("quad", [[0, 1, 1, 3]])], "names one twice"),
]


@pytest.mark.parametrize(("cells", "words"), CELLS)
def test_cells_that_are_no_film(cells: list[tuple[str, Any]], words: str, tmp_path: Path) -> None:
    path = write(tmp_path / "a.vtk", POINTS, cells)
    refused(lambda: read(path), MeshError, f"a.vtk: .*{words}")


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_points_that_are_not_finite(bad: float, tmp_path: Path) -> None:
    points = POINTS.copy()
    points[4, 1] = bad
    refused(
        lambda: read(write(tmp_path / "a.vtu", points, [("quad", QUADS)])), MeshError, "a.vtu: point 4, .*not finite"
    )


@pytest.mark.parametrize(("size", "scale"), [(1e300, 1e12), (1e-200, 1e-12)])
def test_points_beyond_all_bounds(size: float, scale: float, tmp_path: Path) -> None:
    path = write(tmp_path / "a.vtu", size * POINTS, [("quad", QUADS)])
    for more in ({}, {"merge": 1e-3}):
        refused(lambda more=more: Mesh.read(path, scale=scale, **more), MeshError, r"a\.vtu: ")  # type: ignore[misc]


def test_groups_with_members_that_are_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lines = (
        GMSH_22.replace("3 1 2 2 4 1 4", "3 1 2 2 4 1 6")
        .replace("6 20 10 0\n", "60 20 10 0\n")
        .replace("6 3 2 3 1 2 3 6 5", "6 2 2 3 1 2 3 5")
    )
    refused(
        lambda: read(text_file(tmp_path / "a.msh", lines)),
        MeshError,
        r"a\.msh: .*'held edge' of points holds number -1",
    )
    for points, cells, words in (([9], [0], "of points holds number 9"), ([0], [4], "of cells holds number 4")):
        sets = {"HELD": {0: np.array(cells)}}, {"HELD": np.array(points)}
        held = Read(POINTS, [("quad", QUADS)], None, {}, *sets)
        monkeypatch.setattr("membrane_rs.mesh.foreign.read_by_meshio", lambda _, held=held: held)
        refused(lambda: read(tmp_path / "a.msh"), MeshError, rf"a\.msh: the set 'HELD' {words}, counted from 0, of")


def test_more_points_than_fit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path / "a.vtu", POINTS, [("quad", QUADS)])
    monkeypatch.setattr("membrane_rs._bounds.MOST_NODES", 8)
    refused(lambda: read(path), MeshError, "a.vtu: its points: makes about .* nodes; must be at most")


def test_nothing_is_printed_but_the_error(tmp_path: Path) -> None:
    for name, text in (("a.msh", GMSH_22[:300]), ("b.msh", GMSH_22), ("c.stl", STL[:100])):
        path = text_file(tmp_path / name, text)
        code = (
            "import sys; from membrane_rs import Mesh, MeshError\n"
            "try: Mesh.read(sys.argv[1], scale=1.0)\n"
            "except MeshError: pass"
        )
        done = subprocess.run([sys.executable, "-c", code, str(path)], check=True, capture_output=True)
        assert (done.stdout, done.stderr) == (b"", b"")
