"""A flat disc, or ring, of nearly equilateral triangles.

Springs along the sides of triangles behave as a film does where the triangles are equilateral, and only
there; a net of other triangles is too soft or too stiff, however fine it is. A lattice of equilateral
triangles does not fit a circle, but its image under a conformal map does. Such a map turns and scales small
triangles and keeps their angles, so that what it does to their shape fades as they get smaller. Here a
hexagon cut from the lattice is mapped to a disc, and a strip of it to a ring. The error of such a net is of
second order in the size of its triangles.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from membrane_rs._bounds import check_nodes
from membrane_rs._validation import Count, NonNegative, Positive, Unit, validated
from membrane_rs.errors import MeshError
from membrane_rs.folding._rows import cells, numbered, stitch
from membrane_rs.folding.pattern import Pattern, multiplied
from membrane_rs.mesh import Mesh

Complexes = NDArray[np.complex128]

_LEAST_AROUND = 7.5
"""Nodes on each circle of a ring below which its triangles are obtuse."""


@validated
class Disc(Pattern):
    """A disc at z = 0 about the origin, or a ring, of triangles that differ in size but little in shape.

    A disc has circles of 6, 12, 18 ... nodes about one in the middle. With s = radius/rings, the sides of its
    triangles are 1.11 s in the middle, and on the rim from 1.40 s at the azimuths 30, 90, 150 ... degrees
    down to 1.57 s/sqrt(rings) at 0, 60, 120 ... degrees, which limits the step.

    A ring has the same number of nodes on each circle, and triangles in proportion to their distance from the
    middle. That number is rounded, so its triangles are too narrow or too wide by up to 0.5 in that number.

    Node sets, counter-clockwise: "centre" (the node in the middle, or the circle around the hole) and "rim".

    Parameters
    ----------
    radius : float
        Outer radius [m].
    rings : int
        Rings of triangles.
    hub_radius : float
        Radius of a round hole in the middle [m]; 0: none.

    Raises
    ------
    MeshError
        A hole that leaves no disc, too few rings for so small a hole, or more nodes than fit.
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs.folding import Disc
    >>> mesh = Disc(radius=0.1, rings=8).mesh()
    >>> mesh.node_count, len(mesh.node_sets["rim"])
    (217, 48)
    """

    radius: Annotated[Positive, Unit("m")]
    rings: Count
    hub_radius: Annotated[NonNegative, Unit("m")] = 0.0

    def __post_init__(self) -> None:
        """Check the radii against each other and against the number of rings."""
        hole = f"hub_radius = {self.hub_radius:g}"
        if self.hub_radius >= self.radius:
            raise MeshError(f"Disc.{hole}: must be less than radius = {self.radius:g} (m)")
        if self._around() < _LEAST_AROUND:
            least = math.ceil(_LEAST_AROUND * self.rings / self._around())
            raise MeshError(
                f"Disc.rings = {self.rings}: too few round a hole of {hole} (m), triangles would be "
                f"obtuse; take {least} or more"
            )
        nodes = self.rings * (self._around() if self.hub_radius else 3.0 * self.rings)
        check_nodes(nodes, f"Disc.rings = {self.rings} with {hole} (m)", "take fewer", MeshError)

    def mesh(self) -> Mesh:
        """The flat disc."""
        circles = self._circles_of_ring() if self.hub_radius else self._circles_of_disc()
        index = numbered(circles)
        rows = [np.append(row, row[0]) if len(row) > 1 else row for row in index]
        if self.hub_radius:
            lean = np.ones(len(index[0]), dtype=np.bool_)
            triangles = [cells(rows[k], rows[k + 1], lean ^ bool(k % 2)) for k in range(self.rings)]
        else:
            at = [np.arange(len(row)) / max(len(row) - 1, 1) for row in rows]
            triangles = [stitch(rows[k], rows[k + 1], at[k], at[k + 1]) for k in range(self.rings)]
        points = np.concatenate(circles)
        return Mesh(
            np.stack([points.real, points.imag, np.zeros(len(points))], axis=1),
            np.concatenate(triangles),
            node_sets={"centre": index[0], "rim": index[-1]},
            source=self,
        )

    def refined(self, density: float) -> Disc:
        """The disc with `density` times as many rings. Raises InputError as `Pattern.refined` does."""
        return replace(self, rings=multiplied(self, density, "rings", self.rings))

    def _circles_of_disc(self) -> list[Complexes]:
        """Nodes x + iy: those of a hexagon of `rings` triangles to a side, circle after circle, mapped."""
        turn = np.exp(1j * math.pi / 3.0 * np.arange(6))
        circles = [np.zeros(1, dtype=np.complex128)]
        for k in range(1, self.rings + 1):
            place = np.arange(k)  # along one side of the hexagon, from its corner at 1 to the next
            corner = np.where(2 * place > k, turn[1], 1.0)  # the nearer one
            side = (k + place * (turn[1] - 1.0)) / self.rings
            circle: Complexes = np.outer(turn, corner * _hexagon_to_disc(side / corner)).ravel()
            circles.append(self.radius * circle)
        circles[-1] *= self.radius / np.abs(circles[-1])
        return circles

    def _circles_of_ring(self) -> list[Complexes]:
        """Nodes x + iy: those of a strip of triangles, mapped by the exponential function."""
        count = round(self._around())
        angle = 2.0 * math.pi / count * np.arange(count)
        radii = np.geomspace(self.hub_radius, self.radius, self.rings + 1)
        return [r * np.exp(1j * (angle + math.pi / count * (k % 2))) for k, r in enumerate(radii.tolist())]

    def _around(self) -> float:
        """How many nodes on each circle of a ring would make its triangles equilateral."""
        if self.hub_radius == 0.0:
            return math.inf
        wide = math.log(self.radius) - math.log(self.hub_radius)
        return math.sqrt(3.0) * math.pi * self.rings / max(wide, 1e-15)


def _hexagon_to_disc(z: Complexes) -> Complexes:
    """(k,) points w of the unit disc, for points z of the hexagon with corners at the sixth roots of 1.

    The map of Schwarz and Christoffel leads from the disc to the hexagon. Integrated from w to the corner at
    1, to which no other corner may be nearer, it is

        c (1 - z) = int_w^1 (1 - t^6)^(-1/3) dt,    c = int_0^1 (1 - t^6)^(-1/3) dt = B(1/6, 2/3)/6

    With q = (1 - w)^(2/3) and t = 1 - q^(3/2) y^3 the singularity at the corner drops out,

        c (1 - z) = 3 q int_0^1 y g(1 - q^(3/2) y^3) dy,    g(t) = (1 + t + ... + t^5)^(-1/3)

    and Newton's method finds q.
    """
    y, weight = np.polynomial.legendre.leggauss(32)
    y, weight = 0.5 * (1.0 + y), 0.5 * weight
    c = math.gamma(1 / 6) * math.gamma(2 / 3) / math.gamma(5 / 6) / 6.0
    q = c * (1.0 - z)
    for _ in range(8):
        value = 3.0 * q * (_g(1.0 - (q**1.5)[:, None] * y**3) @ (y * weight))
        q = q - (value - c * (1.0 - z)) / (1.5 * _g(1.0 - q**1.5))
    w: Complexes = 1.0 - q**1.5
    return w


def _g(t: Complexes) -> Complexes:
    result: Complexes = (((((t + 1.0) * t + 1.0) * t + 1.0) * t + 1.0) * t + 1.0) ** (-1.0 / 3.0)
    return result
