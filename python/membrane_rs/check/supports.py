"""What holds a scene in space."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from membrane_rs.analysis.extent import span
from membrane_rs.mesh import Finding
from membrane_rs.scene import Scene

CENTRED = 0.01
"""Distance of the centre of mass from the axis, over the size, up to which a free body stays on the axis."""


def supports(scene: Scene) -> Iterator[Finding]:
    """Without a fixed node the whole flies freely: it falls under gravity, and, in the frame that turns with the hub,
    goes outward if its centre of mass lies off the axis. A balanced body without creases that turns freely about the
    axis is meant so; a folded one is a sail, which its hub holds.
    """
    assembly = scene.assemble()
    if len(assembly.fixed):
        return
    turns = any(law.hub_frequency for law in scene.laws)
    falls = any(law.accelerates_all and law.why_idle(scene) is None for law in scene.laws)
    masses = assembly.extra_masses.copy()
    if scene.mesh is not None and scene.material is not None:
        masses[: scene.mesh.node_count] += scene.mesh.masses(scene.material)
    total = float(masses.sum())
    centre = masses @ assembly.positions / total if total > 0.0 else np.zeros(3)
    off_axis = float(np.hypot(centre[0], centre[1]))
    is_flat = scene.mesh is None or not len(scene.mesh.creases)
    if turns and not falls and is_flat and off_axis <= CENTRED * span(assembly.positions):
        return
    why = "it falls" if falls else "any push moves it as a whole"
    if turns and not falls and off_axis > CENTRED * span(assembly.positions):
        why = f"its centre of mass lies {off_axis:.4g} m from the axis of the hub, and goes outward"
    what = "sail" if scene.mesh is not None else "scene"
    yield Finding(
        "warning",
        "supports",
        1,
        f"nothing holds the {what}: no node is fixed, and no tether leads to the hub; {why}",
        "add a part of kind 'fixed' or 'tethers', unless a free flight is meant",
    )
