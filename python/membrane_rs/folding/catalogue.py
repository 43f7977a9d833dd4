"""The one list of folding patterns."""

from __future__ import annotations

from membrane_rs.folding.disc import Disc
from membrane_rs.folding.lattice import EquilateralLattice
from membrane_rs.folding.miura import Miura
from membrane_rs.folding.pattern import Pattern
from membrane_rs.folding.spiral_hexagon import SpiralHexagon
from membrane_rs.folding.square_sail import SquareSail
from membrane_rs.folding.strip import Strip

PATTERNS: dict[str, type[Pattern]] = {
    "square-sail": SquareSail,
    "disc": Disc,
    "strip": Strip,
    "lattice": EquilateralLattice,
    "miura": Miura,
    "spiral-hexagon": SpiralHexagon,
}
"""Every pattern, by the name that scene files use."""
