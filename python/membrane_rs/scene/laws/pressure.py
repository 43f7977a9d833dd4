"""Uniform pressure on the film."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field
from typing import Annotated, ClassVar

from membrane_rs._validation import Finite, Unit, validated
from membrane_rs.analysis.extent import span
from membrane_rs.scene.law import Law, Surroundings
from membrane_rs.scene.laws._factor import largest_factor
from membrane_rs.scene.plausible import FILM, STRETCHED, Doubt, implausible
from membrane_rs.scene.schedule import Schedule


@validated
class Pressure(Law):
    """Uniform pressure on the film, a follower load: F = p/6 (x1 - x0) x (x2 - x0) on each node of a triangle.

    It acts towards the side of each triangle's normal, from which its nodes are seen counter-clockwise. Its work is
    external; on a closed surface it leaves no force and no torque on the whole.

    Parameters
    ----------
    pressure : float
        p [Pa], the difference of the two sides' pressures; below zero it acts against the normal.
    factor : Schedule or None
        By which p is multiplied, as a function of time [-]. None: 1. By keyword alone.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import Pressure
    >>> from membrane_rs import Schedule
    >>> Pressure(2.0).pressure
    2.0
    >>> Pressure(2.0, factor=Schedule([0.0, 0.5], [0.0, 1.0])).factor.at(0.25)
    0.5
    """

    kind: ClassVar[str] = "pressure"
    exerts_outside_torque: ClassVar[bool] = True
    pressure: Annotated[Finite, Unit("Pa")]
    factor: Schedule | None = field(default=None, kw_only=True)

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """A film of width w that is held at its edge is stretched by 0.3 (p w / (E h))^(2/3) (Hencky): by less than
        `STRETCHED`, or than the strain at which the scene stops.
        """
        if scene.mesh is None or scene.material is None:
            return
        width, limits = span(scene.mesh.reference), (law.edge_strain_limit for law in scene.laws)
        strain = max(STRETCHED, *(limit for limit in limits if limit is not None), 0.0)
        most = (strain / 0.3) ** 1.5 * scene.material.youngs_modulus * scene.material.thickness / width
        reason = f"it would stretch the film, {width:.4g} m wide, by more than {100 * strain:g} %"
        units = {"mPa": 1e-3, "uPa": 1e-6}
        size = abs(self.pressure) * largest_factor(self.factor)
        yield from implausible(f"{where}.pressure", size, "Pa", reason, most=most, units=units, derived_from=FILM)

    def why_idle(self, scene: Surroundings) -> str | None:
        """A pressure of no strength, or nothing to act on."""
        if self.pressure == 0:
            return "its pressure is 0"
        if largest_factor(self.factor) == 0.0:
            return "its factor is 0"
        return "there is no film" if scene.mesh is None else None
