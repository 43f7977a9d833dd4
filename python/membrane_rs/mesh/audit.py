"""Audit of a mesh before a run: its faults and risks."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs._validation import flags_of, show
from membrane_rs.errors import InputTypeError, MeshError
from membrane_rs.material import Material
from membrane_rs.mesh.crossings import crossings
from membrane_rs.mesh.findings import Audit, Finding, Severity, first_few
from membrane_rs.mesh.gaps import gaps
from membrane_rs.mesh.growing_modes import growing_modes
from membrane_rs.mesh.links import groups
from membrane_rs.mesh.overlaps import overlaps
from membrane_rs.mesh.queries import distinct
from membrane_rs.mesh.triangulation import NO_AREA, Triangulation

POLYIMIDE = Material(youngs_modulus=3.2e9, poisson_ratio=0.34, density=1420.0, thickness=7.5e-6)
"""The film of Okuizumi and others' deployment experiments (Table 1)."""

SLIVER = 0.05
"""Height over longest side below which a triangle is called a sliver."""
STRAIN_NOTED = 0.005
STRAIN_REFUSED = 0.1
GROWTH_LIMIT = 50_000
"""Most nodes for which growing modes are computed; it takes some seconds there."""


def audit(
    mesh: Triangulation,
    material: Material | None,
    positions: Floats,
    strain: Floats,
    *,
    springs: bool,
    growth: bool,
    crossings: bool,
    stiffness: Floats | None = None,
) -> Audit:
    """Audit a mesh at `positions` (n, 3) [m], with the `strain` of its edges there, (e,). See `Mesh.audit`."""
    if material is not None and not isinstance(material, Material):
        raise InputTypeError(f"audit: material = {show(material)}: must be a Material, or None for polyimide")
    film = material or POLYIMIDE
    springs, growth, crossings = flags_of(springs=springs, growth=growth, crossings=crossings)
    wound = _wound(mesh)
    findings = [
        *_shapes(mesh),
        *_nodes(mesh),
        *_joints(mesh, wound),
        *gaps(mesh),
        *overlaps(mesh, is_wound_alike=not len(wound)),
        *(_thick(mesh, material) if material is not None else ()),
        *(_springs(mesh, film, stiffness, growth=growth) if springs else ()),
        *(crossing(mesh, positions) if crossings else ()),
        *strained(mesh, strain),
    ]
    return Audit.of(findings)


