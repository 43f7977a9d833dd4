"""What holds a scene in space."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from membrane_rs._arrays import Bools
from membrane_rs.analysis.extent import span
from membrane_rs.mesh import Finding
from membrane_rs.mesh.links import groups
from membrane_rs.mesh.queries import distinct
from membrane_rs.scene import Scene
from membrane_rs.scene.scales import node_masses

CENTRED = 0.01
"""Distance of the centre of mass from the axis, over the size, up to which a free body stays on the axis."""


def supports(scene: Scene) -> Iterator[Finding]:
    """Pieces without a fixed node fly freely: they fall under gravity, and, in the frame that turns with the hub, go
    outward if their centre of mass lies off the axis. A balanced body without creases that turns freely about the axis
    is meant so, and a fact; a folded one is a sail, which its hub holds.
    """
    assembly = scene.assemble()
    mesh = scene.mesh
    links = np.concatenate([assembly.cords.nodes, assembly.bridges.nodes])
    if mesh is not None:
        links = np.concatenate([links, mesh.edges])
    label = groups(links, assembly.node_count)
    joined = np.zeros(assembly.node_count, dtype=np.bool_)
    joined[distinct(links)] = True
    free = joined & ~np.isin(label, label[assembly.fixed])
    if not free.any():
        return
    turns = any(law.fastest_turning(scene.run.until) for law in scene.laws)
    falls = any(law.accelerates_all and law.why_idle(scene) is None for law in scene.laws)
    masses = node_masses(scene)
    total, x, y = (np.bincount(label, masses * values) for values in (1.0, *assembly.positions[:, :2].T))
    off_axis = np.hypot(x, y) / np.maximum(total, np.finfo(float).tiny)
    goes_outward = (off_axis > CENTRED * span(assembly.positions))[label]
    folds = np.zeros_like(free) if mesh is None else np.isin(label, label[mesh.creases[:, 0]])
    lost = free if falls or not turns else free & (goes_outward | folds)
    why = "it falls" if falls else "any push moves it as a whole"
    if turns and not falls and (free & goes_outward).any():
        farthest = float(off_axis[label[free]].max())
        why = f"its centre of mass lies {farthest:.4g} m from the axis of the hub, and goes outward"
    if lost.any():
        yield Finding(
            "warning",
            "supports",
            len(np.unique(label[lost])),
            f"nothing holds {_what(scene, lost)}: no node of it is fixed, and no tether leads to the hub; {why}",
            "add a part of kind 'fixed' or 'tethers', unless a free flight is meant",
        )
    balanced = free & ~lost
    if balanced.any():
        yield Finding(
            "info",
            "supports",
            len(np.unique(label[balanced])),
            f"nothing holds {_what(scene, balanced)}: it flies freely, and turns about its own centre on the axis",
            "",
        )


def _what(scene: Scene, nodes: Bools) -> str:
    """The pieces that these nodes are, in words."""
    if nodes.all():
        return "the sail" if scene.mesh is not None else "the scene"
    return f"{int(nodes.sum())} of {len(nodes)} nodes, node {int(np.argmax(nodes))} among them"
