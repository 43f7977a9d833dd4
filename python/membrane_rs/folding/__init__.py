"""Folding patterns: each makes a flat mesh, its creases and its folded shape from a few dimensions.

A new pattern is one file, one line in `PATTERNS` (catalogue.py) and its place here: a validated dataclass that derives
from `Pattern`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from membrane_rs._on_demand import OnDemand

if TYPE_CHECKING:
    from membrane_rs.folding.catalogue import PATTERNS
    from membrane_rs.folding.disc import Disc
    from membrane_rs.folding.lattice import EquilateralLattice
    from membrane_rs.folding.miura import Miura
    from membrane_rs.folding.pattern import Pattern
    from membrane_rs.folding.spiral_hexagon import SpiralHexagon
    from membrane_rs.folding.square_sail import SquareSail
    from membrane_rs.folding.strip import Strip

__all__ = ["PATTERNS", "Disc", "EquilateralLattice", "Miura", "Pattern", "SpiralHexagon", "SquareSail", "Strip"]

if not TYPE_CHECKING:  # a type checker would take every name for one that is there
    _on_demand = OnDemand(
        __name__,
        {
            "membrane_rs.folding.catalogue": ("PATTERNS",),
            "membrane_rs.folding.disc": ("Disc",),
            "membrane_rs.folding.lattice": ("EquilateralLattice",),
            "membrane_rs.folding.miura": ("Miura",),
            "membrane_rs.folding.pattern": ("Pattern",),
            "membrane_rs.folding.spiral_hexagon": ("SpiralHexagon",),
            "membrane_rs.folding.square_sail": ("SquareSail",),
            "membrane_rs.folding.strip": ("Strip",),
        },
    )
    __getattr__, __dir__ = _on_demand, _on_demand.names
