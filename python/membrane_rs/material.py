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
        nu [-], between -1 and 0.5, both excluded.
    density : float
        rho [kg/m3], above 0.
    thickness : float
        h [m], above 0.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or no number.

    Examples
    --------
    >>> from membrane_rs import Material
    >>> film = Material(youngs_modulus=3.2e9, poisson_ratio=0.34, density=1420.0, thickness=7.5e-6)
    >>> film.thickness
    7.5e-06
    >>> Material(3.2e9, 0.34, 1420.0, -7.5e-6)
    Traceback (most recent call last):
    membrane_rs.errors.InputError: Material.thickness = -7.5e-06: must be greater than 0 (m)
    """

    youngs_modulus: Annotated[Positive, Unit("Pa")]
    poisson_ratio: Annotated[Finite, Gt(-1), Lt(0.5)]
    density: Annotated[Positive, Unit("kg/m3")]
    thickness: Annotated[Positive, Unit("m")]
