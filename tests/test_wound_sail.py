"""The wound sail: its hub, its arms, its strain, and layers that lie in order."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from membrane_rs._arrays import Floats
from membrane_rs.errors import InputError, MeshError
from membrane_rs.folding import SquareSail
from membrane_rs.mesh import Mesh

MODEL_1 = {"columns": 10}
MODEL_2 = {"columns": 10, "fold_lines": 3}
THICK = {"layer_gap": 7.5e-6}

# Hub and outer radius [mm], turns, least and largest strain and its root mean square [%], as an independent
# construction of the same shape gave them.
SHAPES = [
    (MODEL_1 | THICK, (26.40, 29.99), 1.174, (-0.324, 0.247, 0.102)),
    (MODEL_1, (26.40, 29.44), 1.186, (-0.233, 0.066, 0.034)),
    (THICK, (29.93, 32.85), 1.039, (-0.310, 0.222, 0.091)),
    ({"columns": 13} | THICK, (25.32, 29.17), 1.219, (-0.330, 0.273, 0.104)),
    ({"columns": 20, "rows": 32} | THICK, (26.27, 27.90), 1.216, (-0.331, 0.260, 0.104)),
    ({"columns": 41, "rows": 64} | THICK, (27.20, 28.27), 1.182, (-0.358, 0.308, 0.101)),
    (MODEL_2 | THICK, (26.40, 29.64), 1.182, (-0.265, 0.130, 0.058)),
]
FOLDS = [0, 1, 2, 3, 7, 12]
TABLE = [shape[0] for shape in SHAPES]


def wound(**dimensions: Any) -> SquareSail:
    return SquareSail(stowage="wound", **dimensions)


def radii(mesh: Mesh) -> Floats:
    return np.asarray(np.hypot(*mesh.positions[:, :2].T))


@pytest.mark.parametrize(("dimensions", "radius", "turns", "strain"), SHAPES)
def test_the_roll_is_that_of_an_independent_construction(
    dimensions: dict[str, Any], radius: tuple[float, float], turns: float, strain: tuple[float, float, float]
) -> None:
    sail = wound(**dimensions)
    mesh = sail.mesh()
    assert sail.wound_radius == pytest.approx(1e-3 * radius[0], abs=6e-6)
    assert sail.wound_outer_radius == pytest.approx(1e-3 * radius[1], abs=4e-5)
    assert sail.wound_outer_radius == pytest.approx(radii(mesh).max(), rel=1e-12)
    assert sail.turns == pytest.approx(turns, abs=0.002)
    found = 100.0 * mesh.strain()
    assert (found.min(), found.max()) == pytest.approx(strain[:2], abs=0.002)
    assert math.sqrt((found**2).mean()) == pytest.approx(strain[2], abs=0.001)


@pytest.mark.parametrize("columns", [10, 11, 13, 20, 41, 82])
@pytest.mark.parametrize("fold_lines", FOLDS)
def test_strain_is_within_a_quarter_percent_by_default(fold_lines: int, columns: int) -> None:
    rows = math.ceil(1.6 * columns / (fold_lines + 1)) * (fold_lines + 1)
    strain = wound(fold_lines=fold_lines, columns=columns, rows=rows).mesh().strain()
    assert np.abs(strain).max() < 0.0025


@pytest.mark.parametrize("outer", [8e-3, 1.5e-2, 3e-2, 5.4e-2])
@pytest.mark.parametrize("columns", [7, 11, 18])
@pytest.mark.parametrize("fold_lines", [1, 3, 8])
def test_strain_is_within_a_quarter_percent_of_unlike_cells_too(outer: float, columns: int, fold_lines: int) -> None:
    sail = wound(outer_width=outer, inner_width=4e-3, fold_lines=fold_lines, spool_radius=1.6e-3, columns=columns)
    assert np.abs(sail.mesh().strain()).max() < 0.0025


def test_the_hub_is_the_smallest_polygon_round_the_spool() -> None:
    for columns in range(4, 60):
        try:
            sail = wound(columns=columns)
        except MeshError:
            continue
        cell, n = 0.103 / columns, wound(columns=columns)._wound_path().on_hub
        assert n % 2 == columns % 2
        assert sail.wound_radius is not None
        assert 2 * n * math.asin(cell / (2 * sail.wound_radius)) == pytest.approx(math.pi / 2)
        assert cell / (2 * math.tan(math.pi / (4 * n))) >= 0.025
        assert n <= 2 or cell / (2 * math.tan(math.pi / (4 * (n - 2)))) < 0.025


@pytest.mark.parametrize("dimensions", [*TABLE[:5], *({"fold_lines": k} for k in FOLDS), {"spool_radius": 0.012}])
def test_all_film_lies_outside_the_spool_and_all_layers_are_prisms(dimensions: dict[str, Any]) -> None:
    sail = wound(**dimensions)
    mesh = sail.mesh()
    assert sail.wound_radius is not None
    middles = mesh.positions[mesh.edges].mean(axis=1)
    assert np.hypot(*middles[:, :2].T).min() >= sail.spool_radius
    distance = (np.abs(mesh.reference[:, :2]).max(axis=1) - sail.inner_width / 2) / sail.strip_height
    np.testing.assert_allclose(mesh.positions[:, 2], sail.strip_height * (1 - np.abs(distance % 2 - 1)), atol=1e-15)
    audit = mesh.audit()
    assert [(finding.kind, finding.severity) for finding in audit.findings] == [("strain", "info")], str(audit)


@pytest.mark.parametrize("join", ["merge", "bridge"])
def test_four_fold_symmetry_to_the_last_bit(join: Any) -> None:
    mesh = wound(join=join, fold_lines=3).mesh()
    place = {tuple(r): tuple(p) for r, p in zip(mesh.reference, mesh.positions, strict=True)}
    for (x, y, _), (u, v, w) in place.items():
        assert place[-y, x, 0.0] == (-v, u, w)
    if join == "bridge":
        assert (mesh.positions[mesh.bridges[:, 0]] == mesh.positions[mesh.bridges[:, 1]]).all()


@pytest.mark.parametrize("dimensions", [{}, MODEL_1, MODEL_2, {"columns": 20, "rows": 32}])
def test_arms_run_counter_clockwise_and_layers_lie_in_order(dimensions: dict[str, Any]) -> None:
    """From the hub outward: the petal's rows, the inner half of an arm with its last row first, its outer half."""
    sail = wound(**dimensions)
    mesh = sail.mesh()
    half = sail._wound_path().hairpin
    x, y, _ = mesh.reference.T
    azimuth = np.arctan2(*mesh.positions[:, 1::-1].T)
    on_diagonal = np.flatnonzero((np.abs(x - y) < 1e-12) & (x > 0))
    on_diagonal = on_diagonal[np.argsort(x[on_diagonal])]
    turned = np.unwrap(azimuth[on_diagonal])
    assert (np.diff(turned) > 0).all()
    assert (np.diff(radii(mesh)[on_diagonal]) > 0).all()
    # The column of petal 0, and that of petal 1, which lie beside each other one cell beyond the root of arm 0.
    s = half + sail.inner_width / sail._wound_path().columns
    outer = np.flatnonzero((np.abs(y - s) < 1e-9) & (x - s > 1e-9) & (x > y))
    inner = np.flatnonzero((np.abs(x - s) < 1e-9) & (y - s > 1e-9) & (y > x))
    hub = np.flatnonzero((np.abs(x - half + sail.inner_width / sail._wound_path().columns) < 1e-9) & (y > np.abs(x)))
    outer, inner = outer[np.argsort(x[outer])], inner[np.argsort(y[inner])][::-1]
    r = radii(mesh)
    assert (np.diff(r[np.concatenate([inner, outer])]) > 0).all()
    assert r[hub].max() < r[inner].min()


