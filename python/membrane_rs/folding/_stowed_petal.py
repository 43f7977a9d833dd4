"""The stowed petal: strips on edge, round the spool from the petal's middle, then out along the diagonal.

In plan, half a petal follows one path, mirrored for the other half: an arc round the spool, a fillet that
turns the other way, and a straight part beside the diagonal plane, where the neighbour petal's half lies as
its mirror image. Nodes are placed on it by their distance in the flat sail, measured as the chord from the
node before, so edges along a strip keep their lengths, and columns of the flat mesh stay upright: the shape
is a prism, a developable surface, and free of strain but for what the layers' distance costs.

Rows lie beside each other in layers, the inner edge nearest to the spool and to the diagonal plane. Every row
ends on the plane, where it meets the neighbour's; as inner rows end first, none is in the way of another.
Each row comes nearer to the plane over its last piece. A layer that lies `offset` further out is longer by
offset times the angle that the path turns (net 45 degrees), so columns shear by that: with layers 7.5 um
apart on strips of 22 mm, 0.027 % of shear and 0.013 % of strain in the diagonals (0.018 % in the fillet). No
shape near this one has less, but those in which the layers lie closer: strain goes with their distance.

Frame of the path: u along the diagonal, v across it, the petal at v < 0, its middle at -45 degrees.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from membrane_rs._arrays import Bools, Floats
from membrane_rs.errors import MeshError
from membrane_rs.folding._flat_petal import FlatPetal

_MIDDLE = -np.pi / 4
_ARC, _FILLET, _STRAIGHT = 0, 1, 2


@dataclass(frozen=True)
class StowedPath:
    """The paths of all rows of a petal, one in each layer.

    Attributes
    ----------
    spool_radius, fillet_radius, diagonal_gap : float
        Of the innermost layer [m]: the arc's and the fillet's radius, distance from the diagonal plane.
    offset : (r,) float64
        How much further out each row lies [m].
    half : (r,) float64
        Half length of each row [m].
    taper : float
        Length of the last piece, over which a row comes to the diagonal plane [m]; the whole straight part if
        that is shorter.
    """

    spool_radius: float
    fillet_radius: float
    diagonal_gap: float
    offset: Floats
    half: Floats
    taper: float

    def __post_init__(self) -> None:
        if self.offset[-1] >= self.fillet_radius:
            raise MeshError(
                f"fillet_radius = {self.fillet_radius:g} m has no room for layers that take "
                f"{self.offset[-1]:.3g} m; make layer_gap smaller or fillet_radius larger"
            )
        reach = self.spool_radius + self.fillet_radius
        across = self.fillet_radius + self.diagonal_gap
        if across >= reach * np.sin(np.pi / 4):
            raise MeshError(
                f"fillet_radius = {self.fillet_radius:g} m leaves no arc on a spool_radius of "
                f"{self.spool_radius:g} m; make it smaller"
            )
        if self.half[0] < self.bent.max():
            raise MeshError(
                f"half of inner_width, {self.half[0]:.6g} m, is too short to go round the spool "
                f"(spool_radius = {self.spool_radius:g} m) and along the fillet "
                f"(fillet_radius = {self.fillet_radius:g} m), {self.bent.max():.6g} m; "
                "make inner_width larger or the radii smaller"
            )

    @property
    def centre(self) -> tuple[float, float]:
        """(u, v) centre of the fillets [m]; they touch the arcs and the straight parts."""
        across = self.fillet_radius + self.diagonal_gap
        return float(np.sqrt((self.spool_radius + self.fillet_radius) ** 2 - across**2)), -across

    @property
    def arc_end(self) -> float:
        """Azimuth where the arcs meet the fillets [rad]."""
        u, v = self.centre
        return float(np.arctan2(v, u))

    @property
    def bent(self) -> Floats:
        """(r,) length of each row's arc and fillet [m]."""
        arc = (self.spool_radius + self.offset) * (self.arc_end - _MIDDLE)
        return np.asarray(arc + (self.fillet_radius - self.offset) * (np.pi / 2 + self.arc_end))

    def gap(self, along: Floats) -> Floats:
        """(r,) distance from the diagonal plane on the straight part, at `along` from the middle [m]."""
        room = np.minimum(self.taper, self.half - self.bent.max())
        rest = np.maximum(self.half - along, 0.0)
        share = np.minimum(rest, room) / np.maximum(room, np.finfo(float).tiny)
        return np.asarray((self.diagonal_gap + self.offset) * share)

    def at(self, along: Floats) -> tuple[Floats, NDArray[np.int64]]:
        """(r, 2) point (u, v) at the distance `along` (r,) on each row's path, and which part it is on."""
        radius, fillet = self.spool_radius + self.offset, self.fillet_radius - self.offset
        azimuth = _MIDDLE + along / radius
        turned = (along - radius * (self.arc_end - _MIDDLE)) / fillet
        angle = self.arc_end + np.pi - turned
        u, v = self.centre
        points = np.select(
            [(azimuth <= self.arc_end)[:, None], (along <= self.bent)[:, None]],
            [
                np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth)], axis=1),
                np.stack([u + fillet * np.cos(angle), v + fillet * np.sin(angle)], axis=1),
            ],
            np.stack([u + along - self.bent, -self.gap(along)], axis=1),
        )
        part = np.where(azimuth <= self.arc_end, _ARC, np.where(along <= self.bent, _FILLET, _STRAIGHT))
        return points, part

    def next(self, before: Floats, chord: Floats, along: Floats) -> tuple[Floats, NDArray[np.int64]]:
        """(r, 2) the point on each row's path at the distance `chord` (r,) after `before`, and its part."""
        radius, fillet = self.spool_radius + self.offset, self.fillet_radius - self.offset
        u, v = self.centre
        with np.errstate(invalid="ignore"):
            azimuth = np.arctan2(before[:, 1], before[:, 0]) + 2.0 * np.arcsin(chord / (2.0 * radius))
            gap = self.gap(along)
            ahead = before[:, 0] + np.sqrt(chord**2 - (gap + before[:, 1]) ** 2)
            # Two circles: `fillet` about the centre c, `chord` about the point before, p. With d = |p - c|,
            # the angle at c between p and their meeting is acos((d^2 + fillet^2 - chord^2) / (2 d fillet)).
            du, dv = before[:, 0] - u, before[:, 1] - v
            distance = np.hypot(du, dv)
            opening = np.arccos((distance**2 + fillet**2 - chord**2) / (2.0 * distance * fillet))
            angle = np.arctan2(dv, du) % (2.0 * np.pi) - opening
            on_arc = (azimuth <= self.arc_end) & np.isfinite(azimuth)
            on_straight = ahead >= u
        points = np.select(
            [on_arc[:, None], on_straight[:, None] | (gap == 0.0)[:, None]],
            [
                np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth)], axis=1),
                np.stack([ahead, -gap], axis=1),
            ],
            np.stack([u + fillet * np.cos(angle), v + fillet * np.sin(angle)], axis=1),
        )
        part = np.where(on_arc, _ARC, np.where(on_straight, _STRAIGHT, _FILLET))
        return points, part


