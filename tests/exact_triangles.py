"""Relations of triangles in rational numbers, by the points that they have in common."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations

Point = tuple[Fraction, ...]


def _minus(a: Point, b: Point) -> Point:
    return tuple(x - y for x, y in zip(a, b, strict=True))


def _dot(a: Point, b: Point) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def _cross(a: Point, b: Point) -> Point:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _between(p: Point, q: Point, of_p: Fraction, of_q: Fraction) -> Point:
    """The point on pq at which a linear function with these values is 0."""
    share = of_p / (of_p - of_q)
    return tuple(x + share * (y - x) for x, y in zip(p, q, strict=True))


def _cut(corners: list[Point], heights: list[Fraction]) -> list[Point]:
    """The points of a triangle's sides at height 0."""
    points = [p for p, height in zip(corners, heights, strict=True) if height == 0]
    for p, q, of_p, of_q in zip(corners, corners[1:] + corners[:1], heights, heights[1:] + heights[:1], strict=True):
        if of_p * of_q < 0:
            points.append(_between(p, q, of_p, of_q))
    return points


def _doubled_area(polygon: list[Point]) -> Fraction:
    return sum(
        (p[0] * q[1] - p[1] * q[0] for p, q in zip(polygon, polygon[1:] + polygon[:1], strict=True)), Fraction(0)
    )


def _common_polygon(first: list[Point], second: list[Point]) -> list[Point]:
    """The part of the second triangle inside of the first, in a plane."""
    sense = 1 if _doubled_area(first) > 0 else -1
    for a, b in zip(first, first[1:] + first[:1], strict=True):
        values = [sense * ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])) for p in second]
        kept = []
        for p, q, of_p, of_q in zip(second, second[1:] + second[:1], values, values[1:] + values[:1], strict=True):
            if of_p >= 0:
                kept.append(p)
            if of_p * of_q < 0:
                kept.append(_between(p, q, of_p, of_q))
        second = kept
    return second


def _relation(first: list[Point], second: list[Point]) -> str:
    normals = [_cross(_minus(b, a), _minus(c, a)) for a, b, c in (first, second)]
    if not all(any(normal) for normal in normals):
        return "without area"
    heights = [_dot(normals[1], _minus(p, second[0])) for p in first]
    others = [_dot(normals[0], _minus(p, first[0])) for p in second]
    line = _cross(*normals)
    if any(line):
        cuts = [
            sorted(_dot(line, p) for p in _cut(first, heights)),
            sorted(_dot(line, p) for p in _cut(second, others)),
        ]
        if not all(cuts):
            return "apart"
        begin, end = max(cut[0] for cut in cuts), min(cut[-1] for cut in cuts)
        is_proper = min(heights) < 0 < max(heights) and min(others) < 0 < max(others)
        if begin < end and is_proper:
            return "crossing"
        return "touching" if begin <= end else "apart"
    return "apart" if any(heights) else _relation_in_plane(first, second, normals[0])


def _relation_in_plane(first: list[Point], second: list[Point], normal: Point) -> str:
    axes = [k for k in range(3) if k != next(k for k in range(3) if normal[k])]
    common = _common_polygon(*([tuple(p[k] for k in axes) for p in corners] for corners in (first, second)))
    if not common:
        return "apart"
    return "overlapping" if _doubled_area(common) else "touching"


def relations(
    positions: Sequence[Sequence[float]], triangles: Sequence[Sequence[int]]
) -> tuple[list[list[int]], Counter[str]]:
    """The pairs of triangles that cross, and how many pairs have which relation."""
    points = [tuple(map(Fraction, point)) for point in positions]
    crossing, counts = [], Counter[str]()
    for (i, first), (j, second) in combinations(enumerate(triangles), 2):
        relation = _relation([points[k] for k in first], [points[k] for k in second])
        if relation == "crossing":
            crossing.append([i, j])
        if relation == "touching" and set(first) & set(second):
            relation = "apart"
        counts[relation] += 1
    return crossing, counts
