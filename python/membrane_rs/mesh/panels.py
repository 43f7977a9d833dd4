"""Panels: the parts of a film between its creases."""

from __future__ import annotations

import numpy as np

from membrane_rs._arrays import Ints
from membrane_rs.mesh.links import groups
from membrane_rs.mesh.triangulation import Triangulation


def inner_sides(mesh: Triangulation) -> tuple[Ints, Ints]:
    """(k, 2) triangles beside each edge that two of them share, and (k,) the index of that edge in `edges`."""
    order = np.argsort(mesh.triangle_edges.ravel(), kind="stable")
    edge = mesh.triangle_edges.ravel()[order]
    is_shared = edge[1:] == edge[:-1]
    return np.stack([order[:-1], order[1:]], axis=1)[is_shared] // 3, edge[1:][is_shared]


def panels(mesh: Triangulation) -> Ints:
    """(m,) the number of the panel that each triangle is in; panels are numbered by their lowest triangles."""
    pairs, between = inner_sides(mesh)
    is_crease = np.isin(between, mesh.find_edges(mesh.creases)[0])
    return groups(pairs[~is_crease], len(mesh.triangles))
