"""A scene as plain arrays: the nodes, masses and cords that the core is given."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np

from membrane_rs._arrays import Floats, Ints


@dataclass(frozen=True, eq=False)
class Assembly:
    """A scene as read-only arrays; N nodes, s cord segments, c creases, b bridges.

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
    creases: Ints
    """(c, 2) nodes of each crease."""
    fold_signs: Floats
    """(c,) +1 for a valley or a flat crease, -1 for a mountain."""
    extra_masses: Floats
    """(N,) what tip masses and cords add to each node [kg]."""
    tips: Ints
    """(t,) nodes that carry a mass of their own beside those of film and cords; a node may stand there twice."""
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
