"""Whether a film of rectangles has rectangles."""

from __future__ import annotations

from collections.abc import Iterator

from membrane_rs.errors import MeshError
from membrane_rs.mesh import Finding
from membrane_rs.scene import Scene


def rectangles_of_film(scene: Scene) -> Iterator[Finding]:
    """Triangles that are no halves of rectangles, and rectangles with negative springs: the core refuses both."""
    mesh, material = scene.mesh, scene.material
    if mesh is None or material is None or not any(law.has_rectangles for law in scene.laws):
        return
    try:
        mesh.rectangle_constants(material, stiffness=scene.membrane_stiffness())
    except MeshError as error:
        message, _, remedy = str(error).partition("; ")
        yield Finding("error", "rectangles", 1, message, remedy)
