"""Regions: parts that give some of the film properties of its own."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import field, replace
from typing import Annotated, Any, ClassVar

import numpy as np

from membrane_rs._arrays import Bools, Floats, Ints
from membrane_rs._validation import (
    Count,
    Finite,
    Fraction,
    NodeSets,
    NonNegative,
    Pair,
    Points,
    Positive,
    TriangleSets,
    Unit,
    show,
    validated,
)
from membrane_rs.errors import InputError, SceneError
from membrane_rs.material import Material
from membrane_rs.scene.builder import Builder
from membrane_rs.scene.components import FilmRegion, Optics
from membrane_rs.scene.law import Surroundings
from membrane_rs.scene.optics import OF_SIDES, optics_of
from membrane_rs.scene.part import Part
from membrane_rs.scene.plausible import FILM, STRETCHED, Doubt, implausible
from membrane_rs.scene.selection import has_numbers

MOST_STRAIN = 0.5
"""Magnitude of a natural strain, at most [-]."""
MOST_CURVATURE, FARTHEST = 1e9, 1e12
"""Magnitudes of a natural curvature [1/m], that of a roll of 1 nm, and of a corner's place [m], at most."""
ROUNDING = 1e-9
"""Distance over the size of a polygon below which a point lies on its side."""
MOST_SIDES, EACH_SIDE = 5 * 10**8, 1000
"""Sides of the polygons of a region times triangles of the mesh, at most, which take some seconds; and how many
triangles a side takes as long as beside its own."""
THICKEST, HEAVIEST = 1e3, 1e3
"""Thickness of a region, and mass per area of its devices, over that of the film, from which it is hardly meant [-]:
solar cells of 25 um are three times as thick as the film of IKAROS."""


