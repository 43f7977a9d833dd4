"""Redundant laws of a scene, and the parts that limit its step; found before a run."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from membrane_rs.errors import MembraneError
from membrane_rs.mesh.findings import Finding
from membrane_rs.scene import Scene
from membrane_rs.scene.parts import Fixed, Part
from membrane_rs.simulation.motion import Motion

SOFT = 1e-8
"""A part made softer by this factor sets no step."""
LEAST_GAIN = 1.02
"""Gain of step from which a part is named."""


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
    """(law, reason) for each law without effect in this scene: leaving it out changes the cost alone."""
    return [(law.kind, why) for law in scene.laws if (why := law.why_idle(scene)) is not None]


def laws_without_effect(scene: Scene) -> Iterator[Finding]:
    """The same as findings."""
    for kind, reason in idle_laws(scene):
        yield Finding("info", "idle_law", 1, f"{kind} is without effect in this scene: {reason}", f"leave {kind} out")


def values_without_effect(scene: Scene) -> Iterator[Finding]:
    """Values of parts that none of the scene's laws feels."""
    kinds = {law.kind for law in scene.laws}
    for k, part in enumerate(scene.parts):
        for name, laws in part.laws_needed.items():
            if not kinds.intersection(laws):
                message = f"parts[{k}].{name} is without effect: the scene has no law {' or '.join(laws)}"
                yield Finding("warning", "setting_without_effect", 1, message, f"add that law, or leave {name} out")


def step_savings(scene: Scene, integrator: str | None = None) -> list[Saving]:
    """The step without each law and part in turn, the largest first; only gains of 2 % and more."""
    limit = limit_of_step(scene, integrator)
    found = []
    for part, changed, advice in _variants(scene):
        without = limit_of_step(changed, integrator)
        gain = without / limit if math.isfinite(limit) else 1.0
        if gain > LEAST_GAIN:
            found.append(Saving(part, without, gain, advice(gain)))
    return sorted([*found, *_at_one_place(scene, integrator, limit)], key=lambda saving: -saving.gain)


def limit_of_step(scene: Scene, integrator: str | None = None) -> float:
    """The limit of the step; inf without stiffness, NaN where the scene cannot be built."""
    try:
        return Motion(replace(scene, run=replace(scene.run, dt=None)), integrator, dt=1e-300).stable_dt()
    except MembraneError:
        return math.nan


def _variants(scene: Scene) -> Iterator[tuple[str, Scene, Callable[[float], str]]]:
    """(what, the scene without it or with it soft, advice for a gain)."""
    for law in scene.laws:
        if law.stiff_through == "law":
            rest = [other for other in scene.laws if other is not law]
            yield law.kind, replace(scene, laws=rest), law.step_advice
        elif law.stiff_through == "film" and scene.mesh is not None and scene.material is not None:
            soft = replace(scene.material, youngs_modulus=scene.material.youngs_modulus * SOFT)
            laws = [other.for_modulus(SOFT) for other in scene.laws]
            parts = [part.for_modulus(SOFT) for part in scene.parts]
            yield law.kind, replace(scene, material=soft, laws=laws, parts=parts), law.step_advice
    stiff: dict[str, Part] = {}
    for part in scene.parts:
        if part.softened(SOFT) != part:
            stiff.setdefault(part.kind, part)
    for kind, first in stiff.items():
        parts = [part.softened(SOFT) if part.kind == kind else part for part in scene.parts]
        yield kind, replace(scene, parts=parts), first.step_advice


def _at_one_place(scene: Scene, integrator: str | None, limit: float) -> Iterator[Saving]:
    """Whether the triangles around one node alone set the step: with those held, what is the limit?"""
    if scene.mesh is None or not math.isfinite(limit):
        return
    node = Motion(scene, integrator).limiting_node
    if node >= scene.mesh.node_count:
        return
    around = scene.mesh.triangles[(scene.mesh.triangles == node).any(axis=1)]
    held = replace(scene, parts=[*scene.parts, Fixed(nodes=tuple(int(i) for i in np.unique(around)))])
    gain = limit_of_step(held, integrator) / limit
    if 1.1 < gain < math.inf:
        flatness = float(scene.mesh.flatness()[(scene.mesh.triangles == node).any(axis=1)].min())
        yield Saving(
            f"the triangles around node {node}",
            gain * limit,
            gain,
            f"the flattest of them is {flatness:.2g} high for a side of 1: move its nodes apart, or merge them",
        )
