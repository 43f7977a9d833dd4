"""Triangles of other programs made one net: nodes that lie together merged, triangles once each and wound alike."""

from __future__ import annotations

import numpy as np

from membrane_rs._arrays import Bools, Floats, Ints
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


def distinct_faces(faces: Ints, *, may_collapse: bool) -> tuple[Ints, Ints, list[str]]:
    """Faces (f, 4) once each, triangles with -1 as their last corner; (k,) the number of each given one among these, -1
    for none; remarks.

    Where nodes were merged (`may_collapse`) a quadrilateral that lost a side is a triangle, and other faces with a node
    twice are left out; elsewhere they are refused, by MeshError.
    """
    if may_collapse:
        faces = _without_lost_sides(faces)
    ordered = np.sort(faces, axis=1)
    is_flat = ((ordered[:, 1:] == ordered[:, :-1]) & (ordered[:, 1:] >= 0)).any(axis=1)
    if is_flat.any() and not may_collapse:
        bad = faces[np.flatnonzero(is_flat)[0]]
        raise MeshError(
            f"the cell of points {bad[bad >= 0].tolist()}, counted from 0, names one twice "
            f"({int(is_flat.sum())} such); correct it, or give merge, a length within which "
            "nodes become one and such cells are left out"
        )
    whole = np.flatnonzero(~is_flat)
    if not len(whole):
        raise MeshError("no triangle is left where nodes are merged; give a shorter length of merge")
    order = whole[np.lexsort(ordered[whole].T)]
    is_new = np.append(True, (ordered[order[1:]] != ordered[order[:-1]]).any(axis=1))
    first = order[is_new]  # the sort is stable, so that this is the first of its equals
    kept = np.sort(first)
    numbers: Ints = np.full(len(faces), -1, np.int64)
    numbers[order] = np.searchsorted(kept, first)[np.cumsum(is_new) - 1]
    remarks = []
    if is_flat.any():
        remarks.append(f"{int(is_flat.sum())} cells left out, whose corners were merged")
    if len(kept) < len(whole):
        remarks.append(f"{len(whole) - len(kept)} cells left out, which are given twice")
    once: Ints = faces[kept]
    return once, numbers, remarks


def _without_lost_sides(faces: Ints) -> Ints:
    """Faces, those of four corners as triangles where two neighbouring corners alone are one node."""
    is_lost = (faces == np.roll(faces, -1, axis=1)) & (faces[:, 3:] >= 0)
    chosen = is_lost.sum(axis=1) == 1
    found: Ints = faces.copy()
    found[chosen, :3] = faces[chosen][~is_lost[chosen]].reshape(-1, 3)
    found[chosen, 3] = -1
    return found


def pairs_of_sides(triangles: Ints) -> tuple[Ints, Bools, Ints]:
    """Pairs (p, 2) of sides that are an edge of exactly two triangles, whether both run along it in one direction, and
    the third side of each edge of more. Side 3 t + k runs from corner k of triangle t to the next one.
    """
    starts, ends = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    low, high = np.minimum(starts, ends), np.maximum(starts, ends)
    order = np.lexsort((high, low))
    low, high = low[order], high[order]
    is_same = (low[1:] == low[:-1]) & (high[1:] == high[:-1])
    is_third = is_same[1:] & is_same[:-1]
    k = np.flatnonzero(is_same & ~np.append(False, is_third) & ~np.append(is_third, False))
    pairs = np.stack([order[k], order[k + 1]], axis=1)
    return pairs, starts[pairs[:, 0]] == starts[pairs[:, 1]], order[np.flatnonzero(is_third) + 2]


def wound_alike(triangles: Ints) -> tuple[Ints, list[str]]:
    """Triangles that run the same way as their neighbours, and remarks: in each piece as most of them did before.

    A piece that has no such sense, as a Moebius strip, stays as it is.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    count = len(triangles)
    pairs, is_reversed, _ = pairs_of_sides(triangles)
    one, other = (pairs // 3).T
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
