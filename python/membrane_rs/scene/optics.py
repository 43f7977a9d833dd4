"""Optical properties of both sides of a film: defaults, and checks of one against the other."""

from __future__ import annotations

from collections.abc import Mapping

from membrane_rs._validation import show
from membrane_rs.errors import InputError
from membrane_rs.scene.components import Optics

OF_SIDES = ("specular", "diffuse", "emissivity", "lambert")
"""Optical properties of a side."""
ROUNDING = 1e-12
"""By which two shares may be more than 1 together."""


def optics_of(owner: str, given: Mapping[str, float]) -> Optics:
    """Both sides by the properties that are given, those of the front's reflection among them: on the front an
    emissivity of 1 that obeys Lambert's law, and on the back what the front has.

    Raises
    ------
    InputError
        A side of `owner` that reflects more than all light, no side that emits.
    """
    front = {"front_emissivity": 1.0, "front_lambert": 2.0 / 3.0} | dict(given)
    found = {f"back_{name}": front[f"front_{name}"] for name in OF_SIDES} | front
    for side in ("front", "back"):
        specular, diffuse = found[f"{side}_specular"], found[f"{side}_diffuse"]
        if specular + diffuse > 1.0 + ROUNDING:
            what = f"reflects more than all light with {side}_specular = {show(specular)}"
            raise InputError(f"{owner}.{side}_diffuse = {show(diffuse)}: {what}; must be at most {1.0 - specular:g}")
    if found["front_emissivity"] + found["back_emissivity"] == 0.0:
        what = "with back_emissivity = 0 nothing emits what the film absorbs; set one of them above 0"
        raise InputError(f"{owner}.front_emissivity = {show(found['front_emissivity'])}: {what}")
    return Optics(**found)
