"""Fold angles agree with positions: taken from them where left out, and refused where they contradict them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import Creases, Fixed, Mesh, MeshError, Scene, Simulation, Springs
from membrane_rs.check import audit
from membrane_rs.folding import SquareSail, Strip
from membrane_rs.mesh.fold_angles import measured_fold_angles
from small_scenes import RUBBER, Floats, rotation

RNG = np.random.default_rng(3)
ANGLES = [*range(-170, 0, 35), -2, 2, *range(30, 171, 35)]


def wings(degrees: float, *, from_below: bool = False, turned: bool = True) -> dict[str, Any]:
    """The arrays of a strip with three creases in alternate senses, turned and moved at random."""
    mesh = Strip(0.4, 0.1, 8, 2, creases=(0.25, 0.5, 0.75), fold_angle=np.radians(degrees)).mesh()
    turn = rotation(list(RNG.normal(size=3)), RNG.uniform(0, 6)) if turned else np.eye(3)
    triangles = mesh.triangles[:, ::-1] if from_below else mesh.triangles
    return {
        "reference": mesh.reference,
        "triangles": triangles,
        "positions": mesh.positions @ turn.T + turned * RNG.normal(size=3),
        "creases": mesh.creases,
        "fold_angles": (-1.0 if from_below else 1.0) * mesh.fold_angles,
    }


def angles_in_core(mesh: Mesh) -> Floats:
    """Crease angles by the law of creases [rad]."""
    scene = Scene(mesh, RUBBER, [Springs(strain_limit=1e9), Creases()], [Fixed(nodes=(0,))])
    return Simulation(scene).crease_angles()


@pytest.mark.parametrize("from_below", [False, True])
@pytest.mark.parametrize("degrees", ANGLES)
def test_left_out_they_are_taken_from_positions(degrees: float, from_below: bool) -> None:
    values = wings(degrees, from_below=from_below)
    expected = values.pop("fold_angles")
    mesh = Mesh(**values)
    np.testing.assert_allclose(mesh.fold_angles, expected, atol=1e-9)
    np.testing.assert_allclose(angles_in_core(mesh), np.pi - np.abs(expected), atol=1e-9)


@pytest.mark.parametrize("from_below", [False, True])
@pytest.mark.parametrize("degrees", [angle for angle in ANGLES if abs(angle) > 2])
def test_another_sign_is_refused_with_the_crease_and_both_angles(degrees: float, from_below: bool) -> None:
    values = wings(degrees, from_below=from_below)
    Mesh(**values)
    values["fold_angles"] = -values["fold_angles"]
    first = -degrees if from_below else degrees
    words = rf"\({-first} degrees\) contradicts positions at creases\[0\] \(nodes \d+ and \d+\), where {first} degrees"
    with pytest.raises(MeshError, match=rf"{words} \(6 such creases\); the sign is that of the FOLD format"):
        Mesh(**values)


@pytest.mark.parametrize(
    ("shown", "given"), [(60, 150), (60, 45), (170, 120), (-90, -170), (30, 0), (90, 180), (-6, 0)]
)
def test_another_angle_is_refused(shown: float, given: float) -> None:
    values = wings(shown)
    values["fold_angles"][:2] = np.radians(given)
    with pytest.raises(MeshError, match=r"\(2 such creases\); give the angle in positions, in radians, or leave"):
        Mesh(**values)


@pytest.mark.parametrize(("shown", "given"), [(3, -1.5), (-3, 1.5), (3, -0.5)])
def test_another_sign_is_refused_within_the_tolerance_of_angles_too(shown: float, given: float) -> None:
    values = wings(shown)
    values["fold_angles"][:2] = np.radians(given)
    with pytest.raises(MeshError, match=r"\(2 such creases\); the sign is that of the FOLD format"):
        Mesh(**values)


def test_one_wrong_crease_of_many_is_named() -> None:
    values = wings(60)
    values["fold_angles"][3] *= -1.0
    nodes = " and ".join(map(str, values["creases"][3]))
    with pytest.raises(MeshError, match=rf"creases\[3\] \(nodes {nodes}\).*\(1 such creases\)"):
        Mesh(**values)


def test_triangles_wound_from_the_other_side_exchange_valley_and_mountain() -> None:
    values = wings(60)
    values["triangles"] = values["triangles"][:, ::-1]
    with pytest.raises(MeshError, match="order of nodes in all triangles"):
        Mesh(**values)


@pytest.mark.parametrize(
    ("shown", "given", "warns"),
    [
        *[(0, 60, True), (0, -6, True), (0, 178, True)],
        *[(0, 0, False), (0, 4, False), (0, 180, False), (0, -180, False), (180, 180, False), (180, -176, False)],
    ],
)
def test_an_angle_that_says_more_than_a_side_is_warned_of(shown: float, given: float, warns: bool) -> None:
    values = wings(shown, turned=False) | {"fold_angles": np.full(6, np.radians(given))}
    found = audit(Scene(Mesh(**values), RUBBER, [Springs(), Creases()], [Fixed((0,))])).find("fold_angles")
    assert (found is not None) == warns
    if found is not None:
        assert (found.severity, found.count) == ("warning", 6)
        assert f"({given} degrees), but creases[0] is folded by {shown} degrees in positions" in found.message
        assert "Creases.natural_angle" in found.remedy


def test_a_flat_crease_may_have_any_angle_and_a_shut_one_either_sign() -> None:
    values = wings(0, turned=False)
    for angle in (-np.pi, -1.0, 0.0, 2.0):
        Mesh(**values | {"fold_angles": np.full(6, angle)})
    assert (Mesh(**values | {"fold_angles": None}).fold_angles == 0.0).all()
    values = wings(180, turned=False)
    for sign in (-1.0, 1.0):
        mesh = Mesh(**values | {"fold_angles": np.full(6, sign * np.pi)})
        np.testing.assert_allclose(np.abs(angles_in_core(mesh)), 0.0, atol=1e-9)
    with pytest.raises(MeshError, match=r"where it is shut .*give pi for a valley and -pi for a mountain"):
        Mesh(**values | {"fold_angles": np.zeros(6)})
    with pytest.raises(MeshError, match=r"left out, and creases\[0\] \(nodes 6 and 7\) is shut"):
        Mesh(**values | {"fold_angles": None})


@pytest.mark.parametrize(
    "dimensions",
    [
        {"layout": "fan", "outer_width": 0.807, "inner_width": 0.162, "fold_lines": 2, "spool_radius": 0.0679},
        {"layout": "fan", "outer_width": 2.19, "inner_width": 0.167, "spool_radius": 0.0669, "fillet_radius": 0.013},
        {
            "layout": "equilateral",
            "outer_width": 0.0855,
            "inner_width": 0.0106,
            "fold_lines": 1,
            "rows": 4,
            "spool_radius": 0.00246,
        },
        {"outer_width": 0.101, "inner_width": 0.0107, "rows": 24, "spool_radius": 0.0042, "layer_gap": 3.5e-4},
    ],
)
def test_a_coarse_stowed_sail_does_not_contradict_itself(dimensions: dict[str, Any]) -> None:
    assert (np.abs(SquareSail(**dimensions).mesh().fold_angles) == np.pi).all()


@pytest.mark.parametrize(("shown", "is_refused"), [(176, False), (174, True)])
def test_flat_facets_in_layers_that_are_given_as_shut_interpenetrate_by_little(shown: float, is_refused: bool) -> None:
    values = wings(shown)
    values["fold_angles"] = -np.pi * np.sign(values["fold_angles"])
    if not is_refused:
        Mesh(**values)
        return
    with pytest.raises(MeshError, match=r"\(6 such creases\)"):
        Mesh(**values)


def wing(degrees: float) -> dict[str, Any]:
    """The arrays of a strip with a single crease, moved at random."""
    mesh = Strip(0.4, 0.1, 4, 2, creases=(0.5,), fold_angle=np.radians(degrees)).mesh()
    turn = rotation(list(RNG.normal(size=3)), RNG.uniform(0, 6))
    positions = mesh.positions @ turn.T
    arrays = {"reference": mesh.reference, "triangles": mesh.triangles, "creases": mesh.creases}
    return arrays | {"positions": positions, "fold_angles": mesh.fold_angles}


CONTRADICTIONS = [
    (150, 180), (174, 180), (178.9, -180), (-178.9, 180), (176, -180), (179.5, 90), (179.5, 150), (180, 170),
    (2, 0), (-2, 0), (1.1, 0.5), (4, -0.1),
]  # fmt: skip


@pytest.mark.parametrize(("shown", "given"), CONTRADICTIONS)
def test_at_a_single_crease_no_clear_contradiction_is_accepted(shown: float, given: float) -> None:
    values = wing(shown)
    if abs(shown) < 179:
        Mesh(**values)
    with pytest.raises(MeshError, match=r"contradicts positions at creases\[0\]"):
        Mesh(**values | {"fold_angles": np.full(len(values["creases"]), np.radians(given))})


@pytest.mark.parametrize(
    ("shown", "given"), [(178, 180), (-176, -180), (179.5, -180), (179.5, 180), (60, 64), (3, 2), (0.5, 0), (0.5, -90)]
)
def test_at_a_single_crease_what_is_near_or_not_clear_is_accepted(shown: float, given: float) -> None:
    values = wing(shown)
    Mesh(**values | {"fold_angles": np.full(len(values["creases"]), np.radians(given))})


def test_noise_of_a_part_in_a_thousand_is_no_contradiction() -> None:
    values = wings(60)
    values["positions"] = values["positions"] + 5e-5 * RNG.normal(size=values["positions"].shape)
    Mesh(**values)


def test_crumpled_facets_show_no_fold() -> None:
    values = wings(60)
    values["positions"] = RNG.normal(size=values["positions"].shape)
    mesh = Mesh(**values | {"fold_angles": None})
    assert (mesh.fold_angles == 0.0).all()
    assert np.isnan(measured_fold_angles(mesh, mesh.positions)).all()


def test_the_natural_angle_is_another_matter() -> None:
    mesh = Mesh(**wings(60, turned=False))
    for natural in (0.0, 1.0, np.pi, 5.0):
        scene = Scene(mesh, RUBBER, [Springs(), Creases(natural_angle=natural)], [Fixed(nodes=(0,))])
        np.testing.assert_allclose(Simulation(scene).crease_angles(), np.radians(120), atol=1e-9)


def test_a_mesh_file_is_refused_alike(tmp_path: Path) -> None:
    values = wings(60)
    values["fold_angles"] = -values["fold_angles"]
    np.savez(tmp_path / "mesh.npz", **values)
    with pytest.raises(MeshError, match="contradicts positions"):
        Mesh.load(tmp_path / "mesh.npz")
    path = tmp_path / "scene.toml"
    material = "[material]\nyoungs_modulus = 1e6\npoisson_ratio = 0.3\ndensity = 1000.0\nthickness = 2e-4\n"
    path.write_text(f'[mesh]\nfile = "mesh.npz"\n{material}[laws.springs]\n', encoding="utf-8")
    with pytest.raises(ValueError, match=r"scene.toml: .*contradicts positions at creases\[0\]"):
        Scene.from_toml(path)
