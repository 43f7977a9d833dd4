"""Meshes of other programs: what is read of each kind of file, in which unit, with which names, and what is said."""

from __future__ import annotations

import copy
import pickle
from itertools import pairwise
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from membrane_rs import InputError, Material, Mesh, MeshError
from membrane_rs.mesh import MeshOrigin, net_moduli
from membrane_rs.mesh.file import ARRAYS, SETS
from membrane_rs.mesh.formats import FORMATS
from membrane_rs.mesh.meshio_process import BY_SUFFIX
from mesh_files import GMSH_22, GMSH_41, OBJ, STL, grid, halves, text_file, write
from small_scenes import refused

FILM = Material(3.2e9, 0.34, 1420.0, 7.5e-6)
POINTS, QUADS = grid(4, 3)
WITHOUT_QUADS = {".stl", ".off"}


def steps(mesh: Mesh) -> str:
    assert isinstance(mesh.source, MeshOrigin)
    return "; ".join(mesh.source.steps)


def corners(mesh: Mesh) -> set[tuple[tuple[float, ...], ...]]:
    """Triangles by the coordinates of their corners, wherever they begin."""
    found = set()
    for points in np.round(mesh.reference[mesh.triangles] * 1e3, 6).tolist():
        rows = [tuple(point) for point in points]
        first = rows.index(min(rows))
        found.add(tuple(rows[first:] + rows[:first]))
    return found


@pytest.mark.parametrize("suffix", BY_SUFFIX)
def test_triangles_of_every_kind_of_file(suffix: str, tmp_path: Path) -> None:
    kind = "gmsh" if suffix == ".msh" else None
    path = write(tmp_path / f"A{suffix.upper()}", POINTS, [("triangle", halves(QUADS))], kind or BY_SUFFIX[suffix])
    mesh = Mesh.read(path, scale="mm")
    assert corners(mesh) == corners(Mesh(POINTS * 1e-3, halves(QUADS)))
    assert mesh.node_count == len(POINTS)
    assert mesh.audit(FILM).ok
    assert mesh.source == MeshOrigin(str(path), 0.001, mesh.source.steps)  # type: ignore[attr-defined]


@pytest.mark.parametrize("suffix", sorted(BY_SUFFIX.keys() - WITHOUT_QUADS))
def test_quadrilaterals_of_every_kind_of_file(suffix: str, tmp_path: Path) -> None:
    kind = "gmsh" if suffix == ".msh" else BY_SUFFIX[suffix]
    path = write(tmp_path / f"a{suffix}", POINTS, [("quad", QUADS)], kind)
    mesh = Mesh.read(path, scale=0.001)
    assert len(mesh.triangles) == 2 * len(QUADS)
    np.testing.assert_allclose(mesh.areas(), 0.5e-6)
    assert '12 quadrilaterals split into triangles by the rule "shorter"' in steps(mesh)
    assert "12 of them have diagonals of equal length, within 1%, and were split alternately" in steps(mesh)


def test_msh_of_fluent(tmp_path: Path) -> None:
    path = write(tmp_path / "a.msh", POINTS, [("triangle", halves(QUADS))], "ansys")
    assert corners(Mesh.read(path, scale="mm")) == corners(Mesh(POINTS * 1e-3, halves(QUADS)))


@pytest.mark.parametrize(("text", "doubles"), [(GMSH_22, "2 cells left out, which are given twice; "), (GMSH_41, "")])
def test_physical_groups_of_gmsh(text: str, doubles: str, tmp_path: Path) -> None:
    mesh = Mesh.read(text_file(tmp_path / "sail.msh", text), scale="mm")
    assert mesh.reference.tolist() == [
        [0, 0, 0],
        [0.01, 0, 0],
        [0.02, 0, 0],
        [0, 0.01, 0],
        [0.01, 0.01, 0],
        [0.02, 0.01, 0],
    ]
    assert len(mesh.triangles) == 4
    assert {name: nodes.tolist() for name, nodes in mesh.node_sets.items()} == {
        "tip": [2], "held edge": [0, 3], "film": [0, 1, 2, 3, 4, 5], "left half": [0, 1, 3, 4], "line-9": [0, 1],
    }  # fmt: skip
    assert {name: rows.tolist() for name, rows in mesh.triangle_sets.items()} == {
        "film": [0, 1, 2, 3], "left half": [0, 1],
    }  # fmt: skip
    for words in (
        doubles,
        "1 quadrilateral split into triangles",
        "1 nodes left out, which no triangle has",
        "2 cells of type 'vertex' left out; 2 cells of type 'line' left out",
        "named groups left out, whose nodes no triangle has: point-5",
        "held edge (2 nodes)",
        "triangle sets: film (4 triangles), left half (2 triangles)",
    ):
        assert words in steps(mesh)


