"""Petals that all do the same: the motion of a sail averaged over the quarter turns that map it onto itself."""

from __future__ import annotations

import math

import numpy as np
from membrane_rs import Simulation
from membrane_rs._arrays import Floats
from scipy.spatial import KDTree

PETALS = 4
QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""A quarter turn about the axis, exact in binary numbers."""


class Petals:
    """The petals of a square sail, by its stowed positions (N, 3) [m], which are symmetric to the last bit."""

    def __init__(self, positions: Floats) -> None:
        apart, image = KDTree(positions).query(positions @ QUARTER.T)
        assert np.max(apart) == 0.0, f"the stowed sail is not symmetric: {np.max(apart):g} m"
        self._image = image

    def mean(self, vectors: Floats) -> Floats:
        """(N, 3) vectors at the nodes, averaged over the turns."""
        turned, total = vectors, np.zeros_like(vectors)
        for _ in range(PETALS):
            total += turned
            following = np.empty_like(turned)
            following[self._image] = turned @ QUARTER.T
            turned = following
        return total / PETALS

    def alike(self, displacement: Floats) -> Floats:
        """(N, 3) random displacements, the same in each petal, of the standard deviation of those given."""
        return math.sqrt(PETALS) * self.mean(displacement)

    def average(self, sim: Simulation) -> None:
        """Give all petals their mean motion."""
        positions, velocities = self.mean(sim.positions), self.mean(sim.velocities)
        sim.positions, sim.velocities = positions, velocities
