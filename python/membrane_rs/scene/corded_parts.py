"""Parts that are cords anywhere in a scene: between any two places, and along edges of the film.

Bridles are cords that meet at a place: one ends where others start. Units are SI.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import field, replace
from typing import Annotated, ClassVar

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._validation import (
    Count,
    Flag,
    Fraction,
    Nodes,
    NonNegative,
    Place,
    Positive,
    Unit,
    show,
    validated,
)
from membrane_rs.errors import InputError, MeshError, SceneError
from membrane_rs.mesh.edge_paths import path_of_set, path_through
from membrane_rs.scene import cord as arrays
from membrane_rs.scene.builder import Builder
from membrane_rs.scene.corded import Corded, cord_of, implausible_waves
from membrane_rs.scene.cords import cord_positions
from membrane_rs.scene.law import Surroundings
from membrane_rs.scene.part import Part
from membrane_rs.scene.plausible import Doubt
from membrane_rs.scene.schedule import Schedule

SHORTEST = 0.01
"""Least factor of the length of a cord [-]: its segments become stiffer by the inverse of it."""
_ONE_OF_SET = re.compile(r"(?P<name>.+)(?:\[(?P<index>-?\d{1,10})\]|@(?P<share>\d*\.?\d+))")
"""A node of a node set, by its index or by its share of the way along it."""


@validated
class Cord(Corded):
    """A cord between any two places: points, nodes of the film, and nodes of cords that stand before it.

    A place is a point (x, y, z), a node index, or a text: the name of a node set of one node ("riser-end"), the node of
    a set by its index ("corners[2]", "corners[-1]"), or by its share of the way along the set ("riser@0.5"), counted by
    nodes: of a `Cord`, whose segments are equal, the share of its length. Cords that name one node meet there, so that
    bridles branch and join. The node sets of a cord are its `name` (all nodes in order), "<name>-start" and
    "<name>-end"; without a name "cord-<k>" and so on, where k counts the cords of a scene from 0. A cord longer than
    its span hangs below in an arc without strain.

    Parameters
    ----------
    start, end : tuple of float, int or str
        The places that it joins; a point gets a node of the cord's own [m].
    segments : int
        Springs in the cord, 1 or above.
    axial_stiffness : float
        EA [N], above 0.
    linear_density : float
        Mass per length [kg/m]; 0 only where all its nodes have another mass or are held.
    length : float or None
        Without load [m], above 0. None: from place to place in the flat shape.
    fixed : bool
        True: a start that is a point is fixed in the turning frame, as on a hub.
    strain_limit : float
        A run stops when a segment is stretched beyond this strain [-], above 0.
    length_factor : Schedule or None
        Factor of the length without load as a function of time [-], as a winch hauls the cord in or pays it out, with
        all its segments alike; at least 0.01. EA and the masses stay. Such a cord has no dashpots. By keyword alone.
    critical_strain : float
        Compressive strain at which its segments buckle [-], beyond which their force is constant. 0: they bear tension
        alone; 1, for a strut of one segment: never. 0 with `length_factor`. By keyword alone.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type; two ends that are one; a critical strain with `length_factor`.

    Examples
    --------
    A bridle: a riser from the hub, and two legs from its end to corners of the film.

    >>> from membrane_rs import Cord
    >>> rope = {"segments": 4, "axial_stiffness": 100.0, "linear_density": 1e-3}
    >>> riser = Cord((0.0, 0.0, 1.0), (0.0, 0.0, 0.5), **rope, name="riser")
    >>> legs = [Cord("riser-end", f"corners[{k}]", **rope) for k in range(2)]
    >>> legs[1].start, legs[1].end
    ('riser-end', 'corners[1]')
    """

    kind: ClassVar[str] = "cord"
    start: Annotated[Place, Unit("m")]
    end: Annotated[Place, Unit("m")]
    segments: Count
    axial_stiffness: Annotated[Positive, Unit("N")]
    linear_density: Annotated[NonNegative, Unit("kg/m")]
    length: Annotated[Positive | None, Unit("m")] = None
    fixed: Flag = True
    strain_limit: Positive = 0.1
    length_factor: Schedule | None = field(default=None, kw_only=True)
    critical_strain: Fraction = field(default=0.0, kw_only=True)
    working_law: ClassVar[str | None] = "winches"
    start_fields: ClassVar[tuple[str, ...]] = ("start", "end")

    def __post_init__(self) -> None:
        """Check the ends against each other, and the length against its bound."""
        if self.start == self.end:
            raise InputError(f"Cord.end = {show(self.end)}: must differ from start")
        least = min(self.length_factor.values) if self.length_factor is not None else 1.0
        if least < SHORTEST:
            what = f"must be at least {SHORTEST:g}: a cord is not hauled in to its end"
            raise InputError(f"Cord.length_factor.values: {least:g}: {what}")
        if self.length_factor is not None and self.critical_strain > 0.0:
            what = "must be 0 with length_factor: a cord on a winch bears tension alone"
            raise InputError(f"Cord.critical_strain = {self.critical_strain:g}: {what}")

    def add_nodes(self, builder: Builder, where: str) -> None:
        """Add the cord, and hold its start if that is a point.

        Raises
        ------
        SceneError
            A place that is not there or not one, ends that are one, a length of 0 or one that its ends stretch beyond
            its strain limit, too many nodes, taken names.
        """
        ends = [self._end(builder, where, field) for field in ("start", "end")]
        (start, flat_start, stowed_start), (end, flat_end, stowed_end) = ends
        if start is not None and start == end:
            raise SceneError(
                f"{where}.end = {show(self.end)}: is node {end}, at which the cord starts; name another one"
            )
        length = self.length or float(np.linalg.norm(flat_end - flat_start))
        if length == 0.0:
            what = "lies where the cord starts in the flat shape; give the cord a length"
            raise SceneError(f"{where}.end = {show(self.end)}: {what} (m)")
        hauled = length if self.length_factor is None else length * self.length_factor.at(0.0)
        span = float(np.linalg.norm(stowed_end - stowed_start))
        if span > hauled * (1.0 + self.strain_limit):
            what = f"its places are {span:.6g} m apart at the start, beyond its strain_limit; give it a greater length"
            raise SceneError(f"{where}.length = {self.length}: a cord of {hauled:.6g} m: {what} (m)")
        own = slice(int(start is not None), self.segments + int(end is None))
        count = own.stop - own.start
        builder.check_room(where, self.segments, count)
        new = range(builder.node_count, builder.node_count + count)
        nodes = np.array([*([] if start is None else [start]), *new, *([] if end is None else [end])], np.int64)
        positions = np.vstack([stowed_start, stowed_end])
        if self.segments > 1:
            positions = cord_positions(stowed_start, stowed_end, hauled, self.segments)
        reference = np.linspace(flat_start, flat_end, self.segments + 1)
        cord = replace(cord_of(self, length), winch=self.length_factor, critical_strain=self.critical_strain)
        builder.append(cord, where, nodes, reference[own], positions[own], kind=self.kind, name=self.name)
        if self.fixed and start is None:
            builder.fix(nodes[:1])

    def check_set(self, given: Part, names: Collection[str]) -> None:
        """As `Part.check_set`; and `fixed` of a cord that starts at no point, where it has no effect."""
        super().check_set(given, names)
        if "fixed" in names and not isinstance(self.start, tuple):
            what = (
                f"is without effect where a cord starts at {show(self.start)}, no point; hold nodes by a part of kind"
            )
            raise InputError(f"Cord.fixed = {show(self.fixed)}: {what} 'fixed', or leave it out of the stage")

    def _end(self, builder: Builder, where: str, field: str) -> tuple[int | None, Floats, Floats]:
        """The node at an end, None for a point; where it is in the flat shape and at the start, (3,) [m]."""
        place = self.start if field == "start" else self.end
        if isinstance(place, tuple):
            point = np.array(place)
            return None, point, point
        node = builder.nodes([place], where, field=field)[0] if isinstance(place, int) else None
        if isinstance(place, str):
            node = _node_of_set(builder, place, where, field)
        assert node is not None
        return int(node), *builder.place_of(int(node))

    @property
    def numbering_field(self) -> str | None:
        """The end that is a node index."""
        return next((name for name in ("start", "end") if isinstance(getattr(self, name), int)), None)

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """A wave runs along a cord as it does along some material."""
        yield from implausible_waves(self, where)


def _node_of_set(builder: Builder, place: str, where: str, field: str) -> int:
    """The node that a text names. Raises SceneError."""
    found = None if place in builder.node_sets else _ONE_OF_SET.fullmatch(place)
    nodes = builder.nodes(place if found is None else found["name"], where, field=field)
    said, count = f"{where}.{field} = {show(place)}", len(nodes)
    if found is None:
        if count != 1:
            remedy = f"name one of them: {f'{place}[0]'!r} to {f'{place}[{count - 1}]'!r}, or {f'{place}@0.5'!r}"
            raise SceneError(f"{said}: is a set of {count} nodes; {remedy}" if count else f"{said}: is an empty set")
        return int(nodes[0])
    if found["share"] is not None:
        share = float(found["share"])
        if share > 1.0 or not count:
            raise SceneError(f"{said}: the share of the way along {count} nodes must be from 0 to 1")
        return int(nodes[round(share * (count - 1))])
    index = int(found["index"])
    if not -count <= index < count:
        raise SceneError(f"{said}: the set has {count} nodes; the index must be from {-count} to {count - 1}")
    return int(nodes[index])


@validated
class Boltrope(Part):
    """A cord along edges of the film, which it stiffens there: it shares the film's nodes, and has no other.

    Each edge on its path has a spring of the cord beside that of the film. The path leads through all nodes of a node
    set, along the boundary where they lie on it, from that end which stands earlier in the set; or through nodes in the
    order of their indices, between two of them by the shortest way along edges in the flat shape. Its node sets are its
    `name`, "<name>-start" and "<name>-end", without a name "boltrope-<k>" and so on, as those of `Cord`.

    Parameters
    ----------
    nodes : str or sequence of int
        A node set of the membrane, or node indices in the order of the path.
    axial_stiffness : float
        EA [N], above 0.
    linear_density : float
        Mass per length [kg/m], 0 or above.
    length : float or None
        Of the whole cord without load [m], above 0: a shorter one than its path gathers the film, a longer one bears
        only what is stretched beyond it. None: that of its path in the flat shape.
    closed : bool
        True: a path through node indices leads back to the first. A node set is closed where its edges are.
    critical_strain : float
        Compressive strain at which it buckles [-], beyond which its force is constant. 0: it bears tension alone; 1: it
        never buckles.
    strain_limit : float
        A run stops when a segment is stretched beyond this strain [-], above 0.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import Boltrope, Gravity, Material, Scene, Springs
    >>> from membrane_rs.folding import Strip
    >>> strip = Strip(length=0.1, width=0.02, columns=10).mesh()
    >>> rope = Boltrope("start", axial_stiffness=50.0, linear_density=1e-4, name="hem")
    >>> scene = Scene(strip, Material(3.2e9, 0.34, 1420.0, 7.5e-6), [Springs(), Gravity()], [rope])
    >>> scene.assemble().node_sets["hem"].size == strip.node_sets["start"].size
    True
    """

    kind: ClassVar[str] = "boltrope"
    nodes: Nodes
    axial_stiffness: Annotated[Positive, Unit("N")]
    linear_density: Annotated[NonNegative, Unit("kg/m")]
    length: Annotated[Positive | None, Unit("m")] = None
    closed: Flag = False
    critical_strain: Fraction = 0.0
    strain_limit: Positive = 0.1
    start_fields: ClassVar[tuple[str, ...]] = ("closed",)

    def add_nodes(self, builder: Builder, where: str) -> None:
        """Add the cord.

        Raises
        ------
        SceneError
            No membrane, nodes that are not there or lie on no path of edges, taken names.
        """
        wanted, mesh = builder.nodes(self.nodes, where, of_mesh=True), builder.mesh
        place = f"{where}.nodes = {show(self.nodes)}"
        if mesh is None:
            raise SceneError(f"{place}: a boltrope lies on edges of a membrane; add a mesh and its material")
        try:
            path = (
                path_of_set(mesh, wanted)
                if isinstance(self.nodes, str)
                else path_through(mesh, wanted, closed=self.closed)
            )
        except MeshError as error:
            raise SceneError(f"{place}: {error}") from None
        lengths = mesh.edge_lengths[mesh.find_edges(np.column_stack([path[:-1], path[1:]]))[0]]
        total = float(lengths.sum())
        cord = arrays.Cord(
            segments=len(lengths),
            length=self.length or total,
            axial_stiffness=self.axial_stiffness,
            linear_density=self.linear_density,
            strain_limit=self.strain_limit,
            critical_strain=self.critical_strain,
            shares=lengths / total,
        )
        none = np.zeros((0, 3))
        builder.append(cord, where, path, none, none, kind=self.kind, name=self.name)

    def with_softened_film(self, factor: float) -> Boltrope:
        """As soft as the film beside it, whose load it shares."""
        return self.softened(1.0 / factor)

    def softened(self, factor: float) -> Boltrope:
        """A cord of `factor` times the axial stiffness."""
        return replace(self, axial_stiffness=self.axial_stiffness * factor)

    def step_advice(self, gain: float) -> str:
        """A smaller stiffness."""
        less = f"an axial_stiffness of {self.axial_stiffness / gain**2:.3g} N in place of {self.axial_stiffness:g} N"
        return f"{less} would take it out of the limit"

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """A wave runs along a cord as it does along some material."""
        yield from implausible_waves(self, where)
