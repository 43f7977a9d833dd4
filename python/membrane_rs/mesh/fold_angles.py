"""Fold angles of creases: measured on positions, and compared with those that are given."""

from __future__ import annotations

import numpy as np

from membrane_rs._arrays import Bools, Floats
from membrane_rs.errors import MeshError
from membrane_rs.mesh.triangulation import Triangulation

FLAT = np.radians(1.0)
"""Below it a crease is flat, and folds to the side that its given angle says."""
SHUT = np.radians(179.0)
"""Beyond it a crease is shut: noise and layers that touch decide on which side its facets seem to lie."""
TOLERANCE = np.radians(5.0)
"""Between a given and a measured angle: angles of other programs are rounded, and shapes are a little relaxed."""
OPEN, OVERLAP = np.radians(30.0), np.radians(9.5)
"""By how much a crease that is given as shut may be open, or interpenetrate: stowed shapes are coarse polygons."""
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
    index = mesh.find_edges(mesh.creases)[0]
    is_crease = np.zeros(len(mesh.edges), dtype=bool)
    is_crease[index] = True
    apexes = np.full((len(mesh.edges), 2), -1, dtype=np.int64)
    rows, corners = np.nonzero(is_crease[mesh.triangle_edges])
    ends = (mesh.triangles[rows, (corners + k) % 3] for k in (1, 2))
    side = np.greater(*ends).astype(np.int64)
    apexes[mesh.triangle_edges[rows, corners], side] = mesh.triangles[rows, corners]
    apex_c, apex_d = apexes[index].T
    a, b = np.sort(mesh.creases, axis=1).T
    e, c, d = (positions[node] - positions[a] for node in (b, apex_c, apex_d))
    normal_c, normal_d = np.cross(e, c), np.cross(d, e)
    sine = np.linalg.norm(e, axis=1) * np.einsum("ij,ij->i", normal_d, c)
    angle: Floats = np.arctan2(sine, np.einsum("ij,ij->i", normal_c, normal_d))
    has_fold = (apex_c >= 0) & (apex_d >= 0)
    for first, second in ((a, b), (a, apex_c), (b, apex_c), (a, apex_d), (b, apex_d)):
        before, now = (np.linalg.norm(points[second] - points[first], axis=1) for points in (mesh.reference, positions))
        has_fold &= np.abs(now - before) < STRAIN * before
    angle[~has_fold] = np.nan
    return angle


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

    Where a crease is folded by 1 to 179 degrees, both have one sign, and differ by 5 degrees at most. One that is given
    as shut may be open by 30 degrees, or interpenetrate by 9.5. A flat crease may have any angle: its sign says to
    which side it will fold. A shut one may have either sign.

    Raises
    ------
    MeshError
        Another sign or another angle.
    """
    found = measured_fold_angles(mesh, positions)
    with np.errstate(invalid="ignore"):
        bad = np.flatnonzero(_contradicts(given, found))
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


def _contradicts(given: Floats, found: Floats) -> Bools:
    apart = np.abs((given - found + np.pi) % (2.0 * np.pi) - np.pi)
    is_clear = (np.abs(found) >= FLAT) & (np.abs(found) <= SHUT)
    is_opposite = (given * found < 0.0) & (np.abs(given) >= FLAT) & (np.abs(given) <= SHUT)
    is_shut = np.abs(found) > SHUT
    tolerance = np.where(np.abs(given) <= SHUT, TOLERANCE, np.where(given * found < 0.0, OVERLAP, OPEN))
    wrong: Bools = (is_clear & ((apart > tolerance) | is_opposite)) | (is_shut & (np.abs(given) < np.pi / 2.0))
    return wrong


def _nodes(mesh: Triangulation, crease: int) -> str:
    return " and ".join(map(str, mesh.creases[crease].tolist()))
