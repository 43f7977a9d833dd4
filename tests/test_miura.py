"""Miura's fold against closed forms: nodes, fold angles, extents, Poisson's ratio, and a sheet that is driven open."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fold_specification import check_specification, frames_of
from membrane_rs import (
    Bending,
    Creases,
    Fixed,
    InputError,
    MassDamping,
    Mesh,
    MeshError,
    Moved,
    Scene,
    Schedule,
    Simulation,
    SpringDamping,
    Triangles,
    scenes,
)
from membrane_rs.folding import Miura
from membrane_rs.mesh.fold_angles import measured_fold_angles
from same_mesh import check_same
from small_scenes import RUBBER, Floats, refused

SHEETS = (
    Miura(0.02, 0.02, 0.0, columns=6, rows=4),
    Miura(0.02, 0.05, 0.0, columns=5, rows=3, angle=1.0, divisions=2),
    Miura(0.05, 0.02, 0.0, columns=3, rows=4, angle=1.3, divisions=3),
)
TILTS = (1e-3, 0.3, 0.8, 1.2, 1.5, math.pi / 2 - 1e-6)
ENDS = (0.0, *TILTS, math.pi / 2)


def sheets(tilts: Sequence[float]) -> pytest.MarkDecorator:
    """All sheets at all of some tilts, for tests."""
    both = [replace(sheet, tilt=tilt) for sheet in SHEETS for tilt in tilts]
    return pytest.mark.parametrize("sheet", both, ids=lambda one: f"{one.columns} columns, {one.tilt:.6g} rad")


def corners(sheet: Miura, positions: Floats) -> Floats:
    """(columns + 1, rows + 1, 3) nodes where facets meet, of all of a sheet."""
    ratio = max(sheet.straight_side, sheet.zigzag_side) / min(sheet.straight_side, sheet.zigzag_side)
    longer = sheet.divisions * round(ratio)
    along, across = (longer, sheet.divisions) if sheet.zigzag_side > sheet.straight_side else (sheet.divisions, longer)
    found: Floats = positions.reshape(sheet.columns * along + 1, sheet.rows * across + 1, 3)[::along, ::across]
    return found


def distances(points: Floats) -> Floats:
    """(n, n) between all nodes: the shape, wherever it lies."""
    found: Floats = np.linalg.norm(points[:, None] - points, axis=-1)
    return found


@sheets(ENDS)
def test_a_folded_sheet_is_sound_and_has_no_strain(sheet: Miura) -> None:
    mesh = sheet.mesh()
    assert np.abs(mesh.strain()).max() < 1e-12
    audit = mesh.audit()
    assert audit.ok
    assert [(finding.kind, finding.severity) for finding in audit.findings] == [("strain", "info")], str(audit)
    found = mesh.crossings()
    assert found.count == 0
    assert found.overlapping == 0
    for points in (mesh.reference, mesh.positions):
        np.testing.assert_allclose(points.max(axis=0) + points.min(axis=0), 0.0, atol=1e-15)


@sheets(ENDS)
def test_nodes_are_those_of_the_closed_form(sheet: Miura) -> None:
    a, b, g, t = sheet.straight_side, sheet.zigzag_side, sheet.angle, sheet.tilt
    root = math.sqrt(1.0 + math.cos(t) ** 2 * math.tan(g) ** 2)
    height, along = a * math.sin(t) * math.sin(g), b * math.cos(t) * math.tan(g) / root
    across, shift = a * math.sqrt(1.0 - math.sin(t) ** 2 * math.sin(g) ** 2), b / root
    points = corners(sheet, sheet.mesh().positions)
    i, j = np.meshgrid(np.arange(sheet.columns + 1), np.arange(sheet.rows + 1), indexing="ij")
    expected = np.stack([i * along, j * across + i % 2 * shift, j % 2 * height], axis=-1)
    np.testing.assert_allclose(points - points[0, 0], expected, atol=1e-15)
    assert sheet.height == pytest.approx(height, rel=1e-12)
    assert sheet.cell_length == pytest.approx(2.0 * along, rel=1e-12)
    assert sheet.cell_width == pytest.approx(2.0 * across, rel=1e-12)
    assert sheet.packing == pytest.approx(along * across / (a * b * math.sin(g)), rel=1e-12)
    sides = points[1, 0] - points[0, 0], points[0, 1] - points[0, 0]
    assert np.linalg.norm(sides, axis=1) == pytest.approx([b, a], rel=1e-12)
    assert sides[0] @ sides[1] == pytest.approx(a * b * math.cos(g), rel=1e-12)


@sheets(TILTS[:-1])
def test_facets_lie_at_the_tilt_to_the_plane_of_the_sheet(sheet: Miura) -> None:
    points = corners(sheet, sheet.mesh().positions)
    normals = np.cross(points[1:, :-1] - points[:-1, :-1], points[:-1, 1:] - points[:-1, :-1])
    upright = normals[..., 2] / np.linalg.norm(normals, axis=-1)
    np.testing.assert_allclose(np.arccos(upright), sheet.tilt, rtol=1e-9)


@sheets(TILTS)
def test_fold_angles_of_both_families_of_creases(sheet: Miura) -> None:
    mesh = sheet.mesh()
    np.testing.assert_allclose(measured_fold_angles(mesh, mesh.positions), mesh.fold_angles, atol=1e-9)
    grid = corners(sheet, mesh.reference)
    ends = mesh.reference[mesh.creases]
    cell = np.array([grid[1, 0, 0] - grid[0, 0, 0], sheet.straight_side])
    column, row = ((ends.mean(axis=1) - grid[0, 0])[:, :2] / cell).T
    is_straight = ends[:, 0, 0] == ends[:, 1, 0]
    straight, zigzag = mesh.fold_angles[is_straight], mesh.fold_angles[~is_straight]
    np.testing.assert_allclose(np.abs(zigzag), 2.0 * sheet.tilt, rtol=1e-12)
    np.testing.assert_allclose(np.tan(np.abs(straight) / 2), math.cos(sheet.angle) * math.tan(sheet.tilt), rtol=1e-9)
    # Along a zigzag line y rises by up to `shift`, and falls again.
    shift = math.cos(sheet.angle) * sheet.zigzag_side / sheet.straight_side
    line = row[~is_straight] - shift * np.abs((column[~is_straight] + 1) % 2 - 1)
    np.testing.assert_allclose(line, np.round(line), atol=1e-9)
    assert (np.sign(zigzag) == np.where(np.round(line) % 2 == 1, -1, 1)).all()
    across = np.round(column[is_straight]).astype(int)
    along = np.floor(row[is_straight] - shift * (across % 2)).astype(int)
    assert (np.sign(straight) == np.where((across + along) % 2 == 1, 1, -1)).all()
    assert len(np.unique(across)) == sheet.columns - 1
    assert len(np.unique(along)) == sheet.rows


def test_the_creases_are_all_lines_between_facets_and_no_others() -> None:
    for sheet in SHEETS:
        mesh = replace(sheet, tilt=0.7).mesh()
        all_edges = Mesh(mesh.reference, mesh.triangles, creases=_inner(mesh))
        folded = np.abs(measured_fold_angles(all_edges, mesh.positions))
        assert (folded > 0.1).sum() == len(mesh.creases)
        assert folded[folded <= 0.1].max() < 1e-12


def _inner(mesh: Mesh) -> Any:
    """(k, 2) edges between two triangles."""
    outer = {tuple(edge) for edge in np.sort(mesh.boundary_edges, axis=1).tolist()}
    return [edge for edge in np.sort(mesh.edges, axis=1).tolist() if tuple(edge) not in outer]


def test_at_every_inner_vertex_three_creases_fold_to_one_side_and_one_to_the_other() -> None:
    for tilt in (0.0, 0.6):
        mesh = replace(SHEETS[0], tilt=tilt).mesh()
        sides = np.zeros(mesh.node_count)
        for ends, angle in zip(mesh.creases, mesh.fold_angles, strict=True):
            sides[ends] += np.sign(angle)
        inner = np.arange(mesh.node_count).reshape(7, 5)[1:-1, 1:-1]
        assert (np.abs(sides[inner]) == 2).all()


@pytest.mark.parametrize("tilt", [0.2, 0.5, 1.0, 1.4])
@pytest.mark.parametrize("angle", [0.5, math.pi / 3, 1.3])
def test_poissons_ratio_is_that_of_two_states(tilt: float, angle: float) -> None:
    sheet = Miura(0.03, 0.02, tilt, 2, 2, angle)
    before, after = (replace(sheet, tilt=tilt + step) for step in (-1e-5, 1e-5))
    ends = [np.ptp(corners(one, one.mesh().positions)[[0, 0, 2], [0, 2, 0]], axis=0)[:2] for one in (before, after)]
    length, width = np.log(ends[1] / ends[0])
    assert sheet.poisson_ratio == pytest.approx(-width / length, rel=1e-8)


def test_poissons_ratio_of_known_states() -> None:
    sheet = Miura(0.02, 0.02, 0.5, 2, 2)
    assert sheet.poisson_ratio == pytest.approx(-2.3105, abs=5e-5)
    assert replace(sheet, tilt=1.0).poisson_ratio == pytest.approx(-0.8758, abs=5e-5)


def test_the_flat_and_the_shut_sheet() -> None:
    flat = replace(SHEETS[0], tilt=0.0)
    assert (flat.mesh().positions == flat.mesh().reference).all()
    assert flat.height == 0.0
    assert flat.packing == pytest.approx(1.0, rel=1e-14)
    shut = replace(flat, tilt=math.pi / 2)
    assert shut.packing == pytest.approx(0.0, abs=1e-15)
    assert np.ptp(shut.mesh().positions[:, 0]) < 1e-15
    for sheet in (flat, shut):
        mesh = sheet.mesh()
        np.testing.assert_allclose(np.abs(mesh.fold_angles), math.pi, rtol=1e-15)
        assert (np.sign(mesh.fold_angles) == np.sign(replace(flat, tilt=0.5).mesh().fold_angles)).all()


def test_node_sets_are_the_edges_and_corners() -> None:
    for sheet in SHEETS:
        mesh = sheet.mesh()
        sets = mesh.node_sets
        names = ["end", "end-left", "end-right", "left", "right", "start", "start-left", "start-right"]
        assert sorted(sets) == names
        around = {int(node) for name in ("start", "end", "left", "right") for node in sets[name]}
        assert around == set(mesh.boundary_edges.ravel().tolist())
        for end, side in ((end, side) for end in ("start", "end") for side in ("left", "right")):
            assert sets[f"{end}-{side}"].tolist() == sorted(set(sets[end].tolist()) & set(sets[side].tolist()))
        x, y = mesh.reference[:, 0], mesh.reference[:, 1]
        assert (x[sets["start"]] == x.min()).all()
        assert (x[sets["end"]] == x.max()).all()
        assert y[sets["left"]].min() > y[sets["right"]].max()


def test_triangles_are_as_equal_as_divisions_allow() -> None:
    for long, short in ((0.02, 0.02), (0.06, 0.02), (0.02, 0.06)):
        mesh = Miura(long, short, 0.5, 2, 2, divisions=2).mesh()
        np.testing.assert_allclose(mesh.edge_lengths, 0.01, rtol=1e-12)


@sheets((0.0, 0.7, math.pi / 2))
def test_scene_files_and_fold_files_give_the_same_sheet(sheet: Miura, tmp_path: Path) -> None:
    mesh = sheet.mesh()
    scene = Scene(mesh, RUBBER, [Triangles()], name="sheet")
    text = scene.to_toml()
    assert 'pattern = "miura"' in text
    (tmp_path / "sheet.toml").write_text(text, encoding="utf-8")
    again = Scene.from_toml(tmp_path / "sheet.toml")
    assert again.mesh is not None
    assert again.mesh.source == sheet
    check_same(again.mesh, mesh)
    mesh.save(tmp_path / "sheet.fold")
    for frame in frames_of(tmp_path / "sheet.fold"):
        check_specification(frame)
    letters = frames_of(tmp_path / "sheet.fold")[0]["edges_assignment"]
    assert letters.count("V") + letters.count("M") == len(mesh.creases)
    check_same(Mesh.load(tmp_path / "sheet.fold"), mesh)


def test_values_with_units() -> None:
    values = {"mesh.straight_side": "30 mm", "mesh.tilt": "90 deg", "mesh.angle": "50 deg", "mesh.divisions": 2}
    mesh = scenes.load("miura").with_values(values).mesh
    assert mesh is not None
    assert mesh.source == Miura(0.03, 0.02, math.pi / 2, 8, 8, math.radians(50.0), 2)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"straight_side": 0.0}, "straight_side = 0.* must be"),
        ({"zigzag_side": -0.1}, "zigzag_side = -0.1.* must be"),
        ({"tilt": -0.1}, "tilt = -0.1.* must be"),
        ({"tilt": 1.6}, "tilt = 1.6.* must be"),
        ({"tilt": math.nan}, "tilt = nan.* must be"),
        ({"angle": 0.0}, "angle = 0.* must be"),
        ({"angle": math.pi / 2}, "angle = 1.57.* must be"),
        ({"columns": 0}, "columns = 0.* must be"),
        ({"rows": 1.5}, "rows = 1.5.* must be"),
        ({"divisions": 0}, "divisions = 0.* must be"),
        ({"divisions": 10_000}, "divisions = 10000: makes about .* take fewer"),
    ],
)
def test_sheets_that_cannot_be(values: dict[str, Any], words: str) -> None:
    given = {"straight_side": 0.02, "zigzag_side": 0.02, "tilt": 0.5, "columns": 4, "rows": 4} | values
    kind = MeshError if "makes" in words else InputError
    refused(lambda: Miura(**given), kind, words)


def shape_at(sheet: Miura, length: float) -> Miura:
    """The sheet at the tilt at which two of its columns are so long [m]."""
    share = (length / (2.0 * sheet.zigzag_side)) ** 2
    return replace(sheet, tilt=math.acos(math.sqrt(share / (1.0 - share)) / math.tan(sheet.angle)))


def test_the_closed_length_leads_back_to_the_tilt() -> None:
    for tilt in (0.1, 0.7, 1.4):
        sheet = replace(SHEETS[1], tilt=tilt)
        assert shape_at(sheet, sheet.cell_length).tilt == pytest.approx(tilt, rel=1e-10)


@pytest.mark.parametrize(("begin", "end"), [(0.1, 1.3), (1.3, 0.2)])
@pytest.mark.parametrize("divisions", [1, 2])
def test_a_sheet_that_one_corner_drives_folds_as_rigid_facets_do(begin: float, end: float, divisions: int) -> None:
    sheet, last = (Miura(0.02, 0.02, tilt, 4, 4, divisions=divisions) for tilt in (begin, end))
    way = 0.5 * sheet.columns * (last.cell_length - sheet.cell_length)
    laws = [Triangles(1.0, 1.0, 1.0), SpringDamping(0.1), Bending("curvature", 1000.0), MassDamping(20.0)]
    # Opened in half the time, inertia turns the last row over: its straight creases stay folded to the other side.
    parts = [Fixed("start-right"), Moved("end-right", x=Schedule([0.0, 1.0], [0.0, way], 0.5))]
    mesh = sheet.mesh()
    sim = Simulation(Scene(mesh, RUBBER, laws, parts))
    sim.run(until=2.5)
    expected = last.mesh()
    assert np.abs(distances(sim.positions) - distances(expected.positions)).max() < 1e-6 * sheet.cell_length
    assert np.abs(mesh.strain(sim.positions)).max() < 1e-7
    np.testing.assert_allclose(measured_fold_angles(mesh, sim.positions), expected.fold_angles, atol=1e-5)
    points = corners(sheet, sim.positions)
    lengths = np.linalg.norm(points[2:] - points[:-2], axis=-1)
    widths = np.linalg.norm(points[:, 2:] - points[:, :-2], axis=-1)
    np.testing.assert_allclose(lengths, last.cell_length, rtol=1e-6)
    np.testing.assert_allclose(widths, last.cell_width, rtol=1e-6)
    assert mesh.crossings(sim.positions).count == 0
    assert abs(sim.ledger()["error"]) < 1e-6


def test_creases_fold_the_flat_sheet_to_their_marked_sides_and_to_the_least_energy() -> None:
    sheet = Miura(0.02, 0.02, 0.0, 4, 4)
    mesh, wanted = sheet.mesh(), math.pi - 2.0
    laws = [Triangles(1.0, 1.0, 1.0), SpringDamping(0.1), Bending("curvature", 1000.0), MassDamping(20.0)]
    sim = Simulation(Scene(mesh, RUBBER, [*laws, Creases(1.0, natural_angle=2.0)], [Fixed("start-right")]))
    sim.run(until=2.0)
    tilts = np.linspace(0.1, 1.4, 13001)
    straight, zigzag = 2.0 * np.arctan(math.cos(sheet.angle) * np.tan(tilts)), 2.0 * tilts
    # Twelve creases of each family, of one stiffness.
    least = float(tilts[np.argmin((straight - wanted) ** 2 + (zigzag - wanted) ** 2)])
    found = measured_fold_angles(mesh, sim.positions)
    np.testing.assert_allclose(found, replace(sheet, tilt=least).mesh().fold_angles, atol=5e-4)
    assert np.abs(mesh.strain(sim.positions)).max() < 2e-5


@pytest.mark.parametrize(("columns", "rows", "creases"), [(1, 1, 0), (3, 1, 2), (1, 3, 2), (2, 2, 4)])
def test_the_smallest_sheets(columns: int, rows: int, creases: int) -> None:
    for tilt in (0.0, 0.5):
        mesh = Miura(0.02, 0.02, tilt, columns, rows).mesh()
        assert len(mesh.creases) == creases
        assert mesh.audit().ok
        assert np.abs(mesh.strain()).max() < 1e-12


def test_the_built_in_scene_opens_to_the_closed_form() -> None:
    scene = scenes.load("miura")
    mesh = scene.mesh
    assert mesh is not None
    sheet = mesh.source
    assert isinstance(sheet, Miura)
    sim = Simulation(scene)
    sim.run(frames=2, samples=2)
    begin, end = (sim.positions[mesh.node_sets[name][0]] for name in ("start-right", "end-right"))
    last = shape_at(sheet, 2.0 * float(np.linalg.norm(end - begin)) / sheet.columns)
    assert last.tilt == pytest.approx(0.518, abs=5e-4)
    assert np.abs(distances(sim.positions) - distances(last.mesh().positions)).max() < 1e-6 * sheet.cell_length
    assert np.abs(mesh.strain(sim.positions)).max() < 1e-7
