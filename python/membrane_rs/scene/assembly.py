"""From a scene to plain arrays: the nodes, masses and cords that the core is given.

Nodes of the membrane come first, in the order of the mesh; nodes of the cords follow, cord after cord.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs._validation import nearest, show
from membrane_rs.errors import InputError, SceneError
from membrane_rs.mesh import Mesh
from membrane_rs.scene.cords import cord_positions
from membrane_rs.scene.laws import Law, SpoolContact
from membrane_rs.scene.parts import Bridges, Fixed, Part, Tether, Tethers, TipMasses

MOST_CORD_NODES = 10**7
"""More nodes than this in the cords of a scene would not fit into memory."""


@dataclass(frozen=True, eq=False)
class Assembly:
    """A scene as read-only arrays; N nodes, s cord segments, c creases, b bridges."""

    node_count: int
    """N, of the membrane and of the cords."""
    reference: Floats
    """(N, 3) the flat shape, cords straight [m]."""
    positions: Floats
    """(N, 3) the shape at the start [m]."""
    triangles: Ints
    """(m, 3) nodes of each triangle."""
    creases: Ints
    """(c, 2) nodes of each crease."""
    fold_signs: Floats
    """(c,) +1 for a valley or a flat crease, -1 for a mountain."""
    extra_masses: Floats
    """(N,) what tip masses and cords add to each node [kg]."""
    fixed: Ints
    """(k,) nodes held at rest, ascending."""
    cord_pairs: Ints
    """(s, 2) nodes of each cord segment."""
    cord_stiffness: Floats
    """(s,) EA / l [N/m]."""
    cord_rest_length: Floats
    """(s,) l [m]."""
    cord_strain_limit: Floats
    """(s,) strain at which a run stops."""
    bridges: Ints
    """(b, 2) node pairs joined by a link of no length."""
    bridge_stiffness: float
    """Of each such link [N/m]; 0 without links."""
    contact_nodes: Ints
    """Nodes that the spool keeps outside, ascending; empty without that law."""
    node_sets: Mapping[str, Ints]
    """The mesh's node sets and the cords' own."""

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        for item in fields(self):
            value = getattr(self, item.name)
            if isinstance(value, np.ndarray):
                value.setflags(write=False)


@dataclass
class _Cord:
    """One cord: its nodes; of its segments rest length [m], EA [N], mass per length [kg/m], strain limit."""

    nodes: Ints
    rest_length: float
    axial_stiffness: float
    linear_density: float
    strain_limit: float


class _Builder:
    """Grows the arrays part by part."""

    def __init__(self, mesh: Mesh | None) -> None:
        self.mesh = mesh
        self.reference = [np.zeros((0, 3)) if mesh is None else np.asarray(mesh.reference)]
        self.positions = [np.zeros((0, 3)) if mesh is None else np.asarray(mesh.positions)]
        self.node_sets: dict[str, Ints] = {}
        if mesh is not None:
            self.node_sets = {name: np.array(nodes, np.int64) for name, nodes in mesh.node_sets.items()}
        self.mesh_count = self.node_count = len(self.reference[0])
        self.cords: list[_Cord] = []
        self.fixed: list[int] = []
        self.added: list[tuple[Ints, float]] = []

    def nodes(self, wanted: str | Sequence[int], where: str, limit: int) -> Ints:
        """Node indices from a set's name or from themselves, all below `limit`."""
        if isinstance(wanted, str):
            if wanted not in self.node_sets:
                hint = nearest(wanted, self.node_sets) if self.node_sets else "this scene has none"
                raise SceneError(f"{where}.nodes = {wanted!r}: no such node set; {hint}")
            found = self.node_sets[wanted]
        else:
            found = np.array(wanted, np.int64)
        if found.size and found.max() >= limit:
            allowed = f"from 0 to {limit - 1}" if limit else "none, for there is no mesh"
            raise SceneError(f"{where}.nodes = {show(wanted)}: node {found.max()} is not there; must be {allowed}")
        return found

    def check_room(self, where: str, segments: int, new_nodes: int) -> None:
        """Refuse cords too fine to be held in memory, before anything is allocated."""
        total = self.node_count - self.mesh_count + new_nodes
        if total > MOST_CORD_NODES:
            raise SceneError(
                f"{where}.segments = {segments}: makes {total} cord nodes in this scene; "
                f"must be at most {MOST_CORD_NODES}; take fewer segments"
            )

    def add_cord(self, cord: _Cord, reference: Floats, positions: Floats) -> None:
        """Append a cord's own nodes; `cord.nodes` already counts them."""
        name = f"tether-{len(self.cords)}"
        sets = {name: cord.nodes, f"{name}-start": cord.nodes[:1], f"{name}-end": cord.nodes[-1:]}
        for key, value in sets.items():
            if key in self.node_sets:
                raise SceneError(f"mesh.node_sets: the name {key!r} is taken by a tether; rename the set")
            self.node_sets[key] = value
        self.reference.append(reference)
        self.positions.append(positions)
        self.node_count += len(reference)
        self.cords.append(cord)

    def add_tethers(self, part: Tethers, where: str) -> None:
        flat, stowed = self.reference[0], self.positions[0]
        held = self.nodes(part.nodes, where, self.mesh_count)
        self.check_room(where, part.segments, len(held) * part.segments)
        for node in held:
            radius = float(np.hypot(flat[node, 0], flat[node, 1]))
            if radius == 0:
                raise SceneError(f"{where}.nodes: node {node} lies on the axis, so its tether has no azimuth")
            anchor = np.array([*(flat[node, :2] * (part.anchor_radius / radius)), 0.0])
            length = part.length or float(np.linalg.norm(flat[node] - anchor))
            if length == 0:
                raise SceneError(f"{where}.anchor_radius = {part.anchor_radius}: node {node} lies on the rim")
            first = self.node_count
            nodes = np.append(np.arange(first, first + part.segments), node)
            straight = np.linspace(anchor, flat[node], part.segments + 1)
            try:
                shape = cord_positions(anchor, stowed[node], length, part.segments)
            except InputError as error:
                raise SceneError(f"{where}.segments = {part.segments}: {error}") from None
            rest = length / part.segments
            cord = _Cord(nodes, rest, part.axial_stiffness, part.linear_density, part.strain_limit)
            self.add_cord(cord, straight[:-1], shape[:-1])
            self.fixed.append(first)

    def add_tether(self, part: Tether, where: str) -> None:
        self.check_room(where, part.segments, part.segments + 1)
        start, end = np.array(part.start), np.array(part.end)
        length = part.length or float(np.linalg.norm(end - start))
        first = self.node_count
        nodes = np.arange(first, first + part.segments + 1)
        try:
            shape = cord_positions(start, end, length, part.segments)
        except InputError as error:
            raise SceneError(f"{where}.segments = {part.segments}: {error}") from None
        rest = length / part.segments
        self.add_cord(
            _Cord(nodes, rest, part.axial_stiffness, part.linear_density, part.strain_limit),
            np.linspace(start, end, part.segments + 1),
            shape,
        )
        if part.fixed:
            self.fixed.append(first)
        self.added.append((nodes[-1:], part.tip_mass))

    def extra_masses(self) -> Floats:
        masses = np.zeros(self.node_count)
        for cord in self.cords:
            half = 0.5 * cord.linear_density * cord.rest_length
            masses[cord.nodes[:-1]] += half
            masses[cord.nodes[1:]] += half
        for nodes, mass in self.added:
            masses[nodes] += mass
        return masses


