"""Variants of a scene: without a law or a part, with a simpler or softer one, on a coarser or finer mesh."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from membrane_rs.check.softening import LEAST_FACTOR, softening_advice
from membrane_rs.check.stepping import is_explicit
from membrane_rs.errors import InputError
from membrane_rs.material import Material
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.scene.laws import Law
from membrane_rs.scene.parts import Part
from membrane_rs.scene.softened import softening_of, with_softening
from membrane_rs.study.common.density import denser

T = TypeVar("T")

COARSER = 4
"""Factor by which the number of segments of a cord is reduced."""


@dataclass(frozen=True)
class Variant:
    """A scene without one of its elements.

    Attributes
    ----------
    name : str
        Name of the element that is left out or replaced.
    place : (str, int)
        Its place in the scene: "laws", "parts", "material" or "mesh", and its index.
    scene : Scene or None
        None where it cannot be left out.
    reason : str
        The reason, where it cannot be left out.
    other : Law, Part, Material or None
        What stands in its place.
    saves_by_step : bool
        Whether a longer step is all that it saves, so that it is judged with that.
    density : float
        Ratio of the density of its mesh to that of the scene.
    """

    name: str
    place: tuple[str, int]
    scene: Scene | None = None
    reason: str = ""
    other: Law | Part | Material | None = None
    saves_by_step: bool = False
    density: float = 1.0


def variants(scene: Scene, integrator: str | None = None) -> list[Variant]:
    """The scene without each law and part, with simpler laws, and with a quarter of the segments in each cord, in the
    order of the scene; then with the film as soft as `softening_advice` says where the method, by default the scene's,
    is explicit, and with the mesh at half and at twice its density.
    """
    found = []
    for k, law in enumerate(scene.laws):
        found.append(Variant(f"law {law.kind}", ("laws", k)))
        if (simpler := law.simpler()) is not None:
            gone, form = simpler
            found.append(Variant(f"{gone} in law {law.kind}", ("laws", k), other=form, saves_by_step=True))
    kinds = [part.kind for part in scene.parts]
    for k, part in enumerate(scene.parts):
        number = f" {kinds[:k].count(part.kind)}" if kinds.count(part.kind) > 1 else ""
        found.append(Variant(f"part {part.kind}{number}", ("parts", k)))
        if (coarser := part.coarser(COARSER)) is not None:
            gone, other = coarser
            found.append(Variant(f"{gone} in part {part.kind}{number}", ("parts", k), other=other))
    explicit = is_explicit(scene.run.integrator if integrator is None else integrator)
    if explicit and scene.material is not None and softening_of(scene) is None:
        factor = softening_advice(scene).factor
        if factor >= LEAST_FACTOR:
            name = f"all but 1/{factor:g} of the in-plane stiffness"
            soft = with_softening(scene, factor).material
            found.append(Variant(name, ("material", 0), other=soft, saves_by_step=True))
    if scene.mesh is not None:
        found.append(Variant("every other line of the mesh", ("mesh", 0), density=0.5))
        found.append(Variant("nothing; mesh twice as dense", ("mesh", 0), density=2.0))
    return [_built(scene, variant) for variant in found]


def without(scene: Scene, chosen: Sequence[Variant]) -> Scene:
    """The scene without several elements at once.

    Raises
    ------
    SceneError
        The remainder is not a valid scene.
    InputError
        A density that its mesh cannot represent.
    """
    gone: dict[tuple[str, int], Any] = {variant.place: variant.other for variant in chosen if variant.density == 1.0}

    def left(place: str, members: Sequence[T]) -> list[T]:
        kept = (gone.get((place, k), member) for k, member in enumerate(members))
        return [member for member in kept if member is not None]

    material = gone.get(("material", 0), scene.material)
    rest = replace(scene, material=material, laws=left("laws", scene.laws), parts=left("parts", scene.parts))
    return denser(rest, math.prod(variant.density for variant in chosen))


def _built(scene: Scene, variant: Variant) -> Variant:
    """The variant with its scene, or with the reason why it has none."""
    try:
        left = without(scene, [variant])
        if len(scene.assemble().fixed) and not len(left.assemble().fixed):
            return replace(variant, reason="it alone fixes the scene in space; without it no node is fixed")
        Simulation(left)
    except InputError as error:
        return replace(variant, reason=str(error))
    return replace(variant, scene=left)
