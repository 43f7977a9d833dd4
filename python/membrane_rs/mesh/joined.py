"""Triangles of other programs made one net: nodes that lie together merged, triangles once each and wound alike."""

from __future__ import annotations

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs.errors import MeshError

MOST_TOGETHER = 100
"""Nodes that lie together, on average; a larger tolerance is refused before memory is taken for all their pairs."""


def merged(points: Floats, tolerance: float) -> tuple[Ints, str]:
    """(n,) for each point the lowest one of those it is merged with, by steps up to `tolerance` [m]; what was done.

    Raises MeshError where countless points would become one.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    tree = cKDTree(points)
    if tree.count_neighbors(tree, tolerance) > MOST_TOGETHER * len(points):
        raise MeshError(
            f"merge = {tolerance:g}: more than {MOST_TOGETHER} nodes would become one (m); give a shorter length"
        )
    pairs = tree.query_pairs(tolerance, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    labels = connected_components(graph, directed=False)[1]
    _, first, place = np.unique(labels, return_index=True, return_inverse=True)
    lowest: Ints = first[place].astype(np.int64)
    count = int((lowest != np.arange(len(points))).sum())
    far = float(np.linalg.norm(points - points[lowest], axis=1).max())
    return lowest, f"{count} nodes merged with others within {tolerance:g} m, moved by {far:.3g} m at most"


def without_repeats(triangles: Ints, *, may_collapse: bool) -> tuple[Ints, Ints, list[str]]:
    """Triangles once each; for each that was given (k,) the number of it among these, -1 for none; remarks.

    A triangle with a node twice is left out where nodes were merged (`may_collapse`), and refused elsewhere, by
    MeshError.
    """
    ordered = np.sort(triangles, axis=1)
    is_flat = (ordered[:, 1:] == ordered[:, :-1]).any(axis=1)
    if is_flat.any() and not may_collapse:
        bad = int(np.flatnonzero(is_flat)[0])
        raise MeshError(
            f"the triangle of nodes {triangles[bad].tolist()} names a node twice ({int(is_flat.sum())} such); correct "
            "it, or give merge, a length within which nodes become one and such triangles are left out"
        )
    whole = np.flatnonzero(~is_flat)
    if not len(whole):
        raise MeshError("no triangle is left where nodes are merged; give a shorter length of merge")
    _, first, place = np.unique(ordered[whole], axis=0, return_index=True, return_inverse=True)
    kept = np.sort(first)
    numbers: Ints = np.full(len(triangles), -1, np.int64)
    numbers[whole] = np.searchsorted(kept, first[place.ravel()])
    remarks = []
    if is_flat.any():
        remarks.append(f"{int(is_flat.sum())} triangles left out, whose corners were merged")
    if len(kept) < len(whole):
        remarks.append(f"{len(whole) - len(kept)} triangles left out, which are given twice")
    return triangles[whole[kept]], numbers, remarks


def wound_alike(triangles: Ints) -> tuple[Ints, list[str]]:
    """Triangles that run the same way as their neighbours, and remarks: in each piece as most of them did before.

    A piece that has no such sense, as a Moebius strip, stays as it is.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    count = len(triangles)
    starts, ends = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    low, high = np.minimum(starts, ends), np.maximum(starts, ends)
    owner = np.repeat(np.arange(count), 3)
    order = np.lexsort((high, low))
    low, high, owner, is_up = low[order], high[order], owner[order], (starts < ends)[order]
    is_same = (low[1:] == low[:-1]) & (high[1:] == high[:-1])
    # Edges of exactly two triangles: the same neither as the one before nor as the one after.
    is_pair = is_same & ~np.append(False, is_same[:-1]) & ~np.append(is_same[1:], False)
    k = np.flatnonzero(is_pair)
    one, other, is_reversed = owner[k], owner[k + 1], is_up[k] == is_up[k + 1]
    # Each triangle twice, as it is and reversed; neighbours are joined in the senses that fit each other.
    rows = np.concatenate([one, one + count])
    columns = np.concatenate([other + count * is_reversed, other + count * ~is_reversed])
    graph = coo_array((np.ones(len(rows), np.int8), (rows, columns)), shape=(2 * count, 2 * count))
    labels = connected_components(graph, directed=False)[1].reshape(2, count)
    has_sense = labels[0] != labels[1]
    piece = np.minimum(labels[0], labels[1])
    is_second = labels[0] > labels[1]
    seconds = np.bincount(piece, is_second, minlength=int(labels.max()) + 1)
    sizes = np.bincount(piece, minlength=int(labels.max()) + 1)
    turned = np.where(2 * seconds[piece] > sizes[piece], ~is_second, is_second) & has_sense
    found = triangles.copy()
    found[turned] = found[turned][:, [0, 2, 1]]
    remarks = []
    if turned.any():
        remarks.append(f"{int(turned.sum())} triangles reversed, so that neighbours run the same way round")
    if not has_sense.all():
        remarks.append(f"{int((~has_sense).sum())} triangles of a surface with one side left as they are")
    return found, remarks
