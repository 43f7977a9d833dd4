"""What a simulation needs to go on elsewhere: a digest of its scene, and the nodes that another scene must share."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable

import numpy as np

from membrane_rs._validation import nearest
from membrane_rs.errors import InputError
from membrane_rs.scene import Scene
from membrane_rs.scene.assembly import Assembly
from membrane_rs.scene.run_settings import RunSettings
from membrane_rs.scene.toml import SceneContent, write_scene


def scene_digest(scene: Scene) -> str:
    """A digest of all in a scene that its motion depends on: neither its name nor the settings of its run."""
    content = SceneContent(scene.mesh, scene.material, tuple(scene.laws), tuple(scene.parts), "", RunSettings())
    found = hashlib.sha256(write_scene(content).encode())
    if scene.mesh is not None:
        mesh = scene.mesh
        for array in (mesh.reference, mesh.triangles, mesh.positions, mesh.creases, mesh.fold_angles, mesh.bridges):
            found.update(np.ascontiguousarray(array).tobytes())
    return found.hexdigest()[:32]


ENTRIES = {
    "step_count", "evaluation_count", "origin", "hub_phase", "positions", "velocities",
    "start_kinetic", "start_internal_kinetic", "start_stored", "work", "swing", "start_shift", "scene_digest",
    "output_time", "adaptive_numbers", "adaptive_was_rejected", "rejected_count",
}  # fmt: skip
"""Entries of a state, beside the histories of the method and of the laws."""


def unknown_entries(names: Iterable[object], laws: Iterable[str]) -> dict[object, str]:
    """Entries that a state of a scene with these laws does not have, and the end of a message about each."""
    histories = ("history", "memory", *(f"history_{law}" for law in laws))  # memory: of version 0.1
    known = ENTRIES | {f"{name}_{part}" for name in histories for part in ("count", "vectors", "numbers")}
    return {name: f"no such entry; {nearest(str(name), known)}" for name in names if name not in known}


def check_same_nodes(wanted: Assembly, found: Assembly) -> None:
    """Refuse to start a scene from another one's motion where their nodes differ. Raises InputError."""
    if wanted.node_count != found.node_count:
        what = f"has {found.node_count} nodes, and this scene {wanted.node_count}"
    elif not np.array_equal(wanted.triangles, found.triangles):
        what = "has other triangles than this scene"
    elif not np.array_equal(wanted.cords.nodes, found.cords.nodes):
        what = "has cords between other nodes than this scene"
    else:
        return
    raise InputError(f"start: its scene {what}; take a scene with the same mesh and the same segments of its cords")
