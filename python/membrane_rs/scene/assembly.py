"""A scene as plain arrays and components: nodes, masses, creases, cords, links and contacts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from membrane_rs._arrays import Floats, Ints
from membrane_rs.scene.components import Component, ContactSet, Cords, Creases, FilmRegion, Layers, Links, Motion


@dataclass(frozen=True, eq=False)
class Assembly(Component):
    """A scene as read-only arrays; N nodes.

    Nodes of the membrane come first, in the order of the mesh; nodes of the cords follow, cord after cord.

    Attributes
    ----------
    node_count : int
        N, of the membrane and of the cords.
    reference : (N, 3) float
        The flat shape, cords straight [m].
    positions : (N, 3) float
        The shape at the start [m].
    triangles : (m, 3) int
        Nodes of each triangle.
    creases : Creases
        Those of the membrane.
    extra_masses : (N,) float
        What tip masses and cords add to each node [kg].
    tips : (t,) int
        Nodes that carry a mass of their own beside those of film and cords; a node may stand there twice.
    fixed : (k,) int
        Nodes held at rest, or moved as prescribed, ascending.
    loaded : (k,) int
        Nodes on which point forces act, ascending.
    cords : Cords
        Segments of all cords.
    bridges : Links
        Node pairs joined by a link of no length.
    contacts : ContactSet
        Nodes that the spool keeps outside.
    layers : Layers
        Triangles that cannot pass through each other.
    node_sets : mapping of str to (k,) int
        The mesh's node sets and the cords' own.
    motions : sequence of Motion
        Of the nodes that move as prescribed.
    regions : sequence of FilmRegion
        Of the membrane, with a film of their own.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> found = scenes.load("spinning-tether").assemble()
    >>> found.node_count, len(found.cords), found.fixed
    (11, 10, array([0]))
    """

    node_count: int
    reference: Floats
    positions: Floats
    triangles: Ints
    creases: Creases
    extra_masses: Floats
    tips: Ints
    fixed: Ints
    loaded: Ints
    cords: Cords
    bridges: Links
    contacts: ContactSet
    layers: Layers
    node_sets: Mapping[str, Ints]
    motions: Sequence[Motion] = ()
    regions: Sequence[FilmRegion] = ()
