"""What is measured on a moving membrane: deployment rate, phase difference and the strain of its triangles.

The corners that are followed are the node set "corners"; without it the free ends of the tethers
("tether-<k>-end"); without those the nodes farthest from the spin axis in the reference.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from membrane_rs.assembly import Assembly
    from membrane_rs.simulation import Simulation

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_TETHER_END = re.compile(r"tether-\d+-end")


def corner_nodes(assembly: Assembly) -> Ints:
    """Nodes whose radius and azimuth tell how far a scene has deployed, (k,)."""
    sets = assembly.node_sets
    if "corners" in sets:
        return np.asarray(sets["corners"], dtype=np.int64)
    ends = [nodes for name, nodes in sets.items() if _TETHER_END.fullmatch(name)]
    if ends:
        return np.concatenate(ends).astype(np.int64)
    radius = np.hypot(assembly.reference[:, 0], assembly.reference[:, 1])
    return np.flatnonzero(radius >= radius.max() * (1.0 - 1e-9)).astype(np.int64)


class Corners:
    """Follows the corners of a scene through time.

    The phase difference is unwrapped: each corner's azimuth is followed from one call to the next, so
    calls must come often enough for a corner to turn by less than half a turn between two of them.
    The first call takes the turn nearest to the reference.

    Parameters
    ----------
    assembly : Assembly
        Names the corners, and holds the reference that radius and azimuth are measured against.

    Attributes
    ----------
    nodes : (k,) int64
        The corners.
    flat_radius : float
        Mean distance of the corners from the spin axis in the reference [m].
    """

    def __init__(self, assembly: Assembly) -> None:
        self.nodes = corner_nodes(assembly)
        x, y = assembly.reference[self.nodes, 0], assembly.reference[self.nodes, 1]
        self.flat_radius = float(np.hypot(x, y).mean())
        self._azimuth = np.arctan2(y, x)
        self._turned = np.zeros(len(self.nodes))

    def deployment_rate(self, positions: Floats) -> float:
        """Mean radius of the corners over that of the reference; NaN where the reference lies on the axis.

        Okuizumi et al. 2012, Figs. 14 and 15. `positions` is (N, 3) [m].
        """
        if self.flat_radius == 0.0:
            return float("nan")
        x, y = positions[self.nodes, 0], positions[self.nodes, 1]
        return float(np.hypot(x, y).mean()) / self.flat_radius

    def phase_difference(self, positions: Floats) -> float:
        """Mean angle of the corners relative to the spool [deg].

        Okuizumi et al. 2012, Figs. 16 to 18: positive where the corners lead the spool. NaN where the
        reference lies on the axis. `positions` is (N, 3) [m], in the turning frame.
        """
        if self.flat_radius == 0.0:
            return float("nan")
        azimuth = np.arctan2(positions[self.nodes, 1], positions[self.nodes, 0])
        step = azimuth - self._azimuth
        self._turned += step - 2.0 * np.pi * np.round(step / (2.0 * np.pi))
        self._azimuth = azimuth
        return float(np.degrees(self._turned.mean())) + 0.0  # never -0


def deployment_rate(sim: Simulation) -> float:
    """Mean radius of the corners now over that of the reference."""
    return Corners(sim.assembly).deployment_rate(sim.positions)


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


def peak_stress(sim: Simulation) -> float:
    """The largest principal stress of the film [Pa]; NaN without film.

    Plane stress of the triangles' strains, E/(1 - nu^2) (e1 + nu e2); where that would press across, the film is
    wrinkled and carries E e1 along its wrinkles only (tension field); 0 where all of it is slack.
    """
    mesh, film = sim.scene.mesh, sim.scene.material
    if mesh is None or film is None:
        return float("nan")
    large, small = triangle_strains(mesh.reference, sim.positions[: len(mesh.reference)], mesh.triangles).T
    nu = film.poisson_ratio
    taut = (large + nu * small) / (1.0 - nu**2)
    return film.youngs_modulus * max(0.0, float(np.where(small > -nu * large, taut, large).max()))


def _gram(points: Floats, triangles: Ints) -> Floats:
    """The three distinct entries of each triangle's Gram matrix of its first two edges, (3, m) [m2]."""
    u = points[triangles[:, 1]] - points[triangles[:, 0]]
    v = points[triangles[:, 2]] - points[triangles[:, 0]]
    gram: Floats = np.stack([(u * u).sum(axis=1), (u * v).sum(axis=1), (v * v).sum(axis=1)])
    return gram
