"""What is wrong with the mesh of a scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterable, Iterator
from weakref import WeakKeyDictionary

import numpy as np

from membrane_rs.check.self_contact import crossings_of_layers
from membrane_rs.mesh import Mesh
from membrane_rs.mesh.audit import crossing, growing, strained
from membrane_rs.mesh.findings import Finding, first_few
from membrane_rs.mesh.fold_angles import measured_fold_angles, taken_as_sides
from membrane_rs.scene import Scene
from membrane_rs.scene.scales import film_masses, natural_lengths

FEW_NODES = 1000
"""Up to which growing modes cost about as much as the other checks of the mesh."""
FEW_TRIANGLES = 5000
"""Up to which crossings cost so; where all triangles lie at one place, 12 million pairs, they take some seconds."""

STRAIN = "strain"
"""The finding that depends on the shape at the start."""

_FOUND: WeakKeyDictionary[Mesh, dict[Hashable, tuple[Finding, ...]]] = WeakKeyDictionary()
"""What was found in meshes that are still there, which never change: the stages of a scene share theirs."""


def mesh_faults(scene: Scene) -> Iterator[Finding]:
    """What `Mesh.audit` finds; growing modes, crossings and the strain at the start are left out."""
    yield from (finding for finding in _audit_of_mesh(scene) if finding.kind != STRAIN)


def start_strain(scene: Scene) -> Iterator[Finding]:
    """The strain at the start, where `Mesh.audit` finds it large; with regions of a natural strain, that beyond it."""
    mesh = scene.mesh
    if mesh is None or not any(any(region.natural_strain) for region in scene.assemble().regions):
        yield from (finding for finding in _audit_of_mesh(scene) if finding.kind == STRAIN)
        return
    strain = mesh.lengths_in(mesh.positions) / natural_lengths(scene, mesh) - 1.0
    yield from strained(mesh, strain, "strain at the start, beyond the natural strain,")


def _audit_of_mesh(scene: Scene) -> tuple[Finding, ...]:
    mesh, material, springs = scene.mesh, scene.material, _has_springs(scene)
    if mesh is None:
        return ()
    has_own = material is not None and (material.softening is not None or scene.assemble().regions)
    stiffness = scene.membrane_stiffness() if springs and has_own else None
    key = "faults", material, springs, None if stiffness is None else stiffness.tobytes()
    options = {"springs": springs, "growth": False, "crossings": False}
    return _once(mesh, key, lambda: mesh.audit(material, stiffness=stiffness, **options).findings)


def crossings(scene: Scene) -> Iterator[Finding]:
    """Triangles that pass through each other at the start, in meshes of up to `FEW_TRIANGLES`. Those that feel each
    other are left to `crossing_layers`.
    """
    yield from _crossings(scene, 0, FEW_TRIANGLES)


def crossings_of_large_meshes(scene: Scene) -> Iterator[Finding]:
    """The same in larger meshes."""
    yield from _crossings(scene, FEW_TRIANGLES, math.inf)


def _crossings(scene: Scene, fewer: float, most: float) -> Iterator[Finding]:
    """Those of a mesh with more triangles than `fewer` and no more than `most`."""
    mesh = scene.mesh
    if mesh is None or not fewer < len(mesh.triangles) <= most:
        return
    for finding in _once(mesh, "crossings", lambda: crossing(mesh, mesh.positions)):
        of_layers = crossings_of_layers(scene, 0)
        if of_layers is None or of_layers.count < finding.count:
            yield finding


def fold_angles(scene: Scene) -> Iterator[Finding]:
    """Fold angles of creases that are flat in positions: their sign is taken as the side, and nothing else."""
    mesh = scene.mesh
    if mesh is None or not len(mesh.creases):
        return
    found = taken_as_sides(mesh, mesh.positions, mesh.fold_angles)
    if len(found):
        k, angle = found[0], float(np.degrees(measured_fold_angles(mesh, mesh.positions)[found[0]]))
        yield Finding(
            "warning",
            "fold_angles",
            len(found),
            f"fold_angles[{k}] = {mesh.fold_angles[k]:.4g} rad ({np.degrees(mesh.fold_angles[k]):.4g} degrees), but "
            f"creases[{k}] is folded by {abs(angle):.4g} degrees in positions ({len(found)} such creases): the "
            "simulation starts from positions, and takes only the side of the fold from the angle",
            "give positions that are folded so; the angle towards which a crease turns is Creases.natural_angle; for a "
            "side alone give pi (valley) or -pi (mountain)",
            first_few(found),
        )


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
        masses = film_masses(scene, scene.mesh, scene.material)
        yield from growing(scene.mesh, scene.material, scene.membrane_stiffness(), masses)


def _once(mesh: Mesh, key: Hashable, find: Callable[[], Iterable[Finding]]) -> tuple[Finding, ...]:
    """What a check finds in a mesh, looked for once for each `key` of all else that it depends on."""
    known = _FOUND.setdefault(mesh, {})
    if key not in known:
        known[key] = tuple(find())
    return known[key]


def _has_springs(scene: Scene) -> bool:
    return scene.negative_springs != "unused"
