"""What notebooks show of a scene: its lines, and what it is made of."""

from __future__ import annotations

from membrane_rs._arrays import Floats
from membrane_rs._html import Lines
from membrane_rs.mesh import Mesh
from membrane_rs.scene.assembly import Assembly


def lines_of(mesh: Mesh | None, assembly: Assembly, positions: Floats) -> Lines:
    """The lines of a scene with its nodes at `positions` (N, 3) [m]."""
    if mesh is None:
        return Lines(positions, cords=assembly.cords.nodes)
    return Lines(positions, mesh.boundary_edges, mesh.creases, assembly.cords.nodes)
