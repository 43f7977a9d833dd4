"""Critical strains of the edges of a film, eq. (2), as the core computes them (`rust/core/src/laws/buckling.rs`)."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.mesh import Mesh


class BucklingFilm(Protocol):
    """A law of the film whose edges buckle."""

    @property
    def buckling(self) -> float:
        """alpha [-]."""

    @property
    def buckling_on_creases(self) -> float:
        """alpha_c [-]."""

    @property
    def buckling_length(self) -> float | None:
        """In place of the length of each edge [m]."""

    @property
    def crease_length(self) -> float | None:
        """Of a crease with a force of its own [m]."""


def critical_strains(law: BucklingFilm, mesh: Mesh, thickness: float) -> Floats:
    """(c,) alpha pi^2 h^2/(12 L^2) [-] of each crease; (e,) of each edge where there are no creases.

    With `crease_length` l_c a crease adds (alpha_c - alpha) pi^2 h^2/(12 l_c L) to the strain of the film.
    """
    edges = mesh.creases if len(mesh.creases) else mesh.edges
    ends = mesh.reference[edges]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    square = math.pi**2 * thickness**2 / 12.0
    least = np.full_like(lengths, law.buckling_length) if law.buckling_length is not None else lengths
    found: Floats = square / (least * least)
    if not len(mesh.creases):
        return law.buckling * found
    if law.crease_length is None:
        return law.buckling_on_creases * found
    own = (law.buckling_on_creases - law.buckling) * square / (law.crease_length * lengths)
    both: Floats = np.maximum(law.buckling * found + own, 0.0)
    return both