def test_sets_of_abaqus(tmp_path: Path) -> None:
    sets: dict[str, Any] = {"point_sets": {"HELD": np.array([0, 1])}, "cell_sets": {"HALF": [np.array([2, 5])]}}
    path = write(tmp_path / "a.inp", POINTS, [("triangle", halves(QUADS))], None, **sets)
    mesh = Mesh.read(path, scale=1.0)
    assert mesh.node_sets["HELD"].tolist() == [0, 1]
    assert mesh.triangle_sets["HALF"].tolist() == [2, 5]
    assert mesh.node_sets["HALF"].tolist() == np.unique(mesh.triangles[[2, 5]]).tolist()


def test_corners_of_stl_are_merged(tmp_path: Path) -> None:
    mesh = Mesh.read(text_file(tmp_path / "a.stl", STL), scale="mm")
    assert (mesh.node_count, len(mesh.edges)) == (4, 5)
    assert steps(mesh) == "2 of 6 corners merged, by equal coordinates"
    binary = tmp_path / "b.stl"
    meshio.stl.write(binary, meshio.Mesh(POINTS, [("triangle", halves(QUADS))]), binary=True)
    assert Mesh.read(binary, scale="mm").node_count == len(POINTS)
    near = Mesh.read(text_file(tmp_path / "c.stl", STL.replace("10 10 0", "10 10 1e-4", 1)), scale="mm", merge=1e-6)
    assert near.node_count == 4
    assert (
        "1 of 6 corners merged, by equal coordinates; 1 nodes merged with others within 1e-06 m, moved by 1e-07 m"
        in steps(near)
    )


def test_obj_of_a_modeller(tmp_path: Path) -> None:
    mesh = Mesh.read(text_file(tmp_path / "a.obj", OBJ), scale="cm")
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert mesh.reference.max() == 0.1
    assert {name: rows.tolist() for name, rows in mesh.triangle_sets.items()} == {"lower": [0], "upper side": [1]}
    assert mesh.node_sets["upper side"].tolist() == [0, 2, 3]


def test_points_of_a_plane_and_cells_of_several_blocks(tmp_path: Path) -> None:
    cells = [("triangle", halves(QUADS[:2])), ("quad", QUADS[2:5]), ("line", [[0, 1]]), ("triangle", halves(QUADS[5:]))]
    mesh = Mesh.read(write(tmp_path / "a.vtk", POINTS, cells), scale=1.0)
    assert len(mesh.triangles) == 2 * len(QUADS)
    assert mesh.areas().sum() == len(QUADS)
    order = np.concatenate([np.arange(2), np.arange(2, 5), np.arange(5, 12)]).repeat(2)
    middles = POINTS[QUADS].mean(axis=1)[order]
    assert np.abs(mesh.reference[mesh.triangles].mean(axis=1) - middles).max() < 0.3  # in the order of the file
    assert "1 cells of type 'line' left out" in steps(mesh)
    flat = Mesh.read(text_file(tmp_path / "a.obj", "v 0 0\nv 1 0\nv 0 1\nf 1 2 3\n"), scale=1.0)
    assert flat.reference.shape == (3, 3)
    assert steps(flat) == "z = 0 added to points of x and y"


def test_neighbours_are_made_to_run_the_same_way_round(tmp_path: Path) -> None:
    triangles = halves(QUADS)
    mixed = triangles.copy()
    mixed[[3, 4, 11]] = mixed[[3, 4, 11]][:, [0, 2, 1]]
    mesh = Mesh.read(write(tmp_path / "a.vtu", POINTS, [("triangle", mixed)]), scale=1.0)
    assert corners(mesh) == corners(Mesh(POINTS, triangles))
    assert steps(mesh) == "3 triangles reversed, so that neighbours run the same way round"
    most = triangles[:, [0, 2, 1]]
    most[0] = triangles[0]
    mesh = Mesh.read(write(tmp_path / "b.vtu", POINTS, [("triangle", most)]), scale=1.0)
    assert corners(mesh) == corners(Mesh(POINTS, triangles[:, [0, 2, 1]]))
    assert "1 triangles reversed" in steps(mesh)


def test_a_surface_with_one_side_stays_as_it_is(tmp_path: Path) -> None:
    turns = np.arange(5) * 2.0 * np.pi / 5
    points = [
        [(3 + s * np.cos(a / 2)) * np.cos(a), (3 + s * np.cos(a / 2)) * np.sin(a), s * np.sin(a / 2)]
        for a in turns
        for s in (-1.0, 1.0)
    ]
    ends = [(2 * k, 2 * k + 1) for k in range(5)] + [(1, 0)]
    strip = [row for (a, b), (c, d) in pairwise(ends) for row in ([a, c, d], [a, d, b])]
    mesh = Mesh.read(write(tmp_path / "a.vtu", points, [("triangle", strip)]), scale=1.0)
    assert mesh.triangles.tolist() == strip
    assert steps(mesh) == "10 triangles of a surface with one side left as they are"


