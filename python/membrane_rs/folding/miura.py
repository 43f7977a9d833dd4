"""Miura's fold: a sheet of parallelograms that folds along both its directions at once, with rigid facets.

Formulas and the angle that they depend on are those of Schenk and Guest, Geometry of Miura-folded metamaterials,
PNAS 110 (2013), 3276-3281.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Annotated

import numpy as np
from annotated_types import Ge, Gt, Le, Lt

from membrane_rs._arrays import Floats, Ints
from membrane_rs._bounds import check_nodes
from membrane_rs._validation import MOST, Count, Finite, Positive, Unit, validated
from membrane_rs.errors import MeshError
from membrane_rs.folding._rows import grid_cells
from membrane_rs.folding.pattern import Pattern, multiplied
from membrane_rs.mesh import Mesh


@validated
class Miura(Pattern):
    """Columns of parallelograms along x, rows along y, folded by a tilt; flat, at z = 0, about the origin.

    Straight creases run along y, zigzag creases along x. All facets are flat and without strain at any tilt, and the
    film between the creases is divided without further creases. Mountains and valleys: all creases of a zigzag line
    are alike, and alternate from line to line; those of a straight line alternate along it and from line to line. At
    tilt 0 the fold angles are pi and -pi, which mark the side to which the flat creases fold.

    Node sets: "start" and "end" (least and greatest x), "right" and "left" (least and greatest y), and their corners,
    each alone, "start-right", "start-left", "end-right" and "end-left".

    Parameters
    ----------
    straight_side, zigzag_side : float
        Sides of the parallelograms, on the straight and on the zigzag creases [m]; a and b below.
    tilt : float
        Angle t of the facets to the plane of the sheet [rad], from 0 (flat) to pi/2 (all facets on each other). The
        fold angle of zigzag creases is 2 t; that of straight ones is 2 atan(cos g tan t).
    columns, rows : int
        Parallelograms along x and along y.
    angle : float
        Acute angle g of the parallelograms [rad], between 0 and pi/2. Default: 60 degrees.
    divisions : int
        Cells on the shorter sides of each parallelogram, of two triangles each, whose sides are as equal as whole
        numbers of cells allow: with sides in a whole ratio and g = 60 degrees, equilateral triangles.

    Raises
    ------
    MeshError
        More nodes than fit.
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> import math
    >>> from membrane_rs.folding import Miura
    >>> sheet = Miura(straight_side=0.02, zigzag_side=0.02, tilt=math.pi / 4, columns=6, rows=4)
    >>> round(1e3 * sheet.height, 3), round(sheet.packing, 3), round(sheet.poisson_ratio, 3)
    (12.247, 0.707, -1.5)
    >>> mesh = sheet.mesh()
    >>> mesh.node_count, len(mesh.creases), bool(abs(mesh.strain()).max() < 1e-12)
    (35, 38, True)
    """

    straight_side: Annotated[Positive, Unit("m")]
    zigzag_side: Annotated[Positive, Unit("m")]
    tilt: Annotated[Finite, Ge(0), Le(math.pi / 2), Unit("rad")]
    columns: Count
    rows: Count
    angle: Annotated[Finite, Gt(0), Lt(math.pi / 2), Unit("rad")] = math.pi / 3
    divisions: Count = 1

    def __post_init__(self) -> None:
        """Check the size."""
        along, across = self._cells()
        where = f"Miura: columns = {self.columns}, rows = {self.rows}, divisions = {self.divisions}"
        check_nodes((self.columns * along + 1.0) * (self.rows * across + 1.0), where, "take fewer", MeshError)

    @property
    def height(self) -> float:
        """Height of the folded sheet, a sin t sin g [m]."""
        return self.straight_side * math.sin(self.tilt) * math.sin(self.angle)

    @property
    def cell_length(self) -> float:
        """Length along x of two columns, the cell by which the folded sheet repeats [m].

        2 b cos t tan g / sqrt(1 + cos^2 t tan^2 g).
        """
        return 2.0 * self.zigzag_side * math.cos(self.tilt) * math.sin(self.angle) / self._slant()

    @property
    def cell_width(self) -> float:
        """Width along y of two rows, the cell by which the folded sheet repeats [m].

        2 a sqrt(1 - sin^2 t sin^2 g).
        """
        return 2.0 * self.straight_side * self._slant()

    @property
    def packing(self) -> float:
        """Area of a folded cell in plan over that of its four parallelograms [-]: 1 flat, 0 at a tilt of pi/2."""
        sides = self.straight_side * self.zigzag_side
        return self.cell_length * self.cell_width / (4.0 * sides * math.sin(self.angle))

    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio of the sheet as it folds, -cos^2 t tan^2 g [-].

        Minus the relative change of `cell_width` over that of `cell_length`: below zero, both shrink together.
        """
        return -((math.cos(self.tilt) * math.tan(self.angle)) ** 2)

    @property
    def zigzag_fold_angle(self) -> float:
        """Size of the fold angle of zigzag creases, 2 t [rad]."""
        return 2.0 * self.tilt

    @property
    def straight_fold_angle(self) -> float:
        """Size of the fold angle of straight creases, 2 atan(cos g tan t) [rad]."""
        return 2.0 * math.atan2(math.cos(self.angle) * math.sin(self.tilt), math.cos(self.tilt))

    def mesh(self) -> Mesh:
        """The flat sheet; its positions are folded by the tilt."""
        along, across = self._cells()
        index = np.arange((self.columns * along + 1) * (self.rows * across + 1)).reshape(-1, self.rows * across + 1)
        column, row = np.arange(self.columns * along) // along, np.arange(self.rows * across) // across
        # The shorter diagonals: even columns rise with x.
        triangles = grid_cells(index, np.broadcast_to((column % 2 == 0)[:, None], (len(column), len(row))))

        zigzag, straight = index.T[across:-1:across], index[along:-1:along]
        # Seen from +z, zigzag lines 1, 3 ... are ridges; straight creases are mountains and valleys in turn both ways.
        zigzag_sides = np.broadcast_to(_signs(np.arange(1, self.rows))[:, None], (len(zigzag), len(column)))
        straight_sides = -_signs(np.add.outer(np.arange(1, self.columns), row))
        is_flat = self.tilt == 0.0
        zigzag_angles = (math.pi if is_flat else self.zigzag_fold_angle) * zigzag_sides
        straight_angles = (math.pi if is_flat else self.straight_fold_angle) * straight_sides

        sets = {"start": index[0], "end": index[-1], "right": index[:, 0], "left": index[:, -1]}
        for end in ("start", "end"):
            sets |= {f"{end}-right": sets[end][:1], f"{end}-left": sets[end][-1:]}
        return Mesh(
            replace(self, tilt=0.0)._points(),
            triangles,
            positions=self._points(),
            creases=np.concatenate([_pairs(zigzag), _pairs(straight)]),
            fold_angles=np.concatenate([zigzag_angles.ravel(), straight_angles.ravel()]),
            node_sets=sets,
            source=self,
        )

    def refined(self, density: float) -> Miura:
        """The same sheet with `density` times as many divisions. Raises InputError as `Pattern.refined` does."""
        return replace(self, divisions=multiplied(self, density, "divisions", self.divisions))

    def _cells(self) -> tuple[int, int]:
        """Cells on the zigzag and on the straight side of each parallelogram."""
        shorter, longer = sorted((self.straight_side, self.zigzag_side))
        many = self.divisions * round(min(longer / shorter, MOST))
        return (many, self.divisions) if self.zigzag_side > self.straight_side else (self.divisions, many)

    def _slant(self) -> float:
        """sqrt(1 - sin^2 t sin^2 g) = cos g sqrt(1 + cos^2 t tan^2 g), without their differences [-]."""
        return math.hypot(math.cos(self.angle), math.cos(self.tilt) * math.sin(self.angle))

    def _points(self) -> Floats:
        """(n, 3) nodes at the tilt, about the origin, those of one x after the other."""
        along, across = self._cells()
        i, j = np.arange(self.columns * along + 1), np.arange(self.rows * across + 1)
        shift = self.zigzag_side * math.cos(self.angle) / self._slant()
        x = 0.5 * self.cell_length * (i / along - 0.5 * self.columns)
        y = 0.5 * self.cell_width * (j / across - 0.5 * self.rows)
        z = self.height * (_zigzag(j, across) - 0.5)
        y_of_column = shift * (_zigzag(i, along) - 0.5)
        points = np.broadcast_arrays(x[:, None], np.add.outer(y_of_column, y), z)
        return np.stack(points, axis=-1).reshape(-1, 3)


def _signs(numbers: Ints) -> Ints:
    """1 for even numbers, -1 for odd ones."""
    return 1 - 2 * (numbers % 2)


def _zigzag(numbers: Ints, period: int) -> Floats:
    """A line that rises from 0 to 1 within `period` numbers, falls within the next, and so on."""
    phase = numbers % (2 * period)
    line: Floats = np.minimum(phase, 2 * period - phase) / period
    return line


def _pairs(lines: Ints) -> Ints:
    """(k, 2) neighbours along each of some lines of nodes."""
    return np.stack([lines[:, :-1], lines[:, 1:]], axis=-1).reshape(-1, 2)
