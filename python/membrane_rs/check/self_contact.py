"""Layers that cannot pass through each other: whether they do so at the start, and what such a law does not go with."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from membrane_rs._arrays import Ints
from membrane_rs.mesh import Finding, Mesh
from membrane_rs.mesh.crossings import Crossings
from membrane_rs.mesh.crossings import crossings as counted
from membrane_rs.mesh.findings import first_few
from membrane_rs.mesh.links import groups
from membrane_rs.scene import Scene
from membrane_rs.scene.hub import hub_of

LEAVE_OUT = "leave triangles out of the law that they feel each other by, by its `without` or `only`"
NAMED = 5
"""Pairs, at most, that a message names."""


def crossings_of_layers(scene: Scene, limit: int) -> Crossings | None:
    """Crossings at the start of the triangles that feel each other, numbered among these; None where none do."""
    mesh, layers = scene.mesh, scene.assemble().layers
    return (
        counted(mesh.triangles[layers.triangles], mesh.positions, limit) if mesh is not None and len(layers) else None
    )


def crossing_layers(scene: Scene) -> Iterator[Finding]:
    """Layers that feel each other and pass through each other at the start, from which no run begins."""
    mesh, found = scene.mesh, crossings_of_layers(scene, 2 * NAMED)
    if mesh is None or found is None or not found.count:
        return
    pairs = scene.assemble().layers.triangles[found.pairs]
    x, y, z = mesh.positions[mesh.triangles[pairs[0, 0], 0]]
    named = ", ".join(f"{first} and {second}" for first, second in pairs[:NAMED].tolist())
    yield Finding(
        "error",
        "crossings",
        found.count,
        f"{found.count} pairs of triangles that feel each other pass through each other at the start, first triangles "
        f"{named} near ({x:.4g}, {y:.4g}, {z:.4g}) m",
        f"move layers apart, or {LEAVE_OUT}",
        first_few(pairs[:, 0]),
    )


def touching_layers(scene: Scene) -> Iterator[Finding]:
    """Layers that feel each other and touch at the start: on which side of each other they lie, nobody knows. Triangles
    that bridges of no length join are neighbours.
    """
    mesh, layers = scene.mesh, scene.assemble().layers
    if mesh is None or not len(layers):
        return
    joined = _joined(mesh)
    first = np.unique(joined, return_index=True)[1]
    found = counted(joined[mesh.triangles[layers.triangles]], mesh.positions[first], 0)
    count = found.overlapping + found.touching
    if count:
        yield Finding(
            "error",
            "touching_layers",
            count,
            f"{count} pairs of triangles that feel each other have no distance at the start: {found.overlapping} "
            f"lie in one plane on each other, {found.touching} touch",
            f"move layers apart, by a share of the film's thickness at least, or {LEAVE_OUT}",
        )


def laws_beside_free_hub(scene: Scene) -> Iterator[Finding]:
    """Laws that do not go with a free hub, which the scene has."""
    hub = hub_of(scene)
    if hub is None or hub.inertia is None:
        return
    for law in scene.laws:
        if not law.goes_with_free_hub:
            yield Finding(
                "error",
                "free_hub",
                1,
                f"laws.{law.kind}: does not go with a free hub",
                f"leave {law.kind} out, or drive the hub: leave its inertia out",
            )


def _joined(mesh: Mesh) -> Ints:
    """(n,) for each node the number of the point that it is with others, by bridges of no length."""
    ends = mesh.positions[mesh.bridges]
    return groups(np.asarray(mesh.bridges)[(ends[:, 0] == ends[:, 1]).all(axis=1)], mesh.node_count)
