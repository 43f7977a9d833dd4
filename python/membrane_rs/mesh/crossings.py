"""Triangles that pass through each other, counted exactly."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Integral

from membrane_rs import _core
from membrane_rs._arrays import Floats, Ints
from membrane_rs._validation import NO_NUMBERS, show
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.mesh.triangulation import frozen

LISTED = 100_000
"""Pairs that are listed by default."""


@dataclass(frozen=True, eq=False)
class Crossings:
    """Pairs of triangles that have more in common than neighbours have, each counted once.

    Two triangles cross where they have inner points in common and lie in two planes. All numbers are exact for the
    positions as they are, doubles without a tolerance. A triangle without area crosses nothing.

    Attributes
    ----------
    pairs : (k, 2) int64
        The first `limit` pairs of triangles that cross, the lower index first, in ascending order.
    count : int
        Pairs that cross, listed or not.
    overlapping : int
        Pairs with inner points in common that lie in one plane, such as layers that are folded flat on each other.
    touching : int
        Pairs without a common node that have common points, but only on the sides of one of them at least. A sheet
        that passes exactly through an edge or a node of another one touches its triangles, and crosses none of them.
    candidates : int
        Pairs whose bounding boxes overlap or touch, which were looked at one by one.

    Examples
    --------
    Two triangles that share no node, one through the other:

    >>> from membrane_rs import Mesh
    >>> points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.2, -1], [0.2, 0.2, 1], [0.3, 0.3, 1]]
    >>> found = Mesh(points, [[0, 1, 2], [3, 4, 5]]).crossings()
    >>> found.count, found.pairs.tolist()
    (1, [[0, 1]])
    """

    pairs: Ints
    count: int
    overlapping: int
    touching: int
    candidates: int


def crossings(triangles: Ints, positions: Floats, limit: int = LISTED) -> Crossings:
    """Crossings of triangles (m, 3) at positions (n, 3) [m], the first `limit` listed. See `Mesh.crossings`."""
    if isinstance(limit, NO_NUMBERS) or not isinstance(limit, Integral):
        raise InputTypeError(f"crossings: limit = {show(limit)}: must be a whole number of pairs")
    if limit < 0:
        raise InputError(f"crossings: limit = {show(limit)}: must be at least 0 (pairs to list)")
    most = len(triangles) * (len(triangles) - 1) // 2
    found = _core.crossings(positions, triangles, min(int(limit), most))
    return Crossings(frozen(found.pairs), found.count, found.overlapping, found.touching, found.candidates)
