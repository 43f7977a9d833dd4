"""A hexagon, or another regular polygon, folded in strips along its sides and wound spirally round its hub.

Each of the n sides has a petal, a trapezoid of parallel strips with mountains and valleys in turn. Folded, its strips
stand on the hub's side, of length a, and all advance by a. From there to the next side each strip has to turn by 2
pi/n, at whatever distance y from the hub's side it lies; so what it is longer than a goes into a pleat at the vertex
of the hub, between two creases p1 and p2 through it. The folded image of the pleat is that of its mirror image in p1,
and that of the next petal is this one's, turned back by 2 pi/n about the vertex. Two reflections in lines that
include pi/n make that rotation, so that both images agree on p2 where p2 lies pi/n beyond p1, whatever the direction
of p1; Kawasaki's condition holds at every crossing with a fold line, for it is a reflection.

The image of a pleat reaches along the hub from p2 to p1. To wind all strips one way it has to begin at the vertex: so
p1 lies on the diagonal, and p2 square to the next side. Then fold lines of the pleat are parallel to that side, those
of the flat sail are polygons about its centre, and a pleat is y tan(pi/n) long. (The pleat that is symmetric about
the diagonal, 2 y tan(pi/(2 n)), folds flat too, but half of it lies before the vertex and half beyond.) The pleats of
the sides overlap on the hub; y tan(pi/n) over n a is the number of turns.

Wound, the shape is that of `_wound_petal`: p2 is the hairpin, and p1 the seam of an arm, whose inner half is the
pleat. Flat, the sail lies at z = 0 about the origin, the middle of side k at the azimuth 2 pi k/n. Stowed, the inner
edge is at z = 0 and fold lines are at z = 0 and z = the strip's height in turn.
"""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
from annotated_types import Ge, Le
from pydantic import BeforeValidator

from membrane_rs._arrays import Floats, Ints
from membrane_rs._bounds import check_nodes
from membrane_rs._numbers import MOST, whole
from membrane_rs._validation import Count, Positive, Unit, validated
from membrane_rs.errors import MeshError
from membrane_rs.folding._flat_petal import FlatPetal, flat_petal
from membrane_rs.folding._petals import Petals, fold_lines, zigzag
from membrane_rs.folding._strips import StripSail
from membrane_rs.folding._wound_petal import NEAREST, WoundPath, default_gap, wound_petal
from membrane_rs.folding.pattern import plan_of
from membrane_rs.mesh import Mesh
from membrane_rs.mesh.fold_angles import measured_fold_angles
from membrane_rs.mesh.queries import distinct

APEX = 2e-4
"""Distance along which the rows of a hairpin lie apart, over the length of a cell: 0.02 % of strain in two cells."""
SHUT = math.radians(175.0)
"""Fold angle from which a fold counts as shut [rad]."""
LEAST_ROWS = 16
"""Rows of cells by default, at least."""


