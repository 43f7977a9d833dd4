"""Values of laws and parts that are hardly meant."""

from __future__ import annotations

from collections.abc import Iterator

from membrane_rs.analysis.extent import span
from membrane_rs.check.material_values import material_values
from membrane_rs.scene import Scene
from membrane_rs.scene.plausible import FILM, Doubt, first_causes, implausible


def law_and_part_values(scene: Scene) -> Iterator[Doubt]:
    """What each law and each part says of its own values, where those of the film do not explain it."""
    yield from first_causes(_doubts(scene), {doubt.place for doubt in material_values(scene)})


def _doubts(scene: Scene) -> Iterator[Doubt]:
    for law in scene.laws:
        yield from law.implausible_values(scene, f"laws.{law.kind}")
        if scene.mesh is not None and scene.material is not None:
            width, thickness = span(scene.mesh.reference), scene.material.thickness
            for field in law.length_fields.values():
                yield from _length(f"laws.{law.kind}.{field}", getattr(law, field), thickness, width)
    for k, part in enumerate(scene.parts):
        yield from part.implausible_values(scene, f"parts[{k}]")
    for k, body in enumerate(scene.bodies):
        yield from body.implausible_values(scene, f"bodies[{k}]")


def _length(place: str, length: float | None, thickness: float, width: float) -> Iterator[Doubt]:
    """A length that a law has in place of one of the mesh lies between the thickness and the width of the film."""
    if length is not None:
        reason = f"lies not between the thickness of the film, {thickness:.4g} m, and its width, {width:.4g} m"
        bounds = {"least": thickness, "most": width}
        units = {"mm": 1e-3, "um": 1e-6}
        yield from implausible(place, length, "m", reason, **bounds, units=units, derived_from=FILM)