def _shapes(mesh: Triangulation) -> Iterator[Finding]:
    """Triangles without area, slivers, and obtuse ones."""
    flatness = mesh.flatness()
    thin = np.flatnonzero(flatness < SLIVER)
    if len(thin):
        gone = np.flatnonzero(flatness < NO_AREA)
        worst = thin[np.argmin(flatness[thin])]
        yield Finding(
            "error" if len(gone) else "warning",
            "degenerate",
            len(gone) or len(thin),
            f"{len(gone)} triangles have no area and {len(thin) - len(gone)} are slivers; the height of "
            f"triangle {worst} is {flatness[worst]:.2g} of its longest side",
            "remove triangles without area; move the nodes of slivers apart, or the step becomes very small",
            first_few(gone if len(gone) else thin),
        )
    sides = [mesh.edge_lengths[edges] for edges in mesh.triangle_edges.T]
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        longest = np.maximum.reduce(sides)
        excess = 2.0 * longest**2 - np.add.reduce([side**2 for side in sides])
        others = np.multiply.reduce(sides) / longest
        may_be = np.flatnonzero(~(excess <= 2e-8 * others) & (flatness >= NO_AREA))
    a, b, c = np.sort(np.stack([side[may_be] for side in sides]), axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = np.nan_to_num((a**2 + b**2 - c**2) / (2.0 * a * b))
    angle = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
    is_obtuse = angle > 90.0 + 1e-6
    obtuse, angle = may_be[is_obtuse], angle[is_obtuse]
    if len(obtuse):
        widest = np.argmax(angle)
        yield Finding(
            "warning",
            "obtuse",
            len(obtuse),
            f"{len(obtuse)} of {len(flatness)} triangles are obtuse, at most {angle[widest]:.1f} degrees "
            f"(triangle {obtuse[widest]})",
            "the spring opposite to such an angle is weak; from about 92 degrees it can turn negative, from "
            "125 it always does: flip diagonals or move nodes",
            first_few(obtuse),
        )


def _nodes(mesh: Triangulation) -> Iterator[Finding]:
    """Nodes that nothing uses."""
    unused = np.flatnonzero(np.bincount(mesh.triangles.ravel(), minlength=mesh.node_count) == 0)
    if len(unused):
        yield Finding(
            "error",
            "unused_nodes",
            len(unused),
            f"{len(unused)} of {mesh.node_count} nodes belong to no triangle, first node {unused[0]}; they "
            "have no mass",
            "remove them: with `used = numpy.unique(triangles)` take `reference[used]` and "
            "`numpy.searchsorted(used, triangles)`, and the same for positions, creases and node sets",
            first_few(unused),
        )


def _joints(mesh: Triangulation, wound: Ints) -> Iterator[Finding]:
    """Triangles given twice, edges of three triangles, edges `wound` in opposite senses, and separate pieces."""
    again = _again(mesh)
    if len(again):
        yield Finding(
            "error",
            "duplicate_triangles",
            len(again),
            f"{len(again)} triangles are given more than once, first triangle {again.min()}",
            "remove the copies; mass and stiffness count twice there",
            first_few(np.sort(again)),
        )
    shared = np.flatnonzero(mesh.triangles_per_edge > 2)
    if len(shared):
        yield Finding(
            "warning",
            "shared_edges",
            len(shared),
            f"{len(shared)} edges belong to three or more triangles, first edge {shared[0]} "
            f"(nodes {mesh.edges[shared[0]].tolist()}, {mesh.triangles_per_edge[shared[0]]} triangles)",
            "a membrane has one or two there: remove triangles, unless a seam of several sheets is meant",
            first_few(shared),
        )
    if len(wound):
        keys = mesh.edges[wound] @ np.array([mesh.node_count, 1])
        on_creases = int(np.isin(np.sort(mesh.creases, axis=1) @ np.array([mesh.node_count, 1]), keys).sum())
        yield Finding(
            "error" if on_creases else "warning",
            "winding",
            len(wound),
            f"{len(wound)} edges lie between triangles wound in opposite senses, {on_creases} of them "
            f"creases, first edge {wound[0]} (nodes {mesh.edges[wound[0]].tolist()})",
            "reverse the order of nodes in one of the two triangles; mountain and valley depend on it",
            first_few(wound),
        )
    links = np.concatenate([mesh.edges, mesh.bridges])
    label = groups(links, mesh.node_count)
    used = distinct(mesh.triangles)
    if label[used].min() < label[used].max():
        names, starts = np.unique(label[used], return_index=True)
        yield Finding(
            "warning",
            "pieces",
            len(names),
            f"the mesh is in {len(names)} separate pieces, the second one from node {used[np.sort(starts)[1]]}",
            "merge the nodes of their seams or add bridges, if they should hold together",
            first_few(used[np.sort(starts)]),
        )


def _again(mesh: Triangulation) -> Ints:
    """Triangles with the nodes of an earlier one."""
    # Two sides of a triangle tell all its nodes.
    a, b, c = mesh.triangle_edges.T
    sides = np.minimum(np.minimum(a, b), c) * len(mesh.edges) + np.maximum(np.maximum(a, b), c)
    ordered = np.sort(sides)
    if (ordered[1:] != ordered[:-1]).all():
        return np.zeros(0, np.int64)
    order = np.argsort(sides, kind="stable")
    again: Ints = order[1:][sides[order[1:]] == sides[order[:-1]]]
    return again


def _wound(mesh: Triangulation) -> Ints:
    """Edges between two triangles wound in opposite senses."""
    a, b, c = mesh.triangles.T
    is_upward = np.stack([b < c, c < a, a < b], axis=1)
    upward = np.bincount(mesh.triangle_edges[is_upward], minlength=len(mesh.edges))
    return np.flatnonzero((mesh.triangles_per_edge == 2) & (upward != 1))


def _thick(mesh: Triangulation, material: Material) -> Iterator[Finding]:
    """Edges shorter than the film is thick: there it is a block, not a film."""
    short = np.flatnonzero(mesh.edge_lengths < material.thickness)
    if len(short):
        least = short[np.argmin(mesh.edge_lengths[short])]
        yield Finding(
            "warning",
            "thick_film",
            len(short),
            f"{len(short)} of {len(mesh.edges)} edges are shorter than the film is thick, {material.thickness:g} m, "
            f"down to {mesh.edge_lengths[least]:.3g} m (edge {least}, nodes {mesh.edges[least].tolist()})",
            "check the units of thickness and mesh (m), or make the mesh coarser",
            first_few(short),
        )


def _negative(mesh: Triangulation, material: Material, stiffness: Floats | None) -> tuple[Ints, Floats]:
    """Edges of negative spring constant, none in a mesh with triangles without area, and all constants [N/m]."""
    if mesh.flatness().min() < NO_AREA:
        return np.zeros(0, np.int64), np.zeros(0)
    constants = mesh.spring_constants(material, stiffness=stiffness)
    return np.flatnonzero(~(constants >= -1e-12 * np.nanmax(np.abs(constants)))), constants


def _springs(mesh: Triangulation, material: Material, stiffness: Floats | None, *, growth: bool) -> Iterator[Finding]:
    """Negative spring constants, and with `growth` the modes that grow by them."""
    try:
        negative, constants = _negative(mesh, material, stiffness)
    except MeshError as error:
        yield Finding("error", "singular_springs", 1, str(error), "move the nodes of that triangle")
        return
    if not len(negative):
        return
    worst = negative[np.argmin(constants[negative])]
    boundary = int((mesh.triangles_per_edge[negative] == 1).sum())
    yield Finding(
        "error",
        "negative_springs",
        len(negative),
        f"{len(negative)} of {len(constants)} springs have a negative constant at nu = "
        f"{material.poisson_ratio:g}, "
        f"{boundary} of them on the boundary, down to {constants[worst]:.4g} N/m (edge {worst}, nodes "
        f"{mesh.edges[worst].tolist()})",
        "they come from obtuse triangles: use a mesh without those; clipping them to zero makes it too soft",
        first_few(negative),
    )
    if growth:
        yield from _growing(mesh, constants, mesh.masses(material))


def growing(
    mesh: Triangulation, material: Material, stiffness: Floats | None = None, masses: Floats | None = None
) -> Iterator[Finding]:
    """The modes that grow by negative spring constants; it takes some seconds for 50,000 nodes. E h of each triangle
    (m,) [N/m] and masses of the nodes (n,) [kg] stand in place of those of the material.
    """
    try:
        negative, constants = _negative(mesh, material, stiffness)
    except MeshError:
        return
    if len(negative):
        yield from _growing(mesh, constants, mesh.masses(material) if masses is None else masses)


def _growing(mesh: Triangulation, constants: Floats, of_nodes: Floats) -> Iterator[Finding]:
    """The modes that grow by spring constants (e,), some of them negative [N/m], with masses (n,) [kg]."""
    if mesh.node_count > GROWTH_LIMIT:
        yield Finding(
            "info",
            "growing_mode",
            0,
            f"not looked for: {mesh.node_count} nodes are more than {GROWTH_LIMIT}",
            "audit a coarser mesh of the same kind",
        )
        return
    # Bridged nodes count as one: the stiff links hardly give.
    node = groups(mesh.bridges, mesh.node_count)
    masses = np.bincount(node, weights=of_nodes).astype(np.float64)
    points = np.empty((len(masses), 3))
    points[node] = mesh.reference
    rate, count = growing_modes(points, node[mesh.edges], constants, masses)
    if count:
        modes = "mode of the unfolded membrane grows" if count == 1 else "modes of the unfolded membrane grow"
        yield Finding(
            "error",
            "growing_mode",
            count,
            f"{count} {modes} without a load, the fastest by a factor of e in {1e3 / rate:.3g} ms",
            "no step is small enough for that: remove the negative springs",
        )


def crossing(mesh: Triangulation, positions: Floats) -> Iterator[Finding]:
    """Triangles that pass through each other at `positions` (n, 3) [m]; some 0.1 s per million pairs of near ones."""
    found = crossings(mesh.triangles, positions, 10)
    if found.count:
        first, second = found.pairs[0]
        x, y, z = positions[mesh.triangles[first, 0]]
        yield Finding(
            "warning",
            "crossings",
            found.count,
            f"{found.count} pairs of triangles pass through each other at the start, first triangles {first} and "
            f"{second} (nodes {mesh.triangles[first].tolist()} and {mesh.triangles[second].tolist()}) near "
            f"({x:.4g}, {y:.4g}, {z:.4g}) m",
            "layers that do not feel each other run all the same, from a shape that no real film can have: move layers "
            "apart, or take another layout",
            first_few(found.pairs[:, 0]),
        )


def strained(mesh: Triangulation, strain: Floats, words: str = "strain at the start") -> Iterator[Finding]:
    """The strain of the edges at the start, (e,), which `words` call."""
    low, high = float(strain.min()), float(strain.max())
    most = int(np.argmax(np.abs(strain)))
    large = np.flatnonzero(np.abs(strain) > STRAIN_NOTED)
    severity: Severity = "error" if high > STRAIN_REFUSED else "warning" if len(large) else "info"
    yield Finding(
        severity,
        "strain",
        len(large),
        f"{words} from {100 * low:.4g} % to {100 * high:.4g} %; {len(large)} of {len(strain)} "
        f"edges beyond {100 * STRAIN_NOTED:g} % (most at edge {most}, nodes {mesh.edges[most].tolist()})",
        "" if severity == "info" else "check the folded positions, or relax the membrane before its release",
        first_few(large),
    )
