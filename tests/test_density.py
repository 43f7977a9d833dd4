"""One scene on coarser and finer meshes: what is multiplied, what stays, what is refused."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from membrane_rs import Fixed, InputError, Mesh, Scene, TipMasses, scenes
from membrane_rs.folding import PATTERNS, Disc, EquilateralLattice, SquareSail, Strip
from membrane_rs.study.common.density import denser
from small_scenes import RUBBER, UNBUCKLED, hanging_strip, refused

SMALL: dict[str, Any] = {
    "square-sail": SquareSail(fold_lines=3),
    "disc": Disc(0.1, rings=4),
    "strip": Strip(0.1, 0.04, 6, 2),
    "lattice": EquilateralLattice(0.01, 4, 4),
}


def test_every_pattern_is_walked() -> None:
    assert SMALL.keys() == PATTERNS.keys()


@pytest.mark.parametrize("name", SMALL)
@pytest.mark.parametrize("density", [0.5, 2.0])
def test_triangles_go_with_the_square_of_the_density(name: str, density: float) -> None:
    scene = Scene(SMALL[name].mesh(), RUBBER, [UNBUCKLED])
    found = denser(scene, density)
    assert scene.mesh is not None
    assert found.mesh is not None
    assert len(found.mesh.triangles) == pytest.approx(density**2 * len(scene.mesh.triangles), rel=0.1)
    size, before = (np.ptp(mesh.reference, axis=0) for mesh in (found.mesh, scene.mesh))
    assert size == pytest.approx(before, rel=0.15)
    assert found.mesh.node_sets.keys() == scene.mesh.node_sets.keys()


def test_the_same_density_is_the_same_scene() -> None:
    scene = hanging_strip()
    assert denser(scene, 1.0) is scene


def test_model_1_halves_to_one_row_a_strip() -> None:
    found = denser(scenes.load("okuizumi-model-1"), 0.5)
    assert found.mesh is not None
    assert isinstance(found.mesh.source, SquareSail)
    assert found.mesh.source.rows == 8
    refused(lambda: denser(found, 0.5), InputError, "rows_per_strip = 1 would become 0.5.*take 1")


def test_tip_masses_on_a_set_keep_their_sum() -> None:
    scene = replace(hanging_strip(), parts=[Fixed("start"), TipMasses(1e-3, "end")])
    found = denser(scene, 2.0)
    masses = []
    for case in (scene, found):
        assert case.mesh is not None
        tips = case.parts[1]
        assert isinstance(tips, TipMasses)
        masses.append(tips.mass * len(case.mesh.node_sets["end"]))
    assert masses[0] == pytest.approx(masses[1])


@pytest.mark.parametrize("density", [0.0, -1.0, math.nan, math.inf, True, "2"])
def test_a_density_is_a_number_above_zero(density: Any) -> None:
    refused(lambda: denser(hanging_strip(), density), InputError, "density = .*must be a number greater than 0")


def test_what_no_pattern_made_keeps_its_mesh() -> None:
    mesh = hanging_strip().mesh
    assert mesh is not None
    own = Scene(Mesh(mesh.reference, mesh.triangles), RUBBER, [UNBUCKLED], name="own")
    refused(
        lambda: denser(own, 2.0), InputError, "scene 'own' has a mesh of its own; only the mesh of a folding pattern"
    )
    refused(lambda: denser(scenes.load("spinning-tether"), 2.0), InputError, "has no mesh")


def test_nodes_by_number_belong_to_one_mesh() -> None:
    scene = replace(hanging_strip(), parts=[Fixed((0, 1, 2))])
    refused(lambda: denser(scene, 2.0), InputError, r"parts.0.nodes of scene 'hanging' names nodes by number")
