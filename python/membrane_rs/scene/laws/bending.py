"""Bending stiffness of the film between its creases."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Annotated, ClassVar, Literal

from annotated_types import Ge, Le

from membrane_rs._validation import Finite, NonNegative, Unit, validated
from membrane_rs.scene.law import Law, StiffThrough, Surroundings


@validated
class Bending(Law):
    """Bending stiffness of the film, D = E h^3 / (12 (1 - nu^2)), between its creases.

    A film with bending stiffness resists the wrinkles that the mesh resolves, so that its buckling parameter is to be
    the plate's own, from 0 to 1: larger ones represent the same wrinkles a second time.

    Parameters
    ----------
    form : str
        "hinges": each edge of the film is a hinge, U = k phi^2 / 2, with phi its fold angle. They represent the plate
        on two lattices: equilateral triangles (k = 2 D/sqrt 3), and rectangles with alternating diagonals, such as
        those of `SquareSail` (k = 4 D/3 on squares). Their Poisson's ratio of bending is -1/3 whatever the film's.
        "curvature": the fold angles of its three edges give the curvature of a triangle, at the film's own Poisson's
        ratio; for general meshes. On rectangles with alternating diagonals it is too stiff in twist. `check` warns
        of a form that does not suit the mesh (docs/bending.md).
    stiffness : float
        Factor of D [-], 0 or above.
    fold_limit : float
        Edges whose fold angle at the start is larger have no bending stiffness [rad]: the film is folded there, not
        bent. 0 to pi. Edges of triangles of which all nodes are held, on both sides, have none either.
    collapse : float
        The fraction of a triangle's area below which its moments fade [-], from 0 (never) to 1, as in `Creases`.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import Bending
    >>> Bending(form="curvature").stiffness
    1.0
    """

    kind: ClassVar[str] = "bending"
    stiff_through: ClassVar[StiffThrough] = "law"
    form: Literal["hinges", "curvature"] = "hinges"
    stiffness: NonNegative = 1.0
    fold_limit: Annotated[Finite, Ge(0), Le(math.pi), Unit("rad")] = 2.0
    collapse: Annotated[Finite, Ge(0), Le(1)] = 0.05

    def why_idle(self, scene: Surroundings) -> str | None:
        """Without a film, or its stiffness, there is no moment."""
        if scene.mesh is None:
            return "the scene has no membrane"
        return "its stiffness is 0" if self.stiffness == 0 else None

    def step_advice(self, gain: float) -> str:
        """A smaller stiffness."""
        return f"a stiffness {gain**2:.3g} times smaller would take it out of the limit"

    def for_modulus(self, factor: float) -> Bending:
        """D is proportional to E."""
        return replace(self, stiffness=self.stiffness / factor)
