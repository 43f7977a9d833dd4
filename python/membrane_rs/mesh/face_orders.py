"""Which of two triangles of a flat-folded film lies above the other, as FOLD's `faceOrders` say it.

Layers have an order along one direction alone where all of them lie across it: so it is given for films whose triangles
are all parallel to one plane, to `STEEPEST`, and of no wound one. It follows from the heights of two triangles over
what both cover of that plane; where these do not differ, from a shut crease between them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from membrane_rs._arrays import Bools, Floats, Ints
from membrane_rs.mesh.triangulation import Triangulation

STEEPEST = np.radians(10.0)
"""Angle between a triangle and the common plane up to which a film counts as folded flat [rad]."""
MOST_TRIANGLES, MOST_PAIRS = 4000, 500_000
"""Of films whose order is looked for: pairs grow by the square of triangles, and each is a line of the file."""
ROUNDING = 1e-9
"""Of lengths, relative to the size of the film."""
SHUT = np.pi - 1e-9
"""Fold angle of a shut crease [rad]."""
BLOCK = 100_000
"""Pairs that are compared at a time, so that memory is bounded."""


@dataclass(frozen=True)
class _Layers:
    """Triangles over a plane: corners in it, (m, 3, 2), and heights of these, (m, 3), over the size of the film."""

    corners: Floats
    heights: Floats
    is_up: Bools
    """Whether the normal of each points along the heights."""


def face_orders(mesh: Triangulation, positions: Floats, fold_angles: Floats) -> list[list[int]]:
    """Triples [f, g, s] of triangles that cover each other, f < g: s is 1 where f lies on the side of g to which the
    normal of g points, and -1 on the other one. None where the film is not folded flat, or is too large.

    Parameters
    ----------
    mesh : Triangulation
        With its creases.
    positions : (n, 3) float64
        Its nodes [m].
    fold_angles : (c,) float64
        Of the creases, valley positive [rad].

    Returns
    -------
    list of [int, int, int]
        Sorted. Pairs without an order, such as triangles that pass through each other, are left out.
    """
    layers = _layers(mesh, positions)
    if layers is None:
        return []
    found: list[list[int]] = []
    shut = _shut(mesh, fold_angles)
    for pairs in _near(layers):
        covers, above = _compared(layers, pairs)
        for (f, g), is_above in zip(pairs[covers].tolist(), above[covers].tolist(), strict=True):
            if is_above:
                found.append([f, g, is_above if layers.is_up[g] else -is_above])
            elif (f, g) in shut:
                found.append([f, g, shut[f, g]])
    return sorted(found)


def _layers(mesh: Triangulation, positions: Floats) -> _Layers | None:
    """The triangles over their common plane; None where they have none."""
    if len(mesh.triangles) > MOST_TRIANGLES:
        return None
    corners = positions[mesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    if not (areas > 0.0).all():
        return None
    units = normals / areas[:, None]
    _, axes = np.linalg.eigh((units * areas[:, None]).T @ units)
    axis = axes[:, 2]
    cosines = units @ axis
    if not (np.abs(cosines) >= np.cos(STEEPEST)).all() or (cosines > 0.0).all() or (cosines < 0.0).all():
        return None
    size = float(np.ptp(positions, axis=0).max())
    scaled = (corners - positions.mean(axis=0)) / size
    return _Layers(scaled @ axes[:, :2], scaled @ axis, cosines > 0.0)


def _shut(mesh: Triangulation, fold_angles: Floats) -> dict[tuple[int, int], int]:
    """The order of the two triangles at each shut crease, by both: a valley turns their normals towards each other."""
    edges, _ = mesh.find_edges(mesh.creases)
    sign_of = {
        int(edge): int(np.sign(angle)) for edge, angle in zip(edges, fold_angles, strict=True) if abs(angle) >= SHUT
    }
    beside: dict[int, list[int]] = {edge: [] for edge in sign_of}
    for triangle, own in enumerate(mesh.triangle_edges.tolist()):
        for edge in own:
            if edge in beside:
                beside[edge].append(triangle)
    return {(both[0], both[1]): sign_of[edge] for edge, both in beside.items() if len(both) == 2}


def _near(layers: _Layers) -> list[Ints]:
    """Pairs (k, 2) of triangles whose boxes in the plane overlap, the lower number first, in blocks; none where there
    are more than `MOST_PAIRS`.
    """
    low, high = layers.corners.min(axis=1), layers.corners.max(axis=1)
    found, count = [np.zeros((0, 2), np.int64)], 0
    for f in range(len(low) - 1):
        rest = slice(f + 1, None)
        meets = ((low[rest] < high[f] - ROUNDING) & (high[rest] > low[f] + ROUNDING)).all(axis=1)
        others = f + 1 + np.flatnonzero(meets)
        found.append(np.column_stack([np.full(len(others), f), others]))
        count += len(others)
        if count > MOST_PAIRS:
            return []
    pairs = np.concatenate(found)
    return [pairs[k : k + BLOCK] for k in range(0, len(pairs), BLOCK)]


def _compared(layers: _Layers, pairs: Ints) -> tuple[Bools, Ints]:
    """Whether the triangles of pairs (k, 2) cover each other; and 1 where the first is above, -1 where it is below, 0
    where neither is, or both in parts.
    """
    first, second = layers.corners[pairs[:, 0]], layers.corners[pairs[:, 1]]
    points, is_common = _common(first, second)
    heights = [
        np.einsum("kpc,kc->kp", _shares(corners, points), layers.heights[own])
        for corners, own in zip((first, second), pairs.T, strict=True)
    ]
    gap = heights[0] - heights[1]
    least = np.where(is_common, gap, np.inf).min(axis=1)
    most = np.where(is_common, gap, -np.inf).max(axis=1)
    above, below = most > ROUNDING, least < -ROUNDING
    return _cover(first, second), np.where(above & ~below, 1, np.where(below & ~above, -1, 0))


def _cover(first: Floats, second: Floats) -> Bools:
    """Whether two triangles (k, 3, 2) overlap in more than a line: no side of either parts them."""
    apart: Bools = np.zeros(len(first), bool)
    for own, other in ((first, second), (second, first)):
        for side in range(3):
            along = own[:, (side + 1) % 3] - own[:, side]
            normal = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.linalg.norm(along, axis=1)[:, None]
            to_own = np.einsum("kc,kc->k", normal, own[:, (side + 2) % 3] - own[:, side])
            to_other = np.einsum("kc,kpc->kp", normal, other - own[:, None, side])
            np.logical_or(apart, (to_other * np.sign(to_own)[:, None]).max(axis=1) <= ROUNDING, out=apart)
    covers: Bools = ~apart
    return covers


def _common(first: Floats, second: Floats) -> tuple[Floats, Bools]:
    """Points (k, 15, 2) among which the corners of what two triangles have in common are, and which of them are."""
    points, is_common = [first, second], [_holds(second, first), _holds(first, second)]
    for i in range(3):
        for j in range(3):
            start, other = first[:, i], second[:, j]
            along, across = first[:, (i + 1) % 3] - start, second[:, (j + 1) % 3] - other
            area = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]
            is_crossed = np.abs(area) > ROUNDING * np.linalg.norm(along, axis=1) * np.linalg.norm(across, axis=1)
            gap, area = other - start, np.where(is_crossed, area, 1.0)
            s = (gap[:, 0] * across[:, 1] - gap[:, 1] * across[:, 0]) / area
            t = (gap[:, 0] * along[:, 1] - gap[:, 1] * along[:, 0]) / area
            inside = (np.minimum(s, t) >= 0.0) & (np.maximum(s, t) <= 1.0) & is_crossed
            points.append((start + s[:, None] * along)[:, None])
            is_common.append(inside[:, None])
    return np.concatenate(points, axis=1), np.concatenate(is_common, axis=1)


def _holds(corners: Floats, points: Floats) -> Bools:
    """(k, p) whether triangles (k, 3, 2) hold points (k, p, 2), their boundary included."""
    return np.asarray(_shares(corners, points).min(axis=2) >= -ROUNDING)


def _shares(corners: Floats, points: Floats) -> Floats:
    """(k, p, 3) barycentric coordinates of points (k, p, 2) in triangles (k, 3, 2)."""
    along, across = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]
    x, y = np.moveaxis(points - corners[:, None, 0], 2, 0)
    second = (x * across[:, None, 1] - y * across[:, None, 0]) / area[:, None]
    third = (y * along[:, None, 0] - x * along[:, None, 1]) / area[:, None]
    return np.stack([1.0 - second - third, second, third], axis=2)
