"""Equal petals round the z axis, joined along their slanted sides."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs.errors import MeshError
from membrane_rs.folding._flat_petal import FlatPetal
from membrane_rs.mesh.queries import distinct


@dataclass(frozen=True)
class Petals:
    """The nodes of all petals, and those of their common sides.

    Attributes
    ----------
    petal : FlatPetal
        Petal 0, about the x axis; the others follow counter-clockwise.
    sides : int
        Petals.
    merge : bool
        Petals share the nodes on their slanted sides, or have their own.
    """

    petal: FlatPetal
    sides: int
    merge: bool = True

    @property
    def size(self) -> int:
        """Nodes of a petal."""
        return sum(map(len, self.petal.index))

    @property
    def copies(self) -> Ints:
        """(sides, 1) number of each petal's first node, before nodes are merged."""
        return np.asarray(self.size * np.arange(self.sides)[:, None])

    @property
    def here(self) -> Ints:
        """(sides, r) the last nodes of the rows of each petal, before nodes are merged."""
        return np.asarray(self.copies + np.array([row[-1] for row in self.petal.index]))

    @property
    def there(self) -> Ints:
        """(sides, r) the first nodes of the rows of the next petal, before nodes are merged."""
        return np.asarray(np.roll(self.copies, -1, axis=0) + np.array([row[0] for row in self.petal.index]))

    def numbers(self) -> tuple[Ints, Ints]:
        """(n,) number of each node in the mesh, and the nodes that it keeps, ascending."""
        number = np.arange(self.sides * self.size)
        if not self.merge:
            return number, number
        number[self.there] = number[self.here]
        kept = distinct(number)
        return np.searchsorted(kept, number), kept

    def points(self, points: Floats, width: float) -> Floats:
        """(sides n, 3) nodes of all petals from the (n, 3) of petal 0 [m].

        Raises MeshError where slanted sides lie more than 1e-12 of `width` apart.
        """
        found = turned(points, self.sides)
        apart = float(np.abs(found[self.here] - found[self.there]).max())
        if apart > 1e-12 * width:
            raise MeshError(f"the petals' slanted sides lie {apart:g} m apart; they cannot be joined")
        return found

    def of_all(self, nodes: Ints) -> Ints:
        """(sides k,) those of all petals, before nodes are merged, from (k,) nodes of petal 0."""
        return np.asarray((self.copies + nodes).ravel())


def turned(points: Floats, sides: int) -> Floats:
    """(sides n, 3) points turned about z by each multiple of 2 pi / sides; by quarter turns without rounding."""
    x, y, z = points.T
    if sides == 4:
        all_sides = [(x, y, z), (-y, x, z), (-x, -y, z), (y, -x, z)]
    else:
        angles = [2.0 * math.pi * k / sides for k in range(sides)]
        all_sides = [
            (math.cos(a) * x - math.sin(a) * y, math.sin(a) * x + math.cos(a) * y, z) if a else (x, y, z)
            for a in angles
        ]
    return np.concatenate([np.stack(columns, axis=1) for columns in all_sides])


def zigzag(strips: int, rows_per_strip: int) -> Floats:
    """(r,) height of each row of strips that stand folded, over that of a strip [-]."""
    level = np.arange(strips * rows_per_strip + 1) % (2 * rows_per_strip)
    height: Floats = 1.0 - np.abs(level / rows_per_strip - 1.0)
    return height


def fold_lines(petal: FlatPetal, strips: int, rows_per_strip: int) -> list[Ints]:
    """(k, 2) edges of each line between two strips, from the inner one outward."""
    lines = [petal.index[k * rows_per_strip] for k in range(1, strips)]
    return [np.stack([line[:-1], line[1:]], axis=1) for line in lines]
