"""The wound petal: strips on edge, round a hub's polygon and then in arms round each other.

Wound counter-clockwise, seen from +z. Arm p leaves the hub at diagonal p. Its outer half A is that of petal p, which
comes round the hub counter-clockwise and just goes on. Its inner half B is that of petal p+1, which lies on the hub
from diagonal p on: it turns back on itself in one hairpin, along a column. Outward at any azimuth lie

    hub | petal's rows 0..N | B's rows N..0 of arm p | middle line | A's rows 0..N | arm p-1 ...

No cell can straddle a hairpin, and A and B meet on the diagonal with equal column numbers. So between two hairpins lie
n cells of the inner edge, from -s_h to s_h, chords c of the hub's circle that span 90 degrees:

    2 n asin(c / (2 R_h)) = pi/2,  s_h = n c / 2        n even or odd as the number of columns

with the smallest n at which these chords, R_h cos(pi / (4 n)) from the axis, lie outside the spool. The middle line of
arm p begins at diagonal p, t = 0:

    r(t) = R_h + a min(1, t / t_1) + f min(1, t / t_2) + q t / (pi/2)       nodes by the lengths of chords
    v_i  = v_0 + g i / (rows of a strip)                offset of row i, to either side; g: distance of layers
    a    = 2 w + e                                      B clears the petal that lies below it
    q    = 2 w + R_h - sqrt(R_h^2 - c_m^2 / 4) + e      a quarter turn: stack, sagitta of the longest chord, clearance

with t_1 the end of the first cell, t_2 that of the last cell of the inner edge, w = v_N / cos(b/2) the offset of the
outermost row where the longest chord c_m, of the angle b, meets another, and e a clearance. The sagitta is there
because neighbouring arms have their columns at different azimuths: chords of one dip towards corners of the other. f
is mostly 0; it is what is lacking where long cells follow short ones while the arm lies on the hub.

All layers share the columns, so the shape is a prism over a polygon, developable but for v. Row i lies at P_k + v_i m_k
on the hub and on A, and at P_k - v_i m_k on B, with the mitre m = (n_1 + n_2) / (1 + n_1 . n_2) of the normals of the
two chords that meet in P_k. Every row ends on the middle line, where it meets the neighbour's. On the hairpin it lies
at P_0 + 0.002 c (v_i - v_0) / (v_N - v_0) d, d the bisector of its two legs, so that no two rows turn in one place.

The strain is v/R on A and -v/R on B, on any mesh, and -0.2 % more in the two cells at the hairpin. In a real stack the
layers slip instead; layers that share columns cannot.

A sail of n sides has n arms, and 2 pi/n in place of the quarter turn. Where no cell of the inner edge is left for its
arms they begin with the cells beyond, and f is reached in the first of these.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._validation import MOST
from membrane_rs.errors import MeshError
from membrane_rs.folding._flat_petal import FlatPetal

APEX = 0.002
"""Distance along which the rows of a hairpin lie apart, over the length of a cell."""
LONGEST = math.sqrt(2.0)
"""Length of a cell over the radius of the hub, at most: it spans a quarter turn."""
CLEARANCE = 8e-4
"""Clearance e of the windings over the spool's radius, 20 um on one of 25 mm ..."""
CLEARANCE_OF_CELL = 8e-3
"""... and at most so much of the shortest cell: an arm rises by it in its first one."""
STACK = 6.8e-4
"""Largest offset of a row over the spool's radius by default, for a strain of 0.25 %: 17 um on one of 25 mm."""
STACK_OF_CELL = 0.002
"""The same over the shortest cell: in their last one rows come to the middle line, after up to 90 degrees of turn."""
UNLIKE, SHARE_OF_UNLIKE = 1.5, 0.7
"""Ratio of the cells' lengths from which the sharper corners between them strain more, and what it leaves of this."""
NEAREST = 1e-9
"""Distance of layers over the spool's radius, at least: below it, rounding of positions would let them cross."""
THICKEST = 7.5e-6
"""Largest distance of layers by default [m]: that of the cross, in which layers touch."""


