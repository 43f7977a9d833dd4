"""Hostile and mistaken values of regions, sets of creases, cords and boltropes: refused at once, by value and place."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    Boltrope,
    Cord,
    CreaseSet,
    InputError,
    Material,
    Mesh,
    Region,
    Scene,
    SceneError,
    Springs,
)
from membrane_rs.folding import Strip
from small_scenes import refused

FILM = Material(3.2e9, 0.34, 1420.0, 7.5e-6)
STRIP = Strip(0.1, 0.02, columns=10, rows=2).mesh()
CREASED = Mesh(STRIP.reference, STRIP.triangles, creases=[(1, 4), (4, 7)], fold_angles=[1.0, 2.0])
SQUARE = [(0.0, -0.02), (0.05, -0.02), (0.05, 0.02), (0.0, 0.02)]
ROPE: dict[str, Any] = {"segments": 4, "axial_stiffness": 10.0, "linear_density": 1e-3}
HEM: dict[str, Any] = {"axial_stiffness": 10.0, "linear_density": 1e-3}
MANY: Any = np.zeros((10**7, 2))
ONE: Any = np.array(1.0)
HOOK = (0.0, 0.0, 1.0)
Part = Region | CreaseSet | Cord | Boltrope


def scene_with(*parts: Part, mesh: Mesh = STRIP) -> Scene:
    return Scene(mesh, FILM, [Springs()], parts)


@pytest.mark.parametrize(
    ("make", "kind", "words"),
    [
        (lambda: Region([]), InputError, "Region.triangles = []: must hold at least one triangle"),
        (lambda: Region(polygon=MANY), InputError, "must hold at most 100000 points (m)"),
        (lambda: Region(polygon=ONE), InputError, "must be a list of points"),
        (lambda: Region([3, 3]), InputError, "must not name a triangle twice"),
        (lambda: Region(["a", "a"]), InputError, "must not name a triangle set twice"),
        (lambda: Region("all", curvature=(1e300, 0.0)), InputError, "curvature = (1e+300, 0.0): each must be -1e9"),
        (
            lambda: Region(polygon=[(-1e308, 0.0), (1e308, 0.0), (0.0, 1.0)]),
            InputError, "corner (-1e+308, 0.0) must be within 1e+12 of the origin (m)",
        ),
        (
            lambda: scene_with(Region(polygon=[(0.0, 0.0), (5e-324, 0.0), (0.0, 5e-324)])),
            SceneError, "there is no triangle of the mesh in it",
        ),
        (
            lambda: scene_with(Region(polygon=SQUARE, copies=10**9, curvature=(1.0, 0.0))),
            SceneError, "parts[0].copies = 1000000000: 1000000000 polygons of 4 corners take too long in 40 triangles",
        ),
        (
            lambda: scene_with(Region([1, 2]), Region([5]), Region([4, 5, 2, 1])),
            SceneError, "parts[2]: triangle 1 (2 such) belongs to parts[0] too",
        ),
        (lambda: CreaseSet([0, 0], stiffness=1.0), InputError, "must not name a row twice"),
        (
            lambda: scene_with(CreaseSet([1], fold="mountain", stiffness=1.0), mesh=CREASED),
            SceneError, "no crease of the mesh is meant by creases = (1,) and fold = 'mountain'",
        ),
        (
            lambda: scene_with(Cord(HOOK, 0, **ROPE, name="cord-1"), Cord(HOOK, 1, **ROPE)),
            SceneError, "parts[1]: the name 'cord-1' is taken",
        ),
        (lambda: scene_with(Cord(HOOK, "x" * 10**5, **ROPE)), SceneError, "...: no such node set"),
    ],
)  # fmt: skip
def test_mistakes_are_named_in_short(make: Any, kind: type[Exception], words: str) -> None:
    with pytest.raises(kind, match=re.escape(words)) as caught:
        make()
    assert len(str(caught.value)) < 300


def test_all_of_the_film_is_a_set_also_in_a_list() -> None:
    one, listed = (scene_with(Region(name, thickness=1e-5)).assemble().regions[0] for name in ("all", ["all"]))
    assert np.array_equal(one.triangles, listed.triangles)


def test_a_path_through_many_nodes_is_found_or_refused_at_once() -> None:
    """Between neighbours no search goes through the mesh, and a path that crosses itself ends where it does."""
    mesh = Strip(1.0, 1.0, columns=200, rows=200).mesh()
    side = scene_with(Boltrope(range(201), **HEM), mesh=mesh).assemble().node_sets["boltrope-0"]
    assert np.array_equal(side, np.arange(201))
    shuffled = np.random.default_rng(1).permutation(40000)
    refused(
        lambda: scene_with(Boltrope(shuffled.tolist(), **HEM), mesh=mesh),
        SceneError,
        "twice; name more nodes on the way",
    )


def test_corners_of_polygons_may_have_units(tmp_path: Path) -> None:
    text = """
        [mesh]
        pattern = "strip"
        length = 0.1
        width = 0.02
        columns = 10
        rows = 2
        [material]
        youngs_modulus = 3.2e9
        poisson_ratio = 0.34
        density = 1420
        thickness = 7.5e-6
        [laws.springs]
        [[parts]]
        kind = "region"
        polygon = CORNERS
    """
    file = tmp_path / "scene.toml"
    file.write_text(text.replace("CORNERS", '[["0 mm", "-2 cm"], ["5 cm", "-2 cm"], ["5 cm", 0.02], [0, 0.02]]'))
    assert Scene.from_toml(file).parts == (Region(polygon=SQUARE),)
    for corners, words in (
        ('"x"', "polygon = 'x': must be a list of points"),
        ('[["1 s", 0], [1, 0], [1, 1]]', "polygon[0][0] = '1 s': is a time; must be a length"),
        ('[[["1 m"], 0], [1, 0], [1, 1]]', "polygon[0][0] = ['1 m']: must be a number"),
    ):
        file.write_text(text.replace("CORNERS", corners))
        refused(lambda: Scene.from_toml(file), InputError, re.escape(words))


def test_mistakes_between_fields_name_their_place_in_a_file(tmp_path: Path) -> None:
    """Also those that name no single field."""
    text = "[laws.gravity]\n[mesh]\npattern = 'spiral-hexagon'\nlayer_gap = 0.01\n"
    (tmp_path / "scene.toml").write_text(text)
    with pytest.raises(SceneError, match=r"^\S*scene.toml: mesh: the layers .* or a smaller layer_gap$"):
        Scene.from_toml(tmp_path / "scene.toml")
    for part, words in (
        ("region", "parts[1]: no triangles are named"),
        ("crease_set", "parts[1]: no property is given"),
    ):
        text = f'[laws.gravity]\n[[parts]]\nkind = "fixed"\nnodes = [0]\n[[parts]]\nkind = "{part}"\n'
        (tmp_path / "scene.toml").write_text(text)
        refused(lambda: Scene.from_toml(tmp_path / "scene.toml"), InputError, re.escape(words))
