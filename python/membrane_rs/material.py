"""What a membrane is made of."""

from __future__ import annotations

from dataclasses import field, replace
from typing import Annotated

from annotated_types import Ge, Gt, Le, Lt

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
    softening : float, optional
        f [-], from 1 to 1e6: the film is simulated with E/f against stretch, and with the buckling forces, crease
        moments and dashpots of E, so that an explicit step is about f^(1/2) times as long. None: as it is. By keyword
        alone; `Scene.as_simulated` has what it changes.

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
    softening: Annotated[Finite, Ge(1), Le(1e6)] | None = field(default=None, kw_only=True)

    @property
    def bending_stiffness(self) -> float:
        """D = E h^3 / (12 (1 - nu^2)), of a plate per width [N m]."""
        return self.youngs_modulus * self.thickness**3 / (12.0 * (1.0 - self.poisson_ratio**2))

    def as_simulated(self) -> Material:
        """The material with its softening carried out.

        Returns
        -------
        Material
            Of E/f, without softening; itself where it has none.

        Examples
        --------
        >>> from membrane_rs import Material
        >>> Material(3.2e9, 0.34, 1420.0, 7.5e-6, softening=10.0).as_simulated().youngs_modulus
        320000000.0
        """
        if self.softening is None:
            return self
        return replace(self, youngs_modulus=self.youngs_modulus / self.softening, softening=None)
