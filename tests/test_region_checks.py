"""Regions in the checks of a scene: spring constants by the film of each triangle."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from membrane_rs import Fixed, Mesh, Rectangles, Region, Scene, Simulation, Springs
from membrane_rs.check import audit
from membrane_rs.errors import InputError, MeshError
from membrane_rs.mesh import Finding
from numpy.testing import assert_allclose
from small_scenes import FILM, patch, refused

KITE = Mesh([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.25, 0.0], [0.5, -0.8, 0.0]], [[0, 1, 2], [1, 0, 3]])
"""An obtuse triangle, whose longest side is negative by itself, beside one that makes up for it."""
LADDER = Mesh(
    [[x, y, 0.0] for y in (0.0, 2.0, 3.0, 5.0) for x in (0.0, 2.0)],
    [[0, 1, 3], [0, 3, 2], [2, 3, 5], [2, 5, 4], [4, 5, 7], [4, 7, 6]],
)
"""A rectangle of 2:1 between two squares, whose long sides hold by these alone."""


def found_in(scene: Scene, kind: str) -> list[Finding]:
    return [finding for finding in audit(scene).findings if finding.kind == kind]


def test_a_stiff_region_turns_a_spring_negative_and_the_audit_says_so() -> None:
    plain, stiff = (
        Scene(KITE, FILM, [Springs()], [Fixed([0]), *parts]) for parts in ((), (Region([0], thickness=1e-3),))
    )
    assert not found_in(plain, "negative_springs")
    Simulation(plain)
    (finding,) = found_in(stiff, "negative_springs")
    constants = KITE.spring_constants(FILM, stiffness=stiff.membrane_stiffness())
    assert finding.severity == "error"
    assert f"down to {constants.min():.4g} N/m (edge 0, nodes [0, 1])" in finding.message
    assert found_in(stiff, "growing_mode")
    refused(lambda: Simulation(stiff), MeshError, r"constants are negative, the worst -.* N/m on edge \[0, 1\]")


def test_a_stiff_region_of_slender_rectangles_is_refused_by_audit_and_core_alike() -> None:
    plain, stiff = (
        Scene(LADDER, FILM, [Rectangles()], [Fixed([0]), *parts])
        for parts in ((), (Region([2, 3], youngs_modulus=3.2e12),))
    )
    assert not found_in(plain, "rectangles")
    Simulation(plain)
    (finding,) = found_in(stiff, "rectangles")
    refused(lambda: Simulation(stiff), MeshError, "spring constants of rectangles are negative")
    with pytest.raises(MeshError) as error:
        Simulation(stiff)
    assert str(error.value).startswith(finding.message)


@pytest.mark.parametrize("softening", [None, 10.0])
def test_constants_are_the_sums_over_the_films(softening: float | None) -> None:
    mesh, film = patch(creases=[], fold_angles=[]), replace(FILM, softening=softening)
    scene = Scene(mesh, film, [Springs()], [Fixed([0]), Region([1], youngs_modulus=6.4e9, thickness=15e-6)])
    stiffness = scene.membrane_stiffness()
    assert_allclose(stiffness, np.array([3.2e9 * 7.5e-6, 6.4e9 * 15e-6]) / (softening or 1.0), rtol=1e-15)
    alone = [Mesh(mesh.reference[corners], [[0, 1, 2]]) for corners in mesh.triangles]
    summed = np.zeros(len(mesh.edges))
    for row, own in enumerate(alone):
        edges, _ = mesh.find_edges(mesh.triangles[row][own.edges])
        summed[edges] += own.spring_constants(film, stiffness=stiffness[row : row + 1])
    assert_allclose(mesh.spring_constants(film, stiffness=stiffness), summed, rtol=1e-14)
    # Both halves of a rectangle: the mean of 1 and 4 films.
    whole = mesh.rectangle_constants(FILM) / (softening or 1.0)
    assert_allclose(mesh.rectangle_constants(film, stiffness=stiffness), 2.5 * whole, rtol=1e-14)


@pytest.mark.parametrize(
    ("stiffness", "words"),
    [([1.0], "stiffness has shape (1,); it must be (2,)"), ([1.0, 0.0], "stiffness[1] = 0: must be greater than 0")],
)
def test_a_stiffness_that_does_not_fit_is_refused(stiffness: list[float], words: str) -> None:
    for constants in (KITE.spring_constants, patch(creases=[], fold_angles=[]).rectangle_constants):
        refused(partial(constants, FILM, stiffness=np.array(stiffness)), InputError, re.escape(words))
