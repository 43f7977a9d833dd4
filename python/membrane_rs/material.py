"""What a membrane is made of."""

from __future__ import annotations

from dataclasses import field, replace
from typing import Annotated, Any

from annotated_types import Ge, Gt, Le, Lt

from membrane_rs._validation import Finite, Positive, Unit, validated
from membrane_rs.errors import InputError


@validated
class Material:
    """A thin film, isotropic, or of two moduli as one of fibres.

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
    youngs_modulus_across : float, optional
        E_2 [Pa] of a film of two moduli, across `direction`; youngs_modulus is then E_1, along it, and poisson_ratio
        the contraction across of a stretch along it. For the law `Triangles` with compression = 1 and the form
        "curvature" of `Bending`. By keyword alone, as all that follow.
    shear_modulus : float, optional
        G [Pa] of it; both are given together.
    direction : float, optional
        Of E_1 in the flat shape, from the x axis on [rad]. None: along x.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or no number; one of two moduli alone, nu^2 E_2/E_1 of 1 or more.

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
    youngs_modulus_across: Annotated[Positive | None, Unit("Pa")] = field(default=None, kw_only=True)
    shear_modulus: Annotated[Positive | None, Unit("Pa")] = field(default=None, kw_only=True)
    direction: Annotated[Finite | None, Unit("rad")] = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        """Check the moduli of a film of two against each other."""
        across, shear = self.youngs_modulus_across, self.shear_modulus
        if (across is None) != (shear is None):
            given, missing = ("shear_modulus", "youngs_modulus_across")
            if shear is None:
                given, missing = missing, given
            what = f"needs {missing} beside it; give both or none"
            raise InputError(f"Material.{given} = {getattr(self, given):g}: {what} (Pa)")
        if across is None:
            if self.direction is not None:
                what = "is that of a film of two moduli; give youngs_modulus_across and shear_modulus, or leave it out"
                raise InputError(f"Material.direction = {self.direction:g}: {what} (rad)")
        elif self.poisson_ratio**2 * across >= self.youngs_modulus:
            most = self.youngs_modulus / self.poisson_ratio**2
            what = f"must be below youngs_modulus/poisson_ratio^2 = {most:g}, where the film is stable"
            raise InputError(f"Material.youngs_modulus_across = {across:g}: {what} (Pa)")

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
        names = ("youngs_modulus", "youngs_modulus_across", "shear_modulus")
        soft: dict[str, Any] = {name: getattr(self, name) / self.softening for name in names if getattr(self, name)}
        return replace(self, **soft, softening=None)
