"""What the core is given of a scene, component by component: plain read-only arrays and numbers, SI units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs.scene.schedule import Schedule

__all__ = ["ContactSet", "Cords", "Creases", "FilmRegion", "Layers", "Links", "Motion", "Optics"]


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
    loaded: Ints
    """(k,) nodes on which point forces act, ascending."""


@dataclass(frozen=True, eq=False)
class Surface(Component):
    """The membrane as a mesh of n nodes."""

    reference: Floats
    """(n, 3) the shape without stress [m]."""
    triangles: Ints
    """(m, 3) nodes of each triangle."""


@dataclass(frozen=True)
class Orthotropy:
    """Moduli of a film that has two, over Young's modulus along its direction."""

    direction: float
    """In the flat shape, from the x axis on [rad]."""
    across: float
    """Young's modulus across the direction [-]."""
    shear: float
    """Shear modulus [-]."""


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
    orthotropy: Orthotropy | None = None
    """None: one modulus in all directions."""


@dataclass(frozen=True)
class Optics:
    """What both sides of a film do with light, shares from 0 to 1 [-].

    Attributes
    ----------
    front_specular, back_specular : float
        Reflected as by a mirror [-].
    front_diffuse, back_diffuse : float
        Reflected to all sides [-].
    front_emissivity, back_emissivity : float
        Emissivity [-].
    front_lambert, back_lambert : float
        Momentum of emitted light along the normal, as a share of that of a beam [-].

    Examples
    --------
    >>> from membrane_rs.scene.components import Optics
    >>> Optics(0.8, 0.1, 1.0, 2 / 3, 0.8, 0.1, 1.0, 2 / 3).front_specular
    0.8
    """

    front_specular: float
    front_diffuse: float
    front_emissivity: float
    front_lambert: float
    back_specular: float
    back_diffuse: float
    back_emissivity: float
    back_lambert: float


@dataclass(frozen=True, eq=False)
class FilmRegion(Component):
    """Triangles whose film has properties of its own.

    Attributes
    ----------
    triangles : (k,) int
        Ascending; no triangle belongs to two regions.
    youngs_modulus, poisson_ratio, density, thickness : float
        Of its film [Pa, -, kg/m3, m].
    areal_mass : float
        Beside that of the film [kg/m2].
    buckling : float or None
        alpha between creases [-]; None: that of the law.
    bending_stiffness : float or None
        D [N m]; None: that of a plate of its film.
    curvature : tuple of float
        Natural curvature along x and y, and the mixed one, in the flat shape [1/m].
    natural_strain : tuple of float
        Strain along x and y, and the mixed one, of the flat shape at which the film is free of stress [-].
    optics : Optics or None
        In sunlight; None: those of the law.
    name : str
        The part that it is of, in messages.

    Examples
    --------
    >>> import dataclasses
    >>> from membrane_rs import Region, scenes
    >>> scene = scenes.load("hanging-strip")
    >>> patch = Region([0, 1], thickness=25e-6)
    >>> found = dataclasses.replace(scene, parts=[*scene.parts, patch]).assemble().regions[0]
    >>> len(found.triangles) > 0, found.thickness
    (True, 2.5e-05)
    """

    triangles: Ints
    youngs_modulus: float
    poisson_ratio: float
    density: float
    thickness: float
    areal_mass: float
    buckling: float | None
    bending_stiffness: float | None
    curvature: tuple[float, float, float]
    natural_strain: tuple[float, float, float]
    optics: Optics | None
    name: str

    @property
    def areal_density(self) -> float:
        """Mass per area [kg/m2]."""
        return self.density * self.thickness + self.areal_mass


@dataclass(frozen=True, eq=False)
class Creases(Component):
    """Lines along which the film is folded.

    Attributes
    ----------
    nodes : (c, 2) int
        The two nodes of each.
    fold_signs : (c,) float
        +1 for a valley or a flat crease, -1 for a mountain [-].
    fold_angles : (c,) float
        By how much each is folded in the pattern, from 0 (flat) to pi (shut) [rad].
    stiffness, contact_penalty, natural_angle : (c,) float
        beta [-], gamma [-] and theta0 [rad] of each; NaN where they are those of the law. Empty where all are.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> creases = scenes.load("single-crease").assemble().creases
    >>> len(creases), creases.fold_signs[0].item()
    (2, 1.0)
    """

    nodes: Ints
    fold_signs: Floats
    fold_angles: Floats
    stiffness: Floats
    contact_penalty: Floats
    natural_angle: Floats

    def __len__(self) -> int:
        """How many creases."""
        return len(self.nodes)


