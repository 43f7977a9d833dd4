"""Fold angles of creases: measured on positions, and compared with those that are given."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from membrane_rs._arrays import Bools, Floats, Ints
from membrane_rs._given_arrays import numeric
from membrane_rs.errors import MeshError
from membrane_rs.mesh.panels import inner_sides, panels
from membrane_rs.mesh.triangulation import Triangulation

FLAT = np.radians(1.0)
"""Below it a crease is flat, and folds to the side that its given angle says."""
SHUT = np.radians(179.0)
"""Beyond it a crease is shut: noise and layers that touch decide on which side its facets seem to lie."""
TOLERANCE = np.radians(5.0)
"""Between a given and a measured angle: angles of other programs are rounded, and shapes are a little relaxed."""
OPEN = np.radians(45.0)
"""By how much a crease that is given as shut may be open where layers lie on each other, which are then as far apart as
its facets are high; and the most that the bend of the film beside it allows."""
STRAIN = 0.05
"""Strain of a side beyond which a facet is crumpled, and shows no fold."""


def measured_fold_angles(mesh: Triangulation, positions: Floats) -> Floats:
    """(c,) fold angle of each crease at `positions` (n, 3) [rad], from -pi to pi, in the sign of the FOLD format.

    With A, B the nodes of the crease, the lower one first, C the apex of the facet to the left of A -> B and D that to
    the right, seen from the side from which triangles run counter-clockwise, e = B - A, n_C = e x (C - A) and
    n_D = (D - A) x e, it is atan2(|e| n_D . (C - A), n_C . n_D): pi less the crease angle of
    `rust/core/src/elements/hinge.rs`. NaN where the two facets are wound in opposite senses, or where a side of them is
    strained by 5 % or more.
    """
    facets = _facets(mesh, mesh.creases)
    angles = _angles(positions, facets)
    has_fold = (facets >= 0).all(axis=1)
    for i, j in ((0, 1), (0, 2), (1, 2), (0, 3), (1, 3)):
        before, now = (
            np.linalg.norm(points[facets[:, j]] - points[facets[:, i]], axis=1)
            for points in (mesh.reference, positions)
        )
        has_fold &= np.abs(now - before) < STRAIN * before
    angles[~has_fold] = np.nan
    return angles


def _facets(mesh: Triangulation, pairs: Ints) -> Ints:
    """(k, 4) nodes A, B, C, D of edges (k, 2), as in `measured_fold_angles`; -1 where there is no such facet."""
    index = mesh.find_edges(pairs)[0]
    is_wanted = np.zeros(len(mesh.edges), dtype=bool)
    is_wanted[index] = True
    apexes = np.full((len(mesh.edges), 2), -1, dtype=np.int64)
    rows, corners = np.nonzero(is_wanted[mesh.triangle_edges])
    ends = (mesh.triangles[rows, (corners + k) % 3] for k in (1, 2))
    side = np.greater(*ends).astype(np.int64)
    apexes[mesh.triangle_edges[rows, corners], side] = mesh.triangles[rows, corners]
    return np.concatenate([np.sort(pairs, axis=1), apexes[index]], axis=1)


def _angles(positions: Floats, facets: Ints) -> Floats:
    a = positions[facets[:, 0]]
    e, c, d = (positions[facets[:, k]] - a for k in (1, 2, 3))
    normal_c, normal_d = np.cross(e, c), np.cross(d, e)
    sine = np.linalg.norm(e, axis=1) * np.einsum("ij,ij->i", normal_d, c)
    angles: Floats = np.arctan2(sine, np.einsum("ij,ij->i", normal_c, normal_d))
    return angles


def _bend(mesh: Triangulation, positions: Floats, creases: Ints) -> Floats:
    """(k,) the largest angle [rad] by which the film bends at another side of the two facets of creases (k, 2)."""
    sides = _facets(mesh, creases)[:, [0, 2, 1, 2, 0, 3, 1, 3]].reshape(-1, 2)
    facets = _facets(mesh, sides)
    bend = np.abs(_angles(positions, facets))
    is_crease = np.isin(mesh.find_edges(sides)[0], mesh.find_edges(mesh.creases)[0])
    bend[is_crease | (facets < 0).any(axis=1)] = 0.0
    largest: Floats = bend.reshape(-1, 4).max(axis=1)
    return largest


def largest_bend(mesh: Triangulation, positions: Floats) -> float:
    """The largest angle [rad] between two triangles of one panel at positions (n, 3); 0 where all panels are flat."""
    is_crease = np.zeros(len(mesh.edges), dtype=bool)
    is_crease[mesh.find_edges(mesh.creases)[0]] = True
    inside = mesh.edges[(mesh.triangles_per_edge == 2) & ~is_crease]
    return float(np.abs(_angles(positions, _facets(mesh, inside))).max(initial=0.0))


def fold_angles_of(mesh: Triangulation, positions: Floats) -> Floats:
    """(c,) fold angles [rad] that positions (n, 3) show; 0 where a crease is flat or crumpled.

    Raises
    ------
    MeshError
        A crease that is shut, whose side positions do not show.
    """
    angles = measured_fold_angles(mesh, positions)
    shut = np.flatnonzero(np.abs(angles) > SHUT)
    if len(shut):
        k = shut[0]
        raise MeshError(
            f"fold_angles are left out, and creases[{k}] (nodes {_nodes(mesh, k)}) is shut in positions, with its "
            f"facets {np.degrees(np.abs(angles[k])):.4g} degrees from flat ({len(shut)} such creases): positions do "
            "not show to which side it folds; give fold_angles, pi for a valley and -pi for a mountain"
        )
    return np.where(np.abs(angles) >= FLAT, angles, 0.0)


def check_fold_angles(mesh: Triangulation, positions: Floats, given: Floats) -> None:
    """Compare given fold angles (c,) [rad] with those that positions (n, 3) show.

    Where a crease is folded by 1 to 179 degrees, both have one sign, and differ by 5 degrees at most; none is given as
    flat. A flat crease may have any angle: its sign says to which side it will fold. A shut one has either sign, and is
    given within 5 degrees of +-180.

    One that is given as shut may be open, or interpenetrate, by as much as the film bends at another side of its
    facets, up to 45 degrees: what is stowed round a hub is a polygon. Where layers lie on each other, at several
    creases, it may be open by 45 degrees, and interpenetrate by 5.

    Raises
    ------
    MeshError
        Another sign or another angle.
    """
    found = measured_fold_angles(mesh, positions)
    with np.errstate(invalid="ignore"):
        bad = np.flatnonzero(_contradicts(mesh, positions, given, found))
    if not len(bad):
        return
    k = bad[0]
    shows = f"{np.degrees(found[k]):.4g} degrees"
    if abs(found[k]) > SHUT:
        shows, remedy = "it is shut", "give pi for a valley and -pi for a mountain"
    elif given[k] * found[k] < 0.0 and abs(given[k] + found[k]) <= TOLERANCE:
        remedy = (
            "the sign is that of the FOLD format, valley positive, seen from the side from which triangles run "
            "counter-clockwise: reverse it or the order of nodes in all triangles, or leave fold_angles out"
        )
    else:
        remedy = "give the angle in positions, in radians, or leave fold_angles out, to take them from positions"
    raise MeshError(
        f"fold_angles[{k}] = {given[k]:.6g} rad ({np.degrees(given[k]):.4g} degrees) contradicts positions at "
        f"creases[{k}] (nodes {_nodes(mesh, k)}), where {shows} ({len(bad)} such creases); {remedy}. The angle "
        "towards which a crease turns is Creases.natural_angle"
    )


def taken_as_sides(mesh: Triangulation, positions: Floats, given: Floats) -> Ints:
    """Creases whose given angle (c,) [rad] says more than positions (n, 3) do, where its sign alone is taken.

    A flat crease that is given as folded by 5 to 179 degrees. 0 and +-pi are the usual marks of a side.
    """
    found, size = np.abs(measured_fold_angles(mesh, positions)), np.abs(given)
    return np.flatnonzero((found < FLAT) & (size > TOLERANCE) & (size <= SHUT))


def _contradicts(mesh: Triangulation, positions: Floats, given: Floats, found: Floats) -> Bools:
    is_clear = (np.abs(found) >= FLAT) & (np.abs(found) <= SHUT)
    is_opposite = given * found < 0.0
    is_given_as_shut, is_given_as_flat = np.abs(given) > SHUT, np.abs(given) < FLAT
    apart = np.abs((given - found + np.pi) % (2.0 * np.pi) - np.pi)
    is_reversed = is_opposite & ~is_given_as_flat
    tolerance = np.full(len(given), TOLERANCE)
    stowed = np.flatnonzero(is_given_as_shut & is_clear & (is_opposite | (apart > TOLERANCE)))
    if len(stowed):
        is_opposed, is_layered = is_opposite[stowed], _lies_in_layers(mesh)[stowed]
        bend = _bend(mesh, positions, mesh.creases[stowed])
        tolerance[stowed] = np.clip(bend, np.where(is_layered & ~is_opposed, OPEN, TOLERANCE), OPEN)
        is_reversed[stowed] &= ~is_layered & (bend < FLAT)
    # A shut crease shows either sign.
    is_shut = np.abs(found) > SHUT
    is_open = np.abs(np.abs(given) - np.abs(found)) > TOLERANCE
    wrong: Bools = (is_clear & ((apart > tolerance) | is_reversed | is_given_as_flat)) | (is_shut & is_open)
    return wrong


def _lies_in_layers(mesh: Triangulation) -> Bools:
    """(c,) whether one of the two panels beside a crease borders a third panel at another crease or a bridge."""
    index = mesh.find_edges(mesh.creases)[0]
    pairs, between = inner_sides(mesh)
    is_crease = np.isin(between, index)
    panel = panels(mesh)
    some = np.zeros(mesh.node_count, dtype=np.int64)
    some[mesh.triangles.ravel()] = np.repeat(np.arange(len(mesh.triangles)), 3)
    ends = panel[np.concatenate([pairs[is_crease], some[mesh.bridges]])]
    ends = np.unique(np.sort(ends[ends[:, 0] != ends[:, 1]], axis=1), axis=0)
    neighbours = np.bincount(ends.ravel(), minlength=len(mesh.triangles))
    beside = np.zeros(len(mesh.edges), dtype=bool)
    beside[between[is_crease]] = (neighbours[panel[pairs[is_crease]]] > 1).any(axis=1)
    found: Bools = beside[index]
    return found


def _nodes(mesh: Triangulation, crease: int) -> str:
    return " and ".join(map(str, mesh.creases[crease].tolist()))


def given_fold_angles(mesh: Triangulation, positions: Floats, values: ArrayLike | None) -> Floats:
    """(c,) given fold angles [rad], compared with positions, or those of positions. Raises MeshError."""
    if values is None:
        return fold_angles_of(mesh, positions)
    array = numeric(values, "fold_angles", "fiu", "angles in radians", MeshError)
    count = len(mesh.creases)
    if array.shape != (count,):
        raise MeshError(f"fold_angles has shape {array.shape}; it must be ({count},), one angle for each crease")
    angles: Floats = np.array(array, dtype=np.float64)
    bad = np.flatnonzero(~(np.abs(angles) <= np.pi + 1e-12))
    if len(bad):
        raise MeshError(
            f"fold_angles[{bad[0]}] = {angles[bad[0]]} is outside -pi to pi; give it in radians, flat is zero"
        )
    check_fold_angles(mesh, positions, angles)
    return angles
