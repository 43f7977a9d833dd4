"""The same scene on a coarser or finer mesh: the counts of its folding pattern are multiplied."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from membrane_rs._validation import show
from membrane_rs.errors import InputError
from membrane_rs.folding import Disc, EquilateralLattice, SquareSail, Strip
from membrane_rs.scene import Scene
from membrane_rs.scene.parts import Part, TipMasses


def denser(scene: Scene, density: float) -> Scene:
    """The scene with its mesh `density` times as dense along each direction; cords keep their segments.

    Tip masses on a node set keep their sum.

    Raises
    ------
    InputError
        A density that is not above 0 or that the pattern cannot represent; a mesh without pattern, or no mesh; a part
        that refers to nodes by number, since another mesh numbers them differently.
    """
    if isinstance(density, bool) or not isinstance(density, int | float) or not 0.0 < density < math.inf:
        raise InputError(f"density = {show(density)}: must be a number greater than 0 and finite")
    if density == 1.0:
        return scene
    source = scene.mesh.source if scene.mesh is not None else None
    if scene.mesh is None or source is None:
        what = "has no mesh" if scene.mesh is None else "has a mesh of its own"
        raise InputError(
            f"density = {density:g}: scene {scene.name!r} {what}; only the mesh of a folding pattern can be made "
            "coarser or finer"
        )
    for k, part in enumerate(scene.parts):
        if not isinstance(getattr(part, "nodes", ""), str):
            raise InputError(
                f"density = {density:g}: parts.{k}.nodes of scene {scene.name!r} names nodes by number, which "
                "another mesh gives to other nodes; name a node set"
            )
    mesh = _pattern(source, density).mesh()
    sizes = {name: (len(nodes), len(mesh.node_sets[name])) for name, nodes in scene.mesh.node_sets.items()}
    return replace(scene, mesh=mesh, parts=[_of_same_mass(part, sizes) for part in scene.parts])


def _pattern(source: Any, density: float) -> Any:
    """The pattern with its counts multiplied."""
    if isinstance(source, SquareSail):
        counts = {"rows_per_strip": source.rows_per_strip, "columns": source.columns}
    elif isinstance(source, Disc):
        counts = {"rings": source.rings}
    elif isinstance(source, Strip | EquilateralLattice):
        counts = {"columns": source.columns, "rows": source.rows}
    else:
        raise InputError(f"density = {density:g}: the pattern {type(source).__name__} cannot be made coarser or finer")
    changed: dict[str, Any] = {}
    for name, count in counts.items():
        if count is None:  # chosen by the pattern, from the others
            continue
        many = count * density
        if round(many) < 1 or abs(many - round(many)) > 1e-9 * many:
            wanted = max(1, round(many))
            raise InputError(
                f"density = {density:g}: {type(source).__name__}.{name} = {count} would become {many:g}, which is no "
                f"whole number; take {wanted / count:g}"
            )
        changed[name] = round(many)
    if isinstance(source, SquareSail):
        changed["rows"] = source.strips * changed.pop("rows_per_strip")
    if isinstance(source, EquilateralLattice):
        changed["side"] = source.side / density
    return replace(source, **changed)


def _of_same_mass(part: Part, sizes: dict[str, tuple[int, int]]) -> Part:
    """Tip masses on a set that has more or fewer nodes now."""
    if isinstance(part, TipMasses) and isinstance(part.nodes, str):
        before, now = sizes.get(part.nodes, (1, 1))
        return replace(part, mass=part.mass * before / now) if before != now else part
    return part
