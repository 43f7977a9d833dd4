"""Strain of triangles between two shapes, and the largest stress of a film."""

from __future__ import annotations

import numpy as np

from membrane_rs._arrays import Floats, Ints


def triangle_strains(reference: Floats, positions: Floats, triangles: Ints) -> Floats:
    """Principal Green-Lagrange strains of the triangles, (m, 2): the larger, then the smaller.

    With two edges of a triangle as columns of D (reference) and d (now), d = F D, the strain is
    E = (F^T F - 1) / 2. The Cholesky factor L of D^T D = L L^T is D in a frame that lies in the triangle, so
    in that frame 2 E = L^-1 (d^T d - D^T D) L^-T: exact for large strain, zero for any rigid motion, and
    without cancellation where the strain is small.

    `reference` and `positions` are (n, 3) [m], `triangles` is (m, 3).
    """
    before, now = _gram(reference, triangles), _gram(positions, triangles)
    (a, b, c), (p, q, r) = before, now - before
    slope, height = b / a, c - b * b / a
    e11 = p / a
    e12 = (q - slope * p) / np.sqrt(a * height)
    e22 = (r - 2.0 * slope * q + slope * slope * p) / height
    mean, spread = 0.5 * (e11 + e22), np.hypot(0.5 * (e11 - e22), e12)
    strains: Floats = 0.5 * np.stack([mean + spread, mean - spread], axis=1)
    return strains


def peak_stress(strains: Floats, youngs_modulus: float | Floats, poisson_ratio: float) -> float:
    """The largest principal stress of a film [Pa], from the principal strains (m, 2) of its triangles, m > 0, of one
    Young's modulus or of (m,) [Pa].

    Plane stress, E/(1 - nu^2) (e1 + nu e2); where that would press across, the film is
    wrinkled and carries E e1 along its wrinkles only (tension field); 0 where all of it is slack.
    """
    large, small = strains.T
    nu = poisson_ratio
    taut = (large + nu * small) / (1.0 - nu**2)
    return max(0.0, float((youngs_modulus * np.where(small > -nu * large, taut, large)).max()))


def _gram(points: Floats, triangles: Ints) -> Floats:
    """The three distinct entries of each triangle's Gram matrix of its first two edges, (3, m) [m2]."""
    u = points[triangles[:, 1]] - points[triangles[:, 0]]
    v = points[triangles[:, 2]] - points[triangles[:, 0]]
    gram: Floats = np.stack([(u * u).sum(axis=1), (u * v).sum(axis=1), (v * v).sum(axis=1)])
    return gram
