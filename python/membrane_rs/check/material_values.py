"""Values of the film that are hardly meant."""

from __future__ import annotations

from collections.abc import Iterator

from membrane_rs.analysis.extent import span
from membrane_rs.scene import Scene
from membrane_rs.scene.plausible import Doubt, implausible

WIDEST, NARROWEST = 300.0, 1e-4
"""[m]: sails of a few hundred metres are the largest that were ever proposed; below a tenth of a millimetre a film in
air or vacuum is a matter of other forces."""
SLENDER = 0.01
"""Thickness over width from which it is a plate, with bending that this film has along creases alone: a plate carries a
load by stretching once it has sunk by several thicknesses, some hundredths of its width here."""
THINNEST = 2e-8
"""[m]: free-standing polymer films of some tens of nanometres are the thinnest that can be handled."""
SOFTEST, STIFFEST = 1e4, 2e12
"""[Pa]: gels and the softest silicones; diamond and graphene have 1.2e12."""
LIGHTEST, DENSEST = 50.0, 23000.0
"""[kg/m3]: foams and nonwovens; osmium has 22,600."""


def material_values(scene: Scene) -> Iterator[Doubt]:
    """Size, thickness, moduli and density of the film, against those of all films."""
    film, mesh = scene.material, scene.mesh
    if film is None or mesh is None:
        return
    width = span(mesh.reference)
    reason = f"sails are {NARROWEST:g} to {WIDEST:g} m wide"
    units = {"mm": 1e-3, "um": 1e-6, "km": 1e3}
    yield from implausible("mesh (its width)", width, "m", reason, least=NARROWEST, most=WIDEST, units=units)
    reason = f"exceeds the sail, {width:.4g} m wide" if film.thickness > width else f"is no film, {width:.4g} m wide"
    thickest = SLENDER * width if NARROWEST <= width <= WIDEST else WIDEST
    units = {"um": 1e-6, "mm": 1e-3, "nm": 1e-9}
    yield from implausible(
        "material.thickness", film.thickness, "m", reason, least=THINNEST, most=thickest, units=units
    )
    reason = f"solid films have {SOFTEST:g} to {STIFFEST:g} Pa"
    units = {"GPa": 1e9, "MPa": 1e6, "kPa": 1e3}
    for name in ("youngs_modulus", "youngs_modulus_across", "shear_modulus"):
        place, value = f"material.{name}", getattr(film, name)
        if value is not None:
            yield from implausible(place, value, "Pa", reason, least=SOFTEST, most=STIFFEST, units=units)
    reason = f"films have {LIGHTEST:g} to {DENSEST:g} kg/m3"
    yield from implausible(
        "material.density",
        film.density,
        "kg/m3",
        reason,
        least=LIGHTEST,
        most=DENSEST,
        units={"g/cm3": 1e3, "g/m3": 1e-3},
    )
