"""Folding patterns: each makes a flat mesh, its creases and its folded shape from a few dimensions.

A new pattern is one file and one line in `PATTERNS`: a validated dataclass that derives from `Pattern`.
"""

from __future__ import annotations

from membrane_rs.folding.disc import Disc
from membrane_rs.folding.lattice import EquilateralLattice
from membrane_rs.folding.pattern import Pattern
from membrane_rs.folding.square_sail import SquareSail
from membrane_rs.folding.strip import Strip

PATTERNS: dict[str, type[Pattern]] = {
    "square-sail": SquareSail,
    "disc": Disc,
    "strip": Strip,
    "lattice": EquilateralLattice,
}
"""Every pattern, by the name that scene files use."""

__all__ = ["PATTERNS", "Disc", "EquilateralLattice", "Pattern", "SquareSail", "Strip"]
