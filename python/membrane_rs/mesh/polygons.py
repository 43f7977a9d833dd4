"""Polygons into triangles that are all wound one way, and slits into boundaries."""

from __future__ import annotations

import heapq

import numpy as np

from membrane_rs._arrays import Bools, Floats, Ints
from membrane_rs.errors import MeshError
from membrane_rs.mesh.joined import pairs_of_sides, wound_alike
from membrane_rs.mesh.links import groups
from membrane_rs.mesh.quads import split_quads

MOST_SIDES = 10_000
"""Sides of a polygon, at most: the search for ears takes time with the square of their number."""
MOST_SQUARES = 2 * MOST_SIDES**2
"""Sum of the squares of the sides of polygons that are cut by ears, at most."""
FLAT = 1e-12
"""Height over the longest side below which a corner counts as straight."""


NO_AREA = "crosses itself, or has no area somewhere between its sides; correct it"


class PolygonError(ValueError):
    """A polygon, or triangles, of which no film can be made: why, and which."""

    def __init__(self, words: str, index: int) -> None:
        super().__init__(words)
        self.index = index


def triangulated(points: Floats, polygons: list[list[int]]) -> tuple[Ints, Ints]:
    """Triangles (m, 3) of polygons among points (n, 3), and the polygon of each, (m,).

    A quadrilateral is cut by its shorter diagonal, rectangles alternately, as `split_quads` does; a larger polygon by
    ears, those with the shortest cut first. Polygons that are not flat are cut as they look along their mean normal.

    Raises
    ------
    PolygonError
        A polygon that crosses itself or has no area, one of more than 10,000 sides, or too many of as many.
    """
    sides = np.array([len(polygon) for polygon in polygons])
    of_triangle = np.repeat(np.arange(len(polygons)), sides - 2)
    triangles = np.empty((len(of_triangle), 3), dtype=np.int64)
    triangles[sides[of_triangle] == 3] = _with(polygons, sides == 3, 3)
    quads = _with(polygons, sides == 4, 4)
    try:
        triangles[sides[of_triangle] == 4] = split_quads(points, quads, "shorter")[0]
    except MeshError:
        for index in np.flatnonzero(sides == 4).tolist():
            _ears(points[polygons[index]], index)  # says which
        raise
    begin = np.cumsum(sides - 2) - (sides - 2)
    squares = np.cumsum(np.where(sides > 100, sides**2, 0))
    for index in np.flatnonzero(squares > MOST_SQUARES)[:1].tolist():
        words = "is one of too many with more than 100 sides; cut them into smaller ones"
        raise PolygonError(words, index)
    for index in np.flatnonzero(sides > 4).tolist():
        if sides[index] > MOST_SIDES:
            words = f"has {sides[index]} sides, and at most {MOST_SIDES} are cut into triangles"
            raise PolygonError(words, index)
        corners = np.array(polygons[index])
        triangles[begin[index] : begin[index] + sides[index] - 2] = corners[_ears(points[corners], index)]
    return triangles, of_triangle


def _with(polygons: list[list[int]], is_wanted: Bools, sides: int) -> Ints:
    """(k, sides) polygons of so many sides."""
    rows = [polygons[k] for k in np.flatnonzero(is_wanted).tolist()]
    return np.array(rows, dtype=np.int64).reshape(-1, sides)


def _in_plane(corners: Floats) -> Floats:
    """(k, 2) corners (k, 3) of a polygon as they look along its mean normal, counter-clockwise, of order 1."""
    from_first = corners - corners.mean(axis=0)
    size = np.abs(from_first).max(initial=0.0)
    from_first = from_first / size if size > 0.0 else from_first
    normal = np.cross(from_first, np.roll(from_first, -1, axis=0)).sum(axis=0)
    dropped = int(np.argmax(np.abs(normal)))
    # Without the axis along which the normal is longest: a sheared view, in which inside stays inside.
    flat = from_first[:, [(dropped + 1) % 3, (dropped + 2) % 3]]
    mirrored: Floats = flat * (1.0 if normal[dropped] >= 0.0 else -1.0, 1.0)
    return mirrored


def _ears(corners: Floats, index: int) -> Ints:
    """(k - 2, 3) triangles of a polygon of corners (k, 3)."""
    points, count = _in_plane(corners), len(corners)
    before, after = np.roll(np.arange(count), 1), np.roll(np.arange(count), -1)
    is_left = np.ones(count, dtype=bool)
    # No other corner lies in an ear unless one does at which the polygon turns right or goes straight on.
    is_reflex = np.array([_height(points[before[k]], points[k], points[after[k]]) <= FLAT for k in range(count)])
    cuts: list[tuple[float, int, int, int]] = []

    def look(corner: int) -> None:
        a, c = int(before[corner]), int(after[corner])
        if _is_ear(points, a, corner, c, is_left & is_reflex):
            heapq.heappush(cuts, (float(((corners[c] - corners[a]) ** 2).sum()), corner, a, c))

    for corner in range(count):
        look(corner)
    found: list[tuple[int, int, int]] = []
    while len(found) < count - 3:
        while cuts:
            _, corner, a, c = heapq.heappop(cuts)
            if is_left[corner] and before[corner] == a and after[corner] == c:
                break
        else:
            raise PolygonError(NO_AREA, index)
        found.append((a, corner, c))
        is_left[corner] = False
        after[a], before[c] = c, a
        look(a)
        look(c)
    last = np.flatnonzero(is_left)
    if _height(*points[last]) <= FLAT:
        raise PolygonError(NO_AREA, index)
    return np.array([*found, last])


