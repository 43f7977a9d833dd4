"""Quadrilaterals in two triangles each: by which diagonal."""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np

from membrane_rs._arrays import Bools, Floats, Ints
from membrane_rs.errors import MeshError

QuadRule: TypeAlias = Literal["shorter", "alternate"]
EQUAL = 0.01
"""Diagonals whose lengths differ by no more than this, relatively, are of equal length: rectangles, rounded."""


def split_quads(points: Floats, quads: Ints, rule: QuadRule) -> tuple[Ints, list[str]]:
    """Triangles (2 q, 3) of quadrilaterals (q, 4), two after each other, wound as these; and remarks.

    "alternate" joins every other node: the corners of each quadrilateral are of two kinds by turns, as the squares of a
    chessboard, and its diagonal joins two of the kind of the lowest-numbered node of its piece. "shorter" takes the
    shorter diagonal, and that of "alternate" where both are of equal length. No diagonal outside its quadrilateral is
    taken. Raises MeshError where there is no other, and where corners are not of two kinds in "alternate".
    """
    if not len(quads):
        return np.empty((0, 3), np.int64), []
    corners = points[quads]
    lengths = np.linalg.norm(corners[:, [2, 3]] - corners[:, [0, 1]], axis=2)
    wanted = _alternate(quads, is_needed=rule == "alternate")
    if rule == "shorter":
        is_equal = np.abs(lengths[:, 1] - lengths[:, 0]) <= EQUAL * lengths[:, 0]
        wanted = np.where(is_equal, wanted, lengths[:, 1] < lengths[:, 0])
    ways = np.array([[[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]])
    fits = np.stack([_is_inside(corners[:, way]) for way in ways], axis=1)
    bad = np.flatnonzero(~fits.any(axis=1))
    if len(bad):
        raise MeshError(
            f"the quadrilateral of nodes {quads[bad[0]].tolist()} crosses itself or has no area ({len(bad)} such); "
            "correct it, or write triangles"
        )
    rows = np.arange(len(quads))
    second = np.where(fits[rows, wanted.astype(np.int64)], wanted, ~wanted).astype(np.int64)
    count = len(quads)
    remarks = [f'{count} quadrilateral{"s" * (count > 1)} split into triangles by the rule "{rule}"']
    others = int((second != wanted).sum())
    if others:
        remarks.append(f"{others} of them split by the other diagonal, since theirs would leave them")
    if rule == "alternate":
        long = int((lengths[rows, second] > (1.0 + EQUAL) * lengths[rows, 1 - second]).sum())
        words = f'{long} of them split by their longer diagonal, which may make obtuse triangles; "shorter" avoids that'
    else:
        long = int(is_equal.sum())
        words = f"{long} of them have diagonals of equal length, within {EQUAL:.0%}, and were split alternately"
    if long:
        remarks.append(words)
    triangles: Ints = np.take_along_axis(quads[:, None, :], ways[second], axis=2).reshape(-1, 3)
    return triangles, remarks


def _alternate(quads: Ints, *, is_needed: bool) -> Bools:
    """Whether a diagonal joins the second and the fourth corner, so that diagonals meet at every other node.

    In a piece where they cannot, diagonals join the first corners. Raises MeshError there if it `is_needed`.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    nodes, corners = np.unique(quads, return_inverse=True)
    corners = corners.reshape(quads.shape)
    count = len(nodes)
    ends = [corners.ravel(), np.roll(corners, -1, axis=1).ravel()]
    # Each node twice, as one of either kind; an edge joins nodes of different kinds.
    rows = np.concatenate([ends[0], ends[0] + count])
    columns = np.concatenate([ends[1] + count, ends[1]])
    graph = coo_array((np.ones(len(rows), np.int8), (rows, columns)), shape=(2 * count, 2 * count))
    label = connected_components(graph, directed=False)[1].reshape(2, count)
    bad = np.flatnonzero(label[0] == label[1])
    if len(bad) and is_needed:
        raise MeshError(
            f"quads = 'alternate': a ring of quadrilaterals about node {nodes[bad[0]]} has an odd number of edges, so "
            "that diagonals cannot meet at every other node; take quads = 'shorter'"
        )
    is_first_kind = label[0] <= label[1]  # that of the lowest node of each piece, which is labelled first
    found: Bools = ~is_first_kind[corners[:, 0]]
    return found


def _is_inside(triangles: Floats) -> Bools:
    """Whether two triangles (q, 2, 3, 3) of each quadrilateral lie beside each other, by their normals."""
    sides = triangles[:, :, 1:] - triangles[:, :, :1]
    normals = np.cross(sides[:, :, 0], sides[:, :, 1])
    found: Bools = (normals[:, 0] * normals[:, 1]).sum(axis=1) > 0.0
    return found
