"""Every folding pattern, from the one list of them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from example_of import example_of
from membrane_rs.errors import InputError, MeshError
from membrane_rs.folding import PATTERNS, Disc, Strip

FOLDED = Strip(0.4, 0.1, 8, 2, creases=(0.25, 0.5), fold_angle=2.0)


@pytest.mark.parametrize("pattern", [*map(example_of, PATTERNS.values()), FOLDED], ids=lambda one: type(one).__name__)
def test_a_pattern_makes_a_sound_flat_mesh(pattern: Any) -> None:
    mesh = pattern.mesh()
    audit = mesh.audit()
    assert [(finding.kind, finding.severity) for finding in audit.findings] == [("strain", "info")], str(audit)
    assert mesh.source is pattern
    x, t = mesh.reference, mesh.triangles
    assert (np.cross(x[t[:, 1]] - x[t[:, 0]], x[t[:, 2]] - x[t[:, 0]])[:, 2] > 0).all()
    assert (x[:, 2] == 0).all()
    assert pattern == replace(pattern)
    with pytest.raises(AttributeError):
        pattern.other = 1


def test_disc() -> None:
    mesh = Disc(radius=0.1, rings=10).mesh()
    assert mesh.node_count == 1 + 3 * 10 * 11
    assert len(mesh.triangles) == 6 * 100
    assert mesh.node_sets["centre"].tolist() == [0]
    rim = mesh.reference[mesh.node_sets["rim"]]
    assert len(rim) == 60
    np.testing.assert_allclose(np.hypot(rim[:, 0], rim[:, 1]), 0.1, rtol=1e-12)
    azimuth = np.unwrap(np.arctan2(rim[:, 1], rim[:, 0]))
    assert (np.diff(azimuth) > 0).all()
    sixth = azimuth[10] - azimuth[0]
    assert sixth == pytest.approx(math.pi / 3, rel=1e-12)
    assert mesh.areas().sum() == pytest.approx(math.pi * 0.01, rel=3e-3)
    assert len(mesh.boundary_edges) == 60


def test_a_disc_with_a_hole() -> None:
    mesh = Disc(radius=0.1, rings=20, hub_radius=0.05).mesh()
    assert mesh.areas().sum() == pytest.approx(math.pi * (0.1**2 - 0.05**2), rel=2e-3)
    hub = mesh.reference[mesh.node_sets["centre"]]
    np.testing.assert_allclose(np.hypot(hub[:, 0], hub[:, 1]), 0.05, rtol=1e-12)
    assert mesh.node_count - len(mesh.edges) + len(mesh.triangles) == 0
    assert mesh.audit().find("obtuse") is None
    # All triangles have one shape.
    quality = mesh.flatness()
    assert np.ptp(quality) < 0.01
    assert quality.mean() == pytest.approx(math.sqrt(0.75), abs=0.02)


@pytest.mark.parametrize(
    ("rings", "hub_radius", "text"),
    [
        (2, 0.2, r"hub_radius = 0.2: must be less than radius = 0.1"),
        (3, 0.01, r"rings = 3: too few round a hole of hub_radius = 0.01 \(m\).* take 4 or more"),
        (3, 5e-324, "take 1023 or more"),
        (3, 0.09999999999, "makes about 4.9e.* nodes"),
        (10_000, 0.0, "makes about 3.0e.* nodes"),
    ],
)
def test_discs_that_cannot_be(rings: int, hub_radius: float, text: str) -> None:
    with pytest.raises(MeshError, match=text):
        Disc(0.1, rings, hub_radius)


@pytest.mark.parametrize("angle", [0.5, -0.5, math.pi, -math.pi])
def test_a_strip_folds_rigidly_about_its_creases(angle: float) -> None:
    mesh = Strip(0.4, 0.1, 4, creases=(0.25, 0.75), fold_angle=angle).mesh()
    assert np.abs(mesh.strain()).max() < 1e-12
    np.testing.assert_allclose(mesh.fold_angles, [angle, -angle])
    # A valley: what lies beyond the first crease turns up, towards the side that was the upper one.
    expected = [0, 0, 0.2 * math.sin(angle), 0.2 * math.sin(angle)]
    np.testing.assert_allclose(mesh.positions[[0, 2, 6, 8], 2], expected, atol=1e-12)
    assert (mesh.reference[mesh.node_sets["start"], 0] == 0).all()
    np.testing.assert_allclose(mesh.reference[mesh.node_sets["end"], 0], 0.4)
    np.testing.assert_allclose(mesh.reference[mesh.node_sets["crease-1"], 0], 0.3)


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"creases": [0.3]}, "0.3 falls inside one of 4 columns"),
        ({"creases": [0.5, 0.5]}, "two lie in one place"),
        ({"creases": [1.0]}, "must be .* less than 1"),
        ({"fold_angle": 4.0}, "fold_angle = 4.0"),
        ({"length": 0.0}, "must be greater than 0"),
        ({"rows": 0}, "must be at least 1"),
    ],
)
def test_strips_that_cannot_be(values: dict[str, Any], text: str) -> None:
    with pytest.raises(InputError, match=text):
        Strip(**({"length": 0.4, "width": 0.1, "columns": 4} | values))
