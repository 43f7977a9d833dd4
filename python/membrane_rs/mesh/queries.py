"""Questions to plain arrays of nodes, edges and triangles."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from membrane_rs._arrays import Ints


def distinct(nodes: Ints) -> Ints:
    """Node indices of any shape, each once, ascending: as `numpy.unique`, but counted, not sorted or hashed."""
    return np.flatnonzero(np.bincount(nodes.ravel()))


def find_pairs(pairs: Ints, wanted: Ints) -> Ints:
    """Row in `pairs` (s, 2) of each of the `wanted` (c, 2) node pairs, in either direction; -1 for none."""
    if not len(wanted) or not len(pairs):
        return np.full(len(wanted), -1, dtype=np.int64)
    stride = int(max(pairs.max(), wanted.max())) + 1
    keys = np.sort(pairs, axis=1) @ [stride, 1]
    order = np.argsort(keys, kind="stable")
    sought = np.sort(wanted, axis=1) @ [stride, 1]
    rows = order[np.minimum(np.searchsorted(keys, sought, sorter=order), len(keys) - 1)]
    return np.where(keys[rows] == sought, rows, -1)


def petal_of_triangles(triangles: Ints, node_sets: Mapping[str, Ints]) -> NDArray[np.int8]:
    """Number of the petal (node set "petal-<k>") that holds all three nodes of each of (m, 3) triangles, (m,).

    -1 for none.
    """
    petal = np.full(len(triangles), -1, dtype=np.int8)
    for name, nodes in node_sets.items():
        head, _, number = name.rpartition("-")
        if head == "petal" and number.isdigit():
            petal[np.isin(triangles, nodes).all(axis=1)] = int(number)
    return petal
