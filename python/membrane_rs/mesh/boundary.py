"""How often the boundary of a flat mesh winds about points."""

from __future__ import annotations

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs.mesh.neighbours import rows_between
from membrane_rs.mesh.triangulation import Triangulation

TURN = np.array([[0.8, -0.6], [0.6, 0.8]])
"""A rotation of the plane by which sides and rows of regular meshes do not lie along an axis."""
CLEAR = 1e-13
"""Twice the area of a triangle of coordinates of order 1 from which its sense is sure."""
SIDES = 20
"""Sides of the boundary below or above each point, of which a plain film has some four."""


def winds_once(mesh: Triangulation, points: Floats, tested: Ints) -> bool:
    """Whether the boundary winds about the centroids of some triangles just once, so that none lies on another one.

    The mesh lies flat at `points` (n, 2), of order 1; `tested` (k,) are the triangles. All triangles of the mesh have
    area and one sense, and those beside an edge run along it in opposite directions. Then as many triangles hold a
    point as the boundary winds about it: in the sum over all triangles, sides between two cancel. False where that is
    not sure.

    The winding number is the number of sides above the point that run to the left, less those that run to the right.
    """
    if mesh.triangles_per_edge.max() > 2:
        return False
    is_boundary = mesh.triangles_per_edge == 1
    rows, side = np.divmod(np.flatnonzero(is_boundary[mesh.triangle_edges]), 3)
    turned = points @ TURN
    start, end = (turned[mesh.triangles[rows, (side + k) % 3]] for k in (1, 2))
    centroids = np.add.reduce([turned[corner] for corner in mesh.triangles[tested].T]) / 3.0
    low, high = np.minimum(start[:, 0], end[:, 0]), np.maximum(start[:, 0], end[:, 0])
    pairs = rows_between(centroids[:, 0], low, high, SIDES * len(centroids))
    if pairs is None:
        return False
    edge, point = pairs
    along, to_point = (end - start)[edge], centroids[point] - start[edge]
    cross = along[:, 0] * to_point[:, 1] - along[:, 1] * to_point[:, 0]
    if np.abs(cross).min(initial=np.inf) < CLEAR:
        return False
    # A point below a side that runs to the left is on its left.
    is_above = (cross > 0.0) == (along[:, 0] < 0.0)
    direction = np.where(along[:, 0] < 0.0, 1.0, -1.0)
    winding = np.bincount(point[is_above], weights=direction[is_above], minlength=len(centroids))
    return bool((np.abs(winding) == 1.0).all())