def test_node_sets() -> None:
    sail = wound()
    mesh = sail.mesh()
    flat = SquareSail().mesh()
    assert set(mesh.node_sets) == {*flat.node_sets, "on_hub", "hairpins"}
    assert (mesh.reference == flat.reference).all()
    assert (mesh.triangles == flat.triangles).all()
    assert (mesh.creases == flat.creases).all()
    assert (mesh.fold_angles == flat.fold_angles).all()
    assert len(mesh.node_sets["guide_bars"]) == mesh.node_count
    rows = 17
    assert len(mesh.node_sets["hairpins"]) == 4 * rows
    assert len(mesh.node_sets["on_hub"]) == 4 * rows * 6  # the columns of five cells
    assert np.isin(mesh.node_sets["hairpins"], mesh.node_sets["on_hub"]).all()
    radius = radii(mesh)[mesh.node_sets["on_hub"]]
    assert sail.wound_radius is not None
    assert np.abs(radius - sail.wound_radius).max() < 5e-5


def test_the_cross_has_no_roll_and_its_defaults() -> None:
    sail = SquareSail()
    assert (sail.wound_radius, sail.wound_outer_radius, sail.turns, sail.facts()) == (None, None, None, {})
    given = SquareSail(layer_gap=7.5e-6, diagonal_gap=3.75e-6, stowage="cross")
    assert (given.mesh().positions == sail.mesh().positions).all()


