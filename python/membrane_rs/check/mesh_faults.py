"""What is wrong with the mesh of a scene."""

from __future__ import annotations

import math
from collections.abc import Iterator

from membrane_rs.mesh.audit import growing
from membrane_rs.mesh.findings import Finding
from membrane_rs.scene import Scene

FEW_NODES = 1000
"""Up to which growing modes cost about as much as the other checks of the mesh."""


def mesh_faults(scene: Scene) -> Iterator[Finding]:
    """What `Mesh.audit` finds, growing modes left out."""
    if scene.mesh is not None:
        yield from scene.mesh.audit(scene.material, springs=_has_springs(scene), growth=False).findings


def growing_modes(scene: Scene) -> Iterator[Finding]:
    """Modes of the mesh that grow by negative springs, in meshes of up to `FEW_NODES`."""
    yield from _growing(scene, 0, FEW_NODES)


def growing_modes_of_large_meshes(scene: Scene) -> Iterator[Finding]:
    """The same for larger meshes."""
    yield from _growing(scene, FEW_NODES, math.inf)


def _growing(scene: Scene, fewer: float, most: float) -> Iterator[Finding]:
    """Those of a mesh with more nodes than `fewer` and no more than `most`; springs that are clipped make none."""
    if scene.mesh is None or scene.material is None or scene.negative_springs == "clip" or not _has_springs(scene):
        return
    if fewer < scene.mesh.node_count <= most:
        yield from growing(scene.mesh, scene.material)


def _has_springs(scene: Scene) -> bool:
    return scene.negative_springs != "unused"
