"""How near to the axis nodes can come that hang on held ones."""

from __future__ import annotations

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs.mesh import Mesh
from membrane_rs.scene.assembly import Assembly


def nearest_radii(assembly: Assembly, mesh: Mesh | None, edge_strain_limit: float | None) -> Floats:
    """(k,) least distance from the axis that each of the scene's contact nodes can come to [m].

    A node is no farther from a held one than the cords and edges between them are long where each is stretched to its
    limit of strain; below 0: the axis itself is in reach. Edges have a limit where `edge_strain_limit` is given.
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
