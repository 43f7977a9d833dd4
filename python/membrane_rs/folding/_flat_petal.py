"""The flat petal: a trapezoid in rows parallel to its inner and outer edge.

Rows lie at x, nodes along y, slanted sides at y = -x and y = x. Four layouts:

ruled   Columns at constant distance across the whole strip: evenly across the inner width, then as far
        apart as the rows, so that the slanted sides run through corners of the grid. Columns are the rulings
        about which a folded strip bends, no triangle is obtuse, and diagonals alternate.
fan     The same number of columns in every row, fanned out between the slanted sides; so are diagonals.
even    Each row evenly spaced, the spacing nearly the same in all rows, rows stitched together.
equilateral
        Nodes 2/sqrt(3) of the rows' distance apart, every other row shifted by half of that, so that triangles are
        equilateral but for those at the slanted sides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs._validation import MOST
from membrane_rs.folding._rows import cells, numbered, stitch


@dataclass(frozen=True)
class FlatPetal:
    """Rows of nodes from the inner to the outer edge, and triangles between them.

    Attributes
    ----------
    distance : (r,) float64
        Distance of each row from the centre of the sail [m]; also half the row's length.
    along : r arrays of float64
        Coordinates of the nodes of each row, from one slanted side to the other [m].
    index : r arrays of int64
        Their node numbers.
    triangles : (m, 3) int64
        Wound counter-clockwise.
    """

    distance: Floats
    along: list[Floats]
    index: list[Ints]
    triangles: Ints

    @property
    def points(self) -> Floats:
        """(n, 3) nodes of the petal whose middle line is the x axis [m]."""
        x = np.concatenate([np.full(len(y), d) for d, y in zip(self.distance, self.along, strict=True)])
        y = np.concatenate(self.along)
        return np.stack([x, y, np.zeros_like(x)], axis=1)


def mean_columns(layout: str, rows: int, columns: float) -> float:
    """Columns of a petal's middle row, from those of its innermost one."""
    return columns + {"ruled": 1.0, "equilateral": 0.5 * math.sqrt(3.0), "even": 4.0, "fan": 0.0}[layout] * rows


def default_columns(layout: str, inner_width: float, row_height: float, rows: int) -> float:
    """Columns across the inner width that make cells a little narrower than high; inf where they are beyond counting.

    Those of "even" and "fan" are a quarter as wide; the fan gets the even layout's mean number, so that both have the
    same counts. Those of "equilateral" are the sides of its triangles.
    """
    width = row_height * {"ruled": 0.875, "equilateral": 2.0 / math.sqrt(3.0)}.get(layout, 0.21875)
    if not width > 0.0 or inner_width / width > MOST:
        return math.inf
    columns = math.ceil(round(inner_width / width, 9))
    return columns + 4 * rows if layout == "fan" else columns


def flat_petal(layout: str, inner: float, outer: float, rows: int, columns: int) -> FlatPetal:
    """The petal between half widths `inner` and `outer` [m], with `rows` rows of cells.

    `columns` counts the cells of the innermost row.
    """
    distance = np.linspace(inner, outer, rows + 1)
    if layout == "ruled":
        return _ruled(distance, columns)
    if layout == "equilateral":
        return _equilateral(distance)
    counts = [columns + (8 * i if layout == "even" else 0) for i in range(rows + 1)]
    along = [_symmetric(d, n) for d, n in zip(distance, counts, strict=True)]
    index = numbered(along)
    triangles = []
    for i in range(rows):
        if layout == "fan":
            flip = np.arange(columns) < columns // 2  # diagonals lean outward, like the columns
            triangles.append(cells(index[i], index[i + 1], flip))
        else:
            triangles.append(stitch(index[i], index[i + 1], along[i], along[i + 1]))
    return FlatPetal(distance, along, index, np.concatenate(triangles))


def _ruled(distance: Floats, columns: int) -> FlatPetal:
    middle = _symmetric(distance[0], columns)
    along = [np.concatenate([-distance[i:0:-1], middle, distance[1 : i + 1]]) for i in range(len(distance))]
    index = numbered(along)
    triangles = []
    for i in range(len(distance) - 1):
        lower, upper = index[i], index[i + 1]
        # Diagonals alternate, counted from the nearer slanted side: the halves are mirror images.
        column = np.arange(len(lower) - 1)
        flip = np.where(column < len(lower) // 2, column % 2 == 1, (len(lower) - column) % 2 == 0)
        triangles.append(cells(lower, upper[1:-1], flip))
        ends = [[lower[0], upper[0], upper[1]], [lower[-1], upper[-2], upper[-1]]]
        triangles.append(np.array(ends, dtype=np.int64))
    return FlatPetal(distance, along, index, np.concatenate(triangles))


def _equilateral(distance: Floats) -> FlatPetal:
    height = distance[1] - distance[0]
    side = 2.0 / math.sqrt(3.0) * height
    along = []
    for i, half in enumerate(distance):
        # At least a row's height from the end, so that no angle at a slanted side is obtuse but by little; but every
        # other row has a node in its middle, even where rows are higher than half of the inner edge is long.
        shift = 0.5 * (i % 2)
        count = math.floor((half - height) / side - shift + 1e-9) + 1
        right = side * (np.arange(max(count, 1)) + shift)
        left = -right[::-1] if i % 2 else -right[:0:-1]
        along.append(np.concatenate([[-half], left, right, [half]]))
    index = numbered(along)
    triangles = []
    for i in range(len(distance) - 1):
        # Each half by itself, from the middle, so that they are mirror images.
        triangles += _stitched_halves(index[i], index[i + 1], along[i], along[i + 1])
    return FlatPetal(distance, along, index, np.concatenate(triangles))


def _stitched_halves(lower: Ints, upper: Ints, lower_at: Floats, upper_at: Floats) -> list[Ints]:
    """Triangles between two rows, one of which has a node in the middle: those at y < 0, the middle one, those at
    y > 0.
    """
    low, high = lower[len(lower) // 2 :], upper[len(upper) // 2 :]
    right = stitch(low, high, lower_at[len(lower) // 2 :], upper_at[len(upper) // 2 :])
    mirror = np.where(right >= upper[0], upper[0] + upper[-1], lower[0] + lower[-1]) - right
    if len(lower) % 2:
        middle = [low[0], upper[0] + upper[-1] - high[0], high[0]]
    else:
        middle = [lower[0] + lower[-1] - low[0], high[0], low[0]]
    return [mirror[:, ::-1], np.array([middle], dtype=np.int64), right]


def _symmetric(half: float, count: int) -> Floats:
    """`count` equal steps from -half to half, mirrored to the last bit."""
    steps = np.arange(-count, count + 1, 2) / count
    return half * steps
