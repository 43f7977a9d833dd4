"""A square sail of four petals, folded into a cross round a spool, or wound round it.

Each petal is a trapezoid with parallel fold lines, alternately mountain and valley. In the cross its strips run round
the spool from the petal's middle and turn outward along the diagonals; wound, they go on round the spool in arms of two
halves (`_wound_petal`). Flat, the sail lies at z = 0 about the
origin, its petals at 0, 90, 180 and 270 degrees, its diagonals between them. Stowed, the inner edge is at z =
0 and fold lines are at z = 0 and z = the strip's height in turn.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np

from membrane_rs._arrays import Bools, Floats
from membrane_rs._bounds import check_nodes
from membrane_rs._validation import Count, NonNegative, Positive, Unit, Whole, validated
from membrane_rs.errors import MeshError
from membrane_rs.folding._flat_petal import FlatPetal, default_columns, flat_petal, mean_columns
from membrane_rs.folding._petals import Petals, fold_lines, zigzag
from membrane_rs.folding._stowed_petal import StowedPath, stowed_petal
from membrane_rs.folding._strips import StripSail
from membrane_rs.folding._wound_petal import NEAREST, THICKEST, WoundPath, default_gap, wound_petal
from membrane_rs.folding.pattern import plan_of
from membrane_rs.mesh import Mesh
from membrane_rs.mesh.queries import distinct

_NARROW = ("fan", "even")
"""Layouts whose cells are a quarter as wide as high."""


@validated
class SquareSail(StripSail):
    """A square sail and its folds, stowed as a cross or wound.

    Parameters
    ----------
    outer_width, inner_width : float
        Side of the square, and of the square hole in its middle [m].
    fold_lines : int
        Fold lines in each petal; it has one strip more.
    rows : int, optional
        Rows of cells from the inner to the outer edge, a multiple of the number of strips. Default: the
        smallest such number from 16 on (8 on, in the layouts "fan" and "even").
    columns : int, optional
        Cells along the inner edge. Default: so that cells are a little narrower than high (a quarter as wide
        in the layouts "fan" and "even"). The layout "equilateral" has none to choose.
    spool_radius : float
        Radius at which the innermost layer goes round the spool [m]; wound, the least one: `wound_radius` is what
        the columns make of it.
    fillet_radius : float, optional
        Of the cross: radius of the turn from the spool to the diagonal [m]. Default: 3 mm; in the layouts "fan" and
        "even", whose edges are cut short by a sharp turn, 10 mm.
    layer_gap : float, optional
        Distance of layers, from one fold line to the next [m]; the strain of the stowed sail grows with it.
        Default: 7.5 um, the thickness of the film that the default dimensions belong to, so that layers touch;
        wound, no more than keeps the strain within 0.25 %, 2 um with seven fold lines on a spool of 25 mm.
    diagonal_gap : float, optional
        Distance of the innermost layer from the diagonal plane, or from the middle of a wound arm [m]. Default:
        3.75 um; wound, half the layers' distance.
    layout : "ruled", "equilateral", "fan" or "even"
        How nodes lie in the flat petal, see `_flat_petal`. "ruled", the paper's, has right triangles, whose net of
        springs is soft in shear (`membrane_rs.mesh.net_moduli`). "equilateral" represents the film in every direction
        but at the slanted sides; stowed, its edges along the rows cut the turns short. "fan" and "even", whose counts
        are equal, have negative spring constants and are kept for comparison.
    join : "merge" or "bridge"
        Petals share the nodes on the diagonals, or have their own, joined by stiff bridges.
    stowage : "cross", "wound" or "flat"
        The shape of the start: four straight arms on the diagonals; all of it wound round the spool, counter-clockwise
        seen from +z, in the layout "ruled"; or flat at z = 0, deployed, its fold angles 0.

    Raises
    ------
    MeshError
        Dimensions that do not go together.
    InputError, InputTypeError
        A value outside its range, or of a wrong type.

    Examples
    --------
    >>> from membrane_rs.folding import SquareSail
    >>> sail = SquareSail(outer_width=0.3, inner_width=0.09, fold_lines=5)
    >>> mesh = sail.mesh()
    >>> mesh.node_count == len(mesh.positions), sorted(sail.counts())
    (True, ['elements', 'masses', 'springs'])
    >>> finer = sail.refined(2.0).mesh()
    >>> len(finer.triangles) == 4 * len(mesh.triangles)
    True
    >>> sail.with_rows(24).rows
    24
    """

    outer_width: Annotated[Positive, Unit("m")] = 0.455
    inner_width: Annotated[Positive, Unit("m")] = 0.103
    fold_lines: Whole = 7
    rows: Count | None = None
    columns: Count | None = None
    spool_radius: Annotated[Positive, Unit("m")] = 0.025
    fillet_radius: Annotated[Positive, Unit("m")] | None = None
    layer_gap: Annotated[NonNegative, Unit("m")] | None = None
    diagonal_gap: Annotated[NonNegative, Unit("m")] | None = None
    layout: Literal["ruled", "equilateral", "fan", "even"] = "ruled"
    join: Literal["merge", "bridge"] = "merge"
    stowage: Literal["cross", "wound", "flat"] = "cross"

    def __post_init__(self) -> None:
        """Check dimensions and counts against each other."""
        if self.outer_width <= self.inner_width:
            raise MeshError(
                f"SquareSail.outer_width = {self.outer_width:g}: must be greater than inner_width = "
                f"{self.inner_width:g} (m)"
            )
        if self.rows is not None and self.rows % self.strips:
            raise MeshError(
                f"SquareSail.rows = {self.rows}: must be a multiple of {self.strips} (strips that "
                f"{self.fold_lines} fold lines make); take {math.ceil(self.rows / self.strips) * self.strips}"
            )
        if self.layout == "equilateral" and self.columns is not None:
            raise MeshError(
                f'SquareSail.columns = {self.columns}: the layout "equilateral" has none to choose; leave it out and '
                "set rows"
            )
        rows = self.strips * self.rows_per_strip
        check_nodes(4.0 * rows * rows, f"SquareSail: {rows} rows", "take fewer, or fewer fold lines", MeshError)
        columns = self._columns()
        nodes = 4.0 * rows * mean_columns(self.layout, rows, columns)
        where = f"SquareSail: {rows} rows and {columns:.6g} columns along the inner edge"
        check_nodes(nodes, where, "take fewer; without columns, a wider film or fewer rows", MeshError)
        if self.stowage == "cross":
            self._path()
        elif self.stowage == "wound":
            self._check_wound()

    @property
    def strips(self) -> int:
        """Strips of each petal."""
        return self.fold_lines + 1

    @property
    def strip_height(self) -> float:
        """Distance of fold lines in the flat sail [m]."""
        return 0.5 * (self.outer_width - self.inner_width) / self.strips

    @property
    def flat_corner_radius(self) -> float:
        """Distance of the outer corners from the centre of the flat sail [m]."""
        return self.outer_width / math.sqrt(2.0)

    @property
    def rows_per_strip(self) -> int:
        """Rows of cells in each strip."""
        if self.rows is not None:
            return self.rows // self.strips
        return math.ceil((8 if self.layout in _NARROW else 16) / self.strips)

    @property
    def wound_radius(self) -> float | None:
        """Radius of the circle through the corners of the innermost layer of the wound sail [m]; None in the cross.

        It follows from the columns of the inner edge: the smallest one, not less than spool_radius, at which a whole
        number of cells spans a quarter turn from one hairpin to the next.
        """
        return self._wound_path().hub_radius if self.stowage == "wound" else None

    @property
    def wound_outer_radius(self) -> float | None:
        """Distance of the outer corners of the wound sail from the axis [m]; None in the cross."""
        return self._wound_path().outer_radius if self.stowage == "wound" else None

    @property
    def turns(self) -> float | None:
        """Turns of each arm round the hub, from the hairpin to the outer corner [-]; None in the cross."""
        return self._wound_path().turns if self.stowage == "wound" else None

    @property
    def corner_turn(self) -> float:
        """Angle from the corners of the flat sail to those of the stowed one [rad]; 0 in the cross."""
        return 2.0 * math.pi * (self.turns or 0.0)

    def facts(self) -> dict[str, str]:
        """Radii, turns and distance of layers of the wound sail; nothing of the cross.

        Returns
        -------
        dict of str to str
            Values with their units, by name.

        Examples
        --------
        >>> from membrane_rs.folding import SquareSail
        >>> list(SquareSail(stowage="wound").facts())
        ['roll']
        """
        if self.stowage != "wound":
            return {}
        path = self._wound_path()
        gap = float(path.offset[self.rows_per_strip] - path.offset[0])
        return {
            "roll": f"radius {path.hub_radius:.5g} to {path.outer_radius:.5g} m, {path.turns:.4g} turns, layers "
            f"{gap:.3g} m apart; {path.on_hub} of {path.columns} columns lie on the hub between two hairpins"
        }

    def cord_path(self, node: Floats) -> Floats | None:
        """(k, 2) points in plan [m] of a cord to a node of the diagonals, at `node` (3,) in the flat sail.

        In the wound sail it lies in the middle of an arm, from the hairpin on. None for other nodes, and in the cross.

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
        >>> from membrane_rs.folding import SquareSail
        >>> sail = SquareSail()
        >>> sail.cord_path(sail.mesh().reference[0]) is None
        True
        """
        x, y = plan_of(self, node)
        row = round((abs(x) - 0.5 * self.inner_width) / self.row_height)
        if self.stowage != "wound" or abs(abs(x) - abs(y)) > 1e-9 * self.outer_width:
            return None
        return self._wound_path().diagonal_path(math.floor(math.atan2(y, x) / (0.5 * math.pi)), row)

    def counts(self) -> dict[str, int]:
        """Masses, springs and elements of the four petals, each petal counted by itself."""
        petal = self._petal()
        nodes, elements = sum(map(len, petal.along)), len(petal.triangles)
        springs = nodes + elements - 1  # Euler's formula for a disc
        return {"masses": 4 * nodes, "springs": 4 * springs, "elements": 4 * elements}

    def mesh(self) -> Mesh:
        """The flat mesh with its creases, and the stowed sail as its positions.

        Node sets: "corners" and "inner_corners" (at 45, 135, 225, 315 degrees when flat), "petal-0" to "petal-3" (at
        0, 90, 180, 270 degrees), "diagonals", and "guide_bars", which are held where the stowed sail is relaxed: what
        lies round the spool and in the fillets; wound, the whole roll. Wound, "on_hub" too, the columns from one
        hairpin of each petal to where it leaves the hub, and "hairpins", those of the hairpins alone.
        """
        petal = self._petal()
        height = self.strip_height * zigzag(self.strips, self.rows_per_strip)
        stowed, stowed_sets = self._stowed(petal, height)
        pairs = fold_lines(petal, self.strips, self.rows_per_strip)
        creases = np.concatenate([*pairs, np.empty((0, 2), dtype=np.int64)])
        # Between strips 0 and 1 the lower sides meet: a mountain. Then valley and mountain in turn.
        fold = 0.0 if self.stowage == "flat" else math.pi
        angles = np.repeat([fold if k % 2 == 0 else -fold for k in range(1, self.strips)], list(map(len, pairs)))

        petals = Petals(petal, 4, self.join == "merge")
        reference, positions = (petals.points(points, self.outer_width) for points in (petal.points, stowed))
        number, kept = petals.numbers()
        copies, here, there = petals.copies, petals.here, petals.there
        sets = {f"petal-{p}": distinct(number[copies[p] + np.arange(petals.size)]) for p in range(4)}
        sets["corners"], sets["inner_corners"] = number[here[:, -1]], number[here[:, 0]]
        sets["diagonals"] = distinct(number[np.concatenate([here, there], axis=1)])
        for name, is_in in stowed_sets.items():
            sets[name] = distinct(number[petals.of_all(np.flatnonzero(is_in))])
        return Mesh(
            reference[kept],
            number[(copies[:, :, None] + petal.triangles).reshape(-1, 3)],
            positions=positions[kept],
            creases=number[(copies[:, :, None] + creases).reshape(-1, 2)],
            fold_angles=np.tile(angles, 4),
            node_sets=sets,
            bridges=None if self.join == "merge" else np.stack([here.ravel(), there.ravel()], axis=1),
            source=self,
        )

    def _petal(self) -> FlatPetal:
        rows = self.strips * self.rows_per_strip
        return flat_petal(self.layout, self.inner_width / 2, self.outer_width / 2, rows, int(self._columns()))

    def _columns(self) -> float:
        """Cells along the inner edge."""
        rows = self.strips * self.rows_per_strip
        return self.columns or default_columns(self.layout, self.inner_width, self.row_height, rows)

    def _stowed(self, petal: FlatPetal, height: Floats) -> tuple[Floats, dict[str, Bools]]:
        """(n, 3) stowed nodes of the petal about the x axis [m], and its node sets by name, (n,)."""
        if self.stowage == "flat":
            return petal.points, {}
        if self.stowage == "cross":
            points, held = stowed_petal(petal, self._path(), height, by_chord=self.layout == "ruled")
            return points, {"guide_bars": held}
        path = self._wound_path()
        along = np.concatenate(petal.along)
        sets = {
            "guide_bars": np.ones(len(along), dtype=bool),
            "on_hub": np.abs(along) < path.hairpin + 0.5 * path.cell,
            "hairpins": np.abs(along + path.hairpin) < 0.5 * path.cell,
        }
        return wound_petal(petal, path, height), sets

    def _wound_path(self) -> WoundPath:
        columns = int(self._columns())
        gap = self.layer_gap
        if gap is None:
            gap = default_gap(self.spool_radius, (self.inner_width / columns, self.row_height), self.strips)
        first = 0.5 * gap if self.diagonal_gap is None else self.diagonal_gap
        return WoundPath(
            spool_radius=self.spool_radius,
            inner_width=self.inner_width,
            columns=columns,
            arm_cell=self.row_height,
            offset=first + gap * np.arange(self.strips * self.rows_per_strip + 1) / self.rows_per_strip,
            strips=self.strips,
        )

    def _check_wound(self) -> None:
        if self.layout != "ruled":
            raise MeshError(
                f'SquareSail.layout = "{self.layout}": a wound sail bends about columns that all rows share; take the '
                'layout "ruled"'
            )
        if self.fillet_radius is not None:
            raise MeshError(
                f"SquareSail.fillet_radius = {self.fillet_radius:g}: a wound sail has no fillets; leave it out"
            )
        for name, value in (("layer_gap", self.layer_gap), ("diagonal_gap", self.diagonal_gap)):
            if value is not None and value < NEAREST * self.spool_radius * (1.0 - 1e-9):
                raise MeshError(
                    f"SquareSail.{name} = {value:g}: wound layers would lie in each other; make it "
                    f"{NEAREST * self.spool_radius:.3g} or more (m)"
                )
        path = self._wound_path()
        path.check_hub()
        path.check("SquareSail", "layer_gap or diagonal_gap")

    def _path(self) -> StowedPath:
        rows = self.strips * self.rows_per_strip
        return StowedPath(
            spool_radius=self.spool_radius,
            fillet_radius=self.fillet_radius or (0.010 if self.layout in _NARROW else 0.003),
            diagonal_gap=3.75e-6 if self.diagonal_gap is None else self.diagonal_gap,
            offset=(THICKEST if self.layer_gap is None else self.layer_gap) * np.arange(rows + 1) / self.rows_per_strip,
            half=np.linspace(self.inner_width / 2, self.outer_width / 2, rows + 1),
            taper=self.inner_width / 2,
        )
