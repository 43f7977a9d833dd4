"""Folding of flat patterns: against closed forms, the same bits, and what is refused."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from folding import PARTS, file
from folding_cases import SECTORS, distance, multiplier, rigid_tilt, sheet, square_twist, vertex
from membrane_rs import Creases, InputError, InputTypeError, Mesh, MeshError, Scene, Simulation, Triangles, fold
from membrane_rs.folding import SquareSail, Strip
from small_scenes import FILM, refused

FLAT = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
TWO = [[0, 1, 2], [0, 2, 3]]


def square(angle: float, **values: object) -> Mesh:
    return Mesh(FLAT, TWO, creases=[[0, 2]], fold_angles=[angle], **values)  # type: ignore[arg-type]


@pytest.mark.parametrize("tilt", [0.2, 0.8, 1.2, 1.5])
@pytest.mark.parametrize("increments", [1, 4])
def test_a_miura_sheet_folds_to_its_closed_form(tilt: float, increments: int) -> None:
    mesh = sheet(tilt).mesh()
    found = fold(mesh, increments=increments)
    assert found.faults == ()
    assert np.abs(found.errors).max() < 1e-6
    assert found.largest_strain < 1e-9
    assert found.largest_bend < 1e-5
    assert found.crossings.count == 0
    assert distance(found.mesh.positions, mesh.positions) < 1e-7
    np.testing.assert_allclose(found.mesh.fold_angles, mesh.fold_angles, atol=1e-6)


@pytest.mark.parametrize("fraction", [0.3, 0.6, 0.9])
def test_stiff_panels_meet_angles_in_the_mean_as_rigid_ones(fraction: float) -> None:
    pattern = sheet(1.5)
    rigid = replace(pattern, tilt=rigid_tilt(pattern, fraction)).mesh()
    distances = []
    for stiffness in (10.0, 100.0, 1000.0):
        found = fold(pattern.mesh(), fraction, facet_stiffness=stiffness)
        assert found.largest_strain < 2e-4
        distances.append(distance(found.mesh.positions, rigid.positions))
    assert distances[0] > 3.0 * distances[1] > 9.0 * distances[2]
    assert distances[2] < 5e-4 * pattern.zigzag_side


@pytest.mark.parametrize("letters", ["MVMM", "VMVV"])
@pytest.mark.parametrize("fraction", [0.3, 0.6, 0.9])
def test_a_vertex_keeps_the_ratio_of_its_tangents(letters: str, fraction: float) -> None:
    found = fold(vertex(SECTORS, letters), fraction)
    first, second, third, fourth = np.tan(0.5 * found.angles)
    assert found.largest_strain < 2e-4
    assert abs(first / third - 1.0) < 1e-5
    assert abs(second / fourth + 1.0) < 1e-5
    assert abs(abs(first / second) / multiplier(SECTORS) - 1.0) < 3e-3
    assert [np.sign(angle) for angle in found.angles] == [1.0 if letter == "V" else -1.0 for letter in letters]


@pytest.mark.parametrize("parts", [1, 2])
def test_a_square_twist_folds_as_its_panels_bend(parts: int) -> None:
    mesh = square_twist().divided(parts)
    found = fold(mesh, 0.9)
    assert found.faults == ()
    assert found.largest_strain < 1e-3
    assert 0.05 < found.largest_bend < 0.5
    assert found.crossings.count == 0
    shut = fold(mesh)
    assert np.abs(shut.errors).max() < 1e-5
    assert shut.largest_strain < 1e-9
    # Sides of the middle and of the corners, parallel before, are at right angles: the middle has turned by a quarter.
    points = shut.mesh.positions
    assert abs((points[1] - points[0]) @ (points[5] - points[4])) < 1e-6 * 0.02 * 0.04


def test_the_bits_are_the_same_and_positions_do_not_matter() -> None:
    mesh = sheet(1.2).mesh()
    flat = Mesh(mesh.reference, mesh.triangles, creases=mesh.creases, fold_angles=mesh.fold_angles)
    one, two = fold(mesh, 0.7), fold(flat, 0.7)
    assert one.mesh.positions.tobytes() == fold(mesh, 0.7).mesh.positions.tobytes()
    assert one.mesh.positions.tobytes() == two.mesh.positions.tobytes()
    assert one.angles.tobytes() == two.angles.tobytes()


def test_a_folded_mesh_keeps_its_sets_and_files(tmp_path: Path) -> None:
    found = fold(sheet(1.2).mesh(), 0.7)
    assert set(found.mesh.node_sets) == set(sheet(1.2).mesh().node_sets)
    assert found.mesh.source is None
    for name in ("folded.npz", "folded.fold"):
        found.mesh.save(tmp_path / name)
        loaded = Mesh.load(tmp_path / name)
        assert loaded.positions.tobytes() == found.mesh.positions.tobytes()
        assert loaded.fold_angles.tobytes() == found.mesh.fold_angles.tobytes()
        assert set(loaded.node_sets) == set(found.mesh.node_sets)


def test_a_folded_mesh_is_at_rest_in_a_scene_whose_creases_keep_its_angles() -> None:
    mesh = fold(sheet(1.2).mesh(), 0.7).mesh
    sim = Simulation(Scene(mesh, FILM, [Triangles(compression=1.0), Creases(fold_fraction=1.0)]))
    assert np.abs(sim.crease_angles() - (math.pi - np.abs(mesh.fold_angles))).max() < 1e-9


def test_creases_without_an_angle_are_free() -> None:
    pattern = sheet(1.2).mesh()
    angles = pattern.fold_angles.copy()
    angles[[0, 20]] = 0.0
    mesh = Mesh(pattern.reference, pattern.triangles, creases=pattern.creases, fold_angles=angles)
    found = fold(mesh)
    assert distance(found.mesh.positions, pattern.positions) < 1e-6
    np.testing.assert_allclose(found.mesh.fold_angles, pattern.fold_angles, atol=1e-5)
    assert not found.errors[[0, 20]].any()


def test_the_page_shows_the_file_of_the_examples() -> None:
    assert PARTS["file"].read() == file()


@pytest.mark.parametrize("scale", [1e-6, 1e3])
def test_any_size_folds_alike(scale: float) -> None:
    mesh, large = (square_twist(), fold(square_twist(), 0.9))
    scaled = Mesh(scale * mesh.reference, mesh.triangles, creases=mesh.creases, fold_angles=mesh.fold_angles)
    found = fold(scaled, 0.9)
    np.testing.assert_allclose(found.angles, large.angles, atol=1e-3)


def test_progress_and_the_path() -> None:
    seen: list[tuple[int, int]] = []
    found = fold(square(1.0), 0.5, increments=4, progress=lambda done, total: seen.append((done, total)))
    assert seen == [(1, 4), (2, 4), (3, 4), (4, 4)]
    assert [increment.fraction for increment in found.increments] == [0.125, 0.25, 0.375, 0.5]
    assert found.steps == sum(increment.steps for increment in found.increments)
    assert found.as_dict()["steps"] == found.steps
    assert "Folded to 0.5 of the pattern's angles" in str(found)


def test_it_can_be_interrupted() -> None:
    def stop(_done: int, _total: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fold(square(1.0), progress=stop)


@pytest.mark.parametrize(
    ("letters", "sectors", "fraction", "words"),
    [
        ("MMMV", SECTORS, 1.0, r"creases\[.\] \(nodes 0 and .\) has folded to .* to the other side than its pattern"),
        ("MMMV", SECTORS, 0.9, "to the other side than its pattern"),
        ("VMMM", (70.0, 100.0, 120.0, 70.0), 1.0, "beyond 180, its facets have passed through each other"),
        ("VVV", (120.0, 120.0, 120.0), 1.0, "the creases have hardly folded: in the mean, to 0.0"),
        ("VVV", (120.0, 120.0, 120.0), 0.5, "have hardly folded: in the mean, to 0.0[0-9]* of the pattern's angles"),
    ],
)
def test_what_does_not_fold_flat_is_refused(
    letters: str, sectors: tuple[float, ...], fraction: float, words: str
) -> None:
    mesh = vertex(sectors, letters)
    with pytest.raises(MeshError, match=words):
        fold(mesh, fraction)
    found = fold(mesh, fraction, force=True)
    assert any(part for part in found.faults)
    assert found.mesh.fold_angles.shape == (len(letters),)


def test_angles_that_do_not_go_together_are_refused() -> None:
    pattern = sheet(1.2).mesh()
    angles = pattern.fold_angles.copy()
    angles[7] *= 0.5
    mesh = Mesh(pattern.reference, pattern.triangles, creases=pattern.creases, fold_angles=angles)
    with pytest.raises(MeshError, match=r"creases\[7\] .* such creases\): its facets do not let it"):
        fold(mesh)
    assert fold(mesh, force=True).worst_crease == 7
    assert fold(mesh, 0.5).faults == ()


def test_a_square_sail_is_no_flat_origami() -> None:
    with pytest.raises(MeshError, match=r"does not fold to 0\.9 of its angles"):
        fold(SquareSail(rows=8).mesh(), 0.9)


@pytest.mark.parametrize(
    ("mesh", "values", "kind", "words"),
    [
        (Strip(length=0.1, width=0.01, columns=10).mesh(), {}, MeshError, "the mesh has no creases"),
        (square(0.0), {}, MeshError, "the fold angles of all creases are 0"),
        (None, {}, InputTypeError, "mesh = None: must be a Mesh"),
        (square(1.0), {"fraction": 0.0}, InputError, "fraction = 0: must be above 0"),
        (square(1.0), {"fraction": 1.1}, InputError, "fraction = 1.1: must be above 0"),
        (square(1.0), {"fraction": -0.5}, InputError, "fraction = -0.5: must be above 0"),
        (square(1.0), {"fraction": math.nan}, InputError, "fraction = nan"),
        (square(1.0), {"fraction": "half"}, InputTypeError, "fraction = 'half'"),
        (square(1.0), {"increments": 0}, InputError, "increments = 0: must be from 1 to 1,000"),
        (square(1.0), {"facet_stiffness": 0.0}, InputError, "facet_stiffness = 0: must be above 0"),
        (square(1.0), {"strain_limit": -1.0}, InputError, "strain_limit = -1: must be above 0"),
        (square(1.0), {"force": "no"}, InputTypeError, "force = 'no'"),
    ],
)
def test_wrong_values_are_refused(mesh: Mesh, values: dict[str, object], kind: type[Exception], words: str) -> None:
    refused(lambda: fold(mesh, **values), kind, words)  # type: ignore[arg-type]


def test_a_reference_that_is_not_flat_is_refused() -> None:
    bent = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]])
    mesh = Mesh(bent, TWO, creases=[[0, 2]])
    with pytest.raises(MeshError, match=r"creases\[0\] \(nodes 0 and 2\) is folded by .* degrees in the reference"):
        fold(mesh)