@dataclass(frozen=True, eq=False)
class Cords(Component):
    """Cord segments, one after the other; each bears tension alone, unless it buckles later.

    Attributes
    ----------
    nodes : (s, 2) int
        The two nodes of each.
    stiffness : (s,) float
        EA / l [N/m].
    rest_length : (s,) float
        l, without load [m].
    strain_limit : (s,) float
        Strain at which a run stops [-].
    critical_strain : (s,) float
        Compressive strain at which it buckles [-]; 0: it bears tension alone.
    winch : (w, 2) int
        Segments whose length changes with time, and the number of the schedule that each follows.
    winches : sequence of Schedule
        Factors of the length without load [-].

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> cords = scenes.load("spinning-tether").assemble().cords
    >>> len(cords), cords.nodes.shape
    (10, (10, 2))
    """

    nodes: Ints
    stiffness: Floats
    rest_length: Floats
    strain_limit: Floats
    critical_strain: Floats
    winch: Ints
    winches: Sequence[Schedule]

    def __len__(self) -> int:
        """How many segments."""
        return len(self.nodes)


@dataclass(frozen=True, eq=False)
class Links(Component):
    """Links of no length, all of one stiffness: bridges between petals.

    Attributes
    ----------
    nodes : (b, 2) int
        The two nodes of each.
    stiffness : float
        Of each link [N/m]; 0 without links.

    Examples
    --------
    >>> from membrane_rs import Bridges, Material, Mesh, Scene, Springs
    >>> points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> mesh = Mesh(points, [[0, 1, 2], [3, 4, 5]], bridges=[[1, 3], [2, 5]])
    >>> scene = Scene(mesh, Material(3.2e9, 0.34, 1420.0, 7.5e-6), [Springs()], [Bridges(100.0)])
    >>> bridges = scene.assemble().bridges
    >>> len(bridges), bridges.stiffness
    (2, 100.0)
    """

    nodes: Ints
    stiffness: float

    def __len__(self) -> int:
        """How many links."""
        return len(self.nodes)


@dataclass(frozen=True, eq=False)
class ContactSet(Component):
    """What a surface keeps outside.

    Attributes
    ----------
    nodes : (k,) int
        Ascending; empty without contact.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> contacts = scenes.load("hanging-strip").assemble().contacts
    >>> len(contacts)
    0
    """

    nodes: Ints

    def __len__(self) -> int:
        """How many nodes."""
        return len(self.nodes)


@dataclass(frozen=True, eq=False)
class Layers(Component):
    """Triangles of the film that cannot pass through each other.

    Attributes
    ----------
    triangles : (k,) int
        Ascending; empty where layers do not feel each other.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> layers = scenes.load("hanging-strip").assemble().layers
    >>> len(layers)
    0
    """

    triangles: Ints

    def __len__(self) -> int:
        """How many triangles."""
        return len(self.triangles)


@dataclass(frozen=True, eq=False)
class Motion(Component):
    """How some nodes move in the turning frame.

    Attributes
    ----------
    nodes : (k,) int
        Those that follow it.
    x, y, z : Schedule or None
        Displacement [m]; None: not at all along that axis.
    turn : Schedule or None
        Turn about the axis of the hub [rad]; None: not at all.

    Examples
    --------
    >>> import dataclasses
    >>> from membrane_rs import Moved, Schedule, scenes
    >>> scene = scenes.load("hanging-strip")
    >>> lifted = Moved([0], z=Schedule([0.0, 1.0], [0.0, 0.1]))
    >>> motion = dataclasses.replace(scene, parts=[lifted]).assemble().motions[0]
    >>> motion.nodes, motion.z.at(0.5), motion.x
    (array([0]), 0.05, None)
    """

    nodes: Ints
    x: Schedule | None
    y: Schedule | None
    z: Schedule | None
    turn: Schedule | None


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
    layers: Layers
    motions: Sequence[Motion] = ()
    """Of nodes that move as prescribed; no node follows two."""
    regions: Sequence[FilmRegion] = ()
    """Of the film; no triangle belongs to two."""
    winches: Sequence[Schedule] = ()
    """Factors of the lengths of cords [-]."""
