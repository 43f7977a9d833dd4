"""The spiral hexagon: its flat mesh, roll, strain, crossings and layers, what it refuses, and the scene that opens."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fold_specification import check_specification, frames_of
from hypothesis import given, settings
from hypothesis import strategies as st
from membrane_rs import InputError, InputTypeError, Mesh, MeshError, Scene, Simulation, Tethers, scenes
from membrane_rs.check import facts
from membrane_rs.folding import SpiralHexagon, SquareSail
from membrane_rs.folding.pattern import RowPattern
from membrane_rs.mesh.fold_angles import measured_fold_angles
from same_mesh import check_same
from small_scenes import FILM, Floats, refused

SAILS = (
    SpiralHexagon(),
    SpiralHexagon(rows=10),
    SpiralHexagon(rows=5),
    SpiralHexagon(spool_radius=0.03),
    SpiralHexagon(sides=3, strip_height=0.02),
    SpiralHexagon(sides=4, strips=3, strip_height=0.06, rows=9, columns=12, spool_radius=0.02),
    SpiralHexagon(sides=5, strips=1, strip_height=0.1),
    SpiralHexagon(sides=8, strips=6, rows=12),
    SpiralHexagon(sides=12, strips=2),
)
every_sail = pytest.mark.parametrize("sail", SAILS, ids=lambda one: f"{one.sides}-{one.strips}-{one.rows}")


def met(mesh: Mesh) -> tuple[int, int, int]:
    """Pairs of triangles that cross, that overlap in one plane, and that touch without a common node."""
    found = mesh.crossings(limit=0)
    assert found.candidates > 0
    return found.count, found.overlapping, found.touching


def in_petals(sail: SpiralHexagon, points: Floats) -> tuple[Any, Floats, Floats]:
    """(n,) side of each point of the flat sail, and its place along that side and beyond the hub's [m]."""
    turn = 2.0 * math.pi / sail.sides
    side = np.round(np.arctan2(points[:, 1], points[:, 0]) / turn).astype(int) % sail.sides
    c, s = np.cos(turn * side), np.sin(turn * side)
    out, along = c * points[:, 0] + s * points[:, 1], c * points[:, 1] - s * points[:, 0]
    return side, along, out - sail.hub_apothem


@every_sail
def test_the_flat_sail_is_a_regular_polygon_with_a_hub_of_as_many_sides(sail: SpiralHexagon) -> None:
    mesh, n = sail.mesh(), sail.sides
    apothem = sail.radius * math.cos(math.pi / n)
    assert sail.hub_apothem == pytest.approx(apothem - sail.strips * sail.strip_height, rel=1e-12)
    area = n * math.tan(math.pi / n) * (apothem**2 - sail.hub_apothem**2)
    assert mesh.areas().sum() == pytest.approx(area, rel=1e-12)
    assert mesh.node_count - len(mesh.edges) + len(mesh.triangles) == 0  # Euler's number of a ring
    corners = mesh.reference[mesh.node_sets["corners"]]
    azimuth = math.pi / n * (1.0 + 2.0 * np.arange(n))
    expected = np.stack([sail.radius * np.cos(azimuth), sail.radius * np.sin(azimuth), 0.0 * azimuth], axis=1)
    np.testing.assert_allclose(corners, expected, atol=1e-15)
    inner = mesh.reference[mesh.node_sets["inner_corners"]]
    np.testing.assert_allclose(inner, expected * (sail.hub_apothem / apothem), atol=1e-15)
    edge = in_petals(sail, mesh.reference[mesh.node_sets["inner_edge"]])[2]
    np.testing.assert_allclose(edge, 0.0, atol=1e-15)
    assert len(edge) == n * sail._path().columns


@every_sail
def test_the_stowed_sail_is_the_flat_one_within_a_strain_and_crosses_nothing(sail: SpiralHexagon) -> None:
    mesh = sail.mesh()
    assert np.abs(mesh.strain()).max() < 7e-4
    assert met(mesh) == (0, 0, 0)
    audit = mesh.audit()
    assert [(finding.kind, finding.severity) for finding in audit.findings] == [("strain", "info")], str(audit)


