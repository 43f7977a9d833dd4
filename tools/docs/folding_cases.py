"""Patterns that fold flat, and what is known of the ways there: for docs/folding.md and the tests of folding."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from marked import ROOT
from membrane_rs import Mesh
from membrane_rs._arrays import Floats
from membrane_rs.folding import Miura
from membrane_rs.mesh import read_fold

SQUARE_TWIST = ROOT / "examples" / "square_twist.fold"
SECTORS = (60.0, 100.0, 120.0, 80.0)
"""Of a vertex that folds flat [degrees]: opposite ones make 180."""


def vertex(sectors: Sequence[float], letters: str) -> Mesh:
    """Creases of 1 m from one vertex, with sectors between them [degrees]; V or M, each to be shut."""
    count = len(sectors)
    angles = np.radians(np.cumsum([0.0, *sectors[:-1]]))
    rim = np.stack([np.cos(angles), np.sin(angles), np.zeros(count)], axis=1)
    spokes = np.arange(count) + 1
    return Mesh(
        np.concatenate([np.zeros((1, 3)), rim]),
        np.stack([np.zeros(count, dtype=int), spokes, np.roll(spokes, -1)], axis=1),
        creases=np.stack([np.zeros(count, dtype=int), spokes], axis=1),
        fold_angles=[math.pi if letter == "V" else -math.pi for letter in letters],
    )


def square_twist() -> Mesh:
    """The square whose middle turns by a quarter as four pleats shut; its panels have to bend on the way."""
    return read_fold(SQUARE_TWIST)


def sheet(tilt: float, columns: int = 6, rows: int = 4) -> Miura:
    """Miura's fold in rhombs of 20 mm."""
    return Miura(straight_side=0.02, zigzag_side=0.02, tilt=tilt, columns=columns, rows=rows)


def rigid_tilt(pattern: Miura, fraction: float) -> float:
    """The tilt [rad] at which rigid panels are at rest under creases that turn to a fraction of the pattern's angles.

    That of the least sum of L (phi - fraction phi1)^2 over all creases, of lengths L, with phi the fold angles at a
    tilt and phi1 those of the pattern: one number, found by bisection of its derivative.
    """
    straight = pattern.rows * (pattern.columns - 1) * pattern.straight_side
    zigzag = pattern.columns * (pattern.rows - 1) * pattern.zigzag_side
    cosine = math.cos(pattern.angle)

    def slope(tilt: float) -> float:
        shape = replace(pattern, tilt=tilt)
        rate = 2.0 * cosine / (math.cos(tilt) ** 2 + (cosine * math.sin(tilt)) ** 2)
        return zigzag * 2.0 * (shape.zigzag_fold_angle - fraction * pattern.zigzag_fold_angle) + straight * rate * (
            shape.straight_fold_angle - fraction * pattern.straight_fold_angle
        )

    low, high = 0.0, math.pi / 2
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if slope(middle) > 0.0 else (middle, high)
    return 0.5 * (low + high)


def multiplier(sectors: Sequence[float]) -> float:
    """tan(a/2) / tan(b/2) of the fold angles a, b of two neighbouring creases at a vertex of four that folds flat.

    cos((s - t)/2) / cos((s + t)/2), with s, t the sectors on both sides of the crease of b, which both neighbours
    fold to one side: R. J. Lang, Twists, Tilings, and Tessellations (2018). It stays as it is while the vertex folds.
    """
    first, second = np.radians(sectors[:2])
    return float(np.cos(0.5 * (first - second)) / np.cos(0.5 * (first + second)))


def distance(points: Floats, others: Floats) -> float:
    """Largest distance [m] of points (n, 3) to others after the rigid motion of the least squares (Kabsch)."""
    one, other = (cloud - cloud.mean(axis=0) for cloud in (points, others))
    left, _, right = np.linalg.svd(one.T @ other)
    turn = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    return float(np.linalg.norm(one @ turn - other, axis=1).max())
