"""Contact with the spool: segments that sink into it between their nodes, and nodes that start inside it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs.mesh import Finding
from membrane_rs.scene import Scene
from membrane_rs.scene.scales import widest_spool

SAG_SHARE = 0.01
"""Depth to which a segment may sink between its nodes, as a share of the spool's radius, before a scene is warned of.

A segment of length l between two nodes on the surface sinks R - sqrt(R^2 - l^2/4), about l^2 / (8 R).
"""

ROUNDING = 1e-9
"""Depth by rounding, as a share of the spool's radius."""


def chord_sag(scene: Scene) -> Iterator[Finding]:
    """Segments that may sink deep into the spool between their nodes, where only nodes have contact.

    Of all cord segments and edges of the membrane between two nodes that have contact, or of which one is held, the
    longest without load counts. Nothing: at most `SAG_SHARE` of the spool's radius, or no node can meet the spool.
    Edges of a membrane that feels a body by its nodes are reported as a fact: that was chosen.
    """
    assembly = scene.assemble()
    cords = assembly.cords.nodes, assembly.cords.rest_length
    edges = (np.zeros((0, 2), np.int64), np.zeros(0))
    if scene.mesh is not None:
        edges = scene.mesh.edges, scene.mesh.edge_lengths
    law, spool = next(((law, law.spool) for law in scene.laws if law.spool is not None), (None, None))
    if law is not None and spool is not None and law.why_idle(scene) is None:
        both = np.concatenate([cords[0], edges[0]]), np.concatenate([cords[1], edges[1]])
        yield from _sag(spool.radius, assembly.contacts.nodes, assembly.fixed, *both)
    for body in scene.bodies:
        if body.spool is not None and body.is_felt_by_nodes:
            if body.cords:
                yield from _sag(body.spool.radius, np.unique(cords[0]), assembly.fixed, *cords)
            if body.membrane:
                found = _sag(body.spool.radius, np.unique(edges[0]), assembly.fixed, *edges)
                yield from (replace(finding, severity="info") for finding in found)


def _sag(radius: float, touching: Ints, fixed: Ints, pairs: Ints, lengths: Floats) -> Iterator[Finding]:
    """Of segments between nodes that touch a spool."""
    count = int(max(touching.max(initial=-1), fixed.max(initial=-1), pairs.max(initial=-1))) + 1
    touches, held = np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.bool_)
    touches[touching], held[fixed] = True, True
    touches &= ~held
    a, b = pairs.T
    near = (touches[a] & (touches | held)[b]) | (held[a] & touches[b])
    if not near.any():
        return
    longest = float(lengths[near].max())
    sag = radius - float(np.sqrt(max(radius**2 - longest**2 / 4.0, 0.0)))
    if sag <= SAG_SHARE * radius:
        return
    enough = 2.0 * radius * float(np.sqrt(2.0 * SAG_SHARE - SAG_SHARE**2))
    yield Finding(
        "warning",
        "chord_sag",
        int((near & (lengths > enough)).sum()),
        f"segments of {longest:.4g} m may sink {sag:.3g} m into the spool of radius {radius:g} m between their nodes, "
        "which alone have contact",
        f"take more segments, of {enough:.3g} m or less, to stay below {SAG_SHARE:.0%} of the radius",
    )


def start_inside(scene: Scene) -> Iterator[Finding]:
    """Nodes with contact that start inside the spool: the contact throws them out.

    A spool that is wider than the whole flat scene is left to `law_and_part_values`.
    """
    spool = next((law.spool for law in scene.laws if law.spool is not None), None)
    if spool is None or spool.radius > widest_spool(scene):
        return
    assembly = scene.assemble()
    nodes = assembly.contacts.nodes
    x, y, z = assembly.positions[nodes].T
    depths = spool.radius - np.hypot(x, y)
    if spool.half_height is not None:
        depths = np.minimum(depths, spool.half_height - np.abs(z))
    inside = depths > ROUNDING * spool.radius
    if not inside.any():
        return
    deepest = int(np.argmax(depths))
    yield Finding(
        "warning",
        "start_inside",
        int(inside.sum()),
        f"{int(inside.sum())} nodes start inside the spool of radius {spool.radius:g} m, node {nodes[deepest]} deepest "
        f"by {depths[deepest]:.3g} m, and are thrown out at the start",
        "move them outside, or hold them fixed",
        tuple(nodes[inside][:10].tolist()),
    )
