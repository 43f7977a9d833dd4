"""A scene with something left out: each law, each part, cords of fewer segments, a mesh of fewer lines."""

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
"""By how much the segments of a cord are fewer, where that is tried."""


@dataclass(frozen=True)
class Variant:
    """A scene without one thing.

    Attributes
    ----------
    name : str
        What was left out, or put in its place.
    place : (str, int)
        Where it stands in the scene: "laws", "parts" or "mesh", and its index.
    scene : Scene or None
        None where it cannot be left out.
    reason : str
        Then why.
    other : Part or None
        What stands in its place.
    density : float
        Of its mesh, over that of the scene.
    """

    name: str
    place: tuple[str, int]
    scene: Scene | None = None
    reason: str = ""
    other: Part | None = None
    density: float = 1.0


def variants(scene: Scene) -> list[Variant]:
    """Every law left out, every part, and every cord with a quarter of its segments, in the order of the scene; then
    the mesh at half and at twice its density.
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
        found.append(Variant("nothing, and the mesh twice as dense", ("mesh", 0), density=2.0))
    return [_built(scene, variant) for variant in found]


def without(scene: Scene, chosen: Sequence[Variant]) -> Scene:
    """The scene without several things at once.

    Raises
    ------
    SceneError
        They hold each other: what is left is no scene.
    InputError
        A density that its mesh cannot have.
    """
    gone = {variant.place: variant.other for variant in chosen if variant.density == 1.0}
    laws = [law for k, law in enumerate(scene.laws) if ("laws", k) not in gone]
    parts = [gone.get(("parts", k), part) for k, part in enumerate(scene.parts)]
    left = replace(scene, laws=laws, parts=[part for part in parts if part is not None])
    return denser(left, math.prod(variant.density for variant in chosen))


def _built(scene: Scene, variant: Variant) -> Variant:
    """The variant with its scene, or with the reason why there is none."""
    try:
        left = without(scene, [variant])
        if len(scene.assemble().fixed) and not len(left.assemble().fixed):
            return replace(variant, reason="it alone holds the scene; without it nothing is held fast")
        Simulation(left)
    except InputError as error:
        return replace(variant, reason=str(error))
    return replace(variant, scene=left)
