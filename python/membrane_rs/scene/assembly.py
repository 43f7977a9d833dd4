"""A scene as plain arrays and components: nodes, masses, creases, cords, links and contacts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from membrane_rs._arrays import Floats, Ints
from membrane_rs.scene.components import Component, ContactSet, Cords, Creases, Links, Motion


@dataclass(frozen=True, eq=False)
class Assembly(Component):
    """A scene as read-only arrays; N nodes.

    Nodes of the membrane come first, in the order of the mesh; nodes of the cords follow, cord after cord.
    """

    node_count: int
    """N, of the membrane and of the cords."""
    reference: Floats
    """(N, 3) the flat shape, cords straight [m]."""
    positions: Floats
    """(N, 3) the shape at the start [m]."""
    triangles: Ints
    """(m, 3) nodes of each triangle."""
    creases: Creases
    """Those of the membrane."""
    extra_masses: Floats
    """(N,) what tip masses and cords add to each node [kg]."""
    tips: Ints
    """(t,) nodes that carry a mass of their own beside those of film and cords; a node may stand there twice."""
    fixed: Ints
    """(k,) nodes held at rest, or moved as prescribed, ascending."""
    cords: Cords
    """Segments of all cords."""
    bridges: Links
    """Node pairs joined by a link of no length."""
    contacts: ContactSet
    """Nodes that the spool keeps outside."""
    node_sets: Mapping[str, Ints]
    """The mesh's node sets and the cords' own."""
    motions: Sequence[Motion] = ()
    """Of the nodes that move as prescribed."""
