"""Whether all that lies round the spool agrees on its size."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeAlias

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs.mesh import Finding, Mesh
from membrane_rs.scene import Scene
from membrane_rs.scene.scales import outermost, widest_spool
from membrane_rs.scene.spool import Spool

Named: TypeAlias = tuple[str, Spool]

APART = 0.05
"""Difference of radii, over the smaller, from which they are two: cords start on the rim of the spool."""


def spool(scene: Scene) -> Iterator[Finding]:
    """Laws, bodies and parts describe one spool."""
    found, rims = _spools(scene)
    for place, rim, other, round_it in _unlike(found, rims):
        yield Finding(
            "warning",
            "spool",
            1,
            f"{place} starts its cords {rim.radius:g} m from the axis, and the spool of {other} has a radius of "
            f"{round_it.radius:g} m",
            "cords start on the rim of the spool: give both the same radius (m)",
        )


def sail_round_spool(scene: Scene) -> Iterator[Finding]:
    """The spool fits into the hole of the flat sail and into the stowed one; nothing where `spool` finds two."""
    found, rims = _spools(scene)
    if scene.mesh is None or not rims or _unlike(found, rims):
        return
    place, widest = max((*found, *rims), key=lambda item: item[1].radius)
    for shape, points in (("flat", scene.mesh.reference), ("stowed", scene.mesh.positions)):
        bound = (1.0 - APART) * widest.radius
        least = _inner_radius(points, _near_axis(scene.mesh, points, bound))
        if least < bound:
            yield Finding(
                "warning",
                "spool",
                1,
                f"the {shape} sail comes as near to the axis as {least:.4g} m, inside the spool of {place}, "
                f"{widest.radius:g} m in radius",
                "make the hole of the sail wider or the spool thinner; check the units of both (m)",
            )
            if widest.radius > outermost(scene, with_cords=False):
                return


def _spools(scene: Scene) -> tuple[list[Named], list[Named]]:
    """Those of laws and bodies, too wide ones left to them, and those on whose rims cords start; with their places."""
    described = [(f"laws.{law.kind}", law.spool) for law in scene.laws]
    described += [(f"bodies.{body.name}", body.spool) for body in scene.bodies]
    spools = [(place, one) for place, one in described if one is not None]
    rims = [(f"parts[{k}]", part.spool) for k, part in enumerate(scene.parts) if part.spool is not None]
    return [(place, one) for place, one in spools if one.radius <= widest_spool(scene)], rims


def _unlike(found: list[Named], rims: list[Named]) -> list[tuple[str, Spool, str, Spool]]:
    """Rims beside spools of another radius."""
    return [
        (place, rim, other, round_it)
        for place, rim in rims
        for other, round_it in found
        if abs(rim.radius - round_it.radius) > APART * min(rim.radius, round_it.radius)
    ]


def _near_axis(mesh: Mesh, points: Floats, radius: float) -> Ints:
    """(k, 2) the edges of the mesh that may come nearer to the z axis than a radius where nodes lie at `points` [m]."""
    # A point of an edge is nearer to one of its ends than its length; that of an edge of no length may be infinite.
    with np.errstate(invalid="ignore"):  # no length times an infinite strain
        longest = float((mesh.edge_lengths * (1.0 + np.maximum(mesh.strain(), 0.0))).max())
    is_far = np.hypot(points[:, 0], points[:, 1]) > (radius + longest) * (1.0 + 1e-9)
    edges: Ints = mesh.edges[~(is_far[mesh.edges[:, 0]] & is_far[mesh.edges[:, 1]])]
    return edges


def _inner_radius(points: Floats, edges: Ints) -> float:
    """The least distance of edges (k, 2) from the z axis [m]; inf without one."""
    a = points[edges[:, 0], :2]
    d = points[edges[:, 1], :2] - a
    square = np.maximum(np.einsum("ij,ij->i", d, d), np.finfo(float).tiny)
    at = np.clip(-np.einsum("ij,ij->i", a, d) / square, 0.0, 1.0)
    nearest = a + at[:, None] * d
    return float(np.hypot(nearest[:, 0], nearest[:, 1]).min(initial=np.inf))
