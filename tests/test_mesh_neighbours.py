"""The short ways of the audit: they find what a tree, a graph library and plain loops find."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest
from membrane_rs import Mesh
from membrane_rs.folding import Disc, EquilateralLattice, SquareSail, Strip
from membrane_rs.mesh import Finding, boundary, gaps, neighbours, overlaps
from membrane_rs.mesh.links import groups, shortest_paths
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import Delaunay
from small_scenes import Floats, rotation


def sector(degrees: float, steps: int = 40) -> Mesh:
    """A flat ring of this angle, one piece: it lies on itself beyond 360 degrees."""
    angle = np.radians(np.linspace(0.0, degrees, steps + 1))
    ring = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    k = np.arange(steps)
    inner, outer = k, k + steps + 1
    triangles = [np.stack([inner, outer, outer + 1], axis=1), np.stack([inner, outer + 1, inner + 1], axis=1)]
    return Mesh(np.vstack([ring, 1.5 * ring]), np.concatenate(triangles))


def scattered() -> Mesh:
    """Delaunay's triangles of scattered points, all of one sense."""
    points = np.random.default_rng(4).random((300, 2))
    found = Delaunay(points).simplices.astype(np.int64)
    a, b, c = (points[found[:, k]] for k in range(3))
    cross = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    found[cross < 0.0] = found[cross < 0.0][:, [0, 2, 1]]
    return Mesh(np.column_stack([points, np.zeros(len(points))]), found)


def slit() -> Mesh:
    """Two sheets side by side that are not joined."""
    sheet = Strip(0.1, 0.04, 10, 4).mesh()
    points = np.vstack([sheet.reference, sheet.reference + np.array([0.1, 0.0, 0.0])])
    return Mesh(points, np.vstack([sheet.triangles, sheet.triangles + sheet.node_count]))


def hanging() -> Mesh:
    """Nodes on the edges of a coarser sheet."""
    coarse, fine = Strip(0.1, 0.04, 5, 2).mesh(), Strip(0.1, 0.04, 10, 4).mesh()
    points = np.vstack([coarse.reference, fine.reference + np.array([0.1, 0.0, 0.0])])
    return Mesh(points, np.vstack([coarse.triangles, fine.triangles + coarse.node_count]))


def pinched() -> Mesh:
    """Two triangles with a common corner."""
    return Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], [[0, 1, 2], [0, 3, 4]])


MESHES: list[Callable[[], Mesh]] = [
    SquareSail(rows=32).mesh,
    SquareSail(layout="even", join="bridge").mesh,
    Disc(0.1, rings=6).mesh,
    EquilateralLattice(0.01, columns=9, rows=7).mesh,
    lambda: sector(300.0),
    lambda: sector(450.0),
    scattered,
    slit,
    hanging,
    pinched,
]


@pytest.mark.parametrize("make", MESHES)
def test_the_short_ways_of_the_audit_find_what_a_tree_finds(
    make: Callable[[], Mesh], monkeypatch: pytest.MonkeyPatch
) -> None:
    mesh = make()

    def found() -> list[Finding]:
        return [*gaps.gaps(mesh), *overlaps.overlaps(mesh, is_wound_alike=True)]

    short = found()
    monkeypatch.setattr(gaps, "may_be_near", lambda points, distance: True)
    monkeypatch.setattr(overlaps, "winds_once", lambda mesh, points, tested: False)
    monkeypatch.setattr(neighbours, "OFTEN", 0)
    assert short == found()


@pytest.mark.parametrize(("degrees", "is_once"), [(90.0, True), (359.0, True), (370.0, False), (800.0, False)])
@pytest.mark.parametrize("turn", [0.0, 0.3, 2.0])
def test_a_ring_winds_once_up_to_a_whole_turn(degrees: float, is_once: bool, turn: float) -> None:
    mesh = sector(degrees, 90)
    points = (mesh.reference @ rotation([0.0, 0.0, 1.0], turn).T)[:, :2]
    for plane in (points, points * [1.0, -1.0]):
        assert boundary.winds_once(mesh, plane, np.arange(len(mesh.triangles))) == is_once
    assert (mesh.audit(springs=False).find("overlaps") is None) == is_once


def test_sound_meshes_need_no_tree() -> None:
    for mesh in (SquareSail(rows=32).mesh(), Disc(0.1, rings=6).mesh(), scattered()):
        plane = mesh.reference[:, :2] / np.abs(mesh.reference).max()
        assert boundary.winds_once(mesh, plane, np.arange(len(mesh.triangles)))
    lattice = EquilateralLattice(0.01, columns=9, rows=7).mesh()
    assert not neighbours.may_be_near(lattice.reference, 1e-4)
    assert neighbours.may_be_near(lattice.reference, 0.0101)


