"""What the core is given of a scene, component by component: plain read-only arrays and numbers, SI units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs.scene.schedule import Schedule


@dataclass(frozen=True, eq=False)
class Component:
    """Fields that are arrays become read-only."""

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        for item in fields(self):
            value = getattr(self, item.name)
            for array in value.values() if isinstance(value, dict) else (value,):
                if isinstance(array, np.ndarray):
                    array.setflags(write=False)

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Unpickle or copy; arrays are read-only again."""
        self.__dict__.update(state)
        self.__post_init__()


@dataclass(frozen=True, eq=False)
class Nodes(Component):
    """All nodes at the start, those of the membrane first."""

    positions: Floats
    """(N, 3) [m]."""
    velocities: Floats
    """(N, 3) relative to the turning frame [m/s]."""
    extra_masses: Floats
    """(N,) masses beside the film's [kg]."""
    fixed: Ints
    """(k,) nodes held at rest, or moved as prescribed, ascending."""


@dataclass(frozen=True, eq=False)
class Surface(Component):
    """The membrane as a mesh of n nodes."""

    reference: Floats
    """(n, 3) the shape without stress [m]."""
    triangles: Ints
    """(m, 3) nodes of each triangle."""


@dataclass(frozen=True, eq=False)
class Film(Component):
    """What the membrane is made of, and what becomes of negative spring constants."""

    youngs_modulus: float
    """[Pa]."""
    poisson_ratio: float
    """[-]."""
    density: float
    """[kg/m3]."""
    thickness: float
    """[m]."""
    negative_springs: str
    """"refuse", "clip", "keep" or "unused"."""


@dataclass(frozen=True, eq=False)
class Creases(Component):
    """Lines along which the film is folded."""

    nodes: Ints
    """(c, 2) the two nodes of each."""
    fold_signs: Floats
    """(c,) +1 for a valley or a flat crease, -1 for a mountain."""

    def __len__(self) -> int:
        """How many creases."""
        return len(self.nodes)


@dataclass(frozen=True, eq=False)
class Cords(Component):
    """Cord segments, one after the other; each bears tension alone."""

    nodes: Ints
    """(s, 2) the two nodes of each."""
    stiffness: Floats
    """(s,) EA / l [N/m]."""
    rest_length: Floats
    """(s,) l, without load [m]."""
    strain_limit: Floats
    """(s,) strain at which a run stops."""

    def __len__(self) -> int:
        """How many segments."""
        return len(self.nodes)


@dataclass(frozen=True, eq=False)
class Links(Component):
    """Links of no length, all of one stiffness: bridges between petals."""

    nodes: Ints
    """(b, 2) the two nodes of each."""
    stiffness: float
    """Of each link [N/m]; 0 without links."""

    def __len__(self) -> int:
        """How many links."""
        return len(self.nodes)


@dataclass(frozen=True, eq=False)
class ContactSet(Component):
    """What a surface keeps outside."""

    nodes: Ints
    """(k,) nodes, ascending; empty without contact."""

    def __len__(self) -> int:
        """How many nodes."""
        return len(self.nodes)


@dataclass(frozen=True, eq=False)
class Motion(Component):
    """How some nodes move in the turning frame; None: not at all along or about that axis."""

    nodes: Ints
    """(k,) those that follow it."""
    x: Schedule | None
    """Displacement [m]."""
    y: Schedule | None
    """[m]."""
    z: Schedule | None
    """[m]."""
    turn: Schedule | None
    """Turn about the axis of the hub [rad]."""


@dataclass(frozen=True, eq=False)
class Model:
    """All components of a scene."""

    nodes: Nodes
    surface: Surface
    film: Film | None
    """None: no membrane."""
    creases: Creases
    cords: Cords
    bridges: Links
    contacts: ContactSet
    motions: Sequence[Motion] = ()
    """Of nodes that move as prescribed; no node follows two."""