@pytest.mark.parametrize("sides", range(3, 13))
def test_strain_by_default_and_of_layers_as_far_apart_as_thick_film(sides: int) -> None:
    sail = SpiralHexagon(sides=sides, strip_height=0.16 * math.cos(math.pi / sides) * 0.325)
    assert np.abs(sail.mesh().strain()).max() < 5.5e-4
    thick = replace(sail, layer_gap=7.5e-6, rows=40)
    assert np.abs(thick.mesh().strain()).max() < 4e-3
    assert met(sail.mesh()) == met(thick.mesh()) == (0, 0, 0)


@every_sail
def test_nodes_lie_where_the_folded_image_is_wound(sail: SpiralHexagon) -> None:
    """From its hairpin on, a petal runs along the hub and out in its arm; its pleat runs back from there, mirrored."""
    mesh, path = sail.mesh(), sail._path()
    side, along, out = in_petals(sail, mesh.reference)
    level = np.abs((out / sail.strip_height + 1.0) % 2.0 - 1.0)
    np.testing.assert_allclose(mesh.positions[:, 2], sail.strip_height * level, atol=1e-14)
    turned = -2.0 * math.pi / sail.sides * side
    x, y, _ = mesh.positions.T
    plan = np.stack([np.cos(turned) * x - np.sin(turned) * y, np.sin(turned) * x + np.cos(turned) * y], axis=1)
    ahead = np.concatenate([path.hub[:-1], path.line])
    pleat = np.concatenate([path.hub[:1], path._back(path.line[1:])])
    for is_pleat, line in ((True, pleat), (False, ahead)):
        length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        nodes = np.flatnonzero((along < -path.hairpin) == is_pleat)
        way = np.abs(along[nodes] + path.hairpin)
        wanted = np.stack([np.interp(way, length, line[:, k]) for k in range(2)], axis=1)
        apart = np.linalg.norm(plan[nodes] - wanted, axis=1)
        assert apart.max(initial=0.0) <= 1.3 * path.offset[-1] + 3e-4 * path.cell


@every_sail
def test_layers_lie_in_order(sail: SpiralHexagon) -> None:
    """Outward beside the hub: all rows of a petal, its pleat's from the outer edge back, then those of the petal before
    from the inner edge on.
    """
    mesh, path = sail.mesh(), sail._path()
    side, along, out = in_petals(sail, mesh.reference)
    radius = np.hypot(*mesh.positions[:, :2].T)
    column = path.hairpin + float(path.chords[0])  # the first in which pleat and petal lie on each other
    beyond = out + sail.hub_apothem > (column + 1e-9) / math.tan(math.pi / sail.sides)
    hub = np.flatnonzero((side == 1) & (np.abs(along + path.hairpin - path.cell) < 1e-9) & (out > -1e-12))
    pleat = np.flatnonzero((side == 1) & (np.abs(along + column) < 1e-9) & beyond)
    before = np.flatnonzero((side == 0) & (np.abs(along - column) < 1e-9) & beyond)
    assert len(pleat) == len(before) > 0
    pleat, before = pleat[np.argsort(-out[pleat])], before[np.argsort(out[before])]
    outward = np.concatenate([pleat, before])
    assert (np.diff(radius[outward]) > 0.0).all()
    assert radius[hub].max() < radius[pleat].min()
    azimuth = np.arctan2(mesh.positions[:, 1], mesh.positions[:, 0])[outward]
    assert np.ptp(np.unwrap(azimuth)) < 1e-2


@every_sail
def test_creases_are_folded_to_their_sides_and_shut(sail: SpiralHexagon) -> None:
    mesh = sail.mesh()
    found = measured_fold_angles(mesh, mesh.positions)
    assert (np.sign(found) == np.sign(mesh.fold_angles)).all()
    assert np.degrees(np.abs(found)).min() > 175.0
    all_edges = mesh.edges[mesh.triangles_per_edge == 2]
    folded = np.abs(measured_fold_angles(Mesh(mesh.reference, mesh.triangles, creases=all_edges), mesh.positions))
    assert (folded > 0.75 * math.pi).sum() == len(mesh.creases)