def test_facts_tell_the_roll() -> None:
    assert wound(columns=10).facts()["roll"].startswith("radius 0.026398 to 0.029459 m, 1.185 turns, layers 2e-06 m")


def test_refined_sails_stay_wound() -> None:
    finer = wound(columns=10, fold_lines=3).refined(2.0)
    assert finer == wound(columns=20, fold_lines=3, rows=32)
    assert replace(finer, stowage="cross").turns is None


BAD: list[tuple[dict[str, Any], type[Exception], str]] = [
    ({"layout": "equilateral"}, MeshError, 'layout = "equilateral": a wound sail bends about columns .* "ruled"'),
    ({"layout": "fan"}, MeshError, 'take the layout "ruled"'),
    ({"fillet_radius": 0.003}, MeshError, "fillet_radius = 0.003: a wound sail has no fillets; leave it out"),
    ({"layer_gap": 0.0}, MeshError, "layer_gap = 0: wound layers would lie in each other; make it 2.5e-11 or more"),
    ({"layer_gap": 1e-18}, MeshError, "layer_gap = 1e-18: wound layers would lie in each other"),
    (
        {"layer_gap": 3e-4},
        MeshError,
        "the layers of a wound arm take 0.00557 m, .* leave 0.00541 m for them; take more",
    ),
    ({"spool_radius": 1e300}, MeshError, "takes 1000000001 of the 11 columns .* make spool_radius smaller"),
    ({"diagonal_gap": 0.0}, MeshError, "diagonal_gap = 0: wound layers"),
    ({"columns": 1}, MeshError, "takes 1 of the 1 columns .* take columns = 4"),
    ({"columns": 3}, MeshError, "takes 3 of the 3 columns .* leaves none for the arms.* take columns = 4"),
    ({"spool_radius": 0.08}, MeshError, "make spool_radius smaller or inner_width larger"),
    ({"rows": 8, "columns": 8, "outer_width": 1.2}, MeshError, r"cells of 0.06856 m do not .* take 16 rows or more"),
    ({"layer_gap": 1e-3}, MeshError, "layers"),
    ({"stowage": "rolled"}, InputError, "stowage"),
]


@pytest.mark.parametrize(("dimensions", "kind", "text"), BAD)
def test_dimensions_that_do_not_go_together(dimensions: dict[str, Any], kind: type[Exception], text: str) -> None:
    with pytest.raises(kind, match=text):
        SquareSail(**({"stowage": "wound"} | dimensions)).mesh()


@st.composite
def sails(draw: st.DrawFn) -> dict[str, Any]:
    inner = draw(st.floats(0.02, 0.4))
    fold_lines = draw(st.sampled_from(FOLDS))
    return {
        "inner_width": inner,
        "outer_width": inner + draw(st.floats(0.01, 1.0)),
        "fold_lines": fold_lines,
        "rows": (fold_lines + 1) * draw(st.integers(1, 12)),
        "columns": draw(st.integers(1, 40)),
        "spool_radius": draw(st.floats(1e-3, 0.1)),
        "layer_gap": draw(st.sampled_from([None, 1e-7, 7.5e-6, 1e-4])),
    }


SHORT_LAST_CELLS: dict[str, Any] = {
    "inner_width": 0.25,
    "outer_width": 0.28125,
    "fold_lines": 1,
    "rows": 6,
    "columns": 3,
    "spool_radius": 0.03125,
    "layer_gap": None,
}


@settings(max_examples=60, deadline=None)
@given(sails())
@example(SHORT_LAST_CELLS)
def test_any_dimensions_make_a_roll_or_a_clear_error(dimensions: dict[str, Any]) -> None:
    message = ""
    try:
        sail = wound(**dimensions)
        mesh = sail.mesh()
    except MeshError as error:
        message = str(error)
    if message:
        assert "make" in message or "take" in message
        return
    assert np.isfinite(mesh.positions).all()
    assert mesh.triangles_per_edge.max() == 2
    middles = mesh.positions[mesh.edges].mean(axis=1)
    assert np.hypot(*middles[:, :2].T).min() >= sail.spool_radius * (1.0 - 1e-12)
    if dimensions["layer_gap"] is None:
        assert np.abs(mesh.strain()).max() < 0.0025
