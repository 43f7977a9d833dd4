"""Triangles between rows of nodes, wound counter-clockwise when rows go along x and nodes along y."""

from __future__ import annotations

from collections.abc import Sequence, Sized

import numpy as np
from numpy.typing import NDArray

from membrane_rs._arrays import Floats, Ints


def cells(lower: Ints, upper: Ints, flip: NDArray[np.bool_]) -> Ints:
    """(2 k, 3) two triangles for each of the k cells between two rows of k + 1 nodes.

    The diagonal runs from lower[c] to upper[c + 1], or where `flip` (k,) is true from lower[c + 1] to
    upper[c].
    """
    return grid_cells(np.stack([lower, upper]), flip[None])


def grid_cells(index: Ints, flip: NDArray[np.bool_]) -> Ints:
    """(2 r k, 3) the triangles of `cells` between all rows of a grid of (r + 1, k + 1) nodes, row after row.

    `flip` (r, k).
    """
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    first = np.where(flip[..., None], np.stack([a, b, d], -1), np.stack([a, b, c], -1))
    second = np.where(flip[..., None], np.stack([d, b, c], -1), np.stack([a, c, d], -1))
    return np.stack([first, second], axis=2).reshape(-1, 3)


def stitch(lower: Ints, upper: Ints, lower_at: Floats, upper_at: Floats) -> Ints:
    """(k, 3) triangles between two rows of any number of nodes, each at an increasing coordinate.

    Both rows are walked together; the row whose next segment has its middle nearer steps first. So each
    segment is the side of one triangle, whose third corner is where the other row has come to.
    """
    middle = np.concatenate([(lower_at[1:] + lower_at[:-1]) / 2, (upper_at[1:] + upper_at[:-1]) / 2])
    is_upper = np.arange(len(middle)) >= len(lower) - 1
    is_upper = is_upper[np.argsort(middle, kind="stable")]
    i: Ints = np.cumsum(~is_upper) - ~is_upper
    j: Ints = np.cumsum(is_upper) - is_upper
    after = np.where(is_upper, upper[np.minimum(j + 1, len(upper) - 1)], lower[np.minimum(i + 1, len(lower) - 1)])
    return np.stack([lower[i], upper[j], after], axis=1)


def numbered(rows: Sequence[Sized]) -> list[Ints]:
    """Node indices of each row, row after row."""
    ends = np.cumsum([len(row) for row in rows])
    return [np.arange(end - len(row), end, dtype=np.int64) for row, end in zip(rows, ends, strict=True)]
