"""Creases, and the contact of their facets."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import field, replace
from typing import Annotated, ClassVar

from annotated_types import Ge, Le

from membrane_rs._validation import Finite, Fraction, NonNegative, Positive, Unit, validated
from membrane_rs.errors import InputError
from membrane_rs.scene.law import Law, StiffThrough, Surroundings


@validated
class Creases(Law):
    """Creases that turn towards a natural angle, and that resist folding through themselves.

    With theta the crease angle (pi flat, 0 shut, below 0 interpenetrating) and kappa = beta E J L / H:

        U = w_C w_D [ kappa (theta - theta0)^2 / 2 + (gamma - 1) kappa min(theta, 0)^2 / 2 ]

    w = (1 + collapse^2) A^2 / (A^2 + (collapse A0)^2) for each of its two facets, A its current area, A0 its reference
    area, where w = 1: it takes away the singular force of a facet that has collapsed to a line.

    Parameters
    ----------
    stiffness : float
        beta [-], 0 or above.
    contact_penalty : float
        gamma [-], how many times stiffer the crease is below 0; 1 or above, 1 meaning no contact.
    natural_angle : float
        theta0 [rad], from 0 (shut) over pi (flat) to 2 pi. A part `CreaseSet` may give creases their own stiffness,
        penalty and angle.
    length_scale : float or None
        H [m]. None: the mean height of the two facets in the reference mesh, crease by crease.
    collapse : float
        The fraction of a facet's area below which its moment fades [-], from 0 (never) to 1.
    fold_fraction : float or None
        In place of natural_angle: theta0 = pi - fold_fraction phi, with phi the magnitude of the fold angle that the
        mesh has for each crease, `Mesh.fold_angles` [-]; from 0 (flat) to 1 (folded as in the pattern). By keyword
        alone.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type; a natural_angle beside a fold_fraction.

    Examples
    --------
    >>> from membrane_rs import Creases
    >>> Creases(stiffness=20.0).collapse
    0.05
    """

    kind: ClassVar[str] = "creases"
    stiff_through: ClassVar[StiffThrough] = "law"
    length_fields: ClassVar[Mapping[str, str]] = {"facet": "length_scale"}
    stiffness: NonNegative = 10.0
    contact_penalty: Annotated[Finite, Ge(1)] = 100.0
    natural_angle: Annotated[Finite, Ge(0), Le(2 * math.pi), Unit("rad")] = 0.0
    length_scale: Annotated[Positive | None, Unit("m")] = None
    collapse: Annotated[Finite, Ge(0), Le(1)] = 0.05
    fold_fraction: Fraction | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        """Check that the natural state is given once."""
        if self.fold_fraction is not None and self.natural_angle != 0.0:
            what = "is not used with fold_fraction, by which each crease has its own; leave one of them out"
            raise InputError(f"Creases.natural_angle = {self.natural_angle:g}: {what} (rad)")

    def replaced_by(self, name: str) -> tuple[str, ...]:
        """One natural angle by a fraction of each fold, and the other way round."""
        return {"fold_fraction": ("natural_angle",), "natural_angle": ("fold_fraction",)}.get(name, ())

    def why_idle(self, scene: Surroundings) -> str | None:
        """Without creases, or their stiffness, there is no moment."""
        if len(scene.assemble().creases) == 0:
            return "the mesh has no creases"
        return "its stiffness is 0, and contact is a multiple of that" if self.stiffness == 0 else None

    def step_advice(self, gain: float) -> str:
        """A smaller penalty or stiffness."""
        return f"contact_penalty or stiffness {gain**2:.3g} times smaller would take it out of the limit"

    def for_modulus(self, factor: float) -> Creases:
        """kappa is proportional to E."""
        return replace(self, stiffness=self.stiffness / factor)
