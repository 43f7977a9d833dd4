"""A flat patch of equilateral triangles: the mesh on which springs model a film exactly, at nu = 1/3."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Annotated

import numpy as np

from membrane_rs._bounds import check_nodes
from membrane_rs._validation import Count, Positive, Unit, validated
from membrane_rs.errors import MeshError
from membrane_rs.folding._rows import grid_cells
from membrane_rs.folding.pattern import Pattern, multiplied
from membrane_rs.mesh import Mesh


@validated
class EquilateralLattice(Pattern):
    """Rows of equilateral triangles at z = 0, every other row half a side further along y.

    Node sets: "start" and "end" (first and last row), "inside" (nodes with six neighbours).

    Parameters
    ----------
    side : float
        Side of the triangles [m].
    columns : int
        Triangle sides along y in each row of nodes.
    rows : int
        Rows of triangles along x, each side * sqrt(3)/2 wide.

    Raises
    ------
    MeshError
        More nodes than fit.
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs.folding import EquilateralLattice
    >>> mesh = EquilateralLattice(side=0.01, columns=10, rows=8).mesh()
    >>> float(mesh.flatness().min().round(3))
    0.866
    """

    side: Annotated[Positive, Unit("m")]
    columns: Count
    rows: Count

    def __post_init__(self) -> None:
        """Check the size."""
        where = f"EquilateralLattice: columns = {self.columns}, rows = {self.rows}"
        check_nodes((self.columns + 1.0) * (self.rows + 1.0), where, "take fewer", MeshError)

    def mesh(self) -> Mesh:
        """The flat patch."""
        index = np.arange((self.rows + 1) * (self.columns + 1)).reshape(self.rows + 1, -1)
        row, column = np.divmod(index.ravel(), self.columns + 1)
        x = self.side * math.sqrt(0.75) * row
        y = self.side * (column + 0.5 * (row % 2))
        lean = np.broadcast_to((np.arange(self.rows) % 2 == 0)[:, None], (self.rows, self.columns))
        triangles = grid_cells(index, lean)
        sets = {"start": index[0], "end": index[-1], "inside": index[1:-1, 1:-1].ravel()}
        return Mesh(np.stack([x, y, np.zeros_like(x)], axis=1), triangles, node_sets=sets, source=self)

    def refined(self, density: float) -> EquilateralLattice:
        """The patch with triangles of 1/`density` of the side. Raises InputError as `Pattern.refined` does."""
        columns = multiplied(self, density, "columns", self.columns)
        rows = multiplied(self, density, "rows", self.rows)
        return replace(self, side=self.side / density, columns=columns, rows=rows)
