"""A flat rectangular strip, with or without creases across it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Annotated

import numpy as np
from annotated_types import Ge, Gt, Le, Lt
from pydantic import BeforeValidator

from membrane_rs._arrays import Floats
from membrane_rs._bounds import check_nodes
from membrane_rs._validation import Count, Finite, Positive, Unit, numbers, validated
from membrane_rs.errors import MeshError
from membrane_rs.folding._rows import grid_cells
from membrane_rs.folding.pattern import Pattern, multiplied
from membrane_rs.mesh import Mesh

Inside = Annotated[Finite, Gt(0), Lt(1)]


@validated
class Strip(Pattern):
    """A strip along x from the origin, its width along y from -width/2 to width/2, flat at z = 0.

    Node sets: "start" (x = 0), "end" (x = length), and "crease-0", "crease-1" ...

    Parameters
    ----------
    length, width : float
        Size [m].
    columns, rows : int
        Cells along the length and across the width; two triangles each, diagonals alternating.
    creases : sequence of float
        Where creases lie, as fractions of the length [-]; each must fall on a line between columns.
    fold_angle : float
        Fold angle of the first crease in the folded strip [rad], between -pi and pi, valley positive; the
        next ones have it in turn with the opposite sign. Faces stay flat.

    Raises
    ------
    MeshError
        A crease that falls inside a column, or twice in one place; more nodes than fit.
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs.folding import Strip
    >>> mesh = Strip(length=0.1, width=0.02, columns=10, creases=[0.5], fold_angle=1.0).mesh()
    >>> sorted(mesh.node_sets), mesh.fold_angles.tolist()
    (['crease-0', 'end', 'start'], [1.0])
    """

    length: Annotated[Positive, Unit("m")]
    width: Annotated[Positive, Unit("m")]
    columns: Count
    rows: Count = 1
    creases: Annotated[tuple[Inside, ...], BeforeValidator(numbers)] = ()
    fold_angle: Annotated[Finite, Ge(-math.pi), Le(math.pi), Unit("rad")] = 0.0

    def __post_init__(self) -> None:
        """Check the size, and that creases lie between columns."""
        where = f"Strip: columns = {self.columns}, rows = {self.rows}"
        check_nodes((self.columns + 1.0) * (self.rows + 1.0), where, "take fewer", MeshError)
        for fraction in self.creases:
            line = round(fraction * self.columns)
            if not 0 < line < self.columns or abs(line - fraction * self.columns) > 1e-6:
                raise MeshError(
                    f"Strip.creases: {fraction:g} falls inside one of {self.columns} columns; "
                    f"take a multiple of 1/{self.columns}, or other columns"
                )
        if len(set(self._lines())) < len(self.creases):
            raise MeshError(f"Strip.creases = {self.creases}: two lie in one place; give each once")

    def mesh(self) -> Mesh:
        """The flat strip; its positions are folded about the creases."""
        lines = np.array(self._lines(), dtype=np.int64)
        x = np.linspace(0.0, self.length, self.columns + 1)
        y = self.width * (np.arange(self.rows + 1) / self.rows - 0.5)
        index = np.arange((self.columns + 1) * (self.rows + 1)).reshape(self.columns + 1, -1)
        triangles = grid_cells(index, np.add.outer(np.arange(self.columns), np.arange(self.rows)) % 2 == 1)

        angles = self.fold_angle * (-1.0) ** np.arange(len(lines))
        turn = np.zeros(self.columns)
        turn[lines] = angles
        heading = np.cumsum(turn)
        step = self.length / self.columns
        folded_x = np.concatenate([[0.0], np.cumsum(step * np.cos(heading))])
        folded_z = np.concatenate([[0.0], np.cumsum(step * np.sin(heading))])

        pairs = [np.stack([index[i, :-1], index[i, 1:]], axis=1) for i in lines]
        sets = {"start": index[0], "end": index[-1]}
        return Mesh(
            _sheet(x, y, np.zeros_like(x)),
            triangles,
            positions=_sheet(folded_x, y, folded_z),
            creases=np.concatenate([*pairs, np.empty((0, 2), dtype=np.int64)]),
            fold_angles=np.repeat(angles, self.rows),
            node_sets=sets | {f"crease-{k}": index[i] for k, i in enumerate(lines)},
            source=self,
        )

    def refined(self, density: float) -> Strip:
        """The strip with `density` times as many columns and rows. Raises InputError as `Pattern.refined` does."""
        columns = multiplied(self, density, "columns", self.columns)
        return replace(self, columns=columns, rows=multiplied(self, density, "rows", self.rows))

    def _lines(self) -> list[int]:
        return sorted(round(fraction * self.columns) for fraction in self.creases)


def _sheet(x: Floats, y: Floats, z: Floats) -> Floats:
    """(len(x) len(y), 3) points: y runs fastest, z goes with x."""
    return np.stack([np.repeat(x, len(y)), np.tile(y, len(x)), np.repeat(z, len(y))], axis=1)
