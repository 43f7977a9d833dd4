"""The faces between edges that lie in a plane and do not cross, as crease patterns without faces have them."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from membrane_rs._arrays import Floats, Ints

AT_ONCE = 2**20
"""Pairs of edges in one part of the search for crossings."""
MOST_PAIRS = 2**29
"""Pairs of edges with overlapping boxes along one axis that are looked at, at most."""
MOST_PIECES = 10_000
"""Pieces without connection, at most."""
SURE = 4e-15
"""Error of twice the area of a triangle over the sum of its two products, at most."""


class NoFacesError(ValueError):
    """Edges between which there are no faces: why, and the edges at fault."""

    def __init__(self, words: str, edges: tuple[int, ...] = ()) -> None:
        super().__init__(words)
        self.edges = edges


def faces_between(points: Floats, edges: Ints) -> list[list[int]]:
    """The faces, counter-clockwise, between edges (e, 2) among points (n, 2).

    From each edge the boundary of the face to its left goes on along the next edge clockwise at the node where it
    arrives, until it is closed. A boundary that runs clockwise is that of the outside.

    Raises
    ------
    NoFacesError
        Edges that cross or touch each other elsewhere than at a common node, one with the same face on both sides, a
        face whose boundary meets itself in a node, a piece that lies inside a face of another one.
    """
    points = np.ldexp(points, -int(np.frexp(np.abs(points).max(initial=0.0))[1]))
    crossing = first_crossing(points, edges)
    if crossing is not None:
        raise NoFacesError("cross or touch each other elsewhere than at a common vertex", crossing)
    loops = _loops(points, edges)
    if len(loops) == 0:
        return []
    halves, loop = np.concatenate(loops), np.repeat(np.arange(len(loops)), [len(each) for each in loops])
    loop_of = np.empty(len(halves), dtype=np.int64)
    loop_of[halves] = loop
    for k in np.flatnonzero(loop_of[::2] == loop_of[1::2])[:1]:
        raise NoFacesError("has the same face, or the outside, on both sides", (int(k),))
    node = edges[halves // 2, halves % 2]
    end = edges[halves // 2, 1 - halves % 2]
    first = node[np.searchsorted(loop, loop)]  # from a node of the loop areas are as exact as they can be
    to, beyond = points[node] - points[first], points[end] - points[first]
    is_face = np.bincount(loop, to[:, 0] * beyond[:, 1] - to[:, 1] * beyond[:, 0]) >= 0.0
    key, count = np.unique((loop * len(points) + node)[is_face[loop]], return_counts=True)
    for each in key[count > 1][:1]:
        meets, at_fault = int(each % len(points)), halves[loop == each // len(points)]
        words = f"is part of a face whose boundary meets itself in vertex {meets}"
        raise NoFacesError(words, (int(at_fault[0] // 2),))
    corners = np.split(node, np.flatnonzero(np.diff(loop)) + 1)
    _check_apart(points, edges, [corners[k] for k in np.flatnonzero(~is_face)])
    return [corners[k].tolist() for k in np.flatnonzero(is_face)]


def first_crossing(points: Floats, edges: Ints) -> tuple[int, int] | None:
    """The first pair of edges that have a point in common other than a common end; exact."""
    for first, second in _near_pairs(points, edges):
        one, other = edges[first], edges[second]
        is_joined = (one[:, :, None] == other[:, None, :]).any(axis=(1, 2))
        is_crossed = np.zeros(len(first), dtype=bool)
        # Collinear edges that do not meet lie apart along an axis, and so do their boxes.
        apart = np.flatnonzero(~is_joined)
        a, b, c, d = (points[ends[apart, k]] for ends in (one, other) for k in (0, 1))
        is_crossed[apart] = (_side(a, b, c) * _side(a, b, d) <= 0) & (_side(c, d, a) * _side(c, d, b) <= 0)
        common, far_one, far_other = _common_ends(one[is_joined], other[is_joined])
        along_one, along_other = points[far_one] - points[common], points[far_other] - points[common]
        beside = (np.sign(along_one) == np.sign(along_other)).all(axis=1)
        joined = np.flatnonzero(is_joined)[beside]
        common, far_one, far_other = common[beside], far_one[beside], far_other[beside]
        is_crossed[joined] = _side(points[common], points[far_one], points[far_other]) == 0
        if is_crossed.any():
            k = np.flatnonzero(is_crossed)[0]
            pair = sorted((int(first[k]), int(second[k])))
            return pair[0], pair[1]
    return None


def _near_pairs(points: Floats, edges: Ints) -> Iterator[tuple[Ints, Ints]]:
    """Pairs of edges whose boxes overlap or touch, in parts."""
    low, high = points[edges].min(axis=1), points[edges].max(axis=1)
    sweeps = []
    for axis in (0, 1):
        order = np.argsort(low[:, axis], kind="stable")
        end = np.searchsorted(low[order, axis], high[order, axis], side="right")
        sweeps.append((int((end - np.arange(len(order)) - 1).sum()), order, end))
    total, order, end = min(sweeps, key=lambda sweep: sweep[0])
    if total > MOST_PAIRS:
        raise NoFacesError(f"are too long and too many to look for crossings, {total:.1e} pairs", ())
    counts = end - np.arange(len(order)) - 1
    part = np.cumsum(counts) // AT_ONCE
    for rows in np.split(np.arange(len(order)), np.flatnonzero(np.diff(part)) + 1):
        many = counts[rows]
        before = np.cumsum(many) - many
        second = np.arange(many.sum()) + np.repeat(rows + 1 - before, many)
        one, other = order[np.repeat(rows, many)], order[second]
        is_near = ((low[one] <= high[other]) & (low[other] <= high[one])).all(axis=1)
        yield one[is_near], other[is_near]


def _side(a: Floats, b: Floats, c: Floats) -> Ints:
    """The side of the line from a to b on which c lies, of points (k, 2): 1 left, -1 right, 0 on it; exact."""
    left, right = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]), (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    side = np.sign(left - right).astype(np.int64)
    for k in np.flatnonzero(np.abs(left - right) <= SURE * (np.abs(left) + np.abs(right))):
        ax, ay, bx, by, cx, cy = (Fraction(float(value)) for point in (a[k], b[k], c[k]) for value in point)
        exact = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        side[k] = (exact > 0) - (exact < 0)
    return side


def _common_ends(one: Ints, other: Ints) -> tuple[Ints, Ints, Ints]:
    """The common node of edges (k, 2), and the other node of each."""
    is_second = (one[:, :1] != other).all(axis=1)
    common, far_one = np.where(is_second, one.T[::-1], one.T)
    return common, far_one, np.where(other[:, 0] == common, other[:, 1], other[:, 0])


def _loops(points: Floats, edges: Ints) -> list[Ints]:
    """Boundaries as half edges: 2 k runs along edge k, 2 k + 1 against it. Each is in one of them."""
    start, end = edges.ravel(), edges[:, ::-1].ravel()
    along = points[end] - points[start]
    order = np.lexsort((np.arctan2(along[:, 1], along[:, 0]), start))
    # Half edges that leave a node stand counter-clockwise one after the other: the one before is the next clockwise.
    is_first = np.r_[True, start[order][1:] != start[order][:-1]]
    begins = np.flatnonzero(is_first)
    last = np.r_[begins[1:], len(order)] - 1
    before = np.empty(len(order), dtype=np.int64)
    before[order[1:]] = order[:-1]
    before[order[begins]] = order[last]
    following = before[np.arange(len(order)) ^ 1].tolist()
    is_left = [True] * len(following)
    loops: list[Ints] = []
    for first in range(len(following)):
        half, loop = first, []
        while is_left[half]:
            is_left[half] = False
            loop.append(half)
            half = following[half]
        if loop:
            loops.append(np.array(loop, dtype=np.int64))
    return loops


def _check_apart(points: Floats, edges: Ints, outsides: list[Ints]) -> None:
    """Refuse a piece that lies inside another one, where it would be a hole of a face."""
    if len(outsides) > MOST_PIECES:
        raise NoFacesError(f"form {len(outsides)} pieces; at most {MOST_PIECES} are read")
    nodes = np.array([outside[0] for outside in outsides], dtype=np.int64)
    for outside in outsides:
        start, stop = points[outside], points[np.roll(outside, -1)]
        is_near = ((start.min(0) <= points[nodes]) & (points[nodes] <= start.max(0))).all(axis=1)
        for node in nodes[is_near & (nodes != outside[0])]:
            x, y = points[node]
            spans = (start[:, 1] <= y) != (stop[:, 1] <= y)
            low, high = start[spans], stop[spans]
            at = low[:, 0] + (y - low[:, 1]) / (high[:, 1] - low[:, 1]) * (high[:, 0] - low[:, 0])
            if np.count_nonzero(at > x) % 2:
                k = np.flatnonzero((edges == node).any(axis=1))[0]
                raise NoFacesError("lies inside a face of another piece, with which nothing connects it", (int(k),))
