"""What sails have in common that are folded in strips, each of some rows of cells."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Protocol, TypeVar

from membrane_rs.folding.pattern import StowedPattern, multiplied

S = TypeVar("S", bound="Strips")


class Strips(Protocol):
    """What such a sail has of its own."""

    @property
    def strips(self) -> int:
        """Strips from the inner to the outer edge."""

    @property
    def rows_per_strip(self) -> int:
        """Rows of cells in each."""

    @property
    def strip_height(self) -> float:
        """Height of each in the flat sail [m]."""

    @property
    def columns(self) -> int | None:
        """Cells along the inner edge; None: as many as fit."""


class StripSail(StowedPattern, Protocol):
    """A sail in strips, whose rows and columns can be chosen."""

    @property
    def row_height(self: Strips) -> float:
        """Height of a row of cells in the flat sail [m]."""
        return self.strip_height / self.rows_per_strip

    def refined(self: S, density: float) -> S:
        """The sail with `density` times as many rows and columns. Raises InputError as `Pattern.refined` does."""
        sail: Any = self
        rows = self.strips * multiplied(sail, density, "rows_per_strip", self.rows_per_strip)
        columns = None if self.columns is None else multiplied(sail, density, "columns", self.columns)
        made: S = replace(sail, rows=rows, columns=columns)
        return made

    def with_rows(self: S, rows: int) -> S:
        """The sail with so many rows of cells in each petal.

        Parameters
        ----------
        rows : int
            From the inner to the outer edge.

        Returns
        -------
        SquareSail or SpiralHexagon
            Of the same kind, with the same dimensions.

        Raises
        ------
        MeshError
            No multiple of the number of strips.
        """
        sail: Any = self
        made: S = replace(sail, rows=rows)
        return made