@validated
class SpiralHexagon(StripSail):
    """A regular polygon of film, of six sides by default, wound spirally round a hub of as many.

    Parameters
    ----------
    radius : float
        Of the circle through the outer corners of the flat sail [m].
    strip_height : float
        Distance of fold lines in the flat sail, the height of the stowed one [m].
    strips : int
        Strips of each petal, from the hub outward.
    sides : int
        Sides of the polygon, at least 3.
    rows : int, optional
        Rows of cells from the hub to the outer edge, a multiple of strips. Default: the smallest one from 16 on.
    columns : int, optional
        Cells along a side of the hub. Default: so that they are about as long as those beyond it, which are the height
        of a row times tan(pi/sides).
    spool_radius : float, optional
        Least radius of the wound inner edge [m]; `wound_radius` is what the columns make of it. Default: as large as
        it can be, all of the inner edge on the hub. With a smaller one the hairpins move inward from the vertices, and
        the rest of the inner edge lies in the arms.
    layer_gap : float, optional
        Distance of layers, from one fold line to the next [m]; the strain of the stowed sail grows with it. Default: as
        of the wound `SquareSail`, 7.5 um at most.

    Raises
    ------
    MeshError
        Dimensions that do not go together.
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs.folding import SpiralHexagon
    >>> sail = SpiralHexagon()
    >>> mesh = sail.mesh()
    >>> mesh.node_count, len(mesh.creases), mesh.crossings().count
    (3780, 960, 0)
    >>> bool(abs(mesh.strain()).max() < 5e-4), round(sail.turns, 3)
    (True, 0.331)
    >>> sail.with_rows(40).rows
    40
    """

    radius: Annotated[Positive, Unit("m")] = 0.325
    strip_height: Annotated[Positive, Unit("m")] = 0.045
    strips: Count = 5
    sides: Annotated[int, BeforeValidator(whole), Ge(3), Le(MOST)] = 6
    rows: Count | None = None
    columns: Count | None = None
    spool_radius: Annotated[Positive, Unit("m")] | None = None
    layer_gap: Annotated[Positive, Unit("m")] | None = None

    def __post_init__(self) -> None:
        """Check dimensions and counts against each other."""
        if self.hub_apothem <= 0.0:
            raise MeshError(
                f"SpiralHexagon.strip_height = {self.strip_height:g}: {self.strips} strips of it (m) leave no hub in a "
                f"polygon of radius = {self.radius:g} with {self.sides} sides, {self._apothem:.6g} from its centre; "
                f"take less than {self._apothem / self.strips:.6g}, or fewer strips"
            )
        if self.rows is not None and self.rows % self.strips:
            raise MeshError(
                f"SpiralHexagon.rows = {self.rows}: must be a multiple of strips = {self.strips}; take "
                f"{math.ceil(self.rows / self.strips) * self.strips}"
            )
        rows = self.strips * self.rows_per_strip
        columns = self._columns()
        where = f"SpiralHexagon: {self.sides} sides, {rows} rows and {columns:.6g} columns along the hub"
        check_nodes(self.sides * (rows + 1.0) * (columns + rows), where, "take fewer", MeshError)
        path = self._path()
        most = path.cell / (2.0 * math.tan(math.pi / (self.sides * path.columns)))
        if path.spool_radius > most * (1.0 + 1e-9):
            raise MeshError(
                f"SpiralHexagon.spool_radius = {self.spool_radius:g}: must be at most {most:.6g} (m), where all of the "
                f"hub's {self.sides} sides of {self.hub_side:.6g} lie round it"
            )
        if self.layer_gap is not None and self.layer_gap < NEAREST * path.spool_radius:
            raise MeshError(
                f"SpiralHexagon.layer_gap = {self.layer_gap:g}: layers would lie in each other; make it "
                f"{NEAREST * path.spool_radius:.3g} or more (m)"
            )
        path.check("SpiralHexagon")

    @property
    def hub_apothem(self) -> float:
        """Distance of the hub's sides, the inner edge of the flat sail, from its centre [m]."""
        return self._apothem - self.strips * self.strip_height

    @property
    def hub_side(self) -> float:
        """Length of each side of the hub [m]."""
        return 2.0 * self.hub_apothem * self._slope

    @property
    def rows_per_strip(self) -> int:
        """Rows of cells in each strip."""
        return math.ceil(LEAST_ROWS / self.strips) if self.rows is None else self.rows // self.strips

    @property
    def wound_radius(self) -> float:
        """Radius of the circle through the corners of the innermost layer of the wound sail [m]."""
        return self._path().hub_radius

    @property
    def wound_outer_radius(self) -> float:
        """Distance of the outermost layer of the wound sail from the axis [m]."""
        return self._path().outer_radius

    @property
    def turns(self) -> float:
        """Turns of each arm round the hub, from the hairpin to the outer corner [-]."""
        return self._path().turns

    @property
    def corner_turn(self) -> float:
        """Angle from the corners of the flat sail to those of the stowed one [rad]."""
        return 2.0 * math.pi * self.turns

    def facts(self) -> dict[str, str]:
        """Radii, turns, distance of layers, strain and crossings of the wound sail.

        Returns
        -------
        dict of str to str
            Values with their units, by name.

        Examples
        --------
        >>> from membrane_rs.folding import SpiralHexagon
        >>> SpiralHexagon(rows=10).facts()["layers"]
        '0 pairs of triangles cross, 0 overlap, 0 touch'
        """
        path, mesh = self._path(), self.mesh()
        strain, met = 100.0 * mesh.strain(), mesh.crossings(limit=0)
        gap = float(path.offset[self.rows_per_strip] - path.offset[0])
        return {
            "roll": f"radius {path.hub_radius:.5g} to {path.outer_radius:.5g} m, {path.turns:.4g} turns, layers "
            f"{gap:.3g} m apart, strain {strain.min():.2g} to {strain.max():.2g} %; {path.on_hub} of {path.columns} "
            "columns lie on the hub between two hairpins",
            "layers": f"{met.count} pairs of triangles cross, {met.overlapping} overlap, {met.touching} touch",
        }

    def cord_path(self, node: Floats) -> Floats | None:
        """(k, 2) points in plan [m] of a cord to a node of the diagonals, at `node` (3,) in the flat sail.

        It lies in the middle of an arm, from the hairpin on. None for other nodes.

        Parameters
        ----------
        node : (3,) float64
            Place of the node in the flat sail [m].

        Returns
        -------
        (k, 2) float64, or None
            Points in plan [m].

        Raises
        ------
        InputError, InputTypeError
            No three finite numbers.

        Examples
        --------
        >>> from membrane_rs.folding import SpiralHexagon
        >>> sail = SpiralHexagon()
        >>> mesh = sail.mesh()
        >>> corner = mesh.node_sets["corners"][0]
        >>> bool(abs(sail.cord_path(mesh.reference[corner])[-1] - mesh.positions[corner][:2]).max() < 1e-12)
        True
        """
        x, y = plan_of(self, node)
        turn = 2.0 * math.pi / self.sides
        diagonal = math.floor(math.atan2(y, x) / turn)
        azimuth = turn * (diagonal + 0.5)
        if abs(y * math.cos(azimuth) - x * math.sin(azimuth)) > 1e-9 * self.radius:
            return None
        row = round((math.hypot(x, y) * math.cos(0.5 * turn) - self.hub_apothem) / self.row_height)
        return self._path().diagonal_path(diagonal, row)

    def mesh(self) -> Mesh:
        """The flat mesh with its creases, and the stowed sail as its positions.

        Creases are the fold lines, then the pleats: first those on the diagonals, then the hairpins. Node sets:
        "corners" and "inner_corners" (on the diagonals, counter-clockwise), "petal-0" and on (of each side),
        "diagonals", "inner_edge", "guide_bars", which are held where the stowed sail is relaxed (all), "on_hub", the
        columns from one hairpin of each petal to where it leaves the hub, and "hairpins", those of the hairpins alone.
        """
        petal, path = self._petal(), self._path()
        height = self.strip_height * zigzag(self.strips, self.rows_per_strip)
        petals = Petals(petal, self.sides)
        reference = petals.points(petal.points / [self._slope, 1.0, 1.0], self.radius)
        positions = petals.points(wound_petal(petal, path, height), self.radius)
        number, kept = petals.numbers()
        creases, angles = self._creases(petal, path)
        sets = {f"petal-{p}": distinct(number[petals.copies[p] + np.arange(petals.size)]) for p in range(self.sides)}
        sets |= {"corners": number[petals.here[:, -1]], "inner_corners": number[petals.here[:, 0]]}
        first = [i + path.free for i in range(len(petal.index))]  # of each row, on the hub
        for name, nodes in (
            ("diagonals", [row[-1:] for row in petal.index]),
            ("inner_edge", petal.index[:1]),
            ("guide_bars", petal.index),
            ("on_hub", [row[k : k + path.on_hub + 1] for k, row in zip(first, petal.index, strict=True)]),
            ("hairpins", [row[k : k + 1] for k, row in zip(first, petal.index, strict=True)]),
        ):
            sets[name] = distinct(number[petals.of_all(np.concatenate(nodes))])
        flat = Mesh(
            reference[kept],
            number[(petals.copies[:, :, None] + petal.triangles).reshape(-1, 3)],
            creases=number[(petals.copies[:, :, None] + creases).reshape(-1, 2)],
        )
        return Mesh(
            flat.reference,
            flat.triangles,
            positions=positions[kept],
            creases=flat.creases,
            fold_angles=_with_open_folds(flat, positions[kept], np.tile(angles, self.sides)),
            node_sets=sets,
            source=self,
        )

    @property
    def _slope(self) -> float:
        """Half of a side over its distance from the centre [-]."""
        return math.tan(math.pi / self.sides)

    @property
    def _apothem(self) -> float:
        """Distance of the outer sides from the centre [m]."""
        return self.radius * math.cos(math.pi / self.sides)

    def _columns(self) -> float:
        """Cells along a side of the hub."""
        return self.columns or max(1.0, round(min(2.0 * self.hub_apothem / self.row_height, MOST)))

    def _petal(self) -> FlatPetal:
        """The petal of side 0, in half lengths of its rows."""
        rows = self.strips * self.rows_per_strip
        inner, outer = (self._slope * apothem for apothem in (self.hub_apothem, self._apothem))
        return flat_petal("ruled", inner, outer, rows, int(self._columns()))

    def _path(self) -> WoundPath:
        columns, rows = int(self._columns()), self.strips * self.rows_per_strip
        cell, arm_cell = self.hub_side / columns, self.row_height * self._slope
        spool_radius = self.spool_radius or cell / (2.0 * math.tan(math.pi / (self.sides * columns)))
        gap = self.layer_gap or default_gap(spool_radius, (cell, arm_cell), self.strips)
        return WoundPath(
            spool_radius=spool_radius,
            inner_width=self.hub_side,
            columns=columns,
            arm_cell=arm_cell,
            offset=gap * (0.5 + np.arange(rows + 1) / self.rows_per_strip),
            strips=self.strips,
            sides=self.sides,
            apex=APEX,
        )

    def _creases(self, petal: FlatPetal, path: WoundPath) -> tuple[Ints, Floats]:
        """(k, 2) creases of a petal, its fold lines, diagonal and hairpin, and (k,) their fold angles [rad].

        The upper side faces the hub in strip 0. Between strips 0 and 1 lower sides meet, a mountain; so they do in the
        hairpin of strip 0, and upper sides on its diagonal; from strip to strip all are mountains and valleys in turn.
        """
        pairs = fold_lines(petal, self.strips, self.rows_per_strip)
        strip = np.arange(len(petal.index) - 1) // self.rows_per_strip
        mountain = np.where(strip % 2 == 0, -math.pi, math.pi)
        seam = np.array([row[-1] for row in petal.index])
        hairpin = np.array([row[i + path.free] for i, row in enumerate(petal.index)])
        angles = [np.full(len(pair), -math.pi if k % 2 else math.pi) for k, pair in enumerate(pairs, start=1)]
        pleats = [np.stack([nodes[:-1], nodes[1:]], axis=1) for nodes in (seam, hairpin)]
        return np.concatenate([*pairs, *pleats]), np.concatenate([*angles, -mountain, mountain])


def _with_open_folds(mesh: Mesh, positions: Floats, angles: Floats) -> Floats:
    """(c,) fold angles [rad], in place of pi and -pi those at `positions` where folds of that side stand open: hairpins
    of cells that are long beside the hub's radius.
    """
    found = measured_fold_angles(mesh, positions)
    is_open = (np.abs(found) < SHUT) & (found * angles > 0.0)
    return np.where(is_open, found, angles)
