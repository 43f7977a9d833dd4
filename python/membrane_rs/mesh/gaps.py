"""Places where the film seems to hang together, and does not: slits, hanging nodes, pinched nodes, long bridges."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.analysis.extent import span
from membrane_rs.mesh.findings import Finding, first_few
from membrane_rs.mesh.links import groups
from membrane_rs.mesh.neighbours import may_be_near, rows_beside
from membrane_rs.mesh.queries import distinct
from membrane_rs.mesh.triangulation import Triangulation

NEAR = 0.01
"""Distance of two nodes, over the shortest edge at either, below which they are meant to be one."""
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

    # Several neighbours: the nearest may be bridged, or may be the node itself.
    count = min(4, len(used))
    distance, other = map(np.asarray, cKDTree(points).query(points, k=count, distance_upper_bound=bound))
    rows, columns = np.nonzero(np.isfinite(distance))
    first, second, apart = rows, other[rows, columns], distance[rows, columns]
    near = apart < np.maximum(NEAR * np.minimum(shortest[first], shortest[second]), 1e-9 * size)
    bridged = groups(mesh.bridges, mesh.node_count)[used]
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


def _hanging_nodes(mesh: Triangulation) -> Iterator[Finding]:
    """Nodes that lie on an edge of the boundary and are not its ends: the film opens there."""
    edges = mesh.boundary_edges
    if not len(edges):
        return
    nodes = distinct(edges)
    a, b = mesh.reference[edges[:, 0]], mesh.reference[edges[:, 1]]
    length = np.linalg.norm(b - a, axis=1)
    edge, row = rows_beside(mesh.reference[nodes], a, b, 2.0 * TOUCHING * length)
    node = nodes[row]
    along = np.einsum("ij,ij->i", mesh.reference[node] - a[edge], (b - a)[edge]) / np.maximum(length[edge] ** 2, 1e-300)
    foot = a[edge] + along[:, None] * (b - a)[edge]
    apart = np.linalg.norm(mesh.reference[node] - foot, axis=1)
    is_on = (along > NEAR) & (along < 1.0 - NEAR) & (apart <= TOUCHING * length[edge])
    is_on &= (node != edges[edge, 0]) & (node != edges[edge, 1])
    found = np.flatnonzero(is_on)
    if len(found):
        k = found[np.lexsort([node[found], edge[found]])[0]]
        hanging = distinct(node[found])
        yield Finding(
            "warning",
            "hanging_nodes",
            len(hanging),
            f"{len(hanging)} nodes lie on an edge of the boundary that does not end there, first node {node[k]}, "
            f"{apart[k]:.2g} m from the edge of nodes {edges[edge[k]].tolist()}; the membrane opens there",
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
