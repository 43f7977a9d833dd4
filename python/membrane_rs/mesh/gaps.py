"""Places where the film seems to hang together, and does not: slits, hanging nodes, pinched nodes, long bridges."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs.analysis.extent import span
from membrane_rs.mesh.findings import Finding, first_few
from membrane_rs.mesh.links import groups
from membrane_rs.mesh.neighbours import by_place, few_of_each, may_be_near, rows_beside
from membrane_rs.mesh.queries import distinct
from membrane_rs.mesh.triangulation import Triangulation

NEAR = 0.01
"""Distance of two nodes, over the shortest edge at either, below which they are meant to be one."""
NEIGHBOURS = 4
"""Nodes that are looked at next to each one, itself among them."""
TOUCHING = 1e-3
"""Distance of a node from an edge, over the edge, below which it is meant to lie on it."""


def gaps(mesh: Triangulation) -> Iterator[Finding]:
    """All of them, in the reference; in none of a size whose square is no number."""
    if not 1e-140 < span(mesh.reference) < 1e140:
        return
    yield from _near_nodes(mesh)
    yield from _hanging_nodes(mesh)
    yield from _pinched_nodes(mesh)
    yield from _long_bridges(mesh)


def _shortest_edges(mesh: Triangulation) -> Floats:
    """(n,) the shortest edge at each node [m]; inf without one."""
    shortest = np.full(mesh.node_count, np.inf)
    for ends in mesh.edges.T:
        np.minimum.at(shortest, ends, mesh.edge_lengths)
    return shortest


def _near_nodes(mesh: Triangulation) -> Iterator[Finding]:
    """Nodes that lie where another one does, or much nearer to it than edges are long; bridged ones left out."""
    used = distinct(mesh.triangles)
    if len(used) < 2:
        return
    points, shortest = mesh.reference[used], _shortest_edges(mesh)[used]
    size = span(points)
    bound = max(NEAR * float(shortest.max()), 1e-9 * size)
    if not may_be_near(points, bound):
        return
    from scipy.spatial import cKDTree  # slow to import

    bridged = groups(mesh.bridges, mesh.node_count)[used]
    place, first_there = by_place(points)
    alike = _pairs_at_a_place(place, first_there, bridged)
    # Several neighbours: the nearest may be bridged, or may be the node itself. No more nodes at a place than those.
    few = few_of_each(place, NEIGHBOURS)
    count = min(NEIGHBOURS, len(few))
    distance, other = map(np.asarray, cKDTree(points[few]).query(points[few], k=count, distance_upper_bound=bound))
    rows, columns = np.nonzero(np.isfinite(distance))
    first, second = few[rows], few[other[rows, columns]]
    apart = np.concatenate([np.zeros(len(alike)), distance[rows, columns]])
    first, second = (np.concatenate([alike[:, k], found]) for k, found in enumerate((first, second)))
    near = apart < np.maximum(NEAR * np.minimum(shortest[first], shortest[second]), 1e-9 * size)
    near &= (first != second) & (bridged[first] != bridged[second])
    pairs, at = np.unique(np.sort(np.stack([first[near], second[near]], axis=1), axis=1), axis=0, return_index=True)
    if not len(pairs):
        return
    # Each node once, however many others lie there.
    later = distinct(pairs[:, 1])
    a, b = used[pairs[0]]
    widest = float(apart[near].max())
    yield Finding(
        "warning",
        "duplicate_nodes",
        len(later),
        f"{len(later)} nodes lie where another one does, or within {100 * NEAR:g} % of an edge of it (at most "
        f"{widest:.2g} m apart), first nodes {a} and {b}, {apart[near][at[0]]:.2g} m apart at "
        f"{mesh.reference[a].tolist()} m; the membrane is not joined there",
        "merge them, or name the pairs as bridges",
        first_few(distinct(used[pairs])),
    )


def _pairs_at_a_place(place: Ints, first: Ints, bridged: Ints) -> Ints:
    """(k, 2) rows of equal `place` (n,), of whose rows the `first` are (p,), in two groups of `bridged` (n,) nodes.

    Not each pair: each row of one with its place's first row, or the first of another group than that one.
    """
    head, rows = first[place], np.arange(len(place))
    is_other = bridged != bridged[head]
    first_other = np.full(len(first), len(place))
    np.minimum.at(first_other, place[is_other], rows[is_other])
    other = first_other[place]
    is_alike = ~is_other & (other < len(place))
    return np.concatenate(
        [np.stack([head[is_other], rows[is_other]], axis=1), np.stack([rows[is_alike], other[is_alike]], axis=1)]
    )


def _hanging_nodes(mesh: Triangulation) -> Iterator[Finding]:
    """Nodes that lie on an edge of the boundary and are not its ends: the film opens there."""
    edges = mesh.boundary_edges
    if not len(edges):
        return
    nodes = distinct(edges)
    place, first = by_place(mesh.reference[nodes])
    # One node, the first, for all that coincide, and one edge likewise.
    ends = place[np.searchsorted(nodes, edges)]
    kept = np.sort(np.unique(ends @ [len(first), 1], return_index=True)[1])
    edges, ends, points = edges[kept], ends[kept], mesh.reference[nodes[first]]
    a, along_edge = points[ends[:, 0]], points[ends[:, 1]] - points[ends[:, 0]]
    length = np.linalg.norm(along_edge, axis=1)
    begin, end, reach = a + NEAR * along_edge, a + (1.0 - NEAR) * along_edge, 2.0 * TOUCHING * length
    is_hanging, message = np.zeros(len(first), dtype=bool), ""
    for edge, row in rows_beside(points, begin, end, reach):
        to_node, side = points[row] - a[edge], along_edge[edge]
        share = np.einsum("ij,ij->i", to_node, side) / np.maximum(length[edge] ** 2, 1e-300)
        apart = np.linalg.norm(points[row] - (a[edge] + share[:, None] * side), axis=1)
        is_on = (share > NEAR) & (share < 1.0 - NEAR) & (apart <= TOUCHING * length[edge])
        is_on &= (row != ends[edge, 0]) & (row != ends[edge, 1])
        found = np.flatnonzero(is_on)
        is_hanging[row[found]] = True
        if len(found) and not message:  # the lowest edges come first
            k = found[np.lexsort([first[row[found]], edge[found]])[0]]
            message = (
                f"first node {nodes[first[row[k]]]}, {apart[k]:.2g} m from the edge of nodes {edges[edge[k]].tolist()}"
            )
    if message:
        hanging = nodes[is_hanging[place]]
        yield Finding(
            "warning",
            "hanging_nodes",
            len(hanging),
            f"{len(hanging)} nodes lie on an edge of the boundary that does not end there, {message}; "
            "the membrane opens there",
            "split the triangle at that edge, so that the node becomes a corner of both parts",
            first_few(hanging),
        )


def _pinched_nodes(mesh: Triangulation) -> Iterator[Finding]:
    """Nodes at which parts of the film meet in a point: triangles that share the node, and no edge at it."""
    # Corners 3t + k of triangles; the side opposite to corner k of triangle t has the ends k+1 and k+2.
    sides, node = mesh.triangle_edges.ravel(), mesh.triangles.ravel()
    corners = np.arange(len(node))
    after = corners.reshape(-1, 3)[:, [1, 2, 0]].ravel()
    # Each side with the last one at the same edge.
    last = np.empty(len(mesh.edges), dtype=np.int64)
    last[sides] = corners
    one = np.flatnonzero(last[sides] != corners)
    two = last[sides[one]]
    ends, other_ends = ((after[side], after[after[side]]) for side in (one, two))
    straight = node[ends[0]] == node[other_ends[0]]
    links = [np.stack([ends[k], np.where(straight, other_ends[k], other_ends[1 - k])], axis=1) for k in (0, 1)]
    fan = groups(np.concatenate(links), len(node))
    node_of_fan = np.empty(int(fan.max()) + 1, dtype=np.int64)
    node_of_fan[fan] = node
    pinched = np.flatnonzero(np.bincount(node_of_fan) > 1)
    if len(pinched):
        yield Finding(
            "warning",
            "pinched_nodes",
            len(pinched),
            f"{len(pinched)} nodes join parts of the membrane that share no edge there, first node {pinched[0]}; "
            "they are held together in a point, about which they turn freely",
            "join the parts along an edge, or give each its own node there",
            first_few(pinched),
        )


def _long_bridges(mesh: Triangulation) -> Iterator[Finding]:
    """Bridges, which have no length, between nodes that lie apart."""
    if not len(mesh.bridges):
        return
    a, b = mesh.bridges.T
    apart = np.linalg.norm(mesh.reference[a] - mesh.reference[b], axis=1)
    shortest = _shortest_edges(mesh)
    long = np.flatnonzero(apart > NEAR * np.minimum(shortest[a], shortest[b]))
    if len(long):
        worst = long[np.argmax(apart[long])]
        yield Finding(
            "warning",
            "long_bridges",
            len(long),
            f"{len(long)} of {len(a)} bridges join nodes that lie apart in the flat mesh, at most {apart[worst]:.3g} m "
            f"(bridge {worst}, nodes {mesh.bridges[worst].tolist()}); a bridge has no length, and pulls them together",
            "put both nodes in one place, or use a tether",
            first_few(long),
        )
