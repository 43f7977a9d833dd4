"""Lower bounds of the radius of nodes that cords and edges connect to fixed nodes."""

from __future__ import annotations

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs.mesh import Mesh
from membrane_rs.scene.assembly import Assembly


def nearest_radii(assembly: Assembly, mesh: Mesh | None, edge_strain_limit: float | None) -> Floats:
    """(k,) lower bound of the radius of each contact node [m].

    The radius of a fixed node minus the shortest path to it along cords and edges at their strain limits; the largest
    such bound is taken. Below 0 the node may reach the axis. Edges have a limit where `edge_strain_limit` is given.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import dijkstra

    pairs: list[Ints] = [assembly.cords.nodes]
    lengths: list[Floats] = [assembly.cords.rest_length * (1.0 + assembly.cords.strain_limit)]
    if mesh is not None and edge_strain_limit is not None:
        pairs.append(mesh.edges)
        lengths.append(mesh.edge_lengths * (1.0 + edge_strain_limit))
    ends, longest = np.concatenate(pairs), np.concatenate(lengths)
    graph = coo_matrix((longest, (ends[:, 0], ends[:, 1])), shape=(assembly.node_count,) * 2)
    anchors = assembly.fixed
    away = dijkstra(graph.tocsr(), directed=False, indices=anchors)[:, assembly.contacts.nodes]
    radii = np.hypot(assembly.positions[anchors, 0], assembly.positions[anchors, 1])
    nearest: Floats = (radii[:, None] - away).max(axis=0)
    return nearest
