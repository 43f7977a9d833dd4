"""Points that lie near each other, near segments, or below them: by sorting, without the import of a tree."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from membrane_rs._arrays import Floats, Ints

DIRECTION = np.sqrt([0.671, 0.251, 0.078])
"""A unit vector along which lines of regular meshes do not run, nor across it."""
OFTEN = 50
"""Rows for each segment from which a tree finds fewer."""
AT_ONCE = 50_000
"""Pairs of a segment and a row in one part of what a tree finds; those of one segment stay together."""


def may_be_near(points: Floats, distance: float) -> bool:
    """Whether two of some points (n, 3) may be as near to each other as `distance`; False only where none are.

    Boxes of four times and more that size hold both of two such points in one of four grids, each shifted by a quarter
    of a box along all axes: along an axis, the bound of a box lies between the points in one grid at most.
    """
    if distance == 0.0:
        return True
    places = [(along - along.min()) / (4.5 * distance) for along in points.T]
    for shift in (0.0, 0.25, 0.5, 0.75):
        x, y, z = (np.floor(place + shift).astype(np.int64) for place in places)
        # Numbers of far boxes may coincide, which only makes the answer True.
        boxes = np.sort((x << 42) + (y << 21) + z)
        if (boxes[1:] == boxes[:-1]).any():
            return True
    return False


def by_place(points: Floats) -> tuple[Ints, Ints]:
    """The place of each of some points (n, 3), (n,), and the first point at each place, (p,): equal ones share it."""
    order = np.lexsort(points.T)
    ordered = points[order]
    is_new = np.ones(len(points), dtype=bool)
    is_new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    place = np.empty(len(points), dtype=np.int64)
    place[order] = np.cumsum(is_new) - 1
    return place, order[is_new]


def few_of_each(place: Ints, most: int) -> Ints:
    """The first rows of each place, (n,), at most `most` of one, ascending: a tree takes long for many equal points."""
    if np.bincount(place).max(initial=0) <= most:
        return np.arange(len(place))
    order = np.argsort(place, kind="stable")
    is_kept = np.ones(len(place), dtype=bool)
    is_kept[order[most:]] = place[order[most:]] != place[order[:-most]]
    return np.flatnonzero(is_kept)


def rows_beside(points: Floats, a: Floats, b: Floats, distance: Floats) -> Iterator[tuple[Ints, Ints]]:
    """Segments and rows of points (n, 3) that may lie nearer than `distance` (s,) to segments from a to b, (s, 3).

    Those that do are all among them, each pair once, in parts of bounded size, of ascending segments.
    """
    start, end = a @ DIRECTION, b @ DIRECTION
    low, high = np.minimum(start, end) - distance, np.maximum(start, end) + distance
    pairs = rows_between(points @ DIRECTION, low, high, OFTEN * len(a))
    if pairs is not None:
        yield pairs
        return
    from scipy.spatial import cKDTree  # slow to import

    tree, centres, radii = cKDTree(points), 0.5 * (a + b), 0.5 * np.linalg.norm(b - a, axis=1) + distance
    counts = np.asarray(tree.query_ball_point(centres, radii, return_length=True), np.int64)
    part = (np.cumsum(counts) - counts) // AT_ONCE
    for segments in np.split(np.arange(len(a)), np.flatnonzero(np.diff(part)) + 1):
        found = tree.query_ball_point(centres[segments], radii[segments])
        rows = np.concatenate([np.asarray(of_one, np.int64) for of_one in found])
        yield np.repeat(segments, counts[segments]), rows


def rows_between(places: Floats, low: Floats, high: Floats, most: int) -> tuple[Ints, Ints] | None:
    """Intervals (s,) and rows of `places` (n,) from `low` on and below `high`, each pair once; None for over `most`."""
    order = np.argsort(places)
    ordered = places[order]
    begin, end = np.searchsorted(ordered, low), np.searchsorted(ordered, high)
    counts = np.maximum(end - begin, 0)
    total = int(counts.sum())
    if total > most:
        return None
    before = np.cumsum(counts) - counts
    return np.repeat(np.arange(len(low)), counts), order[np.arange(total) + np.repeat(begin - before, counts)]