def _height(a: Floats, b: Floats, c: Floats) -> float:
    """Twice the area of a triangle over the square of its longest side, positive counter-clockwise."""
    longest = max(((q - p) ** 2).sum() for p, q in ((a, b), (b, c), (c, a)))
    twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return float(twice / longest) if longest > 0.0 else 0.0


def _is_ear(points: Floats, a: int, corner: int, c: int, others: Bools) -> bool:
    """Whether the polygon turns left at a corner, and none of some others lies in the triangle that is cut off."""
    if _height(points[a], points[corner], points[c]) <= FLAT:
        return False
    rest = np.setdiff1d(np.flatnonzero(others), (a, corner, c))
    if not len(rest):
        return True
    inside = np.ones(len(rest), dtype=bool)
    for start, end in ((a, corner), (corner, c), (c, a)):
        along, to = points[end] - points[start], points[rest] - points[start]
        inside &= along[0] * to[:, 1] - along[1] * to[:, 0] >= 0.0
    return not inside.any()


def neighbours(triangles: Ints, node_count: int) -> tuple[Ints, Bools]:
    """Pairs of sides (p, 2) of triangles that are one edge, and whether both run along it in one direction.

    Side 3 t + k runs from corner k of triangle t to the next one.

    Raises
    ------
    PolygonError
        An edge of three triangles or more; the index is that of the third one.
    """
    pairs, is_against, thirds = pairs_of_sides(triangles)
    if len(thirds):
        side = int(thirds[0])
        nodes = sorted((int(triangles[side // 3, side % 3]), int(triangles[side // 3, (side + 1) % 3])))
        raise PolygonError(f"is the third beside the edge of vertices {nodes[0]} and {nodes[1]}", side // 3)
    return pairs, is_against


def wound_one_way(points: Floats, triangles: Ints) -> Ints:
    """Triangles (m, 3), of which those are reversed that run otherwise than their neighbours.

    If all lie in one plane z = constant, they then run counter-clockwise seen from +z; else each piece as most of its
    triangles do. Triangles that agree are left as they are.

    Raises
    ------
    PolygonError
        Triangles that cannot agree, as those of a Moebius band; an edge of three.
    """
    if not neighbours(triangles, len(points))[1].any():
        return triangles
    if np.ptp(points[triangles, 2]) == 0.0:
        a, b, c = (points[corner, :2] for corner in triangles.T)
        is_reversed = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) < (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
        made: Ints = np.where(is_reversed[:, None], triangles[:, ::-1], triangles)
    else:
        made, _ = wound_alike(triangles)
    pairs, is_against = neighbours(made, len(points))
    if is_against.any():
        side = int(pairs[is_against][0, 1])
        raise PolygonError("cannot run the same way as all its neighbours: the film would have one side", side // 3)
    return made


def slit(triangles: Ints, cuts: Ints, node_count: int) -> tuple[Ints, Ints]:
    """Triangles (m, 3) whose sides along cuts (k, 2) are no neighbours any more, and the old node of each, (n + new,).

    A node on a cut becomes one for each group of triangles around it that sides without a cut connect. The first keeps
    its number, the others follow after all nodes.
    """
    origin = np.arange(node_count)
    if len(cuts) == 0:
        return triangles, origin
    pairs, _ = neighbours(triangles, node_count)
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    keys = [np.minimum(a, b) * node_count + np.maximum(a, b) for a, b in ((start, end), (cuts[:, 0], cuts[:, 1]))]
    pairs = pairs[~np.isin(keys[0][pairs[:, 0]], keys[1])]
    one, other = pairs.T
    one_next, other_next = (3 * (side // 3) + (side + 1) % 3 for side in (one, other))
    # In a film wound one way the side of a neighbour runs from the end of this one to its start.
    ties = np.concatenate([np.stack([one, other_next], axis=1), np.stack([one_next, other], axis=1)])
    uncut = np.flatnonzero(~np.isin(start, cuts))
    first = np.full(node_count, -1, dtype=np.int64)
    first[start[uncut][::-1]] = uncut[::-1]
    ties = np.concatenate([ties, np.stack([first[start[uncut]], uncut], axis=1)])
    group = groups(ties, len(start))
    _, corner = np.unique(group, return_index=True)
    of_group = np.empty(len(corner), dtype=np.int64)
    is_taken = np.zeros(node_count, dtype=bool)
    made: list[int] = []
    for k in np.argsort(corner, kind="stable").tolist():
        node = int(start[corner[k]])
        if is_taken[node]:
            of_group[k] = node_count + len(made)
            made.append(node)
        else:
            is_taken[node], of_group[k] = True, node
    return of_group[group].reshape(-1, 3), np.concatenate([origin, np.array(made, dtype=np.int64)])
