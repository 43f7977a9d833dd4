"""The film as triangles of uniform strain."""

from __future__ import annotations

from typing import Annotated, ClassVar

from annotated_types import Ge, Le

from membrane_rs._validation import Finite, NonNegative, Positive, Unit, validated
from membrane_rs.scene.laws._buckling import BucklingFilm


@validated
class Triangles(BucklingFilm):
    """The film as triangles of uniform strain, which wrinkle; a scene takes it in place of `Springs`.

    St. Venant and Kirchhoff's law in plane stress, with Green's strain: isotropic at any Poisson's ratio, on any
    mesh. Under uniaxial compression the stress falls no lower than -E eps_c, with eps_c the critical strain of eq.
    (2), alpha pi^2 h^2 / (12 L^2), mean over the triangle's sides: the film then wrinkles. With alpha = 0 it bears
    tension only. The forces have a potential, with wrinkles too.

    Parameters
    ----------
    compression : float
        Share of the stiffness that is left in compression [-], from 0 (a film) to 1 (it never buckles).
    buckling : float
        alpha [-] of sides that are no creases, 0 or above.
    buckling_on_creases : float
        alpha [-] along creases, 0 or above. A wrinkle that crosses a crease must buckle it, so that a value above
        `buckling` stiffens the film beside a crease in shear too, far more than springs do. The default is the value
        calibrated to the springs of the paper's model 1, on the paper's mesh, rounded (docs/mesh_parameters.md).
    buckling_length : float or None
        Length in place of L in the critical strain [m]: the same on every mesh. None: each side's own.
    crease_length : float or None
        Length [m] that makes a crease a line with a buckling force of its own, as in `Springs`.
    strain_limit : float
        A run stops when a triangle is stretched beyond this strain in any direction [-].

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import Triangles
    >>> Triangles(compression=0.0).compression
    0.0
    """

    kind: ClassVar[str] = "triangles"
    compression: Annotated[Finite, Ge(0), Le(1)] = 0.0
    buckling: NonNegative = 100.0
    buckling_on_creases: NonNegative = 20.0
    buckling_length: Annotated[Positive | None, Unit("m")] = None
    crease_length: Annotated[Positive | None, Unit("m")] = None
    strain_limit: Positive = 0.1

    @property
    def negative_springs(self) -> str:
        """Nothing uses the constants of springs, so none need be refused."""
        return "unused"
