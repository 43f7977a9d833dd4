"""Paths along edges of a mesh: through given nodes, or through all nodes of a set."""

from __future__ import annotations

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs.errors import MeshError
from membrane_rs.mesh.links import shortest_paths
from membrane_rs.mesh.triangulation import Triangulation


def path_through(mesh: Triangulation, nodes: Ints, *, closed: bool = False) -> Ints:
    """The path along edges that leads through some nodes in their order, between two of them by the shortest way.

    Lengths are those of the reference. Of ways of equal length one is taken, the same each time; more nodes on the way
    say which.

    Parameters
    ----------
    mesh : Triangulation
        With the edges.
    nodes : (k,) int
        Two or more.
    closed : bool
        Whether the path leads back to the first of them.

    Returns
    -------
    (p,) int
        Neighbours on it are joined by an edge. The first is also the last where it is closed.

    Raises
    ------
    MeshError
        A single node, nodes that no edges join, a way that comes to a node twice.
    """
    if len(nodes) < 2:
        raise MeshError(f"a path needs two nodes or more, and there is node {nodes[0]} alone; name the others")
    stops = [*nodes.tolist(), *nodes[:1].tolist()] if closed else nodes.tolist()
    links = _Links(mesh)
    path = stops[:1]
    visited = set() if closed else set(path)
    for stop in stops[1:]:
        for node in links.way(path[-1], stop):
            if node in visited:
                what = "twice; name more nodes on the way, in order"
                raise MeshError(f"the path along the edges comes to node {node} {what}")
            visited.add(node)
            path.append(node)
    return np.array(path, np.int64)


def path_of_set(mesh: Triangulation, nodes: Ints) -> Ints:
    """The path along edges through all nodes of a set, and through no other: along the boundary where it is one.

    It begins at that end which stands earlier in the set, or, where it is closed, at the first node of the set.

    Parameters
    ----------
    mesh : Triangulation
        With the edges.
    nodes : (k,) int
        In any order.

    Returns
    -------
    (p,) int
        Neighbours on it are joined by an edge. The first is also the last where it is closed.

    Raises
    ------
    MeshError
        Nodes that lie on no single path, with one at which it fails.
    """
    fault = ""
    for edges in (mesh.boundary_edges, mesh.edges):
        own = edges[np.isin(edges, nodes).all(axis=1)]
        path, fault = _chain(own, nodes)
        if not fault:
            return path
    raise MeshError(f"the edges between its nodes are no single path: {fault}; name the nodes of the path in order")


def _chain(edges: Ints, nodes: Ints) -> tuple[Ints, str]:
    """The nodes in the order of a path along these edges, all of which it takes; or what is wrong."""
    nothing = np.zeros(0, np.int64)
    count = np.bincount(edges.ravel(), minlength=int(nodes.max()) + 1)[nodes]
    for node, k in zip(nodes.tolist(), count.tolist(), strict=True):
        if k == 0:
            return nothing, f"no edge joins node {node} to another one"
        if k > 2:
            return nothing, f"{k} edges join node {node} to others"
    neighbours: dict[int, list[int]] = {node: [] for node in nodes.tolist()}
    for a, b in edges.tolist():
        neighbours[a].append(b)
        neighbours[b].append(a)
    ends = nodes[count == 1]
    path = [int(ends[0]) if len(ends) else int(nodes[0])]
    visited = set(path)
    while (after := next((node for node in neighbours[path[-1]] if node not in visited), None)) is not None:
        path.append(after)
        visited.add(after)
    if len(path) < len(nodes):
        left = next(node for node in nodes.tolist() if node not in visited)
        return nothing, f"node {left} lies on another piece than node {path[0]}"
    if not len(ends):
        path.append(path[0])
    return np.array(path, np.int64), ""


class _Links:
    """The edges by their nodes."""

    def __init__(self, mesh: Triangulation) -> None:
        self.mesh = mesh
        both = np.concatenate([mesh.edges, mesh.edges[:, ::-1]])
        order = np.lexsort((both[:, 1], both[:, 0]))
        self.others: Ints = both[order, 1]
        self.lengths: Floats = np.tile(mesh.edge_lengths, 2)[order]
        self.first: Ints = np.searchsorted(both[order, 0], np.arange(mesh.node_count + 1))

    def way(self, start: int, end: int) -> list[int]:
        """Nodes of the shortest way from a node to another one, without the first. Raises MeshError."""
        if end in self.others[self.first[start] : self.first[start + 1]]:
            return [end]  # a straight edge, and no search through the mesh
        mesh, total = self.mesh, float(self.mesh.edge_lengths.sum())
        goal, begun = np.array([end], np.int64), np.zeros(1)
        left = shortest_paths(mesh.edges, mesh.edge_lengths, mesh.node_count, goal, begun=begun, longest=total)
        if not np.isfinite(left[start]):
            raise MeshError(f"no edges lead from node {start} to node {end}; name nodes of one piece of the film")
        found, at = [], start
        while at != end:
            rows = slice(self.first[at], self.first[at + 1])
            others = self.others[rows]
            nearer = left[others] < left[at]
            at = int(others[np.argmin(np.where(nearer, left[others] + self.lengths[rows], np.inf))])
            found.append(at)
        return found
