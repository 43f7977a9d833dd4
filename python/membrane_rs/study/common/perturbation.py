"""Perturbed starts: runs of one scene that differ by no more than rounding, and so show how far chaos spreads them."""

from __future__ import annotations

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._validation import number_of
from membrane_rs.errors import InputError
from membrane_rs.scene import Scene

SHIFT = 1e-12
"""Standard deviation of the perturbation of each coordinate in an ensemble of starts [m]."""
MODEL_SHIFT = 1e-6
"""The same where models are compared [m]: starts that differ by rounding alone have their first instants in common, and
a changed model has not."""


def shift_of(shift: float) -> float:
    """A standard deviation of the perturbation [m], checked. Raises InputError and InputTypeError."""
    shift = number_of("shift", shift, "m")
    if shift <= 0.0:
        raise InputError(f"shift = {shift}: must be above 0 (m, --shift)")
    return shift


def check_shift(shift: float, scene: Scene) -> None:
    """Refuse a perturbation as large as the shortest edge or cord of a scene. Raises InputError."""
    shortest = scene.assemble().cords.rest_length.min(initial=np.inf)
    if scene.mesh is not None:
        shortest = min(shortest, scene.mesh.edge_lengths.min())
    if shift >= shortest:
        raise InputError(
            f"shift = {shift:g}: must be below {shortest:.4g}, the shortest edge or cord of the scene (m); starts that "
            "are perturbed by as much are others"
        )


def perturbation(scene: Scene, seed: int, shift: float = SHIFT) -> Floats:
    """(N, 3) random displacements [m] of the start: normal, of standard deviation `shift`, and 0 at nodes that are
    held or move as prescribed.
    """
    assembly = scene.assemble()
    found: Floats = shift * np.random.default_rng(seed).standard_normal((assembly.node_count, 3))
    found[assembly.fixed] = 0.0
    return found
