"""What a simulation needs to go on elsewhere: a digest of its scene, and the nodes that another scene must share."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import replace
from numbers import Real
from typing import Any

import numpy as np

from membrane_rs._validation import nearest, number_of, show
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.mesh import Mesh
from membrane_rs.scene import Scene
from membrane_rs.scene.assembly import Assembly
from membrane_rs.scene.run_settings import RunSettings
from membrane_rs.scene.toml import SceneContent, write_scene


def scene_digest(scene: Scene) -> str:
    """A digest of all in a scene that its motion depends on: neither its name nor the settings of its run."""
    laws, parts = tuple(scene.laws), tuple(scene.parts)
    stages = tuple(replace(stage, frames=None, samples=None) for stage in scene.stages)
    bodies = tuple(scene.bodies)
    content = SceneContent(scene.mesh, scene.material, laws, parts, "", RunSettings(), stages, bodies)
    found = hashlib.sha256(write_scene(content, with_later=False).encode())
    if scene.mesh is not None:
        mesh = scene.mesh
        for array in (mesh.reference, mesh.triangles, mesh.positions, mesh.creases, mesh.fold_angles, mesh.bridges):
            found.update(np.ascontiguousarray(array).tobytes())
    return found.hexdigest()[:32]


ENTRIES = {
    "step_count", "evaluation_count", "origin", "hub_phase", "positions", "velocities",
    "start_kinetic", "start_internal_kinetic", "start_stored", "work", "motor_numbers", "swing", "start_shift",
    "scene_digest", "output_time", "adaptive_numbers", "adaptive_was_rejected", "rejected_count", "integrator", "dt",
    "is_adaptive", "origin_step", "changes",
}  # fmt: skip
"""Entries of a state, beside the histories of the method and of the laws."""


def unknown_entries(names: Iterable[object], laws: Iterable[str]) -> dict[object, str]:
    """Entries that a state of a scene with these laws does not have, and the end of a message about each."""
    histories = ("history", "memory", *(f"history_{law}" for law in laws))  # memory: of version 0.1
    known = ENTRIES | {f"{name}_{part}" for name in histories for part in ("count", "vectors", "numbers")}
    return {name: f"no such entry; {nearest(str(name), known)}" for name in names if name not in known}


FLAGS = {"adaptive_was_rejected", "is_adaptive"}
"""Entries that are true or false; no other one is."""
ENERGIES = ("start_kinetic", "start_internal_kinetic", "swing")
"""Entries that are energies of motion, or sizes of energies [J]."""


def check_kinds(state: Mapping[str, Any]) -> None:
    """Refuse truth values where a state has numbers, and energies below 0 that have no sign.

    Raises InputError and InputTypeError.
    """
    for name, value in state.items():
        array = np.asarray(value)
        if name not in FLAGS and array.dtype.kind == "b":
            raise InputTypeError(f"saved state: {name} = {show(value)}: must be a number, or an array of numbers")
        for kind, names, what in (("b", FLAGS, "true or false"), ("U", {"integrator"}, "the name of a method")):
            if name in names and (array.ndim or array.dtype.kind != kind):
                raise InputTypeError(f"saved state: {name} = {show(value)}: must be {what}")
    for name in ENERGIES:
        energy = state.get(name)  # the core refuses what is no number, or not finite
        if isinstance(energy, Real) and energy < 0.0 and (name == "swing" or "changes" not in state):
            raise InputError(f"saved state: {name} = {show(energy)}: must be at least 0 (J); {DAMAGED}")


def check_method(state: Mapping[str, Any], integrator: str, dt: float, *, is_adaptive: bool) -> None:
    """Refuse a state of another method, or of another step, by which its steps would be other times.

    A state that an earlier version saved does not say them. Raises InputError.
    """
    instead = "or go on from its motion: Simulation(scene, start=other)"
    given = str(state.get("integrator", integrator))
    if given != integrator:
        raise InputError(
            f"saved state: integrator is {show(given)}, and that of this simulation {integrator!r}; build one with "
            f"that method, {instead}"
        )
    chooses = state.get("is_adaptive", is_adaptive)
    if bool(chooses) != is_adaptive:
        ways = ("with a fixed step", "choosing its steps")
        raise InputError(
            f"saved state: it was stepped {ways[bool(chooses)]}, and this simulation steps {ways[is_adaptive]}; build "
            f"one that does as it did, {instead}"
        )
    step = number_of("saved state: dt", state.get("dt", dt))
    if not is_adaptive and step != dt:
        raise InputError(
            f"saved state: dt = {step!r} s, and that of this simulation {dt!r} s; build one with that step, {instead}"
        )


DAMAGED = "it is damaged: give one that a simulation gave"
MOST_RATIO = 100.0
"""Energies at the start, over those at hand, above which a state is taken as damaged."""
MOST_SWING = 1e9
"""The largest change of an energy, over those at hand, above which it is: an oscillation may be near its start."""


def check_balance(state: Mapping[str, Any], ledger: Mapping[str, Any]) -> None:
    """Refuse a state whose energies at the start do not fit those at hand, since its balance then shows nothing.

    `ledger` is that of a simulation which was set to the state. Raises InputError.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        stored = [abs(energy) for energy in ledger["stored_by_law"].values()]
        saved = np.abs(np.concatenate([np.ravel(state.get(name, 0.0)) for name in ("work", "start_stored", "changes")]))
        at_hand = ledger["kinetic"] + sum(stored) + float(saved.sum())
        known = at_hand + state["swing"]
    bounds = {"swing": MOST_SWING * at_hand}
    bounds |= dict.fromkeys(("start_kinetic", "start_internal_kinetic", "start_shift"), MOST_RATIO * known)
    for name, most in bounds.items():
        if not abs(state[name]) <= most:
            raise InputError(
                f"saved state: {name} = {state[name]:.4g} J, where its other energies are {known:.4g} J; {DAMAGED}"
            )


def has_same_creases(wanted: Mesh | None, found: Mesh | None) -> bool:
    """Whether the creases of two meshes join the same nodes and fold to the same side."""
    if wanted is None or found is None:
        return False
    alike = np.array_equal(wanted.creases, found.creases)
    return alike and np.array_equal(np.sign(wanted.fold_angles), np.sign(found.fold_angles))


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
