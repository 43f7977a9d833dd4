"""Variants of a scene: without a law, without a part, with fewer segments in a cord, with a coarser or finer mesh."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from membrane_rs.errors import InputError
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.scene.parts import Part
from membrane_rs.study.common.density import denser

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
        Its place in the scene: "laws", "parts" or "mesh", and its index.
    scene : Scene or None
        None where it cannot be left out.
    reason : str
        The reason, where it cannot be left out.
    other : Part or None
        The part in its place.
    density : float
        Ratio of the density of its mesh to that of the scene.
    """

    name: str
    place: tuple[str, int]
    scene: Scene | None = None
    reason: str = ""
    other: Part | None = None
    density: float = 1.0


def variants(scene: Scene) -> list[Variant]:
    """The scene without each law and part, and with a quarter of the segments in each cord, in the order of the scene;
    then with the mesh at half and at twice its density.
    """
    found = [Variant(f"law {law.kind}", ("laws", k)) for k, law in enumerate(scene.laws)]
    kinds = [part.kind for part in scene.parts]
    for k, part in enumerate(scene.parts):
        number = f" {kinds[:k].count(part.kind)}" if kinds.count(part.kind) > 1 else ""
        found.append(Variant(f"part {part.kind}{number}", ("parts", k)))
        if (coarser := part.coarser(COARSER)) is not None:
            gone, other = coarser
            found.append(Variant(f"{gone} in part {part.kind}{number}", ("parts", k), other=other))
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
    gone = {variant.place: variant.other for variant in chosen if variant.density == 1.0}
    laws = [law for k, law in enumerate(scene.laws) if ("laws", k) not in gone]
    parts = [gone.get(("parts", k), part) for k, part in enumerate(scene.parts)]
    left = replace(scene, laws=laws, parts=[part for part in parts if part is not None])
    return denser(left, math.prod(variant.density for variant in chosen))


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