def test_points_that_are_near_are_never_missed() -> None:
    rng = np.random.default_rng(7)
    for size in (1e-3, 1.0, 1e6):
        for _ in range(300):
            point, way = rng.random(3) * size, rng.normal(size=3)
            other = point + 1e-2 * way / np.linalg.norm(way)
            points = np.vstack([np.zeros(3), point, other])
            assert neighbours.may_be_near(points, 1.000001e-2)


@pytest.mark.parametrize(("often", "at_once"), [(0, 50_000), (0, 20), (50, 50_000), (10_000, 50_000)])
def test_all_points_beside_segments_are_found(often: int, at_once: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(neighbours, "OFTEN", often)
    monkeypatch.setattr(neighbours, "AT_ONCE", at_once)
    rng = np.random.default_rng(3)
    points, a = rng.random((400, 3)), rng.random((60, 3))
    b = a + 0.1 * rng.normal(size=a.shape)
    reach = rng.random(60) * 0.05
    parts = list(neighbours.rows_beside(points, a, b, reach))
    if often == 0:
        assert (len(parts) > 1) == (at_once == 20)
        assert all(np.sum(segment != segment[-1]) <= at_once for segment, _ in parts)
    segment, row = map(np.concatenate, zip(*parts, strict=True))
    assert (np.diff(segment) >= 0).all()
    pairs = set(zip(segment.tolist(), row.tolist(), strict=True))
    assert len(pairs) == len(segment)

    def distance(k: int) -> Floats:
        along = np.clip((points - a[k]) @ (b[k] - a[k]) / ((b[k] - a[k]) @ (b[k] - a[k])), 0.0, 1.0)
        away: Floats = np.linalg.norm(points - a[k] - along[:, None] * (b[k] - a[k]), axis=1)
        return away

    near = {(k, int(i)) for k in range(60) for i in np.flatnonzero(distance(k) < reach[k])}
    assert near
    assert near <= pairs


def test_the_memory_of_the_audit_is_linear_in_triangles_that_coincide() -> None:
    count = 2000
    points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.0, 0.0], [0.5, -1.0, 0.0]]
    triangles = np.array([[0, 1, 2], [0, 4, 3]]) + 5 * np.arange(count)[:, None, None]
    mesh = Mesh(np.tile(points, (count, 1)), triangles.reshape(-1, 3))
    tracemalloc.start()
    found = mesh.audit(springs=False, crossings=False)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    # One double for each pair of a triangle and another one takes more.
    assert peak < 8 * (2 * count) ** 2 / 2
    kinds = {finding.kind: finding.count for finding in found.findings}
    assert kinds["hanging_nodes"] == count
    assert kinds["duplicate_nodes"] == 5 * (count - 1)
    assert kinds["overlaps"] == 2 * count


@pytest.mark.parametrize("joined", [0, 1, 3, 7])
def test_each_of_many_nodes_in_one_place_is_told_unless_it_is_bridged_to_all_before(joined: int) -> None:
    count = 8
    points = [[0.0, 0.0, 0.0], *([np.cos(k), np.sin(k), 0.0] for k in range(2 * count))]
    triangles = [[k, count + 2 * k, count + 2 * k + 1] for k in range(count)]
    nodes = np.vstack([np.tile(points[0], (count, 1)), points[1:]])
    mesh = Mesh(nodes, triangles, bridges=[[k, k + 1] for k in range(joined)])
    found = mesh.audit(springs=False).find("duplicate_nodes")
    later = count - 1 - joined
    assert (found.count if found else 0) == later
    if found:
        assert found.where == tuple(range(count))
        assert f"first nodes 0 and {joined + 1}," in found.message


def test_groups_and_paths_are_those_of_a_graph_library() -> None:
    rng = np.random.default_rng(11)
    for count, links in ((200, 120), (200, 400), (1, 0)):
        ends = np.unique(np.sort(rng.integers(0, count, (links, 2)), axis=1), axis=0)
        ends = ends[ends[:, 0] != ends[:, 1]].astype(np.int64)
        lengths = rng.random(len(ends)) + 0.1
        graph = coo_matrix((lengths, (ends[:, 0], ends[:, 1])), shape=(count, count)).tocsr()
        assert (groups(ends, count) == connected_components(graph, directed=False)[1]).all()
        starts = np.arange(0, count, 37)
        expected = dijkstra(graph, directed=False, indices=starts)
        for k, paths in enumerate(expected):
            assert (
                shortest_paths(ends, lengths, count, starts[k : k + 1], begun=np.zeros(1), longest=np.inf) == paths
            ).all()
        begun = rng.random(len(starts))
        least = (begun[:, None] + expected).min(axis=0)
        for longest in (np.inf, 0.8):
            found = shortest_paths(ends, lengths, count, starts, begun=begun, longest=longest)
            assert np.allclose(found, np.where(least <= longest, least, np.inf), rtol=1e-14, atol=0.0)
