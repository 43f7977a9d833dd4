"""One scene on coarser and finer meshes: what is multiplied, what stays, what is refused."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from example_of import example_of
from membrane_rs import CreaseSet, Fixed, InputError, Mesh, Scene, TipMasses, scenes
from membrane_rs.folding import PATTERNS, SquareSail, Strip
from membrane_rs.study.common.density import denser
from small_scenes import RUBBER, UNBUCKLED, hanging_strip, refused


@pytest.mark.parametrize("name", PATTERNS)
def test_triangles_go_with_the_square_of_the_density(name: str) -> None:
    scene = Scene(example_of(PATTERNS[name]).mesh(), RUBBER, [UNBUCKLED])
    finer = denser(scene, 2.0)
    meshes = [one.mesh for one in (scene, finer, denser(finer, 0.5))]
    plain, fine, back = (mesh for mesh in meshes if mesh is not None)
    assert len(fine.triangles) == pytest.approx(4 * len(plain.triangles), rel=0.1)
    assert len(back.triangles) == len(plain.triangles)
    assert np.ptp(fine.reference, axis=0) == pytest.approx(np.ptp(plain.reference, axis=0), rel=0.15)
    assert fine.node_sets.keys() == plain.node_sets.keys()


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
    creased = Strip(0.1, 0.02, 4, 2, creases=(0.5,)).mesh()
    fold = Scene(creased, RUBBER, [UNBUCKLED], [CreaseSet([0], stiffness=1.0)], name="fold")
    refused(lambda: denser(fold, 2.0), InputError, r"parts.0.creases .* creases by number, .* a node set, or mountains")