def stowed_petal(petal: FlatPetal, path: StowedPath, height: Floats, by_chord: bool) -> tuple[Floats, Bools]:
    """(n, 3) stowed nodes of the petal about the x axis [m], and (n,) whether the guide bars hold them.

    Parameters
    ----------
    height : (r,) float64
        z of each row [m].
    by_chord : bool
        Measure along the path by chords (all rows share their columns), or else by the path's length.
    """
    width = max(len(row) for row in petal.along)
    count = np.array([(len(row) + 1) // 2 for row in petal.along])
    # The half of each row with y >= 0; rows that have ended stay at their end.
    along = np.stack([np.pad(row[len(row) // 2 :], (0, width), mode="edge")[:width] for row in petal.along])
    rows = np.arange(len(count))
    points, part = np.zeros((len(count), width, 2)), np.zeros((len(count), width), dtype=np.int64)
    for j in range(count.max()):
        if j > 0 and by_chord:
            points[:, j], part[:, j] = path.next(points[:, j - 1], along[:, j] - along[:, j - 1], along[:, j])
            ended = j >= count
            points[ended, j], part[ended, j] = points[ended, j - 1], part[ended, j - 1]
        elif by_chord:
            # The first chord crosses the middle line, where the neighbour is its mirror image.
            radius = path.spool_radius + path.offset
            if along[0, 0] > path.spool_radius * np.sin(path.arc_end - _MIDDLE):
                raise MeshError(
                    f"a cell of {2.0 * along[0, 0]:.3g} m across the petal's middle does not lie on a spool "
                    f"of spool_radius = {path.spool_radius:g} m; take more columns"
                )
            points[:, 0], part[:, 0] = path.at(radius * np.arcsin(along[:, 0] / radius))
        else:
            points[:, j], part[:, j] = path.at(along[:, j])
    points[rows, count - 1, 1] = 0.0
    u, v = points[..., 0], points[..., 1]
    x, y = (u - v) / np.sqrt(2.0), (u + v) / np.sqrt(2.0)
    y[rows, count - 1] = x[rows, count - 1]
    stowed, held = [], []
    for i, row in enumerate(petal.along):
        half = np.arange(count[i])
        order = np.concatenate([half[len(row) % 2 :][::-1], half])
        side = np.where(np.arange(len(row)) < len(row) // 2, -1.0, 1.0)
        plan = np.stack([x[i, order], side * y[i, order], np.full(len(row), height[i])], axis=1)
        if len(row) % 2:
            plan[len(row) // 2, 1] = 0.0
        stowed.append(plan)
        held.append(part[i, order] != _STRAIGHT)
    if not np.isfinite(np.concatenate(stowed)).all():
        raise MeshError(
            "the stowed shape cannot be placed: layers or the diagonal gap are wider than a cell; "
            "make layer_gap or diagonal_gap smaller, or the mesh coarser"
        )
    return np.concatenate(stowed), np.concatenate(held)
