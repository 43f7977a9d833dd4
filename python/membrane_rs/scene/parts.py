"""The parts that a scene may hold beside its membrane: tethers, tip masses, what is held fast.

Parts are plain checked values; `assembly` makes nodes, masses and cords of them. Units are SI.
"""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, TypeAlias

from membrane_rs._validation import Count, Flag, Nodes, NonNegative, Positive, Unit, Vector, validated
from membrane_rs.errors import InputError

SHORTEST = 1e-12
"""Ends of a cord that are nearer to each other than this are one point [m]."""


@validated
class TipMasses:
    """The same mass added to each of some nodes.

    Parameters
    ----------
    mass : float
        For each node [kg], above 0.
    nodes : str or sequence of int
        A node set, or node indices.
    """

    kind: ClassVar[str] = "tip_masses"
    mass: Annotated[Positive, Unit("kg")]
    nodes: Nodes = "corners"


@validated
class Tethers:
    """Cords from the rim of the spool to nodes of the membrane, one for each node.

    Each starts on the rim, at z = 0 and at the azimuth that its node has in the flat sail, where it is
    held fast. If the node is nearer than the cord is long, the cord hangs below in an arc without strain.

    Parameters
    ----------
    nodes : str or sequence of int
        A node set of the membrane, or node indices.
    anchor_radius : float
        Radius of the rim [m], above 0.
    length : float or None
        Of each cord without load [m]. None: from rim to node in the flat sail.
    segments : int
        Springs in each cord, 1 or above; as many masses, the one on the rim among them.
    axial_stiffness : float
        EA [N], above 0.
    linear_density : float
        Mass per length [kg/m], above 0.
    strain_limit : float
        A run stops when a segment is stretched beyond this strain [-], above 0.
    """

    kind: ClassVar[str] = "tethers"
    nodes: Nodes = "inner_corners"
    anchor_radius: Annotated[Positive, Unit("m")] = 0.025
    length: Annotated[Positive | None, Unit("m")] = None
    segments: Count = 19
    axial_stiffness: Annotated[Positive, Unit("N")] = 17.0
    linear_density: Annotated[Positive, Unit("kg/m")] = 1.004e-4
    strain_limit: Positive = 0.1


@validated
class Tether:
    """A cord of its own between two points, with or without a mass at its end.

    It adds the node sets "tether-<k>" (all nodes in order), "tether-<k>-start" and "tether-<k>-end",
    where k counts the cords of a scene from 0. If the two points are nearer than the cord is long, it
    hangs below in an arc without strain.

    Parameters
    ----------
    start, end : tuple of float
        The two ends (x, y, z) [m]; they must differ.
    segments : int
        Springs in the cord, 1 or above; one mass more.
    axial_stiffness : float
        EA [N], above 0.
    linear_density : float
        Mass per length [kg/m]; 0 only for a cord of one segment with a tip mass.
    length : float or None
        Without load [m]. None: the distance between the two points.
    tip_mass : float
        Added to the last node [kg], 0 or above.
    fixed : bool
        True: the first node is held fast.
    strain_limit : float
        A run stops when a segment is stretched beyond this strain [-], above 0.
    """

    kind: ClassVar[str] = "tether"
    start: Annotated[Vector, Unit("m")]
    end: Annotated[Vector, Unit("m")]
    segments: Count
    axial_stiffness: Annotated[Positive, Unit("N")]
    linear_density: Annotated[NonNegative, Unit("kg/m")]
    length: Annotated[Positive | None, Unit("m")] = None
    tip_mass: Annotated[NonNegative, Unit("kg")] = 0.0
    fixed: Flag = True
    strain_limit: Positive = 0.1

    def __post_init__(self) -> None:
        """Check the ends against each other."""
        if math.dist(self.start, self.end) < SHORTEST:
            raise InputError(f"Tether.end = {self.end}: must differ from start, by {SHORTEST:g} or more (m)")


@validated
class Fixed:
    """Nodes held at rest in the turning frame.

    Parameters
    ----------
    nodes : str or sequence of int
        A node set, or node indices.
    """

    kind: ClassVar[str] = "fixed"
    nodes: Nodes


@validated
class Bridges:
    """Stiff links of no length that join the node pairs `Mesh.bridges`.

    Parameters
    ----------
    stiffness : float
        Of each link [N/m], above 0.
    """

    kind: ClassVar[str] = "bridges"
    stiffness: Annotated[Positive, Unit("N/m")]


Part: TypeAlias = TipMasses | Tethers | Tether | Fixed | Bridges

PARTS: dict[str, type[Part]] = {part.kind: part for part in (TipMasses, Tethers, Tether, Fixed, Bridges)}
"""The one list of parts: its `kind` in a scene file, and its class."""