def _of_kind(parts: Sequence[Part]) -> Iterator[tuple[str, Part]]:
    return ((f"parts[{i}]", part) for i, part in enumerate(parts))


def assemble(mesh: Mesh | None, laws: Sequence[Law], parts: Sequence[Part]) -> Assembly:
    """Turn mesh, laws and parts into the core's arrays.

    Raises
    ------
    SceneError
        A node set or node that is not there, a node without mass, bridges without their stiffness, cords of too
        many nodes.
    """
    builder = _Builder(mesh)
    bridges = np.zeros((0, 2), np.int64) if mesh is None else np.array(mesh.bridges, np.int64)
    stiffness = 0.0
    for where, part in _of_kind(parts):
        if isinstance(part, Tethers):
            builder.add_tethers(part, where)
        elif isinstance(part, Tether):
            builder.add_tether(part, where)
        elif isinstance(part, Bridges):
            if stiffness:
                raise SceneError(f"{where}: a scene holds one part of kind 'bridges'")
            stiffness = part.stiffness
    for where, part in _of_kind(parts):  # these may name nodes of cords that come later in the list
        if isinstance(part, TipMasses):
            builder.added.append((builder.nodes(part.nodes, where, builder.node_count), part.mass))
        elif isinstance(part, Fixed):
            builder.fixed.extend(builder.nodes(part.nodes, where, builder.node_count).tolist())
    if bool(len(bridges)) != bool(stiffness):
        state = f"has {len(bridges)} bridges" if len(bridges) else "has no bridges"
        cure = "add a part of kind 'bridges' with their stiffness" if len(bridges) else "leave that part out"
        raise SceneError(f"parts: the mesh {state}; {cure}")

    triangles = np.zeros((0, 3), np.int64) if mesh is None else np.array(mesh.triangles, np.int64)
    creases = np.zeros((0, 2), np.int64) if mesh is None else np.array(mesh.creases, np.int64)
    angles = np.zeros(0) if mesh is None else np.asarray(mesh.fold_angles)
    assembly = Assembly(
        node_count=builder.node_count,
        reference=np.vstack(builder.reference),
        positions=np.vstack(builder.positions),
        triangles=triangles,
        creases=creases,
        fold_signs=np.where(angles < 0, -1.0, 1.0),
        extra_masses=builder.extra_masses(),
        fixed=np.unique(np.array(builder.fixed, np.int64)),
        bridges=bridges,
        bridge_stiffness=stiffness,
        contact_nodes=_contact_nodes(builder, laws),
        node_sets=builder.node_sets,
        **_segments(builder.cords),
    )
    _check_masses(assembly)
    return assembly