def test_alternate_diagonals_meet_at_every_other_node(tmp_path: Path) -> None:
    for rule in ("alternate", "shorter"):
        mesh = Mesh.read(write(tmp_path / "a.vtu", POINTS, [("quad", QUADS)]), scale=1e-3, quads=rule)
        long = mesh.edges[mesh.edge_lengths > 1.2e-3]
        assert len(long) == len(QUADS)
        parity = np.round(mesh.reference[long] * 1e3)[:, :, :2].sum(axis=2) % 2
        assert (parity == 0).all()
    whole = net_moduli(mesh, FILM).local_extremes
    assert whole[0] > 2.0 * net_moduli(Mesh(POINTS * 1e-3, halves(QUADS)), FILM).local_extremes[0]


def test_the_shorter_diagonal_makes_no_obtuse_triangles_of_skewed_cells(tmp_path: Path) -> None:
    skewed = POINTS + 0.3 * POINTS[:, [1]] * [1.0, 0.0, 0.0]
    path = write(tmp_path / "a.vtu", skewed, [("quad", QUADS)])
    shorter, alternate = (Mesh.read(path, scale=1.0, quads=rule) for rule in ("shorter", "alternate"))
    assert "obtuse" not in str(shorter.audit(FILM))
    assert "obtuse" in str(alternate.audit(FILM))
    assert '6 of them split by their longer diagonal, which may make obtuse triangles; "shorter" avoids' in steps(
        alternate
    )


def test_no_diagonal_leaves_its_quadrilateral(tmp_path: Path) -> None:
    dart = [[2.0, -0.1, 0], [1.5, 0, 0], [2, 0.1, 0], [0, 0, 0]]
    path = write(tmp_path / "a.vtu", dart, [("quad", [[0, 1, 2, 3]])])
    for rule in ("shorter", "alternate"):  # both would join 0 and 2
        mesh = Mesh.read(path, scale=1.0, quads=rule)
        assert mesh.areas().sum() == pytest.approx(0.15)
        assert sorted(map(sorted, mesh.triangles.tolist())) == [[0, 1, 3], [1, 2, 3]]
        assert "1 of them split by the other diagonal, since theirs would leave them" in steps(mesh)


def test_a_ring_of_an_odd_number_of_quadrilaterals(tmp_path: Path) -> None:
    turns = np.arange(7) * 2.0 * np.pi / 7
    circle = np.stack([np.cos(turns), np.sin(turns), 0 * turns], axis=1)
    k = np.arange(7)
    quads = np.stack([k, k + 7, (k + 1) % 7 + 7, (k + 1) % 7], axis=1)
    path = write(tmp_path / "a.vtu", np.concatenate([circle, 2 * circle]), [("quad", quads)])
    refused(
        lambda: Mesh.read(path, scale=1.0, quads="alternate"), MeshError, "a ring .* about node 0 .*quads = 'shorter'"
    )
    assert len(Mesh.read(path, scale=1.0).triangles) == 14


def test_nodes_are_merged_within_a_length(tmp_path: Path) -> None:
    apart = POINTS[QUADS].reshape(-1, 3) + 1e-5 * np.arange(4 * len(QUADS))[:, None] % 1e-4
    path = write(tmp_path / "a.vtu", apart, [("quad", np.arange(4 * len(QUADS)).reshape(-1, 4))])
    assert Mesh.read(path, scale=1e-3).node_count == 4 * len(QUADS)
    mesh = Mesh.read(path, scale=1e-3, merge="0.5 um")
    assert (mesh.node_count, len(mesh.triangles)) == (len(POINTS), 2 * len(QUADS))
    assert "28 nodes merged with others within 5e-07 m" in steps(mesh)
    assert len(mesh.boundary_edges) == 14
    thin = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [1e-6, 1e-6, 0], [0.5, 0.5, 1.0], [0, 0, 1e-6]])
    cells = [("quad", [[0, 1, 2, 3]]), ("triangle", [[0, 3, 2], [5, 2, 4]])]
    mesh = Mesh.read(write(tmp_path / "b.vtu", thin, cells), scale=1.0, merge=1e-5)
    assert len(mesh.triangles) == 2
    assert "1 cells left out, whose corners were merged" in steps(mesh)
    refused(lambda: Mesh.read(path, scale=1e-3, merge=1.0), MeshError, "no triangle is left|would become one")


