"""The creases of a FOLD file: which edges are some, and how far each is folded in a shape."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from membrane_rs._arrays import Bools, Floats, Ints
from membrane_rs.errors import MeshError
from membrane_rs.mesh.fold_angles import FLAT, SHUT, check_fold_angles, measured_fold_angles
from membrane_rs.mesh.fold_frames import Frame
from membrane_rs.mesh.triangulation import Triangulation

RADIANS = "edges_membrane_rs:fold_angle"
"""Fold angles in radians, bit by bit: those that degrees do not hold."""
SIGNS = {"M": -1.0, "V": 1.0}
OF_DEGREES = 1e-9
"""By how much an angle in radians may differ from that in degrees [degrees]; another program changed larger ones."""


class Creases(NamedTuple):
    """The creases of a frame."""

    edges: Ints
    """(c,) of each, among the edges."""
    angles: Floats
    """(c,) fold angle as given [rad]; NaN where none is."""
    sides: Floats
    """(c,) the side to which each folds: 1 valley, -1 mountain, 0 not known."""

    @property
    def has_side_alone(self) -> Bools:
        """(c,) whether the side of each is known, and no angle."""
        found: Bools = np.isnan(self.angles) & (self.sides != 0.0)
        return found


def creases_of(flat: Frame, stowed: Frame, edges: Ints, letters: list[str], beside: Ints) -> Creases:
    """The creases of a pattern, with the fold angles of a shape; `beside` (e,) counts the faces beside each edge."""
    given = stowed.fold_angles(len(edges))
    is_pattern = stowed is flat and "creasePattern" in flat.words("frame_classes")
    index, degrees, sides = [], [], []
    for k, angle in enumerate(given or [None] * len(edges)):
        letter = letters[k] if letters else "U" if angle else "F"
        place = f"edges_foldAngle[{k}]"
        if angle and angle * SIGNS.get(letter, angle) < 0.0:
            stowed.fail(place, f" = {angle:g}: edges_assignment[{k}] = {letter!r}; a valley V is positive, M negative")
        if angle and is_pattern and letter in "BFCJ":
            words = f" = {angle:g}: edges_assignment[{k}] = {letter!r}, which is not folded; give 0, or M or V"
            flat.fail(place, words)
        if (letter in SIGNS or letter == "U") and beside[k] == 2:
            index.append(k)
            degrees.append(float(angle) if angle else np.nan)
            sides.append(SIGNS.get(letter, float(np.sign(angle or 0.0))))
    found = np.array(index, dtype=np.int64)
    return Creases(found, _exact(stowed, found, np.array(degrees, dtype=np.float64)), np.array(sides, dtype=np.float64))


def _exact(stowed: Frame, index: Ints, degrees: Floats) -> Floats:
    """Angles [rad] of those in degrees, with the bits that our own key keeps; it counts where it says the same."""
    angles: Floats = np.radians(degrees)
    kept = stowed.rows(RADIANS)
    if kept is None:
        return angles
    numbers = [kept[k] if k < len(kept) and type(kept[k]) is float else np.nan for k in index.tolist()]
    exact = np.array(numbers, dtype=np.float64)
    return np.where(np.abs(np.degrees(exact) - degrees) <= OF_DEGREES, exact, angles)


def fold_angles_of(stowed: Frame, creases: Creases, mesh: Triangulation, positions: Floats) -> Floats:
    """Fold angles [rad] of a shape: as given; else as it shows; else, flat or shut, 180 degrees to the side given.

    Angles that a frame inherits are those of another shape, and say the side alone.
    """
    angles, sides = creases.angles, creases.sides
    shown = measured_fold_angles(mesh, positions)
    is_clear = (np.abs(shown) >= FLAT) & (np.abs(shown) <= SHUT)
    is_open = np.isnan(angles) | ~stowed.has_own("edges_foldAngle")
    for k in np.flatnonzero(is_open & is_clear & (shown * sides < 0.0))[:1]:
        fold = f"a {'valley' if shown[k] > 0.0 else 'mountain'} of {abs(np.degrees(shown[k])):.4g} degrees"
        words = f": is given as folded to one side, and the vertices show {fold} there, seen from where faces run"
        stowed.fail(
            f"edges_assignment[{creases.edges[k]}]", f"{words} counter-clockwise; reverse the faces, or M and V"
        )
    for k in np.flatnonzero(is_open & (np.abs(shown) > SHUT) & (sides == 0.0))[:1]:
        words = ": the crease is shut, and nothing says to which side; give M or V, or its edges_foldAngle"
        stowed.fail(f"edges_assignment[{creases.edges[k]}]", words)
    angles = np.where(is_open & is_clear, shown, np.where(np.isnan(angles), np.pi * sides, angles))
    try:
        check_fold_angles(mesh, positions, angles)
    except MeshError as error:
        stowed.fail("edges_foldAngle", f": {error}")
    return angles