def test_at_every_inner_vertex_three_creases_fold_to_one_side_and_one_to_the_other() -> None:
    sail = SpiralHexagon(strips=4, rows=4)
    mesh = sail.mesh()
    count, sides = np.zeros((2, mesh.node_count))
    for ends, angle in zip(mesh.creases, mesh.fold_angles, strict=True):
        count[ends] += 1
        sides[ends] += np.sign(angle)
    border = np.unique(mesh.boundary_edges)
    crossing = np.setdiff1d(np.flatnonzero(count == 4), border)
    assert len(crossing) == 6 * 2 * (sail.strips - 1)  # on each diagonal and hairpin, by each fold line
    assert (np.abs(sides[crossing]) == 2).all()


@pytest.mark.parametrize("n", [3, 4, 6, 7])
def test_the_pleat_closes_the_flat_fold(n: int) -> None:
    """Across p2 the mirror image in p1 and the next petal agree, and p1 on the diagonal keeps fold lines parallel."""
    p1, p2 = math.pi / n, 2.0 * math.pi / n  # from the normal of a side, about its vertex
    point = 0.3 * np.array([math.sin(p2), math.cos(p2)])
    mirror = np.array([[-math.cos(2 * p1), math.sin(2 * p1)], [math.sin(2 * p1), math.cos(2 * p1)]])
    turn = np.array([[math.cos(p2), -math.sin(p2)], [math.sin(p2), math.cos(p2)]])
    np.testing.assert_allclose(mirror @ point, turn @ point, atol=1e-15)
    np.testing.assert_allclose(mirror @ [1.0, 0.0], [-math.cos(p2), math.sin(p2)], atol=1e-15)


def test_default_lies_whole_round_the_hub_and_a_smaller_spool_takes_less() -> None:
    whole, small = SpiralHexagon(), SpiralHexagon(spool_radius=0.03)
    assert whole._path().free == 0
    assert small._path().free == 2
    assert 0.03 <= small.wound_radius < whole.wound_radius < small.hub_side * 6 / (2 * math.pi) * 1.01
    for sail in (whole, small):
        mesh = sail.mesh()
        middles = mesh.positions[mesh.edges].mean(axis=1)
        assert np.hypot(*middles[:, :2].T).min() >= sail._path().spool_radius * (1.0 - 1e-12)
        assert np.hypot(*mesh.positions[:, :2].T).max() == pytest.approx(sail.wound_outer_radius, rel=1e-9)
        corner = mesh.positions[mesh.node_sets["corners"][0]]
        turned = math.atan2(corner[1], corner[0]) - math.pi / 6
        assert (sail.corner_turn - turned + 1e-9) % (2 * math.pi) < 2e-9


def test_four_sides_are_the_wound_square() -> None:
    square = SquareSail(fold_lines=5, rows=12, columns=10, layer_gap=2e-6, stowage="wound")
    sail = SpiralHexagon(
        radius=square.flat_corner_radius, strip_height=square.strip_height, strips=6, sides=4, rows=12, columns=10,
        spool_radius=0.025, layer_gap=2e-6,
    )  # fmt: skip
    np.testing.assert_allclose(sail.mesh().reference, square.mesh().reference, atol=1e-15)
    np.testing.assert_array_equal(sail.mesh().triangles, square.mesh().triangles)
    np.testing.assert_allclose(sail.mesh().positions, square.mesh().positions, atol=3e-5)


