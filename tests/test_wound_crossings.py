"""No two triangles of a wound sail pass through each other, counted exactly."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from membrane_rs.errors import MeshError
from membrane_rs.folding import SquareSail
from membrane_rs.mesh import Mesh

FOLDS = [0, 1, 2, 3, 7, 12]


def met(mesh: Mesh) -> tuple[int, int, int]:
    """Pairs of triangles that cross, that overlap in one plane, and that touch without a common node."""
    found = mesh.crossings(limit=0)
    assert found.candidates > 0
    return found.count, found.overlapping, found.touching


@pytest.mark.parametrize("gap", [7.5e-6, None])
@pytest.mark.parametrize(
    ("fold_lines", "columns", "rows"),
    [(7, 10, 16), (7, None, 16), (7, 13, 16), (3, 10, 16), (7, 20, 32), pytest.param(7, 41, 64, id="2.75 mm")],
)
def test_no_triangle_crosses_another(fold_lines: int, columns: int | None, rows: int, gap: float | None) -> None:
    sail = SquareSail(fold_lines=fold_lines, columns=columns, rows=rows, layer_gap=gap, stowage="wound")
    assert met(sail.mesh()) == (0, 0, 0)


@pytest.mark.parametrize("columns", [4, 5, 6, 7, 8, 9, 12, 17])
@pytest.mark.parametrize("fold_lines", FOLDS)
def test_any_number_of_fold_lines_and_columns(fold_lines: int, columns: int) -> None:
    rows = (fold_lines + 1) * -(-13 // (fold_lines + 1))
    for spool_radius in (0.01, 0.014, 0.025):
        sail = SquareSail(fold_lines=fold_lines, columns=columns, rows=rows, spool_radius=spool_radius, stowage="wound")
        assert met(sail.mesh()) == (0, 0, 0), sail


@st.composite
def sails(draw: st.DrawFn) -> dict[str, Any]:
    inner = 10.0 ** draw(st.floats(-2.5, 0.5))
    fold_lines = draw(st.sampled_from(FOLDS))
    gap = st.one_of(st.none(), st.floats(-6.0, -2.5).map(lambda power: inner * 10.0**power))
    return {
        "inner_width": inner,
        "outer_width": inner * (1.0 + 10.0 ** draw(st.floats(-1.3, 1.0))),
        "fold_lines": fold_lines,
        "rows": (fold_lines + 1) * draw(st.integers(1, max(1, 16 // (fold_lines + 1)))),
        "columns": draw(st.integers(3, 24)),
        "spool_radius": inner * 10.0 ** draw(st.floats(-1.8, -0.2)),
        "layer_gap": draw(gap),
        "diagonal_gap": draw(gap),
    }


@settings(max_examples=60, deadline=None)
@given(sails())
def test_any_dimensions_that_are_accepted_wind_without_a_crossing(dimensions: dict[str, Any]) -> None:
    try:
        mesh = SquareSail(**dimensions, stowage="wound").mesh()
    except MeshError:
        return
    assert met(mesh) == (0, 0, 0)


def test_wrong_mitres_would_be_found() -> None:
    """Layers that are pushed together cross."""
    mesh = SquareSail(columns=10, stowage="wound").mesh()
    positions = mesh.positions.copy()
    inner = np.setdiff1d(mesh.node_sets["on_hub"], mesh.node_sets["hairpins"])
    positions[inner, :2] *= 1.005
    assert mesh.crossings(positions, limit=0).count > 0