@dataclass(frozen=True)
class WoundPath:
    """The polygon on which all rows of a wound petal lie.

    Attributes
    ----------
    spool_radius : float
        Least radius of the hub's circle [m].
    inner_width, columns : float, int
        Length of the inner edge [m], and its cells.
    arm_cell : float
        Length of the cells beyond it [m].
    offset : (r,) float64
        Distance of each row from the polygon [m].
    strips : int
        Strips of a petal, into which the rows are divided evenly.
    sides : int
        Sides of the sail, each of one petal.
    apex : float
        Distance along which the rows of a hairpin lie apart, over the length of a cell.
    """

    spool_radius: float
    inner_width: float
    columns: int
    arm_cell: float
    offset: Floats
    strips: int
    sides: int = 4
    apex: float = APEX

    @property
    def cell(self) -> float:
        """Length of the cells on the hub [m]."""
        return self.inner_width / self.columns

    @property
    def on_hub(self) -> int:
        """Columns from one hairpin to the next."""
        around = math.pi / (self.sides * math.atan(self.cell / (2.0 * self.spool_radius)))
        least = math.ceil(min(around, MOST) * (1.0 - 1e-12))
        return least + (least + self.columns) % 2

    @property
    def hub_radius(self) -> float:
        """Radius of the circle on which the corners of the innermost polygon lie [m]."""
        return self.cell / (2.0 * math.sin(math.pi / (self.sides * self.on_hub)))

    @property
    def hairpin(self) -> float:
        """Distance of the hairpins from the middle of the petal, along it [m]."""
        return 0.5 * self.on_hub * self.cell

    @property
    def free(self) -> int:
        """Cells of the inner edge beyond a hairpin."""
        return (self.columns - self.on_hub) // 2

    @cached_property
    def chords(self) -> Floats:
        """(k,) lengths of the cells of an arm, from the hairpin to the outer corner [m]."""
        rows = len(self.offset) - 1
        return np.concatenate([np.full(self.free, self.cell), np.full(rows, self.arm_cell)])

    @cached_property
    def arm(self) -> Floats:
        """(k + 1, 2) azimuth from the hairpin [rad] and radius [m] of the middle line's nodes."""
        first = self._arm(0.0, 1.0)
        lacking = self._stack_of(first) + 0.5 * self._clearance - self._least_gap(first)
        if lacking <= 0.0:
            return first
        until = float(first[max(1, self.free), 0])
        share = 1.0 if self.free else min(1.0, self._step / until)  # of the rise, at the hub's next corner
        return self._arm((lacking + 0.5 * self._clearance) / share, until)

    def check_hub(self) -> None:
        """Raise MeshError where a square sail has no cells of its inner edge for arms."""
        if self.on_hub > self.columns - 2:
            more = (replace(self, columns=n) for n in range(self.columns + 1, 2 * self.columns + 100))
            enough = next((path.columns for path in more if path.on_hub <= path.columns - 2), None)
            remedy = f"take columns = {enough}" if enough else "make spool_radius smaller or inner_width larger"
            raise MeshError(
                f"SquareSail.spool_radius = {self.spool_radius:g}: so wide a hub (m) takes {self.on_hub} of the "
                f"{self.columns} columns of the inner edge from one hairpin to the next, and leaves none for the arms "
                f"of a wound sail; {remedy}"
            )

    def check(self, owner: str, gaps: str = "layer_gap") -> None:
        """Raise MeshError, in the name of a pattern, where cells are too long for the roll, or its layers cross; `gaps`
        are the fields that say how far these are apart.
        """
        longest = LONGEST * self.hub_radius
        if self.arm_cell > longest * (1.0 + 1e-9):
            rows = len(self.offset) - 1
            enough = self.strips * math.ceil(rows * self.arm_cell / (longest * self.strips))
            raise MeshError(
                f"{owner}.rows = {rows}: cells of {self.arm_cell:.4g} m do not lie on a roll of "
                f"{self.hub_radius:.4g} m in radius, on which {longest:.4g} m is the most; take {enough} rows or more"
            )
        stack, gap = self._stack_of(self.arm), self._least_gap(self.arm)
        if gap < stack:
            raise MeshError(
                f"{owner}: the layers of a wound arm take {stack:.3g} m, and cells of {self.cell:.4g} m along the "
                f"inner edge and {self.arm_cell:.4g} m beyond it leave {gap:.3g} m for them; take more rows, fewer "
                f"columns, or a smaller {gaps}"
            )

    @property
    def _turn(self) -> float:
        """Angle from one arm to the next [rad]."""
        return 2.0 * math.pi / self.sides

    @property
    def _step(self) -> float:
        """Angle from one corner of the hub to the next [rad]."""
        return self._turn / self.on_hub

    @property
    def _bend(self) -> float:
        """Half of the angle that the longest cell of an arm spans on the hub [rad]."""
        return math.asin(min(1.0, float(self.chords.max()) / (2.0 * self.hub_radius)))

    def _stack_of(self, arm: Floats) -> float:
        """What the rows on either side of an arm take at its sharpest corner [m]."""
        mitres = _mitres(np.concatenate([self.hub[:-1], self._plan(arm)]))
        return 2.0 * float(self.offset[-1] * np.hypot(*mitres.T).max())

    @property
    def _clearance(self) -> float:
        return min(CLEARANCE * self.spool_radius, CLEARANCE_OF_CELL * float(self.chords.min()))

    def _arm(self, more: float, until: float) -> Floats:
        """`arm`, which rises by `more` [m] until an azimuth [rad]."""
        rise = 2.0 * float(self.offset[-1]) / math.cos(self._bend) + self._clearance
        pitch = (rise + self.hub_radius * (1.0 - math.cos(self._bend))) / self._turn

        def radius(azimuth: float) -> float:
            return self.hub_radius + rise + more * min(1.0, azimuth / until) + pitch * azimuth

        nodes = [(0.0, self.hub_radius)]
        for chord in self.chords.tolist():
            azimuth, r = nodes[-1]
            low, high = azimuth, azimuth + math.pi
            for _ in range(60):  # halving: the distance grows with the azimuth
                middle = 0.5 * (low + high)
                far = radius(middle)
                square = (far - r) ** 2 + 4.0 * far * r * math.sin(0.5 * (middle - azimuth)) ** 2
                low, high = (low, middle) if square > chord * chord else (middle, high)
            nodes.append((high, radius(high)))
        return np.array(nodes)

    def _least_gap(self, arm: Floats) -> float:
        """The least distance, along the radius, of the polygon from itself a quarter turn on, beyond an arm's first
        cell [m].
        """
        on_hub = self._turn * (np.arange(self.on_hub) / self.on_hub - 1.0)
        azimuth = np.concatenate([on_hub, arm[:, 0]])
        radius = np.concatenate([np.full(self.on_hub, self.hub_radius), arm[:, 1]])
        at = np.concatenate([azimuth, azimuth - self._turn])
        begin = min(float(arm[1, 0]), self._step * (1.0 - 1e-9)) - self._turn
        at = at[(at >= begin) & (at <= azimuth[-1] - self._turn)]
        return float((_radius(azimuth, radius, at + self._turn) - _radius(azimuth, radius, at)).min(initial=math.inf))

    @cached_property
    def line(self) -> Floats:
        """(k + 1, 2) the middle line of arm 0 in plan, from the hairpin to the outer corner [m]."""
        return self._plan(self.arm)

    @property
    def outer_radius(self) -> float:
        """Distance of the outermost layer from the axis [m]."""
        mitred = self.line[:-1] + self.offset[-1] * _mitres(self.line)[:-1]
        return float(max(np.hypot(*mitred.T).max(), self.arm[-1, 1]))

    @property
    def turns(self) -> float:
        """Turns of the arm from the hairpin to the outer corner."""
        return float(self.arm[-1, 0]) / (2.0 * math.pi)

    def diagonal_path(self, diagonal: int, row: int) -> Floats:
        """(k, 2) the middle line of an arm in plan, from the hairpin to where a row ends [m]."""
        line = self.line[: self.free + row + 1]
        for _ in range(self.sides - diagonal % self.sides):
            line = self._back(line)
        return line

    @property
    def hub(self) -> Floats:
        """(n + 1, 2) corners of petal 0 on the hub in plan, from one hairpin to the next [m]."""
        azimuth = 0.5 * self._turn * (2.0 * np.arange(self.on_hub + 1) / self.on_hub - 1.0)
        corners = self.hub_radius * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
        start = self._plan(np.array([[0.0, self.hub_radius]]))[0]
        corners[-1], corners[0] = start, self._back(start)
        return corners

    def _plan(self, arm: Floats) -> Floats:
        """(k, 2) points in plan [m] of arm 0 at azimuths from its hairpin [rad] and radii [m], (k, 2)."""
        azimuth = arm[:, 0] + 0.5 * self._turn
        return np.asarray(arm[:, 1:] * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1))

    def _back(self, points: Floats) -> Floats:
        """Points in plan (..., 2), turned by one arm clockwise; by -90 degrees without rounding."""
        x, y = points[..., 0], points[..., 1]
        if self.sides == 4:
            return np.stack([y, -x], axis=-1)
        c, s = math.cos(self._turn), math.sin(self._turn)
        return np.stack([c * x + s * y, c * y - s * x], axis=-1)