@st.composite
def sails(draw: st.DrawFn) -> dict[str, Any]:
    sides, strips = draw(st.integers(3, 20)), draw(st.integers(1, 8))
    radius = 10.0 ** draw(st.floats(-2.0, 1.0))
    apothem = radius * math.cos(math.pi / sides)
    gap = st.one_of(st.none(), st.floats(-6.0, -3.0).map(lambda power: radius * 10.0**power))
    return {
        "sides": sides,
        "radius": radius,
        "strips": strips,
        "strip_height": apothem * draw(st.floats(0.1, 0.97)) / strips,
        "rows": strips * draw(st.integers(1, max(1, 16 // strips))),
        "columns": draw(st.one_of(st.none(), st.integers(1, 20))),
        "spool_radius": draw(st.one_of(st.none(), st.floats(0.02, 0.8).map(lambda share: radius * share))),
        "layer_gap": draw(gap),
    }


@settings(max_examples=80, deadline=None)
@given(sails())
def test_any_dimensions_wind_without_a_crossing_or_are_refused_with_a_remedy(dimensions: dict[str, Any]) -> None:
    message = ""
    try:
        mesh = SpiralHexagon(**dimensions).mesh()
    except MeshError as error:
        message = str(error)
    if message:
        assert message.startswith("SpiralHexagon")
        assert any(word in message for word in ("take", "make", "must be at most"))
        return
    assert met(mesh) == (0, 0, 0)
    assert np.isfinite(mesh.positions).all()


def test_layers_that_are_pushed_together_cross() -> None:
    mesh = SpiralHexagon().mesh()
    positions = mesh.positions.copy()
    positions[np.setdiff1d(mesh.node_sets["on_hub"], mesh.node_sets["hairpins"]), :2] *= 1.005
    assert mesh.crossings(positions, limit=0).count > 0


@pytest.mark.parametrize(
    ("values", "kind", "words"),
    [
        ({"sides": 2}, InputError, "sides = 2: must be .* 3"),
        ({"sides": 6.5}, InputError, "sides = 6.5"),
        ({"sides": "six"}, InputTypeError, "sides = 'six'"),
        ({"sides": 10**8}, MeshError, "100000000 sides, 20 rows .* do not fit; take fewer"),
        ({"layer_gap": 0.0}, InputError, r"layer_gap = 0.*must be greater than 0 \(m\)"),
        ({"layer_gap": -1e-6}, InputError, r"layer_gap = -1e-06.*must be greater than 0"),
        (
            {"layer_gap": 1e-12},
            MeshError,
            "layer_gap = 1e-12: layers would lie in each other; make it 6.22e-11 or more",
        ),
        ({"layer_gap": 2e-3}, MeshError, "SpiralHexagon: the layers of a wound arm take .* take more rows"),
        ({"radius": math.inf}, InputError, "radius = inf"),
        ({"radius": math.nan}, InputError, "radius = nan"),
        ({"radius": 0.0}, InputError, "radius = 0.*greater than 0"),
        ({"strip_height": -math.inf}, InputError, "strip_height = -inf"),
        (
            {"strip_height": 0.06},
            MeshError,
            "strip_height = 0.06: 5 strips .* leave no hub .* take less than 0.0562917",
        ),
        ({"strips": 0}, InputError, "strips = 0: must be at least 1"),
        ({"strips": 10**9}, MeshError, "strip_height = 0.045: 1000000000 strips"),
        ({"strips": 10**9, "strip_height": 1e300}, MeshError, "strip_height = 1e.300: 1000000000 strips"),
        ({"strips": 10**9, "strip_height": 1e-300}, MeshError, "do not fit; take fewer"),
        ({"rows": 12}, MeshError, "rows = 12: must be a multiple of strips = 5; take 15"),
        ({"rows": 10**9}, MeshError, "1000000000 rows .* do not fit; take fewer"),
        ({"rows": 0}, InputError, "rows = 0: must be at least 1"),
        ({"columns": 10**9}, MeshError, "1e.09 columns along the hub.* do not fit; take fewer"),
        (
            {"spool_radius": 0.07},
            MeshError,
            "spool_radius = 0.07: must be at most 0.0621972 .m., where all of the hub's 6",
        ),
        ({"strip_height": 0.056, "rows": 5}, MeshError, "rows = 5: cells of .* m do not lie on a roll .* take"),
        ({"width": 1.0}, InputTypeError, "width"),
    ],
)
def test_what_cannot_be_is_refused_by_name_and_place(values: dict[str, Any], kind: Any, words: str) -> None:
    refused(lambda: SpiralHexagon(**values), kind, words)


def test_facts_tell_roll_strain_and_crossings() -> None:
    found = facts(scenes.load("hexagon"))
    assert found["roll"].startswith(
        "radius 0.062368 to 0.063341 m, 0.3293 turns, layers 4.72e-06 m apart, strain -0.043"
    )
    assert found["layers"] == "0 pairs of triangles cross, 0 overlap, 0 touch"


def test_finer_sails_and_sails_by_rows() -> None:
    sail = SpiralHexagon(rows=10, columns=5)
    assert sail.refined(2.0) == SpiralHexagon(rows=20, columns=10)
    assert sail.with_rows(20).rows == 20
    assert isinstance(sail, RowPattern)
    refused(lambda: SpiralHexagon(rows=5).refined(0.5), InputError, "rows_per_strip = 1 would become 0.5")


def test_scene_files_and_fold_files_give_the_same_sail(tmp_path: Path) -> None:
    sail = SpiralHexagon(sides=5, rows=10, spool_radius=0.04)
    mesh = sail.mesh()
    Scene(mesh, FILM, [], name="sail").save(tmp_path)
    again = Scene.from_toml(tmp_path / "scene.toml").mesh
    assert again is not None
    assert again.source == sail
    check_same(again, mesh)
    mesh.save(tmp_path / "sail.fold")
    for frame in frames_of(tmp_path / "sail.fold"):
        check_specification(frame)
    check_same(Mesh.load(tmp_path / "sail.fold"), mesh)


def test_tethers_lie_along_the_arms() -> None:
    for sail in (SpiralHexagon(rows=10), SpiralHexagon(spool_radius=0.04)):
        mesh = sail.mesh()
        for nodes in ("inner_corners", "corners"):
            scene = Scene(mesh, FILM, [], [Tethers(nodes, anchor_radius=0.035, segments=40)])
            assembly = scene.assemble()
            for k in range(6):
                cord = assembly.positions[assembly.node_sets[f"tether-{k}"]]
                turned = np.unwrap(np.arctan2(cord[:, 1], cord[:, 0]))
                assert (np.diff(turned) > -1e-9).all()
                wanted = sail.corner_turn if nodes == "corners" else sail._path().arm[sail._path().free, 0]
                assert turned[-1] - turned[0] == pytest.approx(wanted, abs=1e-9)
        assert sail.cord_path(mesh.reference[np.argmin(np.abs(mesh.reference[:, 1]))]) is None


def test_the_built_in_scene_spins_out_flat() -> None:
    scene = scenes.load("hexagon")
    mesh = scene.mesh
    assert mesh is not None
    sim = Simulation(scene)
    sim.run(until=1.0)
    corners = mesh.node_sets["corners"]
    radius = np.hypot(*sim.positions[corners, :2].T)
    # Held where they lie in the roll, its inner corners are nearer to the axis than those of the flat sail.
    held = np.hypot(*mesh.positions[mesh.node_sets["inner_corners"][0], :2])
    reach = 0.325 - np.hypot(*mesh.reference[mesh.node_sets["inner_corners"][0], :2]) + held
    np.testing.assert_allclose(radius, reach, rtol=2e-3)
    azimuth = np.arctan2(*sim.positions[corners, 1::-1].T) - np.arctan2(*mesh.reference[corners, 1::-1].T)
    assert np.abs(np.degrees(azimuth)).max() < 4.0
    assert abs(sim.ledger()["error"]) < 0.01
    assert np.abs(mesh.strain(sim.positions)).max() < 0.06


@pytest.mark.parametrize("sail", [SpiralHexagon(rows=10), SquareSail(stowage="wound")])
@pytest.mark.parametrize("node", [[math.nan, 0.0, 0.0], [1.0, math.inf, 0.0], [1.0, 2.0], "corner"])
def test_a_cord_to_no_place_is_refused(sail: Any, node: Any) -> None:
    refused(lambda: sail.cord_path(node), InputError, f"{type(sail).__name__}.cord_path: node")
