"""The same scene on a coarser or finer mesh: the counts of its folding pattern are multiplied."""

from __future__ import annotations

import math
from dataclasses import replace

from membrane_rs._validation import show
from membrane_rs.errors import InputError
from membrane_rs.folding.pattern import pattern_of
from membrane_rs.mesh import MeshOrigin
from membrane_rs.scene import Scene

_REMEDIES = {
    "triangles": ("triangles", "a node set or a polygon"),
    "creases": ("creases", "a node set, or mountains or valleys"),
}
"""Elements that a field names by number, and what names them on any mesh; other fields name nodes."""


def denser(scene: Scene, density: float) -> Scene:
    """The scene with its mesh `density` times as dense along each direction; cords keep their segments.

    Tip masses on a node set keep their sum.

    Raises
    ------
    InputError
        A density that is not above 0 or that the pattern cannot represent; a mesh without pattern, or no mesh; a part
        or a law that refers to nodes by number, since another mesh numbers them differently.
    """
    if isinstance(density, bool) or not isinstance(density, int | float) or not 0.0 < density < math.inf:
        raise InputError(f"density = {show(density)}: must be a number greater than 0 and finite")
    if density == 1.0:
        return scene
    if scene.mesh is None or scene.mesh.source is None or isinstance(scene.mesh.source, MeshOrigin):
        what = "has no mesh" if scene.mesh is None else "has a mesh of its own"
        raise InputError(
            f"density = {density:g}: scene {scene.name!r} {what}; only the mesh of a folding pattern can be made "
            "coarser or finer"
        )
    refuse_numbers(scene, f"density = {density:g}")
    pattern = pattern_of(scene.mesh)
    if pattern is None:
        kind = type(scene.mesh.source).__name__
        raise InputError(f"density = {density:g}: the pattern {kind} cannot be made coarser or finer")
    mesh = pattern.refined(density).mesh()
    before, now = scene.mesh.node_sets, mesh.node_sets
    sizes = {name: (len(nodes), len(now[name])) for name, nodes in before.items() if name in now}
    return replace(scene, mesh=mesh, parts=[part.resized(sizes) for part in scene.parts])


def refuse_numbers(scene: Scene, where: str) -> None:
    """Raise InputError for a part or a law that refers to the mesh by numbers, since another one numbers otherwise."""
    places = [(f"parts.{k}", part.numbering_field) for k, part in enumerate(scene.parts)]
    places += [(f"laws.{law.kind}", law.numbering_field) for law in scene.laws]
    for place, field in places:
        if field is not None:
            what, remedy = _REMEDIES.get(field, ("nodes", "a node set"))
            raise InputError(
                f"{where}: {place}.{field} of scene {scene.name!r} names {what} by number, which another mesh gives to "
                f"other {what}; name {remedy}"
            )
