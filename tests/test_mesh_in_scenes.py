"""Mesh files of other programs in scene files and at the command line: read, checked, run, converted, refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from membrane_rs import InputError, Mesh, MissingFileError, Scene, SceneError, Simulation
from membrane_rs.mesh.file import SETS
from membrane_rs.scene.toml import tomllib
from membrane_rs.study.common.density import denser
from membrane_rs.study.common.kept_runs import mesh_mark
from mesh_files import GMSH_22, OBJ, grid, text_file, write
from small_scenes import FILM, patch, refused
from test_cli import call
from test_schema import VALIDATOR

REST = """
[material]
youngs_modulus = "3.2 GPa"
poisson_ratio = 0.34
density = 1420.0
thickness = "7.5 um"

[laws.springs]

[[parts]]
kind = "fixed"
nodes = "held edge"

[[parts]]
kind = "tip_masses"
nodes = "tip"
mass = "1 g"

[run]
until = "0.1 ms"
"""


def scene(folder: Path, mesh: str, name: str = "own") -> Path:
    """A scene file beside the mesh of Gmsh."""
    text_file(folder / "sail.msh", GMSH_22)
    return text_file(folder / f"{name}.toml", f"[mesh]\n{mesh}\n{REST}")


MESH = 'file = "sail.msh"\nscale = "mm"'


@pytest.mark.parametrize("scale", ['"mm"', '"1 mm"', "0.001", '"0.1 cm"'])
def test_a_scene_with_a_mesh_of_gmsh(scale: str, tmp_path: Path) -> None:
    path = scene(tmp_path, f'file = "sail.msh"\nscale = {scale}\nquads = "shorter"\nmerge = "1 nm"')
    assert list(VALIDATOR.iter_errors(tomllib.loads(path.read_text()))) == []
    made = Scene.from_toml(path)
    assert made.mesh is not None
    assert made.mesh.reference.max() == pytest.approx(0.02)
    sim = Simulation(made)
    sim.run(until=1e-4)
    assert sim.masses[2] > 1e-3
    np.testing.assert_array_equal(sim.positions[[0, 3]], made.mesh.positions[[0, 3]])
    made.save(tmp_path / "saved")
    again = Scene.from_toml(tmp_path / "saved" / "scene.toml")
    assert again.to_toml() == made.to_toml()
    assert again.mesh is not None
    assert again.mesh.triangle_sets.keys() == {"film", "left half"}
    assert mesh_mark(again) == mesh_mark(made)
    refused(lambda: denser(made, 2.0), InputError, "has a mesh of its own; only the mesh of a folding pattern")


WRONG = [
    ('file = "sail.msh"', "mesh.scale: is missing; a .msh file does not say"),
    ('file = "sail.msh"\nscale = "kg"', "mesh.scale = '1 kg': is a mass"),
    ('file = "sail.msh"\nscale = 0', "mesh.scale = 0.*: must be at least 1e-12"),
    (f'{MESH}\nquad = "shorter"', "mesh.quad: no such key; did you mean 'quads'"),
    (f'{MESH}\nquads = "long"', "mesh.quads = 'long': must be 'shorter' or 'alternate'"),
    (f'{MESH}\nmerge = "-1 um"', "mesh.merge = -1e-06: must be greater than 0"),
    (f'{MESH}\npattern = "strip"', "must hold either pattern"),
    ('file = "sail.xyz"\nscale = "mm"', "mesh.file = 'sail.xyz': must be the path of a mesh file"),
    ('file = ""\nscale = "mm"', "mesh.file = ''"),
    ("file = 3", "mesh.file = 3: must be the path of a mesh file"),
    ('file = "mesh.npz"\nscale = 1.0', "mesh.scale: no such key beside file; a .npz file says all"),
]


@pytest.mark.parametrize(("mesh", "words"), WRONG)
def test_wrong_tables_of_meshes(mesh: str, words: str, tmp_path: Path) -> None:
    path = scene(tmp_path, mesh)
    if '"kg"' not in mesh:  # the schema knows no units
        assert list(VALIDATOR.iter_errors(tomllib.loads(path.read_text()))) != []
    refused(lambda: Scene.from_toml(path), SceneError, rf"own\.toml: .*{words}")


def test_mesh_files_that_are_damaged_or_not_there(tmp_path: Path) -> None:
    path = scene(tmp_path, MESH)
    (tmp_path / "sail.msh").write_text(GMSH_22[:300])
    refused(lambda: Scene.from_toml(path), SceneError, r"own\.toml: .*sail\.msh: is no Gmsh file that can be read")
    (tmp_path / "sail.msh").unlink()
    with pytest.raises((SceneError, MissingFileError), match=r"sail\.msh: there is no such mesh file"):
        Scene.from_toml(path)
    refused(lambda: Scene.from_toml(scene(tmp_path, 'file = "a\\u0000.msh"\nscale = 1')), SceneError, "mesh.file = ")


def test_check_says_what_was_done(tmp_path: Path) -> None:
    path = scene(tmp_path, MESH)
    code, shown = call("check", path)
    assert code == 0
    assert (
        f"Mesh     {tmp_path / 'sail.msh'}, in units of 0.001 m\n  2 cells left out, which are given twice\n" in shown
    )
    code, shown = call("check", path, "--json")
    document = json.loads(shown)
    assert (document["mesh"]["scale"], document["ok"]) == (0.001, True)
    assert '1 quadrilateral split into triangles by the rule "shorter"' in document["mesh"]["steps"]


def test_a_new_scene_from_one_with_a_mesh_of_gmsh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    path = scene(tmp_path, MESH)
    assert call("new", "other", "--from", path, "--set", "material.thickness=5um")[0] == 0
    made = Scene.from_toml(tmp_path / "other.toml")
    assert (made.mesh is not None, made.material and made.material.thickness) == (True, 5e-6)


def test_a_mesh_is_converted(tmp_path: Path) -> None:
    path = text_file(tmp_path / "sail.msh", GMSH_22)
    code, shown = call("convert", path, "--scale", "mm")
    assert code == 0
    assert f"{path}, in units of 0.001 m\n" in shown
    assert f"Wrote {tmp_path / 'sail.npz'}: 6 nodes, 4 triangles, 0.02 x 0.01 x 0 m" in shown
    mesh = Mesh.load(tmp_path / "sail.npz")
    assert mesh.triangle_sets["left half"].tolist() == [0, 1]
    code, shown = call("convert", path, "--scale", "mm")
    assert code == 2
    assert f"{tmp_path / 'sail.npz'}: is there already; choose another name by --out, or replace it" in shown
    code, shown = call(
        "convert", path, "--scale", "0.1", "--quads", "alternate", "--merge", "1 nm", "--overwrite", "--json"
    )
    assert code == 0
    document = json.loads(shown)
    assert (document["nodes"], document["triangles"], document["of"]["scale"]) == (6, 4, 0.1)
    assert document["node_sets"]["held edge"] == 2
    assert document["triangle_sets"] == {"film": 4, "left half": 2}
    assert Mesh.load(tmp_path / "sail.npz").reference.max() == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("sail.msh",), "--scale: is missing; a .msh file does not say"),
        (("sail.msh", "--scale", "parsec"), "--scale = '1 parsec': unit 'parsec' is not known"),
        (("sail.msh", "--scale", "-1"), "--scale = -1.0: must be at least 1e-12"),
        (("sail.msh", "--scale", "mm", "--quads", "long"), "--quads = 'long': must be 'shorter' or 'alternate'"),
        (("sail.msh", "--scale", "mm", "--merge", "0"), "--merge = 0.0: must be greater than 0"),
        (("sail.msh", "--scale", "mm", "--out", "a.obj"), "must end in .npz"),
        (("none.msh", "--scale", "mm"), "none.msh: there is no such mesh file"),
        (("sail.txt", "--scale", "mm"), "its suffix '.txt' is that of no mesh file"),
        (("bad.obj", "--scale", "mm"), "bad.obj: holds no points"),
    ],
)
def test_what_is_not_converted(
    words: tuple[str, ...], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text_file(tmp_path / "sail.msh", GMSH_22)
    text_file(tmp_path / "bad.obj", "nothing")
    code, shown = call("convert", *words)
    assert code == 2
    assert said in shown
    assert list(tmp_path.glob("*.npz")) == []


def test_sets_of_triangles_are_checked_saved_and_marked(tmp_path: Path) -> None:
    mesh = patch(triangle_sets={"film": [1, 0], "none": []})
    assert mesh.triangle_sets["film"].tolist() == [1, 0]
    mesh.save(tmp_path / "mesh.npz")
    assert "triangle_set:film" in np.load(tmp_path / "mesh.npz")
    again = Mesh.load(tmp_path / "mesh.npz")
    assert {name: rows.tolist() for name, rows in again.triangle_sets.items()} == {"film": [1, 0], "none": []}
    for given, words in (
        ({"film": [2]}, r"triangle_sets\['film'\]\[0\] = 2 is no triangle; indices run from 0 to 1"),
        ({"film": [-1]}, "is no triangle"),
        ({"film": [0, 0]}, "names a triangle twice"),
        ({"film": [[0]]}, "a list of triangle indices"),
        ({"film": [0.5]}, "whole numbers, triangle indices"),
        ({"": [0]}, "triangle_sets: the name '': must be 1 to 1000 characters"),
        ([0], "triangle_sets must be a dict"),
    ):
        refused(lambda given=given: patch(triangle_sets=given), InputError, words)  # type: ignore[misc]
    scenes = [Scene(patch(**sets), FILM) for sets in ({}, {"triangle_sets": {"a": [0]}}, {"triangle_sets": {"a": [1]}})]
    assert len({mesh_mark(each) for each in scenes}) == 3
    assert set(SETS) == {"node_sets", "triangle_sets"}


def test_the_wrong_suffix_is_said(tmp_path: Path) -> None:
    text_file(tmp_path / "a.stl", OBJ)
    refused(lambda: Mesh.read(tmp_path / "a.stl", scale=1.0), InputError, r"a\.stl: is no STL file that can be read")
    points, quads = grid(1, 1)
    write(tmp_path / "a.vtu", points, [("quad", quads)]).rename(tmp_path / "a.obj")
    refused(lambda: Mesh.read(tmp_path / "a.obj", scale=1.0), InputError, r"a\.obj: ")
    refused(lambda: Mesh.read(tmp_path / "a.objj", scale=1.0), InputError, "suffix '.objj' .*did you mean '.obj'")
    refused(lambda: Mesh.load(tmp_path / "a.stl"), InputError, r"a\.stl.*is a mesh of another program")
