"""What a folding pattern is: a few dimensions from which a mesh follows."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from typing_extensions import Self

from membrane_rs._arrays import Floats
from membrane_rs._given_arrays import numeric
from membrane_rs._validation import MOST, number_of, show
from membrane_rs.errors import InputError
from membrane_rs.mesh import Mesh


@runtime_checkable
class Pattern(Protocol):
    """Makes a flat mesh, its creases and its folded shape. A class that derives from it needs `mesh` alone.

    Examples
    --------
    >>> from membrane_rs.folding import PATTERNS, Pattern
    >>> isinstance(PATTERNS["strip"](length=0.1, width=0.01, columns=10), Pattern)
    True
    """

    def mesh(self) -> Mesh:
        """The mesh, whose `source` is this pattern.

        Returns
        -------
        Mesh
            Flat, with its stowed positions and creases.
        """

    def refined(self, density: float) -> Pattern:
        """The pattern with `density` times as many cells along each direction.

        Parameters
        ----------
        density : float
            Factor of the number of cells along each direction [-].

        Returns
        -------
        Pattern
            Of the same kind.

        Raises
        ------
        InputError
            A density that gives no whole number of cells, or a pattern whose cells cannot be counted so.
        """
        raise InputError(f"density = {density:g}: the pattern {type(self).__name__} cannot be made coarser or finer")

    def counts(self) -> dict[str, int] | None:
        """ "masses", "springs" and "elements" as the literature counts them; None: as the mesh has them.

        Returns
        -------
        dict of str to int, or None
            By name.
        """
        return None


@runtime_checkable
class RowPattern(Pattern, Protocol):
    """A pattern in rows of cells, from an inner to an outer edge, whose number can be chosen."""

    def with_rows(self, rows: int) -> Self:
        """The pattern with so many rows in all. Raises InputError for a number that it cannot have."""

    @property
    def row_height(self) -> float:
        """Height of a row in the flat mesh [m]."""


@runtime_checkable
class StowedPattern(Pattern, Protocol):
    """A pattern that describes its stowed shape in words, and knows where cords from the hub lie in it."""

    def facts(self) -> dict[str, str]:
        """What its stowed shape is, by name, each with its unit."""

    def cord_path(self, node: Floats) -> Floats | None:
        """(k, 2) points in plan [m] by which a stowed cord goes from the hub to the node that lies at `node` (3,) in
        the flat mesh, that node the last of them; None: straight.
        """

    @property
    def corner_turn(self) -> float:
        """Angle from the corners of the flat sail to those of the stowed one, with whole turns [rad]."""


def facts_of(mesh: Mesh | None) -> dict[str, str]:
    """What the pattern of a mesh says of its stowed shape."""
    pattern = pattern_of(mesh)
    return pattern.facts() if isinstance(pattern, StowedPattern) else {}


def cord_path(mesh: Mesh | None, node: int) -> Floats | None:
    """`StowedPattern.cord_path` of a node of a mesh; None without such a pattern."""
    pattern = pattern_of(mesh)
    if mesh is None or not isinstance(pattern, StowedPattern):
        return None
    return pattern.cord_path(mesh.reference[node])


def corner_turn(mesh: Mesh | None) -> float:
    """`StowedPattern.corner_turn` of a mesh; 0 without such a pattern."""
    pattern = pattern_of(mesh)
    return pattern.corner_turn if isinstance(pattern, StowedPattern) else 0.0


def pattern_of(mesh: Mesh | None) -> Pattern | None:
    """The pattern that made a mesh; None without one."""
    source = None if mesh is None else mesh.source
    return source if isinstance(source, Pattern) else None


def plan_of(pattern: Pattern, node: Floats) -> tuple[float, float]:
    """x and y of a place `node` (3,) in a flat mesh [m].

    Raises
    ------
    InputError, InputTypeError
        No three finite numbers.
    """
    where = f"{type(pattern).__name__}.cord_path: node"
    place = numeric(node, where, "fiu", "three numbers: x, y, z in the flat sail (m)")
    if place.shape != (3,) or not np.isfinite(place).all():
        raise InputError(
            f"{where} = {show(place.tolist())}: must be three finite numbers: x, y, z in the flat sail (m)"
        )
    return float(place[0]), float(place[1])


def multiplied(pattern: Pattern, density: float, name: str, count: int) -> int:
    """A count of a pattern's cells, called `name`, times `density`.

    Raises
    ------
    InputError
        It would be no whole number; the message says the nearest density that has one.
    """
    density = number_of("density", density, "relative")
    if not 0.0 < density <= MOST:
        raise InputError(f"density = {density:g}: must be greater than 0 and at most {MOST:g}")
    many = count * density
    if round(many) < 1 or abs(many - round(many)) > 1e-9 * many:
        raise InputError(
            f"density = {density:g}: {type(pattern).__name__}.{name} = {count} would become {many:g}, which is no "
            f"whole number; take {max(1, round(many)) / count:g}"
        )
    return round(many)
