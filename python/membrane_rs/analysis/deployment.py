"""Deployment rate and phase difference of a membrane, read off its corners.

The corners that are followed are the node set "corners"; without it the free ends of the tethers
("tether-<k>-end"); without those the nodes of triangles farthest from the spin axis in the reference.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Protocol

import numpy as np

from membrane_rs._arrays import Floats, Ints

_TETHER_END = re.compile(r"tether-\d+-end")


class NamedShape(Protocol):
    """A flat shape whose nodes have names: a mesh, or the assembly of a scene."""

    @property
    def reference(self) -> Floats:
        """(N, 3) nodes of the flat shape [m]."""
        ...

    @property
    def triangles(self) -> Ints:
        """(m, 3) nodes of each triangle."""
        ...

    @property
    def node_sets(self) -> Mapping[str, Ints]:
        """Node indices by name."""
        ...


def corner_nodes(shape: NamedShape) -> Ints:
    """Nodes whose radius and azimuth measure the deployment of a membrane, (k,)."""
    sets = shape.node_sets
    if "corners" in sets:
        return np.asarray(sets["corners"], dtype=np.int64)
    ends = [nodes for name, nodes in sets.items() if _TETHER_END.fullmatch(name)]
    if ends:
        return np.concatenate(ends).astype(np.int64)
    radius = np.hypot(shape.reference[:, 0], shape.reference[:, 1])
    if len(shape.triangles):
        unused = np.bincount(shape.triangles.ravel(), minlength=len(radius)) == 0
        radius[unused] = 0.0
    return np.flatnonzero(radius >= radius.max() * (1.0 - 1e-9)).astype(np.int64)


class Corners:
    """Follows the corners of a membrane through time.

    The phase difference is unwrapped: each corner's azimuth is followed from one call to the next, so
    calls must come often enough for a corner to turn by less than half a turn between two of them.
    The first call takes the turn nearest to `near`.

    Parameters
    ----------
    shape : Assembly or Mesh
        Names the corners, and holds the reference that radius and azimuth are measured against.
    near : float
        Angle by which the corners have turned from the reference at the first call, to half a turn [rad]: more than
        that in a wound sail.

    Attributes
    ----------
    nodes : (k,) int64
        The corners.
    flat_radius : float
        Mean distance of the corners from the spin axis in the reference [m].
    """

    def __init__(self, shape: NamedShape, near: float = 0.0) -> None:
        self.nodes = corner_nodes(shape)
        x, y = shape.reference[self.nodes, 0], shape.reference[self.nodes, 1]
        self.flat_radius = float(np.hypot(x, y).mean())
        self._flat = np.arctan2(y, x)
        self._turned = np.full(len(self.nodes), near)

    def deployment_rate(self, positions: Floats) -> float:
        """Mean radius of the corners over that of the reference; NaN where the reference lies on the axis.

        Okuizumi et al. 2012, Figs. 14 and 15. `positions` is (N, 3) [m].
        """
        if self.flat_radius == 0.0:
            return float("nan")
        x, y = positions[self.nodes, 0], positions[self.nodes, 1]
        return float(np.hypot(x, y).mean()) / self.flat_radius

    @property
    def turned(self) -> Floats:
        """(k,) angles by which the corners have turned so far from the reference [rad]."""
        turned: Floats = self._turned.copy()
        return turned

    def resume(self, turned: Floats) -> None:
        """Follow on from where the corners have turned by `turned` (k,) [rad]."""
        self._turned = np.array(turned, dtype=np.float64)

    def phase_difference(self, positions: Floats) -> float:
        """Mean angle of the corners relative to the spool [deg].

        Okuizumi et al. 2012, Figs. 16 to 18: positive where the corners lead the spool. NaN where the
        reference lies on the axis. `positions` is (N, 3) [m], in the turning frame.
        """
        if self.flat_radius == 0.0:
            return float("nan")
        angle = np.arctan2(positions[self.nodes, 1], positions[self.nodes, 0]) - self._flat
        self._turned = angle + 2.0 * np.pi * np.round((self._turned - angle) / (2.0 * np.pi))
        return float(np.degrees(self._turned.mean())) + 0.0  # never -0