def _segments(cords: Sequence[_Cord]) -> dict[str, Any]:
    """The cords' segments, one after the other."""
    counts = [len(cord.nodes) - 1 for cord in cords]
    pairs = [np.column_stack([cord.nodes[:-1], cord.nodes[1:]]) for cord in cords]
    rest = np.repeat([cord.rest_length for cord in cords], counts)
    return {
        "cord_pairs": np.vstack([np.zeros((0, 2), np.int64), *pairs]),
        "cord_stiffness": np.repeat([cord.axial_stiffness for cord in cords], counts) / rest,
        "cord_rest_length": rest,
        "cord_strain_limit": np.repeat([cord.strain_limit for cord in cords], counts),
    }


def _contact_nodes(builder: _Builder, laws: Sequence[Law]) -> Ints:
    contact = next((law for law in laws if isinstance(law, SpoolContact)), None)
    if contact is None:
        return np.zeros(0, np.int64)
    nodes = [cord.nodes for cord in builder.cords]
    if contact.membrane:
        nodes.append(np.arange(builder.mesh_count))
    touched = np.unique(np.concatenate([np.zeros(0, np.int64), *nodes]))
    return np.setdiff1d(touched, builder.fixed)


def _check_masses(assembly: Assembly) -> None:
    """Every node that can move needs a mass."""
    bare = assembly.extra_masses <= 0
    bare[assembly.triangles.ravel()] = False
    bare[assembly.fixed] = False
    if bare.any():
        node = int(np.flatnonzero(bare)[0])
        raise SceneError(
            f"node {node} has no mass ({int(bare.sum())} such nodes): give its tether a linear_density, "
            "add a tip mass, hold it fixed, or remove it from the mesh"
        )
