"""How large a scene is."""

from __future__ import annotations

from membrane_rs.folding.pattern import pattern_of
from membrane_rs.mesh import Mesh
from membrane_rs.scene.assembly import Assembly


def counts_of(mesh: Mesh | None, assembly: Assembly) -> dict[str, int]:
    """What `Scene.counts` gives, of a scene with this mesh."""
    edges = 0 if mesh is None else len(mesh.edges)
    mesh_nodes = 0 if mesh is None else len(mesh.reference)
    own = {"masses": mesh_nodes, "springs": edges, "elements": len(assembly.triangles)}
    pattern = pattern_of(mesh)
    own |= (pattern.counts() if pattern is not None else None) or {}
    cords = len(assembly.cords)
    return {
        "masses": own["masses"] + assembly.node_count - mesh_nodes,
        "springs": own["springs"] + cords,
        "elements": own["elements"],
        "nodes": assembly.node_count,
        "edges": edges + cords,
        "triangles": len(assembly.triangles),
        "hinges": len(assembly.creases.nodes),
    }
