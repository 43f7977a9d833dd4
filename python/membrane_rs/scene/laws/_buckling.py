"""Critical strains of the edges of a film, eq. (2), as the core computes them (`rust/core/src/laws/buckling.rs`)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.material import Material
from membrane_rs.mesh import Mesh
from membrane_rs.scene.law import Law, StiffThrough, Surroundings

F = TypeVar("F", bound="BucklingFilm")


class BucklingFilm(Law):
    """A law of the film whose edges buckle: alpha, alpha_c, and the lengths in their critical strain [m]."""

    is_film: ClassVar[bool] = True
    length_fields: ClassVar[Mapping[str, str]] = {"buckling": "buckling_length", "crease": "crease_length"}
    if TYPE_CHECKING:  # fields, in the order of each law, are those of its own class
        buckling: float
        buckling_on_creases: float
        buckling_length: float | None
        crease_length: float | None

    def with_softened_film(self: F, factor: float) -> F:
        """k (L - l_cr), the force beyond buckling, is proportional to E alpha."""
        return _with(self, buckling=factor * self.buckling, buckling_on_creases=factor * self.buckling_on_creases)

    def with_buckling(self: F, buckling: float) -> F:
        """One parameter for all edges."""
        return _with(self, buckling=buckling, buckling_on_creases=buckling)

    def critical_strains(self, mesh: Mesh, material: Material) -> Floats:
        """Those at which creases buckle; edges, where there are no creases."""
        return _critical_strains(self, mesh, material.thickness)


class FilmOfSprings(BucklingFilm):
    """A law of the film whose edges are springs."""

    stiff_through: ClassVar[StiffThrough] = "film"
    if TYPE_CHECKING:
        strain_limit: float

    @property
    def edge_strain_limit(self) -> float:
        """Every edge is a spring."""
        return self.strain_limit

    def why_idle(self, scene: Surroundings) -> str | None:
        """Without a membrane there is no spring."""
        return "the scene has no membrane" if scene.mesh is None else None

    def step_advice(self, gain: float) -> str:
        """A coarser mesh."""
        return "a coarser mesh of the membrane has a longer step in proportion to its springs"


def _with(law: F, **values: float) -> F:
    """The law with other values of its fields."""
    changed: Any = law
    made: F = replace(changed, **values)
    return made


def _critical_strains(law: BucklingFilm, mesh: Mesh, thickness: float) -> Floats:
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
