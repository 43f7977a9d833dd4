"""The parts that a scene may hold beside its membrane: tethers, tip masses, nodes held or moved.

Parts are plain checked values, which add nodes, masses and cords to a scene's arrays. Units are SI.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import field, replace
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import model_validator
from pydantic_core import ArgsKwargs

from membrane_rs._validation import Count, Flag, Nodes, NonNegative, Positive, Unit, Vector, validated
from membrane_rs.errors import InputError, SceneError
from membrane_rs.folding.pattern import cord_path
from membrane_rs.scene.builder import Builder
from membrane_rs.scene.corded import Corded, cord_of, implausible_waves
from membrane_rs.scene.corded_parts import Boltrope, Cord
from membrane_rs.scene.crease_set import CreaseSet
from membrane_rs.scene.held import Fixed, Moved
from membrane_rs.scene.law import Surroundings
from membrane_rs.scene.part import Part
from membrane_rs.scene.plausible import FILM, RATES, Doubt, implausible
from membrane_rs.scene.region import Region
from membrane_rs.scene.scales import hub_frequency, outermost, pull_of_spin
from membrane_rs.scene.spool import Spool
from membrane_rs.scene.tips import LIGHT_TIP, TipMasses, count_of, implausible_tip

__all__ = [
    "PARTS",
    "Boltrope",
    "Bridges",
    "Cord",
    "CreaseSet",
    "Fixed",
    "Moved",
    "Part",
    "Region",
    "Tether",
    "Tethers",
    "TipMasses",
]

SHORTEST = 1e-12
"""Ends of a cord that are nearer to each other than this are one point [m]."""
THIN_RIM = 1e-3
"""Radius of the rim over that of the flat sail: its shaft is then less than a millimetre on one metre [-]."""


@validated
class Tethers(Corded):
    """Cords from the rim of the spool to nodes of the membrane, one for each node.

    Each starts on the rim, at z = 0 and at the azimuth that its node has in the flat sail, where it is
    fixed. If the node is nearer than the cord is long, the cord hangs below in an arc without strain. In a wound sail
    it lies along the middle of an arm, from the hairpin on, and hangs below that.

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

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import Tethers
    >>> Tethers(anchor_radius=0.025).axial_stiffness
    17.0
    """

    kind: ClassVar[str] = "tethers"
    nodes: Nodes = "inner_corners"
    anchor_radius: Annotated[Positive, Unit("m")] = 0.025
    length: Annotated[Positive | None, Unit("m")] = None
    segments: Count = 19
    axial_stiffness: Annotated[Positive, Unit("N")] = 17.0
    linear_density: Annotated[Positive, Unit("kg/m")] = 1.004e-4
    strain_limit: Positive = 0.1
    start_fields: ClassVar[tuple[str, ...]] = ("anchor_radius",)

    def add_nodes(self, builder: Builder, where: str) -> None:
        """Add the cords, and hold their nodes on the rim.

        Raises
        ------
        SceneError
            Nodes that are not there, on the axis or on the rim; cords of too many nodes; slack cords of one segment.
        """
        held = builder.nodes(self.nodes, where, of_mesh=True)
        builder.check_room(where, self.segments, len(held) * self.segments)
        for node in held.tolist():
            flat = builder.reference[node]
            radius = float(np.hypot(flat[0], flat[1]))
            if radius == 0:
                raise SceneError(f"{where}.nodes: node {node} lies on the axis, so its tether has no azimuth")
            anchor = np.array([*(flat[:2] * (self.anchor_radius / radius)), 0.0])
            length = self.length or float(np.linalg.norm(flat - anchor))
            if length == 0:
                raise SceneError(f"{where}.anchor_radius = {self.anchor_radius}: node {node} lies on the rim")
            path = cord_path(builder.mesh, node)
            nodes = builder.add_cord(cord_of(self, length), where, anchor, node, path)
            builder.fix(nodes[:1])

    @property
    def spool(self) -> Spool:
        """The spool whose rim the cords start on."""
        return Spool(self.anchor_radius)

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """A wave runs along a cord as it does along some material, the spinning sail does not tear its cords, and the
        hub is no thread.
        """
        waves = [*implausible_waves(self, where)]
        if scene.mesh is not None and scene.material is not None:
            yield from self._torn(scene, where, has_plausible_waves=not waves)
            most = outermost(scene, with_cords=False)
            reason = (
                f"a sail that reaches to {most:.4g} m from the axis has a hub of {THIN_RIM * most:.3g} m and more, "
            )
            reason += "and less than its own reach"
            place, units = f"{where}.anchor_radius", {"mm": 1e-3, "cm": 1e-2}
            bounds = {"least": THIN_RIM * most, "most": most}
            yield from implausible(
                place, self.anchor_radius, "m", reason, **bounds, units=units, derived_from=("mesh",)
            )
        yield from waves

    def _torn(self, scene: Surroundings, where: str, *, has_plausible_waves: bool) -> Iterator[Doubt]:
        """Cords that the flat sail stretches beyond their limit as it turns.

        Where stiffness and density of the cords fit each other, the spin is doubted rather than the stiffness.
        """
        hub, tension = hub_frequency(scene), pull_of_spin(scene) / count_of(self.nodes, scene)
        least = tension / self.strain_limit
        if self.axial_stiffness >= least:
            return
        pulled = f"the flat sail, at {hub:g} Hz, pulls each cord by about {tension:.3g} N and so stretches it beyond "
        if not has_plausible_waves:
            reason = f"{pulled}its strain_limit = {self.strain_limit:g}"
            place, derived, units = f"{where}.axial_stiffness", (*FILM, "laws.spin", "parts*mass"), {"kN": 1e3}
            value = self.axial_stiffness
            yield from implausible(place, value, "N", reason, least=least, units=units, derived_from=derived)
            return
        turning = next(law.kind for law in scene.laws if law.hub_frequency is not None)
        most = hub * math.sqrt(self.axial_stiffness / least)
        reason = f"{pulled}{where}.strain_limit = {self.strain_limit:g}, with {self.axial_stiffness:g} N"
        place, derived = f"laws.{turning}.frequency", (*FILM, f"laws.{turning}", "parts*mass")
        for found in implausible(place, hub, "Hz", reason, most=most, units=RATES, derived_from=derived):
            more = f"{found.remedy}; else cords of {least:.3g} N or more are needed, or less mass"
            yield replace(found, remedy=more)


@validated
class Tether(Corded):
    """A cord of its own between two points, with or without a mass at its end.

    It adds the node sets "tether-<k>" (all nodes in order), "tether-<k>-start" and "tether-<k>-end",
    where k counts the cords of a scene from 0. If the two points are nearer than the cord is long, it
    hangs below in an arc without strain. A wound cord lies without strain on the circle about the z axis through its
    start, in chords of equal length, as that of a yo-yo; its end follows.

    Parameters
    ----------
    start : tuple of float
        The first end (x, y, z) [m].
    end : tuple of float or None
        The other one [m], which must differ from it. None, in files left out: that of a wound cord.
    segments : int
        Springs in the cord, 1 or above; one mass more.
    axial_stiffness : float
        EA [N], above 0.
    linear_density : float
        Mass per length [kg/m]; 0 only for a cord of one segment with a tip mass.
    length : float or None
        Without load [m]. None: the distance between the two points; a wound cord needs it.
    tip_mass : float
        Added to the last node [kg], 0 or above.
    fixed : bool
        True: the first node is fixed.
    strain_limit : float
        A run stops when a segment is stretched beyond this strain [-], above 0.
    wound : str, optional
        "clockwise" or "counterclockwise": the sense, seen from +z, in which the cord lies round the axis from its start
        on. None: it is not wound. By keyword alone.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type; two ends that are one, a wound cord with an end or without a
        length or a radius, another one without an end.

    Examples
    --------
    >>> from membrane_rs import Tether
    >>> Tether((0.1, 0.0, 0.0), (0.3, 0.0, 0.0), 8, axial_stiffness=17.0, linear_density=1e-4, tip_mass=0.01).segments
    8
    >>> Tether((0.1, 0.0, 0.0), None, 40, 17.0, 1e-4, length=0.5, wound="clockwise").end is None
    True
    """

    kind: ClassVar[str] = "tether"
    start: Annotated[Vector, Unit("m")]
    end: Annotated[Vector | None, Unit("m")]
    segments: Count
    axial_stiffness: Annotated[Positive, Unit("N")]
    linear_density: Annotated[NonNegative, Unit("kg/m")]
    length: Annotated[Positive | None, Unit("m")] = None
    tip_mass: Annotated[NonNegative, Unit("kg")] = 0.0
    fixed: Flag = True
    strain_limit: Positive = 0.1
    wound: Literal["clockwise", "counterclockwise"] | None = field(default=None, kw_only=True)
    start_fields: ClassVar[tuple[str, ...]] = ("start", "end", "wound")

    @model_validator(mode="before")
    @classmethod
    def _without_end(cls, given: Any) -> Any:
        """A wound cord may leave its end out."""
        if isinstance(given, ArgsKwargs) and len(given.args) < 2 and (given.kwargs or {}).get("wound") is not None:
            return ArgsKwargs(given.args, {"end": None, **(given.kwargs or {})})
        return given

    def __post_init__(self) -> None:
        """Check the ends against each other, and against the sense in which it is wound."""
        if self.wound is not None:
            self._check_wound()
        elif self.end is None:
            what = "is missing; give the point at which it ends, or wound and a length"
            raise InputError(f"Tether.end = None: {what} (m)")
        elif math.dist(self.start, self.end) < SHORTEST:
            raise InputError(f"Tether.end = {self.end}: must differ from start, by {SHORTEST:g} or more (m)")

    def _check_wound(self) -> None:
        if self.end is not None:
            what = "is not used with wound, by which it follows from the length; leave it out"
            raise InputError(f"Tether.end = {self.end}: {what}, None in Python (m)")
        if self.length is None:
            raise InputError(f"Tether.length = None: is missing; a cord wound {self.wound} needs its length (m)")
        if math.hypot(*self.start[:2]) < SHORTEST:
            what = "lies on the z axis, round which the cord is wound; give a point off it"
            raise InputError(f"Tether.start = {self.start}: {what} (m)")

    def add_nodes(self, builder: Builder, where: str) -> None:
        """Add the cord, its support and its tip mass.

        Raises
        ------
        SceneError
            Too many nodes, a slack cord of one segment, a wound one whose segments are too long for its circle.
        """
        builder.check_room(where, self.segments, self.segments + 1)
        start, cord = np.array(self.start), cord_of(self, self._length)
        if self.end is None:
            nodes = builder.add_wound_cord(cord, where, start, clockwise=self.wound == "clockwise")
        else:
            nodes = builder.add_cord(cord, where, start, np.array(self.end))
        if self.fixed:
            builder.fix(nodes[:1])
        builder.add_mass(nodes[-1:], self.tip_mass)

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """A wave runs along a cord as it does along some material; a mass at its end is lighter than `HEAVIEST_TIP`."""
        yield from implausible_waves(self, where)
        least = LIGHT_TIP * self.linear_density * self._length if self.tip_mass > 0.0 else 0.0
        yield from implausible_tip(f"{where}.tip_mass", self.tip_mass, scene, least)

    @property
    def _length(self) -> float:
        """Without load [m]."""
        return self.length or math.dist(self.start, self.end or self.start)

    @property
    def spool(self) -> Spool | None:
        """The spool on whose rim a wound cord lies."""
        return None if self.wound is None else Spool(math.hypot(*self.start[:2]))

    def coarser(self, factor: int) -> tuple[str, Part] | None:
        """Cords of fewer segments; None of a wound one, which would lie otherwise and end elsewhere."""
        return super().coarser(factor) if self.wound is None else None


@validated
class Bridges(Part):
    """Stiff links of no length that join the node pairs `Mesh.bridges`.

    Parameters
    ----------
    stiffness : float
        Of each link [N/m], above 0.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs import Bridges
    >>> Bridges(stiffness=1000.0).stiffness
    1000.0
    """

    kind: ClassVar[str] = "bridges"
    stiffness: Annotated[Positive, Unit("N/m")]

    def add_nodes(self, builder: Builder, where: str) -> None:
        """Give the links their stiffness. Raises SceneError where another part has."""
        builder.link_bridges(self.stiffness, where)

    def with_softened_film(self, factor: float) -> Bridges:
        """As soft as the film that they join."""
        return self.softened(1.0 / factor)

    def softened(self, factor: float) -> Bridges:
        """Links of `factor` times the stiffness."""
        return replace(self, stiffness=self.stiffness * factor)

    def step_advice(self, gain: float) -> str:
        """A smaller stiffness."""
        return f"a stiffness of {self.stiffness / gain**2:.3g} N/m or less would take it out of the limit"


_ALL: tuple[type[Part], ...] = (
    TipMasses,
    Tethers,
    Tether,
    Cord,
    Boltrope,
    Fixed,
    Moved,
    Bridges,
    Region,
    CreaseSet,
)
PARTS: dict[str, type[Part]] = {part.kind: part for part in _ALL}
"""The one list of parts: its `kind` in a scene file, and its class."""
