"""What is shown of a scene: a line of text, and in notebooks its lines and what it is made of."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from membrane_rs._arrays import Floats
from membrane_rs._html import Card, Lines, in_a_line
from membrane_rs._quantities import compact
from membrane_rs.material import Material
from membrane_rs.mesh import Mesh
from membrane_rs.scene.assembly import Assembly
from membrane_rs.scene.places import Changeable


class ShownScene(Changeable, Protocol):
    """What of a scene is shown."""

    @property
    def name(self) -> str:
        """Its name."""


def text_of(scene: ShownScene, assembly: Assembly) -> str:
    """Name, size and laws."""
    laws = ", ".join(law.kind for law in scene.laws) or "none"
    stages = f"; stages {in_a_line(', '.join(stage.name for stage in scene.stages))}" if scene.stages else ""
    return f"Scene({scene.name!r}: {assembly.node_count} nodes; laws {laws}{stages})"


def _film(film: Material) -> str:
    """Its thickness and Young's modulus, such as "7.5 um thick, E = 3.2 GPa, softened 10-fold"."""
    softened = "" if film.softening is None else f", softened {film.softening:g}-fold"
    return f"{compact(film.thickness, 'm', 4)} thick, E = {compact(film.youngs_modulus, 'Pa', 4)}{softened}"


def card_of(scene: ShownScene, assembly: Assembly, counts: Mapping[str, int]) -> Card:
    """The scene at its start."""
    film, run = scene.material, scene.run
    rows: list[tuple[str, object]] = [
        ("nodes", counts["nodes"]),
        ("springs", counts["edges"]),
        ("triangles", counts["triangles"]),
        ("film", "none" if film is None else _film(film)),
        ("laws", ", ".join(law.kind for law in scene.laws) or "none"),
        ("parts", ", ".join(part.name or part.kind for part in scene.parts) or "none"),
        *([("bodies", ", ".join(body.name for body in scene.bodies))] if scene.bodies else []),
        *([("stages", ", ".join(stage.name for stage in scene.stages))] if scene.stages else []),
        ("run", f"{run.until:.6g} s by {run.integrator}"),
    ]
    return Card(f"Scene {scene.name}", rows, lines_of(scene.mesh, assembly, assembly.positions))


def lines_of(mesh: Mesh | None, assembly: Assembly, positions: Floats) -> Lines:
    """The lines of a scene with its nodes at `positions` (N, 3) [m]."""
    if mesh is None:
        return Lines(positions, cords=assembly.cords.nodes)
    return Lines(positions, mesh.boundary_edges, mesh.creases, assembly.cords.nodes)
