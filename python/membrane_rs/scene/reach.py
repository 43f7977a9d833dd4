"""Lower bounds of the radius of nodes that cords and edges connect to fixed nodes."""

from __future__ import annotations

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs.mesh import Mesh
from membrane_rs.mesh.links import shortest_paths
from membrane_rs.scene.assembly import Assembly

ROUNDING = 1e-9
"""Share of the radius by which sums of lengths are less exact than this."""


def nearest_radii(assembly: Assembly, mesh: Mesh | None, edge_strain_limit: float | None, radius: float) -> Floats:
    """(k,) lower bound of the radius of each contact node [m], where it is above `radius`; else that or less, or -inf.

    The radius of a fixed node minus the shortest path to it along cords and edges at their strain limits; the largest
    such bound is taken. Edges have a limit where `edge_strain_limit` is given.
    """
    anchors = assembly.fixed
    radii = np.hypot(assembly.positions[anchors, 0], assembly.positions[anchors, 1])
    outside = radii > radius
    anchors, radii = anchors[outside], radii[outside]
    if not len(anchors):
        return np.full(len(assembly.contacts), -np.inf)
    pairs: list[Ints] = [assembly.cords.nodes]
    lengths: list[Floats] = [assembly.cords.rest_length * (1.0 + assembly.cords.strain_limit)]
    if mesh is not None and edge_strain_limit is not None:
        pairs.append(mesh.edges)
        lengths.append(mesh.edge_lengths * (1.0 + edge_strain_limit))
    # Paths begin at the largest of the radii. Rounding is not to cut one that counts.
    outermost = float(radii.max())
    longest = outermost - (1.0 - ROUNDING) * radius
    links = np.concatenate(pairs), np.concatenate(lengths)
    paths = shortest_paths(*links, assembly.node_count, anchors, begun=outermost - radii, longest=longest)
    nearest: Floats = outermost - paths[assembly.contacts.nodes]
    return nearest