@validated
class Region(Part):
    """Triangles of the film with properties of their own: solar cells, reinforced edges, devices that curl it.

    The triangles are those of triangle sets of the mesh, those between the nodes of node sets, or those whose centre
    lies in a polygon of the flat shape; one of the three is given. What is left out is that of the whole film. No
    triangle belongs to two regions.

    Parameters
    ----------
    triangles : str, sequence of str or sequence of int, optional
        A triangle set of the mesh, names of several, or triangle indices. "all": the whole film, in a mesh without a
        set of that name.
    nodes : str, sequence of str or sequence of int, optional
        A node set, names of several, or node indices: triangles whose nodes all belong to one of them.
    polygon : sequence of (float, float), optional
        Corners (x, y) in the flat shape [m], from 3 to 10^5, within 10^12 m.
    copies : int
        How often the polygon is repeated round the hub's axis, at equal angles; too many for the mesh are refused, and
        copies that overlap where curvature or natural strain of one direction differ between them.
    youngs_modulus : float or None
        E [Pa], above 0.
    density : float or None
        rho [kg/m3], above 0.
    thickness : float or None
        h [m], above 0. Stretch goes with E h, mass with rho h, buckling with h^2, creases and bending with E h^3; an
        edge between two films has of each the mean of both sides, or the sum of their halves.
    areal_mass : float
        Mass per area beside that of the film, as of devices and glue [kg/m2].
    buckling : float or None
        alpha between creases [-], in place of that of the film's law.
    bending_stiffness : float or None
        D [N m] in place of E h^3 / (12 (1 - nu^2)), as of a film with devices; felt by the law `Bending`.
    curvature : tuple of float
        Natural curvatures (kappa_1, kappa_2) [1/m] along `direction` and across it, to which the law `Bending` turns
        the film, from -1e9 to 1e9; positive where it curls towards the side of its normals, from which triangles run
        counter-clockwise.
    natural_strain : tuple of float
        Strains (e_1, e_2) of the flat shape [-], along `direction` and across it, at which the film is free of stress,
        from -0.5 to 0.5: a warmer film has its thermal strain, and one below 0 is taut where its edge is held. A stage
        that sets it makes the film warmer or colder.
    direction : float
        Of kappa_1 and e_1 in the flat shape, from the x axis on [rad]; in a copy of the polygon it is turned with it.
    front_specular, front_diffuse : float or None
        Shares of sunlight, as those of `SolarPressure` [-]; given together, in place of all of its optical properties.
    back_specular, back_diffuse : float or None
        Those of the back [-]. None: as the front.
    front_emissivity, front_lambert, back_emissivity, back_lambert : float or None
        Of emission [-]. None: as the front, and there 1 and 2/3.

    Raises
    ------
    InputError, InputTypeError
        A value outside its range, or of a wrong type; no triangles named or in two ways, copies or direction without
        effect, optical properties without those of the front or that reflect more than all light.

    Examples
    --------
    >>> from membrane_rs import Region
    >>> cells = Region(polygon=[(1.0, -0.5), (2.0, -0.5), (2.0, 0.5), (1.0, 0.5)], copies=4, thickness=25e-6)
    >>> cells.copies, cells.youngs_modulus
    (4, None)
    """

    kind: ClassVar[str] = "region"
    triangles: TriangleSets | None = None
    nodes: NodeSets | None = field(default=None, kw_only=True)
    polygon: Annotated[Points | None, Unit("m")] = field(default=None, kw_only=True)
    copies: Count = field(default=1, kw_only=True)
    youngs_modulus: Annotated[Positive | None, Unit("Pa")] = field(default=None, kw_only=True)
    density: Annotated[Positive | None, Unit("kg/m3")] = field(default=None, kw_only=True)
    thickness: Annotated[Positive | None, Unit("m")] = field(default=None, kw_only=True)
    areal_mass: Annotated[NonNegative, Unit("kg/m2")] = field(default=0.0, kw_only=True)
    buckling: NonNegative | None = field(default=None, kw_only=True)
    bending_stiffness: Annotated[NonNegative | None, Unit("N m")] = field(default=None, kw_only=True)
    curvature: Annotated[Pair, Unit("1/m")] = field(default=(0.0, 0.0), kw_only=True)
    natural_strain: Pair = field(default=(0.0, 0.0), kw_only=True)
    direction: Annotated[Finite, Unit("rad")] = field(default=0.0, kw_only=True)
    front_specular: Fraction | None = field(default=None, kw_only=True)
    front_diffuse: Fraction | None = field(default=None, kw_only=True)
    front_emissivity: Fraction | None = field(default=None, kw_only=True)
    front_lambert: Fraction | None = field(default=None, kw_only=True)
    back_specular: Fraction | None = field(default=None, kw_only=True)
    back_diffuse: Fraction | None = field(default=None, kw_only=True)
    back_emissivity: Fraction | None = field(default=None, kw_only=True)
    back_lambert: Fraction | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        """Check fields against each other."""
        given = [name for name in ("triangles", "nodes", "polygon") if getattr(self, name) is not None]
        if len(given) != 1:
            found = " and ".join(given) + " are given together" if given else "no triangles are named"
            raise InputError(f"Region: {found}; give one of triangles, nodes and polygon")
        if self.polygon is not None and len(self.polygon) < 3:
            raise InputError(f"Region.polygon = {show(self.polygon)}: must have three corners or more")
        far = next((corner for corner in self.polygon or () if max(map(abs, corner)) > FARTHEST), None)
        if far is not None:
            raise InputError(f"Region.polygon: corner {show(far)} must be within {FARTHEST:g} of the origin (m)")
        if self.polygon is None and self.copies != 1:
            raise InputError(f"Region.copies = {self.copies}: a polygon is repeated, and none is given; leave it out")
        if any(abs(value) > MOST_CURVATURE for value in self.curvature):
            raise InputError(f"Region.curvature = {show(self.curvature)}: each must be -1e9 to 1e9 (1/m)")
        if any(abs(value) > MOST_STRAIN for value in self.natural_strain):
            raise InputError(f"Region.natural_strain = {show(self.natural_strain)}: each must be -0.5 to 0.5")
        if self.direction != 0.0 and self.curvature == self.natural_strain == (0.0, 0.0):
            what = "is that of a natural curvature or strain; give curvature or natural_strain, or leave it out"
            raise InputError(f"Region.direction = {show(self.direction)}: {what}")
        self._optics()

    def add_loads(self, builder: Builder, where: str) -> None:
        """Give the triangles their film.

        Raises
        ------
        SceneError
            No membrane, sets or elements that are not there, no triangle at all, one of another region.
        """
        mesh, material = builder.mesh, builder.material
        if mesh is None or material is None:
            raise SceneError(f"{where}: the scene has no membrane, so that no region of it; leave the part out")
        name, turned = self._turned_triangles(builder, where)
        if not any(len(triangles) for _, triangles in turned):
            raise SceneError(f"{where}.{name} = {show(getattr(self, name))}: there is no triangle of the mesh in it")
        for angle, triangles in turned:
            if len(triangles):
                builder.add_region(self._film(material, triangles, angle, where))

    def _turned_triangles(self, builder: Builder, where: str) -> tuple[str, list[tuple[float, Ints]]]:
        """The field that names the triangles; and the triangles, those of each turned copy [rad] that differs."""
        if self.triangles is not None:
            return "triangles", [(0.0, builder.triangles_of_sets(self.triangles, where, "triangles"))]
        if self.nodes is not None:
            return "nodes", [(0.0, builder.triangles(self.nodes, where, "nodes"))]
        corners, centres = np.array(self.polygon), np.zeros((0, 2))
        if builder.mesh is not None:
            centres = builder.reference[builder.mesh.triangles][..., :2].mean(axis=1)
        if self.copies * len(corners) * (len(centres) + EACH_SIDE) > MOST_SIDES:
            what = f"{self.copies} polygons of {len(corners)} corners take too long in {len(centres)} triangles"
            raise SceneError(f"{where}.copies = {self.copies}: {what}; take fewer copies or corners")
        angles = 2.0 * math.pi / self.copies * np.arange(self.copies)
        found: list[tuple[float, Ints]] = []
        copy_of: Ints = np.full(len(centres), -1)
        is_round = self.curvature[0] == self.curvature[1] and self.natural_strain[0] == self.natural_strain[1]
        for k, angle in enumerate(angles.tolist()):
            sine, cosine = math.sin(angle), math.cos(angle)
            back = centres @ np.array([[cosine, -sine], [sine, cosine]])
            inside = _inside(back, corners)
            twice = np.flatnonzero(inside & (copy_of >= 0))
            if len(twice) and not is_round:
                self._check_copies(where, copy_of, k, twice[_within(back[twice], corners)])
            own = np.flatnonzero(inside & (copy_of < 0))
            copy_of[own] = k
            found.append((angle, own))
        return "polygon", [(0.0, np.flatnonzero(copy_of >= 0))] if is_round else found

    def _check_copies(self, where: str, copy_of: Ints, copy: int, shared: Ints) -> None:
        """Refuse a copy of the polygon with triangles of an earlier one, whose film is turned otherwise."""
        others = copy_of[shared]
        # Copies half a turn apart have the same film: curvature and strain look alike from both ends.
        shared = shared[2 * (copy - others) != self.copies]
        if len(shared):
            first = copy_of[shared[0]]
            what = f"copies {first} and {copy} share triangle {shared[0]} ({len(shared)} such), where their directions"
            remedy = "differ; take fewer copies or a narrower polygon"
            raise SceneError(f"{where}.copies = {self.copies}: {what} {remedy}")

    def _film(self, material: Material, triangles: Ints, angle: float, where: str) -> FilmRegion:
        """The film of triangles of a copy that is turned by an angle [rad]."""
        return FilmRegion(
            triangles=triangles,
            youngs_modulus=self.youngs_modulus or material.youngs_modulus,
            poisson_ratio=material.poisson_ratio,
            density=self.density or material.density,
            thickness=self.thickness or material.thickness,
            areal_mass=self.areal_mass,
            buckling=self.buckling,
            bending_stiffness=self.bending_stiffness,
            curvature=_turned(self.curvature, self.direction + angle),
            natural_strain=_turned(self.natural_strain, self.direction + angle),
            optics=self._optics(),
            name=where,
        )

    def _optics(self) -> Optics | None:
        """What both sides do with light; None: that of the law. Raises InputError."""
        sides = [f"{side}_{name}" for side in ("front", "back") for name in OF_SIDES]
        given = {name: getattr(self, name) for name in sides if getattr(self, name) is not None}
        if not given:
            return None
        for name in ("front_specular", "front_diffuse"):
            if name not in given:
                first, value = next(iter(given.items()))
                raise InputError(f"Region.{first} = {show(value)}: needs {name} beside it, from 0 to 1")
        return optics_of("Region", given)

    @property
    def numbering_field(self) -> str | None:
        """The field by which it names triangles or nodes by their numbers."""
        return next((name for name in ("triangles", "nodes") if has_numbers(getattr(self, name))), None)

    @property
    def laws_needed(self) -> dict[str, tuple[str, ...]]:
        """Those of each property that is given, without material, thickness and mass."""
        films = ("springs", "rectangles", "triangles")
        needed = {"bending_stiffness": ("bending",), "curvature": ("bending",), "buckling": films}
        needed |= {"natural_strain": films}
        needed |= {f"{side}_{name}": ("solar_pressure",) for side in ("front", "back") for name in OF_SIDES}
        return {name: laws for name, laws in needed.items() if getattr(self, name) not in (None, (0.0, 0.0))}

    def for_modulus(self, factor: float) -> Region:
        """E and D with the film's, by which the moments of `Bending` stay as they were."""
        names = ("youngs_modulus", "bending_stiffness")
        own: dict[str, Any] = {name: getattr(self, name) * factor for name in names if getattr(self, name)}
        return replace(self, **own)

    def with_softened_film(self, factor: float) -> Region:
        """As soft as the film: E over the factor, with buckling forces and the moments of `Bending` as they were."""
        soft = self.for_modulus(1.0 / factor)
        return soft if self.buckling is None else replace(soft, buckling=self.buckling * factor)

    def implausible_values(self, scene: Surroundings, where: str) -> Iterator[Doubt]:
        """A region is thinner than `THICKEST` films, its devices are lighter than `HEAVIEST` times the film, and it has
        no natural strain at which films are torn.
        """
        if scene.material is None or scene.mesh is None:
            return
        film = scene.material.thickness
        if self.thickness is not None:
            reason = f"the film of the scene is {film:.3g} m thick"
            yield from implausible(
                f"{where}.thickness", self.thickness, "m", reason, least=film / THICKEST, most=film * THICKEST,
                units={"um": 1e-6, "mm": 1e-3}, derived_from=FILM,
            )  # fmt: skip
        own, units = scene.material.density * film, {"g/m2": 1e-3}
        place, reason, most = f"{where}.areal_mass", f"the film weighs {own:.3g} kg/m2", HEAVIEST * own
        strain = max(map(abs, self.natural_strain))
        torn = f"films are torn at a strain of {STRETCHED:g}, and expand by some 3e-5 a kelvin"
        yield from implausible(f"{where}.natural_strain", strain, "", torn, most=STRETCHED)
        yield from implausible(place, self.areal_mass, "kg/m2", reason, most=most, units=units, derived_from=FILM)


