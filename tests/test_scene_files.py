"""Scene files: from TOML and back with every bit, and what is refused, by file, key and value."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from membrane_rs.errors import MissingFileError, OutputError, SceneError
from membrane_rs.scene import Scene
from membrane_rs.scene.laws import Creases, Law, Spin, SpringDamping, Springs
from membrane_rs.scene.parts import Fixed
from small_scenes import FILM, cord, patch


def write(folder: Path, text: str) -> Path:
    path = folder / "own.toml"
    path.write_text(text, encoding="utf-8")
    return path


TEXT = """
[mesh]
pattern = "strip"
length = 0.04
width = 0.02
columns = 2
creases = [0.5]

[material]
youngs_modulus = 3.2e9
poisson_ratio = 0.34
density = 1420.0
thickness = 7.5e-6

[laws.springs]

[laws.creases]
stiffness = 5.0

[[parts]]
kind = "fixed"
nodes = "start"

[run]
until = 0.1
"""


def test_scene_from_toml(tmp_path: Path) -> None:
    scene = Scene.from_toml(write(tmp_path, TEXT))
    assert scene.name == "own"
    assert scene.laws == (Springs(), Creases(stiffness=5.0))
    assert scene.law("creases") == Creases(stiffness=5.0)
    assert scene.law("spin") is None
    assert scene.run.until == 0.1
    assert Scene.from_toml(str(tmp_path / "own.toml")).to_toml() == scene.to_toml()


def test_mesh_of_no_pattern_is_kept_beside_the_scene(tmp_path: Path) -> None:
    stowed = np.add(patch().reference, [0.0, 0.0, 1e-3])
    scene = Scene(patch(positions=stowed), FILM, [Springs()], [Fixed("corners")], name='a "name"\x7f\n')
    scene.save(tmp_path / "new" / "folder")
    again = Scene.from_toml(tmp_path / "new" / "folder" / "scene.toml")
    assert again.name == scene.name
    assert again.mesh is not None
    assert scene.mesh is not None
    for name in ("reference", "triangles", "positions", "creases", "fold_angles", "bridges"):
        assert (getattr(again.mesh, name) == getattr(scene.mesh, name)).all()
    assert again.mesh.node_sets["corners"].tolist() == [1, 3]
    assert not list(tmp_path.rglob("*.part"))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("stiffness = 5.0", "stiffness = -5.0", r"laws\.creases\.stiffness = -5\.0: must be at least 0"),
        (
            "stiffness = 5.0",
            "stifness = 5.0",
            r"laws\.creases\.stifness: no such key; did you mean 'stiffness'",
        ),
        ("stiffness = 5.0", "stiffness = nan", "must be finite"),
        ("stiffness = 5.0", "stiffness = true", "must be a number"),
        ("stiffness = 5.0", "self = 5.0", r"laws\.creases\.self: no such key"),
        ("[laws.creases]", "[laws.crease]", "laws = 'crease': is not known; did you mean 'creases'"),
        ("[laws.creases]", "[law.creases]", "law: no such key; did you mean 'laws'"),
        ("[laws.springs]", "[laws]\nsprings = 3", r"laws\.springs = 3: must be a table"),
        (
            "thickness = 7.5e-6",
            "thickness = -1e-6",
            r"material\.thickness = -1e-06: must be greater than 0 \(m\)",
        ),
        ("thickness = 7.5e-6", "", r"material\.thickness: is missing"),
        ("poisson_ratio = 0.34", "poisson_ratio = 0.5", r"greater than -1 and less than 0\.5"),
        (
            'pattern = "strip"',
            'pattern = "stripe"',
            r"mesh\.pattern = 'stripe': is not known; did you mean 'strip'",
        ),
        ('pattern = "strip"', "", "must hold either pattern"),
        ('pattern = "strip"', 'file = "x.npz"', "no such key beside file"),
        ("width = 0.02", "width = inf", r"mesh\.width = inf: must be finite"),
        ("creases = [0.5]", "creases = [0.3]", r"mesh\.creases"),
        (
            'nodes = "start"',
            'nodes = "strat"',
            r"parts\[0\]\.nodes = 'strat': no such node set; did you mean 'start'",
        ),
        ('nodes = "start"', "nodes = [99]", "node 99 is not there"),
        ('kind = "fixed"', 'kind = "fix"', r"parts\[0\]\.kind = 'fix': is not known; did you mean 'fixed'"),
        ('kind = "fixed"', "", r"parts\[0\]\.kind: is missing"),
        ("[[parts]]", "[parts]", "must be a list of tables"),
        ("until = 0.1", "until = 0", r"run\.until = 0: must be greater than 0 \(s\)"),
        (
            "until = 0.1",
            "until = 0.1\ndt = -5",
            r"run\.dt = -5: must be greater than 0 \(s\)",
        ),
        ("until = 0.1", "until = ", "no valid TOML"),
        ("until = 0.1", f"until = {5000 * '9'}", "an integer of thousands of digits"),
        ("until = 0.1", f"until = 0x{5000 * 'f'}", r"run\.until = a number of thousands of digits: must be finite"),
        ("until = 0.1", f"frames = 0x{5000 * 'f'}", r"run\.frames = a number of thousands of digits: must be at least"),
        ("[mesh]", "name = 3\n[mesh]", "name = 3: must be a text"),
        ("[mesh]", "mesh = 3\n[messh]", "no such key"),
    ],
)
def test_bad_toml(old: str, new: str, words: str, tmp_path: Path) -> None:
    assert TEXT.count(old) == 1
    with pytest.raises(SceneError, match=words) as caught:
        Scene.from_toml(write(tmp_path, TEXT.replace(old, new)))
    assert str(caught.value).startswith(str(tmp_path / "own.toml"))


def test_files_that_are_not_there_or_no_scenes(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match="no such scene file"):
        Scene.from_toml(tmp_path / "none.toml")
    with pytest.raises(SceneError, match="cannot be read"):
        Scene.from_toml(tmp_path)
    with pytest.raises(SceneError, match=r"deep.*(nested too deeply|no valid TOML)"):
        Scene.from_toml(write(tmp_path, f"deep = {100_000 * '['}").rename(tmp_path / "deep.toml"))
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(SceneError, match="UTF-8"):
        Scene.from_toml(tmp_path / "binary.toml")


def test_mesh_files_that_are_not_there_or_no_meshes(tmp_path: Path) -> None:
    path = write(tmp_path, '[mesh]\nfile = "mesh.npz"\n')
    with pytest.raises(MissingFileError, match="no such mesh file"):
        Scene.from_toml(path)
    for content in (b"", b"junk", b"PK\x03\x04junk"):
        (tmp_path / "mesh.npz").write_bytes(content)
        with pytest.raises(SceneError, match="no numpy archive"):
            Scene.from_toml(path)
    np.savez(tmp_path / "mesh.npz", reference=np.zeros((3, 3)))
    with pytest.raises(SceneError, match="holds no array 'triangles'"):
        Scene.from_toml(path)
    np.savez(tmp_path / "mesh.npz", reference=np.zeros((3, 3)), triangles=np.array([[0, 1, 9]]))
    with pytest.raises(SceneError, match=r"own\.toml: .*9"):
        Scene.from_toml(path)
    with pytest.raises(SceneError, match="must be the path of a"):
        Scene.from_toml(write(tmp_path, '[mesh]\nfile = "mesh.txt"\n'))


def test_folder_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot write"):
        Scene(patch(), FILM).save(tmp_path / "file" / "folder")


finite = st.floats(allow_nan=False, allow_infinity=False)
NAMES = st.text(st.characters(exclude_characters="/\\\0", exclude_categories=["Cs"]), min_size=1, max_size=100).filter(
    lambda name: name not in (".", "..")
)
LAW_VALUES = st.builds(
    lambda a, b, c, d, e: [Springs(a, b), SpringDamping(c), Spin(d, e)],
    st.floats(0, 1e300),
    st.floats(0, 1e300),
    st.floats(0, 1e300),
    finite,
    finite,
)


@settings(max_examples=50)
@given(LAW_VALUES, NAMES)
def test_toml_keeps_every_bit(tmp_path_factory: pytest.TempPathFactory, laws: list[Law], name: str) -> None:
    scene = Scene(None, None, laws, [cord()], name=name)
    path = tmp_path_factory.mktemp("toml") / "scene.toml"
    path.write_text(scene.to_toml(), encoding="utf-8", newline="")
    again = Scene.from_toml(path)
    assert (again.laws, again.parts, again.name) == (scene.laws, scene.parts, scene.name)
