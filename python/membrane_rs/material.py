"""What a membrane is made of."""

from __future__ import annotations

from typing import Annotated

from annotated_types import Gt, Lt

from membrane_rs._validation import Finite, Positive, Unit, validated


@validated
class Material:
    """A thin isotropic film.

    Parameters
    ----------
    youngs_modulus : float
        E [Pa], above 0.
    poisson_ratio : float
        nu, between -1 and 0.5, both excluded.
    density : float
        rho [kg/m3], above 0.
    thickness : float
        h [m], above 0.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or no number.
    """

    youngs_modulus: Annotated[Positive, Unit("Pa")]
    poisson_ratio: Annotated[Finite, Gt(-1), Lt(0.5)]
    density: Annotated[Positive, Unit("kg/m3")]
    thickness: Annotated[Positive, Unit("m")]