def default_gap(spool_radius: float, cells: tuple[float, float], strips: int) -> float:
    """Distance of layers [m] at which the outermost row keeps the strain within 0.25 %; at most `THICKEST`. With the
    lengths of the cells of the inner edge and of those beyond it.
    """
    stack = min(STACK * spool_radius, STACK_OF_CELL * min(cells))
    if max(cells) > UNLIKE * min(cells):
        stack *= SHARE_OF_UNLIKE
    return min(THICKEST, stack / (strips + 0.5))


def wound_petal(petal: FlatPetal, path: WoundPath, height: Floats) -> Floats:
    """(n, 3) wound nodes of the petal about the x axis [m]; `height` (r,) is the z of each row [m]."""
    arm, hub, offset = path.line, path.hub, path.offset
    ahead = np.concatenate([hub[:-1], arm])
    behind = np.concatenate([hub[:1], path._back(arm[1:])])
    mitre_ahead, mitre_behind = _mitres(ahead), _mitres(path._back(arm))
    legs = np.stack([hub[1] - hub[0], behind[1] - hub[0]])
    legs /= np.linalg.norm(legs, axis=1)[:, None]
    apex = legs.sum(axis=0)
    apex *= path.apex * path.cell / np.linalg.norm(apex)
    apart = (offset - offset[0]) / (offset[-1] - offset[0])
    wound = []
    for i in range(len(petal.along)):
        free = path.free + i  # cells of this row beyond its hairpin
        front = ahead[: path.on_hub + free + 1] + offset[i] * mitre_ahead[: path.on_hub + free + 1]
        back = behind[: free + 1] - offset[i] * mitre_behind[: free + 1]
        front[0] = hub[0] + apart[i] * apex
        front[-1], back[-1] = ahead[path.on_hub + free], behind[free]
        plan = np.concatenate([back[:0:-1], front])
        wound.append(np.column_stack([plan, np.full(len(plan), height[i])]))
    return np.concatenate(wound)


def _mitres(points: Floats) -> Floats:
    """(k, 2) the mitre at each corner of a polygon that runs counter-clockwise, outward; at its ends the normal."""
    along = np.diff(points, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    normals = np.stack([along[:, 1], -along[:, 0]], axis=1)
    first, second = np.concatenate([normals[:1], normals]), np.concatenate([normals, normals[-1:]])
    return np.asarray((first + second) / (1.0 + (first * second).sum(axis=1))[:, None])


def _radius(azimuth: Floats, radius: Floats, at: Floats) -> Floats:
    """(m,) radius [m] at azimuths `at` of a polygon with corners at ascending azimuths [rad] and radii, (k,)."""
    k = np.clip(np.searchsorted(azimuth, at, side="right") - 1, 0, len(azimuth) - 2)
    before, after = at - azimuth[k], azimuth[k + 1] - at
    inverse = np.sin(before) / radius[k + 1] + np.sin(after) / radius[k]
    return np.asarray(np.sin(before + after) / inverse)
