"""Arrays of a scene, grown part by part.

Parts add nodes, cords and links first, then masses and supports; laws name what they act on at the end.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs._bounds import check_nodes
from membrane_rs._validation import nearest, show
from membrane_rs.errors import InputError, SceneError
from membrane_rs.material import Material
from membrane_rs.mesh import Mesh
from membrane_rs.scene.assembly import Assembly
from membrane_rs.scene.components import ContactSet, Cords, Creases, FilmRegion, Layers, Links, Motion
from membrane_rs.scene.cord import Cord
from membrane_rs.scene.cords import cord_along, cord_positions, cord_round_axis
from membrane_rs.scene.selection import groups_of


class Builder:
    """A scene's arrays while they grow.

    Attributes
    ----------
    mesh : Mesh or None
        The membrane.
    material : Material or None
        What it is made of.
    reference, positions : (n, 3) float
        Of the membrane alone: flat, and at the start [m].
    mesh_count, node_count : int
        Nodes of the membrane; nodes so far.
    node_sets : dict of str to (k,) int
        Those of the mesh, and those of the cords so far.
    """

    def __init__(self, mesh: Mesh | None, material: Material | None) -> None:
        self.mesh, self.material = mesh, material
        self.reference: Floats = np.zeros((0, 3)) if mesh is None else np.asarray(mesh.reference)
        self.positions: Floats = np.zeros((0, 3)) if mesh is None else np.asarray(mesh.positions)
        self.node_sets: dict[str, Ints] = {}
        if mesh is not None:
            self.node_sets = {name: np.array(nodes, np.int64) for name, nodes in mesh.node_sets.items()}
        self.mesh_count = self.node_count = len(self.reference)
        self._reference, self._positions = [self.reference], [self.positions]
        self._cords: list[tuple[Cord, Ints]] = []
        self._cord_places: list[str] = []
        self._fixed: list[int] = []
        self._motions: list[tuple[Motion, str]] = []
        self._masses: list[tuple[Ints, float]] = []
        self._contacts: list[Ints] = []
        self._layers: Ints = np.zeros(0, np.int64)
        self._loaded: Ints = np.zeros(0, np.int64)
        self._bridge_stiffness = 0.0
        self._regions: list[FilmRegion] = []
        self._owners: Ints = np.zeros(0 if mesh is None else len(mesh.triangles), np.int64)
        self._creases: dict[str, Floats] = {}
        self._crease_places: dict[str, list[tuple[str, Ints]]] = {}

    def nodes(self, wanted: str | Sequence[int], where: str, *, of_mesh: bool = False, field: str = "nodes") -> Ints:
        """Node indices from a set's name or from themselves, of the whole scene so far or of the mesh alone; `field` of
        the part or law at `where` names them.

        Raises
        ------
        SceneError
            A node set or a node that is not there.
        """
        limit = self.mesh_count if of_mesh else self.node_count
        if isinstance(wanted, str):
            if wanted not in self.node_sets:
                hint = nearest(wanted, self.node_sets) if self.node_sets else "this scene has none"
                raise SceneError(f"{where}.{field} = {show(wanted)}: no such node set; {hint}")
            found = self.node_sets[wanted]
        else:
            found = np.array(wanted, np.int64)
        if found.size and found.max() >= limit:
            allowed = f"from 0 to {limit - 1}" if limit else "none, for there is no mesh"
            raise SceneError(f"{where}.{field} = {show(wanted)}: node {found.max()} is not there; must be {allowed}")
        return found

    def triangles(self, wanted: str | Sequence[str] | Sequence[int], where: str, field: str) -> Ints:
        """Triangles whose nodes all belong to one of some node sets, or to the nodes of these indices; ascending.

        Raises
        ------
        SceneError
            A node set or a node that is not there.
        """
        triangles = np.zeros((0, 3), np.int64) if self.mesh is None else self.mesh.triangles
        return self.elements_inside(triangles, wanted, where, field)

    def elements_inside(
        self, elements: Ints, wanted: str | Sequence[str] | Sequence[int], where: str, field: str
    ) -> Ints:
        """Rows of elements (m, k) whose nodes all belong to one of some node sets of the mesh, or to the nodes of these
        indices; ascending.

        Raises
        ------
        SceneError
            A node set or a node that is not there.
        """
        found: Ints = np.zeros(0, np.int64)
        for group in groups_of(wanted):
            nodes = self.nodes(group, where, of_mesh=True, field=field)
            found = np.union1d(found, np.flatnonzero(np.isin(elements, nodes).all(axis=1)))
        return found

    def triangles_of_sets(self, wanted: str | Sequence[str] | Sequence[int], where: str, field: str) -> Ints:
        """Triangles of some triangle sets of the mesh, or of these indices; ascending.

        Raises
        ------
        SceneError
            A triangle set or a triangle that is not there.
        """
        count = 0 if self.mesh is None else len(self.mesh.triangles)
        sets = {} if self.mesh is None else self.mesh.triangle_sets
        if count:
            sets = {"all": np.arange(count), **sets}
        found: Ints = np.zeros(0, np.int64)
        for group in groups_of(wanted):
            if isinstance(group, str) and group not in sets:
                hint = nearest(group, sets) if sets else "this mesh has none"
                raise SceneError(f"{where}.{field} = {show(group)}: no such triangle set; {hint}")
            found = np.union1d(found, sets[group] if isinstance(group, str) else np.array(group, np.int64))
        if found.size and found.max() >= count:
            allowed = f"from 0 to {count - 1}" if count else "none, for there is no mesh"
            raise SceneError(f"{where}.{field}: triangle {found.max()} is not there; must be {allowed}")
        return found

    @property
    def cord_nodes(self) -> Ints:
        """Nodes of all cords so far, those that they share with the membrane among them."""
        return np.concatenate([np.zeros(0, np.int64), *(nodes for _, nodes in self._cords)])

    def check_room(self, where: str, segments: int, new_nodes: int) -> None:
        """Refuse cords too fine to be held in memory, before anything is allocated. Raises SceneError."""
        where, remedy = f"{where}.segments = {segments}", "take fewer segments"
        check_nodes(self.node_count + new_nodes, where, remedy, SceneError, "cord nodes with those of the mesh")

    def add_wound_cord(self, cord: Cord, where: str, start: Floats, *, clockwise: bool) -> Ints:
        """Append a cord that lies round the z axis from a point (3,) [m] on, as `add_cord` does with others. In the
        reference it is straight and leads outward.

        Raises
        ------
        SceneError
            Segments too long for the circle; a mesh with node sets of these names.
        """
        flat = start * (1.0 + cord.length / np.hypot(start[0], start[1]))
        flat[2] = start[2]
        try:
            positions = cord_round_axis(start, cord.length, cord.segments, clockwise=clockwise)
        except InputError as error:
            raise SceneError(f"{where}.segments = {cord.segments}: {error}") from None
        nodes = np.arange(self.node_count, self.node_count + cord.segments + 1)
        return self.append(cord, where, nodes, np.linspace(start, flat, cord.segments + 1), positions)

    def add_cord(self, cord: Cord, where: str, start: Floats, end: Floats | int, path: Floats | None = None) -> Ints:
        """Append a cord, with the node sets "tether-<k>", "tether-<k>-start" and "tether-<k>-end"; return its nodes.

        It starts at a point (3,) [m] and ends at a point, or at a node of the membrane. At the start of a run it is
        straight if taut, and else hangs below; between the two it goes by the points of a `path` in plan, (k, 2) [m].

        Raises
        ------
        SceneError
            A slack cord of one segment; a mesh with node sets of these names.
        """
        shared = isinstance(end, int)
        flat, stowed = (self.reference[end], self.positions[end]) if isinstance(end, int) else (end, end)
        count = cord.segments + (not shared)
        nodes = np.arange(self.node_count, self.node_count + count)
        if shared:
            nodes = np.append(nodes, end)
        try:
            if path is None:
                positions = cord_positions(start, stowed, cord.length, cord.segments)
            else:
                between = np.column_stack([path[:-1], np.full(len(path) - 1, start[2])])
                positions = cord_along(np.vstack([start, between, stowed]), cord.length, cord.segments)
        except InputError as error:
            raise SceneError(f"{where}.segments = {cord.segments}: {error}") from None
        return self.append(cord, where, nodes, np.linspace(start, flat, cord.segments + 1)[:count], positions[:count])

    def place_of(self, node: int) -> tuple[Floats, Floats]:
        """Where a node is in the flat shape and at the start, (3,) each [m]."""
        for reference, positions in zip(self._reference, self._positions, strict=True):
            if node < len(reference):
                return reference[node], positions[node]
            node -= len(reference)
        raise IndexError(node)

    def append(
        self,
        cord: Cord,
        where: str,
        nodes: Ints,
        reference: Floats,
        positions: Floats,
        *,
        kind: str = "tether",
        name: str | None = None,
    ) -> Ints:
        """Append a cord of these nodes, with places of those that are new; its node sets have its name, if it has one,
        in place of "<kind>-<k>".

        Raises
        ------
        SceneError
            A node set that has one of these names already.
        """
        own = name or f"{kind}-{len(self._cords)}"
        for key, value in {own: nodes, f"{own}-start": nodes[:1], f"{own}-end": nodes[-1:]}.items():
            if key in self.node_sets and name is None:
                what = f"is taken, which is that of a {kind} without a name; rename the set of the mesh or the cord"
                raise SceneError(f"{where}: the name {key!r} {what} that has it")
            if key in self.node_sets:
                raise SceneError(f"{where}.name = {name!r}: there is a node set {key!r} already; rename one of them")
            self.node_sets[key] = value
        self._reference.append(reference)
        self._positions.append(positions)
        self.node_count += len(positions)
        self._cords.append((cord, nodes))
        self._cord_places.append(where)
        return nodes

    def add_mass(self, nodes: Ints, mass: float) -> None:
        """Add a mass [kg] to each of some nodes."""
        self._masses.append((nodes, mass))

    def fix(self, nodes: Ints) -> None:
        """Fix nodes in the turning frame."""
        self._fixed.extend(nodes.tolist())

    def move(self, motion: Motion, where: str) -> None:
        """Move nodes as prescribed, also fixed ones. Raises SceneError where another part moves one of them."""
        for other, place in self._motions:
            both = np.intersect1d(motion.nodes, other.nodes)
            if both.size:
                raise SceneError(f"{where}.nodes: {place} moves node {both[0]} too; leave it out of one of them")
        self._motions.append((motion, where))
        self.fix(motion.nodes)

    def add_contacts(self, nodes: Ints) -> None:
        """Detect contact with the spool at these nodes, those that are fixed left out."""
        self._contacts.append(nodes)

    def add_layers(self, triangles: Ints) -> None:
        """Let these triangles, ascending, not pass through each other."""
        self._layers = triangles

    def load(self, nodes: Ints) -> None:
        """Let point forces act on these nodes."""
        self._loaded = np.unique(nodes)

    def add_region(self, region: FilmRegion) -> None:
        """Give triangles a film of their own. Raises SceneError where another part has given one of them its own."""
        owners = self._owners[region.triangles]
        if owners.any():
            first = int(np.flatnonzero(owners)[0])
            place, count = self._regions[owners[first] - 1].name, np.count_nonzero(owners == owners[first])
            what = f"triangle {region.triangles[first]} ({count} such) belongs to {place} too"
            raise SceneError(f"{region.name}: {what}; leave it out of one of them, or make a region of what they share")
        self._regions.append(region)
        self._owners[region.triangles] = len(self._regions)

    def set_creases(self, creases: Ints, field: str, value: float, where: str) -> None:
        """Give creases a value of their own. Raises SceneError where another part has given one of them its own."""
        for place, others in self._crease_places.setdefault(field, []):
            both = np.intersect1d(creases, others)
            if both.size:
                what = f"crease {both[0]} ({both.size} such) has one of {place} too"
                raise SceneError(f"{where}.{field} = {value:g}: {what}; leave it out of one of them")
        self._crease_places[field].append((where, creases))
        count = 0 if self.mesh is None else len(self.mesh.creases)
        self._creases.setdefault(field, np.full(count, np.nan))[creases] = value

    def link_bridges(self, stiffness: float, where: str) -> None:
        """Give the links of the mesh their stiffness [N/m]. Raises SceneError where they have one already."""
        if self._bridge_stiffness:
            raise SceneError(f"{where}: a scene holds one part of kind 'bridges'")
        self._bridge_stiffness = stiffness

    def check_links(self) -> None:
        """Refuse links without stiffness, and a stiffness without links. Raises SceneError."""
        count = 0 if self.mesh is None else len(self.mesh.bridges)
        if bool(count) != bool(self._bridge_stiffness):
            state = f"has {count} bridges" if count else "has no bridges"
            remedy = "add a part of kind 'bridges' with their stiffness" if count else "leave that part out"
            raise SceneError(f"parts: the mesh {state}; {remedy}")

    def assembly(self) -> Assembly:
        """The arrays as they are now.

        Raises
        ------
        SceneError
            A node that can move and has no mass.
        """
        mesh = self.mesh
        none = np.zeros((0, 2), np.int64)
        angles = np.zeros(0) if mesh is None else np.asarray(mesh.fold_angles)
        unset = np.full(len(angles) if self._creases else 0, np.nan)
        touched = np.unique(np.concatenate([np.zeros(0, np.int64), *self._contacts]))
        assembly = Assembly(
            node_count=self.node_count,
            reference=np.vstack(self._reference),
            positions=np.vstack(self._positions),
            triangles=np.zeros((0, 3), np.int64) if mesh is None else np.array(mesh.triangles, np.int64),
            creases=Creases(
                nodes=none if mesh is None else np.array(mesh.creases, np.int64),
                fold_signs=np.where(angles < 0, -1.0, 1.0),
                fold_angles=np.abs(angles),
                **{
                    field: self._creases.get(field, unset)
                    for field in ("stiffness", "contact_penalty", "natural_angle")
                },
            ),
            extra_masses=self._extra_masses(),
            tips=np.concatenate([np.zeros(0, np.int64), *(nodes for nodes, mass in self._masses if mass > 0.0)]),
            fixed=np.unique(np.array(self._fixed, np.int64)),
            loaded=self._loaded,
            cords=self._segments(),
            bridges=Links(
                nodes=none if mesh is None else np.array(mesh.bridges, np.int64), stiffness=self._bridge_stiffness
            ),
            contacts=ContactSet(np.setdiff1d(touched, self._fixed)),
            layers=Layers(self._layers),
            node_sets=self.node_sets,
            motions=tuple(motion for motion, _ in self._motions),
            regions=tuple(self._regions),
        )
        self._check_masses(assembly)
        return assembly

    def _check_masses(self, assembly: Assembly) -> None:
        """Every node that can move needs a mass."""
        bare = assembly.extra_masses <= 0
        bare[assembly.triangles.ravel()] = False
        bare[assembly.fixed] = False
        if bare.any():
            node = int(np.flatnonzero(bare)[0])
            what = f"node {node} has no mass ({int(bare.sum())} such nodes)"
            for (cord, nodes), where in zip(self._cords, self._cord_places, strict=True):
                if node in nodes:
                    remedy = "give the cord a linear_density, add a tip mass, or hold the node fixed"
                    raise SceneError(f"{where}.linear_density = {cord.linear_density:g}: {what}: {remedy}")
            raise SceneError(f"mesh: {what}: it belongs to no triangle; remove it from the mesh: Mesh.audit says how")

    def _extra_masses(self) -> Floats:
        masses = np.zeros(self.node_count)
        for cord, nodes in self._cords:
            half = 0.5 * cord.linear_density * cord.rest_lengths
            masses[nodes[:-1]] += half
            masses[nodes[1:]] += half
        for nodes, mass in self._masses:
            masses[nodes] += mass
        return masses

    def _segments(self) -> Cords:
        """The cords' segments, one after the other."""
        cords = [cord for cord, _ in self._cords]
        counts = [cord.segments for cord in cords]
        pairs = [np.column_stack([nodes[:-1], nodes[1:]]) for _, nodes in self._cords]
        rest = np.concatenate([np.zeros(0), *(cord.rest_lengths for cord in cords)])
        wound = [k for k, cord in enumerate(cords) if cord.winch is not None]
        firsts = np.cumsum([0, *counts])
        winch = [(segment, j) for j, k in enumerate(wound) for segment in range(firsts[k], firsts[k + 1])]
        return Cords(
            nodes=np.vstack([np.zeros((0, 2), np.int64), *pairs]),
            stiffness=np.repeat([cord.axial_stiffness for cord in cords], counts) / rest,
            rest_length=rest,
            strain_limit=np.repeat([cord.strain_limit for cord in cords], counts),
            critical_strain=np.repeat([cord.critical_strain for cord in cords], counts),
            winch=np.array(winch, np.int64).reshape(-1, 2),
            winches=tuple(cord.winch for cord in cords if cord.winch is not None),
        )