def test_what_is_read_is_saved_copied_and_pickled_with_its_names(tmp_path: Path) -> None:
    mesh = Mesh.read(text_file(tmp_path / "sail.msh", GMSH_41), scale="mm")
    mesh.save(tmp_path / "sail.npz")
    for again in (
        Mesh.load(tmp_path / "sail.npz"),
        Mesh.read(tmp_path / "sail.npz"),
        pickle.loads(pickle.dumps(mesh)),
        copy.deepcopy(mesh),
    ):
        np.testing.assert_array_equal(again.reference, mesh.reference)
        np.testing.assert_array_equal(again.triangles, mesh.triangles)
        for kind in ("node_sets", "triangle_sets"):
            sets: Any = getattr(again, kind)
            assert {name: rows.tolist() for name, rows in sets.items()} == {
                name: rows.tolist() for name, rows in getattr(mesh, kind).items()
            }
            assert not any(rows.flags.writeable for rows in sets.values())
            with pytest.raises(TypeError):
                sets["new"] = [0]
    assert "triangle sets" in mesh._repr_html_()


def test_the_scale_is_asked_for_and_checked(tmp_path: Path) -> None:
    path = text_file(tmp_path / "a.obj", OBJ)
    values: list[tuple[dict[str, Any], str]] = [
        ({}, 'Mesh.read.scale: is missing; a .obj file does not say .*scale = "mm".*scale = 0.001'),
        ({"scale": 0.0}, "Mesh.read.scale = 0.0: must be at least 1e-12"),
        ({"scale": -1}, "must be at least 1e-12"),
        ({"scale": float("nan")}, "must be finite"),
        ({"scale": True}, "must be a number"),
        ({"scale": "furlong"}, "unit 'furlong' is not known"),
        ({"scale": "kg"}, "is a mass; must be a length"),
        ({"scale": ""}, "must be a number"),
        ({"scale": "mm", "quads": "longer"}, "Mesh.read.quads = 'longer': must be 'shorter' or 'alternate'"),
        ({"scale": "mm", "merge": 0.0}, "Mesh.read.merge = 0.0: must be greater than 0"),
        ({"scale": "mm", "merge": "1 kg"}, "must be a length"),
    ]
    for given, words in values:
        refused(lambda given=given: Mesh.read(path, **given), InputError, words)  # type: ignore[misc]
    for scale in ("mm", "1 mm", "1e-3 m", 0.001, np.float64(0.001)):
        assert Mesh.read(path, scale=scale).reference.max() == 0.01
    Mesh.read(path, scale=1.0).save(tmp_path / "a.npz")
    refused(
        lambda: Mesh.read(tmp_path / "a.npz", scale=1.0), InputError, "no such key beside file; a .npz file says all"
    )
    assert set(FORMATS) >= {".npz", ".msh", ".obj", ".stl", ".vtu"}


def test_the_page_lists_every_kind_of_file() -> None:
    page = (Path(__file__).parents[1] / "docs" / "mesh_files.md").read_text(encoding="utf-8")
    table = page[page.index("| suffix |") : page.index("A file with another suffix")]
    listed = {word for line in table.splitlines()[2:] if line for word in line.split("|")[1].split()}
    assert listed == set(BY_SUFFIX)
    arrays = page[page.index("| array |") :]
    for name in (*ARRAYS, *(f"{prefix}NAME" for prefix in SETS.values())):
        assert f"\n| `{name}` | " in arrays


@pytest.mark.parametrize("text", [GMSH_22, GMSH_41])
def test_physical_groups_that_share_a_name(text: str, tmp_path: Path) -> None:
    path = text_file(tmp_path / "sail.msh", text.replace('"held edge"', '"film"').replace('"tip"', '"film"'))
    mesh = Mesh.read(path, scale="mm")
    assert mesh.node_sets.keys() == {"film", "left half", "line-9"}
    assert mesh.node_sets["film"].tolist() == [0, 1, 2, 3, 4, 5]
    assert mesh.triangle_sets["film"].tolist() == [0, 1, 2, 3]
    both = text.replace('"left half"', '"held edge"')
    mesh = Mesh.read(text_file(path, both), scale="mm")
    assert mesh.node_sets["held edge"].tolist() == [0, 1, 3, 4]


def test_modules_beside_a_file_are_not_imported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("meshio", "numpy", "resource", "pickle"):
        text_file(tmp_path / f"{name}.py", "open('imported', 'w')")
    assert Mesh.read(text_file(tmp_path / "a.obj", OBJ), scale=1.0).node_count == 4
    assert not (tmp_path / "imported").exists()


@pytest.mark.parametrize("suffix", BY_SUFFIX)
def test_load_leads_to_read_where_the_unit_is_needed(suffix: str, tmp_path: Path) -> None:
    refused(lambda: Mesh.load(tmp_path / f"sail{suffix}"), InputError, r"is a mesh of another program.*Mesh\.read")
