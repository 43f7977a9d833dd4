"""Stages as a whole: bodies at work in none of them, and measures that have no value."""

from __future__ import annotations

from collections.abc import Iterator

from membrane_rs.mesh.findings import Finding
from membrane_rs.scene import Scene


def stages_together(scene: Scene) -> Iterator[Finding]:
    """Findings about a scene with stages that no stage by itself shows."""
    for name in (body.name for body in scene.bodies):
        if all(name in stage.without for stage in scene.stages):
            message = f"{name} is at work in no stage: each is without it"
            yield Finding("warning", "idle_in_all", 1, message, f"leave {name} out, or take it out of one `without`")
    for k, stage in enumerate(scene.stages):
        staged = scene.staged(k)
        has_film = len(staged.assemble().triangles) and any(law.is_film for law in staged.laws)
        if stage.measure == "largest_film_stress" and not has_film:
            message = f"stages[{k}].measure = {stage.measure!r}: there is no film at work whose stress it could be"
            yield Finding("warning", "measure", 1, message, "take another measure, or a law of the film into the stage")
