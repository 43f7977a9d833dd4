"""Triangles of a flat mesh that are upside down, or lie on others."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from membrane_rs._arrays import Bools, Floats, Ints
from membrane_rs.mesh.boundary import winds_once
from membrane_rs.mesh.findings import Finding, first_few
from membrane_rs.mesh.neighbours import by_place, few_of_each
from membrane_rs.mesh.triangulation import NO_AREA, Triangulation

FLAT = 1e-9
"""Height over width below which a reference is flat."""
SAMPLE = 100_000
"""Of a mesh with more triangles, a sample of about so many is looked for, and those that are upside down."""
NEIGHBOURS = 6
"""Centroids next to that of a triangle, in whose triangles it is looked for."""
INSIDE = 1e-3
"""Barycentric coordinates from which a point lies inside: triangles of a mesh touch along their sides."""


def overlaps(mesh: Triangulation, *, is_wound_alike: bool) -> Iterator[Finding]:
    """Both, where the reference is flat; `is_wound_alike`: no two triangles beside an edge have opposite senses."""
    points = _in_plane(mesh.reference)
    if points is None:
        return
    along, across = mesh.sides_along_axes(points)
    areas = along[0] * across[1] - along[1] * across[0]
    has_area = mesh.flatness() >= NO_AREA
    up, down = (areas > 0.0) & has_area, (areas < 0.0) & has_area
    turned = np.flatnonzero(down if up.sum() >= down.sum() else up)
    sample = np.arange(0, len(areas), 1 + len(areas) // SAMPLE)
    if is_wound_alike and has_area.all() and not len(turned) and winds_once(mesh, points, sample):
        return
    lies_on = _lies_on_another(points[mesh.triangles], has_area, np.union1d(turned, sample))
    both = np.intersect1d(turned, lies_on)
    if len(turned):
        is_folded = is_wound_alike and len(both) > 0
        yield Finding(
            "error" if is_folded else "warning",
            "upside_down",
            len(turned),
            f"{len(turned)} of {len(areas)} triangles are upside down in the flat reference, first triangle "
            f"{turned[0]} (nodes {mesh.triangles[turned[0]].tolist()})",
            "the mesh is folded over there: move their nodes apart"
            if is_folded
            else "reverse the order of their nodes: pressure, mountain and valley depend on it",
            first_few(turned),
        )
    if len(lies_on):
        yield Finding(
            "warning",
            "overlaps",
            len(lies_on),
            f"{len(lies_on)} of {len(areas)} triangles lie on others in the flat reference, first triangle "
            f"{lies_on[0]} (nodes {mesh.triangles[lies_on[0]].tolist()})",
            "move nodes or remove triangles, unless several sheets are meant: mass and stiffness count twice there",
            first_few(lies_on),
        )


def _in_plane(reference: Floats) -> Floats | None:
    """(n, 2) coordinates in the plane of a flat reference, of order 1; None where it is not flat, or is a line."""
    scaled = reference / max(float(np.abs(reference).max()), np.finfo(float).tiny)
    centred = scaled - scaled.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1]
    places = centred @ axes
    heights = np.ptp(places, axis=0)
    if heights[0] > FLAT * heights[2] or heights[1] <= FLAT * heights[2]:
        return None
    return np.asarray(places[:, 1:], dtype=np.float64)


def _cross(first: Floats, second: Floats) -> Floats:
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0], dtype=np.float64)


def _lies_on_another(corners: Floats, has_area: Bools, tested: Ints) -> Ints:
    """Those of the `tested` triangles whose centroid lies inside a triangle with one of the nearest centroids."""
    from scipy.spatial import cKDTree  # slow to import

    centroids = corners.mean(axis=1)
    if len(corners) < 2:
        return np.zeros(0, dtype=np.int64)
    few = few_of_each(by_place(centroids)[0], NEIGHBOURS)
    centroid = centroids[tested]
    found = np.zeros(len(tested), dtype=bool)
    nearest = cKDTree(centroids[few]).query(centroid, k=list(range(1, min(NEIGHBOURS, len(few)) + 1)))[1]
    for other in few[nearest.T]:
        a, b, c = (corners[other, k] for k in range(3))
        area = _cross(b - a, c - a)
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = [_cross(q - p, centroid - p) / area for p, q in ((a, b), (b, c), (c, a))]
            found |= (np.minimum.reduce(shares) > INSIDE) & (other != tested) & has_area[other]
    return tested[found]
