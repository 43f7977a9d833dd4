"""What a scene holds for nothing, and what makes its step as small as it is: asked before anything runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from membrane_rs.errors import MembraneError
from membrane_rs.scene import Scene
from membrane_rs.scene.laws import AirDrag, Creases, Gravity, MassDamping, Spin, SpoolContact, SpringDamping, Springs
from membrane_rs.scene.parts import Bridges, Fixed, Tether, Tethers
from membrane_rs.simulation.motion import Motion

SOFT = 1e-8
"""A part made softer by this factor sets no step."""
WORTH_TELLING = 1.02
"""Gain of step from which a part is named."""
ALONE = 20.0
"""Gain of step from which a part counts as the only stiff one."""


@dataclass(frozen=True)
class Saving:
    """By how much the step could grow without one part, or with it made softer."""

    part: str
    limit: float
    """Of the step without it [s]."""
    gain: float
    """That, over the limit with it."""
    advice: str


def idle_laws(scene: Scene) -> list[tuple[str, str]]:
    """(law, why) for each law that cannot matter in this scene: leaving it out changes nothing but the cost."""
    return [(law.kind, why) for law in scene.laws if (why := _why_idle(scene, law)) is not None]


def _why_idle(scene: Scene, law: Any) -> str | None:  # noqa: PLR0911
    assembly = scene.assemble()
    has_springs = scene.mesh is not None or len(assembly.cord_pairs) > 0
    match law:
        case Springs() | AirDrag() if scene.mesh is None:
            return "the scene has no membrane"
        case AirDrag() if law.pressure == 0:
            return "its pressure is 0: there is no air"
        case AirDrag() if law.air == "turning" and _is_at_rest(scene):
            return "nothing moves in this scene"
        case Creases() if len(assembly.creases) == 0:
            return "the mesh has no creases"
        case Creases() if law.stiffness == 0:
            return "its stiffness is 0, and contact is a multiple of that"
        case SpringDamping() if law.ratio == 0 or not has_springs:
            return "its ratio is 0" if has_springs else "the scene has no springs"
        case Gravity() if not any(law.acceleration):
            return "its acceleration is 0"
        case MassDamping() if law.rate == 0:
            return "its rate is 0"
        case Spin() if law.frequency == 0 and law.acceleration == 0:
            return "the hub does not turn"
        case SpoolContact():
            return _why_no_contact(scene, law)
        case _:
            return None


def _is_at_rest(scene: Scene) -> bool:
    assembly = scene.assemble()
    return len(assembly.fixed) == assembly.node_count


def _why_no_contact(scene: Scene, law: SpoolContact) -> str | None:
    """Nodes that hang on something held can come no nearer to the axis than their springs stretch."""
    assembly = scene.assemble()
    nodes = assembly.contact_nodes
    if len(nodes) == 0:
        return "no tether's node and no node of the membrane can meet the spool"
    if len(assembly.fixed) == 0 or len(assembly.bridges):
        return None
    springs = scene.law("springs")
    pairs, lengths = [assembly.cord_pairs], [assembly.cord_rest_length * (1.0 + assembly.cord_strain_limit)]
    if scene.mesh is not None and isinstance(springs, Springs):
        pairs.append(scene.mesh.edges)
        lengths.append(scene.mesh.edge_lengths * (1.0 + springs.strain_limit))
    ends, reach = np.concatenate(pairs), np.concatenate(lengths)
    graph = coo_matrix((reach, (ends[:, 0], ends[:, 1])), shape=(assembly.node_count,) * 2)
    anchors = assembly.fixed
    away = dijkstra(graph.tocsr(), directed=False, indices=anchors)[:, nodes]
    radii = np.hypot(assembly.positions[anchors, 0], assembly.positions[anchors, 1])
    nearest = (radii[:, None] - away).max(axis=0)
    if (nearest > law.radius).all():
        return f"nothing can come nearer to the axis than {nearest.min():.4g} m, and the spool ends at {law.radius:g} m"
    return None


def step_savings(scene: Scene, integrator: str | None = None) -> list[Saving]:
    """What the step could be without each law and part in turn, best first; only gains of 2 % and more."""
    limit = _limit(scene, integrator)
    found = []
    for part, changed, advice in _variants(scene):
        without = _limit(changed, integrator)
        gain = without / limit if math.isfinite(limit) else 1.0
        if gain > WORTH_TELLING:
            found.append(Saving(part, without, gain, advice(gain)))
    return sorted([*found, *_at_one_place(scene, integrator, limit)], key=lambda saving: -saving.gain)


def _limit(scene: Scene, integrator: str | None) -> float:
    """The limit of the step; inf without stiffness, NaN where the scene cannot be built."""
    try:
        return Motion(replace(scene, run=replace(scene.run, dt=None)), integrator, dt=1e-300).stable_dt()
    except MembraneError:
        return math.nan


def _variants(scene: Scene) -> Iterator[tuple[str, Scene, Callable[[float], str]]]:
    """(what, the scene without it or with it soft, advice for a gain)."""
    for law in scene.laws:
        rest = [other for other in scene.laws if other is not law]
        if isinstance(law, Creases | SpoolContact | MassDamping | Spin | SpringDamping):
            yield law.kind, replace(scene, laws=rest), _advice_for(law)
    if scene.mesh is not None and scene.material is not None and scene.law("springs") is not None:
        soft = replace(scene.material, youngs_modulus=scene.material.youngs_modulus * SOFT)
        laws: list[Any] = [
            replace(law, stiffness=law.stiffness / SOFT) if isinstance(law, Creases) else law for law in scene.laws
        ]
        yield "springs", replace(scene, material=soft, laws=laws), _mesh_advice
    for kind in (Tethers, Tether, Bridges):
        if any(isinstance(part, kind) for part in scene.parts):
            parts = [_softened(part) if isinstance(part, kind) else part for part in scene.parts]
            first = next(part for part in scene.parts if isinstance(part, kind))
            yield kind.kind, replace(scene, parts=parts), _part_advice(first)


def _mesh_advice(gain: float) -> str:
    return "a coarser mesh of the membrane has a longer step in proportion to its springs"


def _advice_for(law: Any) -> Callable[[float], str]:
    def advice(gain: float) -> str:
        match law:
            case Creases():
                return f"contact_penalty or stiffness {gain**2:.3g} times smaller would take it out of the limit"
            case SpoolContact():
                return f"a stiffness of {law.stiffness / gain**2:.3g} N/m or less would take it out of the limit"
            case SpringDamping():
                return "a smaller ratio makes the step longer"
            case MassDamping():
                return f"a rate of {law.rate / gain:.3g} 1/s or less would take it out of the limit"
            case _:
                return "the frame turns too fast for the step"

    return advice


def _softened(part: Any) -> Any:
    if isinstance(part, Bridges):
        return replace(part, stiffness=part.stiffness * SOFT)
    return replace(part, axial_stiffness=part.axial_stiffness * SOFT)


def _part_advice(part: Any) -> Callable[[float], str]:
    def advice(gain: float) -> str:
        if gain > ALONE and not isinstance(part, Bridges):
            return "nothing else comes near: with half of its segments the step is twice as long"
        if isinstance(part, Bridges):
            return f"a stiffness of {part.stiffness / gain**2:.3g} N/m or less would take it out of the limit"
        fewer = max(1, math.floor(part.segments / gain))
        return (
            f"an axial_stiffness of {part.axial_stiffness / gain**2:.3g} N in place of {part.axial_stiffness:g} N, "
            f"or {fewer} segments in place of {part.segments}, would take it out of the limit"
        )

    return advice


def _at_one_place(scene: Scene, integrator: str | None, limit: float) -> Iterator[Saving]:
    """Whether the triangles around one node alone set the step: with those held, what is the limit?"""
    if scene.mesh is None or not math.isfinite(limit):
        return
    node = Motion(scene, integrator).limiting_node
    if node >= scene.mesh.node_count:
        return
    around = scene.mesh.triangles[(scene.mesh.triangles == node).any(axis=1)]
    held = replace(scene, parts=[*scene.parts, Fixed(nodes=tuple(int(i) for i in np.unique(around)))])
    gain = _limit(held, integrator) / limit
    if 1.1 < gain < math.inf:
        flatness = float(scene.mesh.flatness()[(scene.mesh.triangles == node).any(axis=1)].min())
        yield Saving(
            f"the triangles around node {node}",
            gain * limit,
            gain,
            f"the flattest of them is {flatness:.2g} high for a side of 1: move its nodes apart, or merge them",
        )