def _turned(values: tuple[float, float], angle: float) -> tuple[float, float, float]:
    """xx, yy and xy of a tensor of principal values, the first at an angle from x [rad]."""
    mean, half = 0.5 * (values[0] + values[1]), 0.5 * (values[0] - values[1])
    along, mixed = half * math.cos(2.0 * angle), half * math.sin(2.0 * angle)
    return (mean + along, mean - along, mixed)


def _within(points: Floats, corners: Floats) -> Bools:
    """Whether points (n, 2) lie off the sides of a polygon (k, 2) by more than rounding: its copies may touch."""
    near: Bools = np.zeros(len(points), bool)
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        side = end - start
        share = np.clip((points - start) @ side / max(float(side @ side), np.finfo(float).tiny), 0.0, 1.0)
        near |= np.hypot(*(points - start - share[:, None] * side).T) <= ROUNDING * np.abs(corners).max()
    return ~near


def _inside(points: Floats, corners: Floats) -> Bools:
    """Whether points (n, 2) lie in a polygon (k, 2): the half line from each crosses an odd number of its sides."""
    inside: Bools = np.zeros(len(points), bool)
    for (x, y), (to_x, to_y) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        crosses = (points[:, 1] < y) != (points[:, 1] < to_y)
        at_x = x + (points[crosses, 1] - y) / (to_y - y) * (to_x - x)
        inside[crosses] ^= points[crosses, 0] < at_x
    return inside
