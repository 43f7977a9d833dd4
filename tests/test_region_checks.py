"""Regions and two moduli in the checks of a scene, and what its refusals name."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from membrane_rs import Bending, Fixed, Mesh, Rectangles, Region, Scene, Simulation, Springs, Tether, Triangles
from membrane_rs.check import audit, facts
from membrane_rs.errors import InputError, MeshError, SceneError
from membrane_rs.folding import Disc, Strip
from membrane_rs.mesh import Finding
from membrane_rs.scene.scales import natural_lengths
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
    [([1.0], "stiffness has shape (1,); it must be (2,)"), ([1.0, -2.0], "stiffness[1] = -2: must be 0 or greater")],
)
def test_a_stiffness_that_does_not_fit_is_refused(stiffness: list[float], words: str) -> None:
    for constants in (KITE.spring_constants, patch(creases=[], fold_angles=[]).rectangle_constants):
        refused(partial(constants, FILM, stiffness=np.array(stiffness)), InputError, re.escape(words))


@pytest.mark.parametrize("form", ["hinges", "curvature"])
def test_a_curvature_beyond_the_mesh_names_law_region_and_edge(form: Any) -> None:
    mesh = Strip(0.12, 0.04, 8, 4).mesh()
    half = len(mesh.triangles) // 2
    parts = [Fixed([0]), Region(range(half), thickness=1e-5), Region(range(half, 2 * half), curvature=(1e4, 0.0))]
    scene = Scene(mesh, FILM, [Springs(), Bending(form)], parts)
    words = r"laws.bending: the natural curvature of parts\[2\] folds edge \[\d+, \d+\] by \d+ degrees.*make it finer"
    refused(lambda: Simulation(scene), MeshError, words)


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (Springs(), r'laws.springs: its springs represent .* has 0.25 times .*take the law "triangles"'),
        (Rectangles(), r'laws.rectangles: its springs represent .* has 0.25 times .*take the law "triangles"'),
        (Triangles(0.1), "laws.triangles: triangles that wrinkle represent .*set compression"),
    ],
)
def test_two_moduli_are_refused_with_law_value_and_remedy(law: Any, words: str) -> None:
    fibres = replace(FILM, youngs_modulus_across=0.8e9, shear_modulus=0.5e9)
    scene = Scene(Strip(0.12, 0.06, 4, 2).mesh(), fibres, [law], [Fixed([0])])
    refused(lambda: Simulation(scene), InputError, words)


def test_a_node_without_mass_is_named_with_its_part_and_place() -> None:
    light = Scene(patch(), replace(FILM, density=1e-320), [Springs()], [Fixed([0])])
    words = r"node 1, of the mesh at \[0.2, 0.0, 0.0\] m, has a mass of 0e0 kg; give it mass"
    refused(lambda: Simulation(light), InputError, words)
    bare = Tether((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 2, 1.0, 0.0)
    words = r"parts\[1\].linear_density = 0: node \d+ has no mass \(\d such nodes\): give the cord a linear_density"
    refused(lambda: Scene(patch(), FILM, [Springs()], [Fixed([0]), bare]), SceneError, words)


def test_the_strain_at_the_start_is_that_beyond_the_natural_one() -> None:
    mesh, held = Strip(0.12, 0.04, 8, 4).mesh(), Fixed([0])
    half = len(mesh.triangles) // 2
    warm = Region(range(half), natural_strain=(0.012, -0.004), direction=0.6)
    stretched = np.array(mesh.reference)
    stretched[:, 0] *= 1.2
    taut = Mesh(mesh.reference, mesh.triangles, positions=stretched)

    def message(mesh: Mesh, *parts: Any) -> str:
        (finding,) = found_in(Scene(mesh, FILM, [Triangles(1.0)], [held, *parts]), "strain")
        return f"{finding.severity}: {finding.message}"

    assert message(mesh).startswith("info: strain at the start from 0 % to 0 %")
    assert message(mesh, warm).startswith("warning: strain at the start, beyond the natural strain, from -1.")
    assert message(taut).startswith("error: ")
    grown = message(taut, Region("all", natural_strain=(0.2, 0.0)))
    assert grown.startswith("info: strain at the start, beyond the natural strain,")
    assert "0 of " in grown


def test_natural_lengths_are_those_of_a_film_at_rest() -> None:
    """Of edges inside each region those of the stretched shape; of the border between two the mean."""
    mesh = Strip(0.12, 0.04, 8, 4).mesh()
    strain = (0.01, -0.02, 0.004)
    matrix = np.array([[1.0 + strain[0], strain[2]], [strain[2], 1.0 + strain[1]]])
    grown = np.array(mesh.reference)
    grown[:, :2] = grown[:, :2] @ matrix
    principal, axes = np.linalg.eigh(matrix - np.eye(2))
    direction = float(np.arctan2(axes[1, 0], axes[0, 0]))
    half = np.arange(len(mesh.triangles) // 2)
    region = Region(half.tolist(), natural_strain=(float(principal[0]), float(principal[1])), direction=direction)
    lengths = natural_lengths(Scene(mesh, FILM, [Springs()], [Fixed([0]), region]), mesh)
    inside = np.bincount(mesh.triangle_edges[half].ravel(), minlength=len(mesh.edges)) / mesh.triangles_per_edge
    assert set(inside) == {0.0, 0.5, 1.0}
    assert_allclose(lengths, inside * mesh.lengths_in(grown) + (1.0 - inside) * mesh.edge_lengths, rtol=1e-14)


def test_moduli_and_regions_in_use_are_listed() -> None:
    fibres = replace(FILM, youngs_modulus_across=0.8e9, shear_modulus=0.5e9, direction=0.4)
    scene = Scene(
        Strip(0.12, 0.06, 4, 2).mesh(), fibres, [Triangles(1.0)], [Fixed([0]), Region([0, 1], thickness=1e-5)]
    )
    words = "E 3.2e+09 Pa at 22.92 degrees from x, nu 0.34; 8e+08 Pa across; G 5e+08 Pa"
    assert facts(scene)["moduli"] == words
    assert facts(scene)["regions"] == "2 of 16 triangles (parts[1])"
    assert [finding.message for finding in found_in(scene, "two_moduli")] == [f"the film has two moduli: {words}"]
    assert any(finding.kind == "two_moduli" for finding in Simulation(scene).audit().findings)
    stiff = replace(scene, material=replace(fibres, shear_modulus=1e13))
    assert any(finding.message.startswith("material.shear_modulus = 1e+13 Pa") for finding in audit(stiff).warnings)
    assert not {"moduli", "regions"} & facts(Scene(patch(), FILM, [Springs()], [Fixed([0])])).keys()


WIDE = [(0.03, -0.05), (0.12, -0.05), (0.12, 0.05), (0.03, 0.05)]


def test_copies_that_overlap_with_other_directions_are_refused_with_both_and_a_triangle() -> None:
    mesh = Disc(0.1, rings=6).mesh()

    def scene(polygon: Any, copies: int, **film: Any) -> Scene:
        return Scene(mesh, FILM, [Springs()], [Fixed("rim"), Region(polygon=polygon, copies=copies, **film)])

    words = (
        r"parts\[1\].copies = 6: copies 0 and 1 share triangle (\d+) \(\d+ such\), where their directions differ; take"
    )
    with pytest.raises(SceneError, match=words) as caught:
        scene(WIDE, 6, curvature=(4.0, 0.0))
    found = re.search(words, str(caught.value))
    assert found is not None
    x, y = mesh.reference[mesh.triangles[int(found[1])], :2].mean(axis=0)
    for angle in (0.0, math.pi / 3):
        along, across = x * math.cos(angle) + y * math.sin(angle), y * math.cos(angle) - x * math.sin(angle)
        assert 0.03 < along < 0.12
        assert abs(across) < 0.05
    refused(lambda: scene(WIDE, 6, natural_strain=(0.0, 1e-3)), SceneError, "share triangle")
    # The same film in all directions, or that of a copy half a turn apart: what they share is of both.
    assert len(scene(WIDE, 6, curvature=(4.0, 4.0)).assemble().regions) == 1
    assert len(scene(WIDE, 6, thickness=1e-5).assemble().regions) == 1
    through = [(-0.12, -0.02), (0.12, -0.02), (0.12, 0.02), (-0.12, 0.02)]
    assert len(scene(through, 2, curvature=(4.0, 0.0)).assemble().regions) == 1


def test_copies_that_touch_do_not_overlap() -> None:
    """Quarters of a square of triangles, some of whose centres lie on the borders of the quarters, to rounding."""
    side = np.linspace(-0.1, 0.1, 8)
    points = np.stack([*np.meshgrid(side, side, indexing="ij"), np.zeros((8, 8))], axis=-1).reshape(-1, 3)
    corner = (8 * np.arange(7)[:, None] + np.arange(7)).ravel()
    lower, upper = (np.stack([corner, corner + a, corner + b], axis=1) for a, b in ((8, 9), (9, 1)))
    mesh = Mesh(points, np.concatenate([lower, upper]))
    centre = mesh.reference[mesh.triangles].mean(axis=1)[:, :2]
    assert (np.abs(np.abs(centre[:, 0]) - np.abs(centre[:, 1])) < 1e-12).any()
    quarter = [(0.0, 0.0), (0.3, -0.3), (0.3, 0.3)]
    regions = Scene(
        mesh, FILM, [Springs()], [Fixed([0]), Region(polygon=quarter, copies=4, curvature=(1.0, 0.0))]
    ).assemble().regions  # fmt: skip
    assert sum(len(region.triangles) for region in regions) >= len(mesh.triangles) - 4
