"""What is wrong with the mesh of a scene."""

from __future__ import annotations

from collections.abc import Iterator

from membrane_rs.mesh.audit import growing
from membrane_rs.mesh.findings import Finding
from membrane_rs.scene import Scene


def mesh_faults(scene: Scene) -> Iterator[Finding]:
    """What `Mesh.audit` finds, growing modes left out."""
    if scene.mesh is not None:
        yield from scene.mesh.audit(scene.material, springs=_has_springs(scene), growth=False).findings


def growing_modes(scene: Scene) -> Iterator[Finding]:
    """Modes of the mesh that grow by negative springs, which those that are clipped to zero do not have."""
    if scene.mesh is None or scene.material is None or scene.negative_springs == "clip":
        return
    if _has_springs(scene):
        yield from growing(scene.mesh, scene.material)


def _has_springs(scene: Scene) -> bool:
    return scene.negative_springs != "unused"
