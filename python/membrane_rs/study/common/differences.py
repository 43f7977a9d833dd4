"""Difference between two runs: of positions node by node, or of their curves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.errors import InputError
from membrane_rs.study.common.run import StudyRun


def position_error(run: StudyRun, reference: StudyRun, start: Floats) -> float:
    """RMS over nodes and instants of the difference in position, over the RMS displacement from the start."""
    scale = float(np.sqrt(np.mean((reference.shapes - start) ** 2)))
    if scale == 0.0:
        raise InputError("nothing moves in this scene up to the end; give a later one, or another scene")
    return float(np.sqrt(np.mean((run.shapes - reference.shapes) ** 2))) / scale


def rate_error(run: StudyRun, reference: StudyRun, _: Floats) -> float:
    """Largest difference in the deployment rate."""
    return float(np.abs(run.rate - reference.rate).max())


def phase_error(run: StudyRun, reference: StudyRun, _: Floats) -> float:
    """Largest difference in the phase [deg]."""
    return float(np.abs(run.phase - reference.phase).max())


Error = Callable[[StudyRun, StudyRun, Floats], float]
POINTWISE: dict[str, tuple[str, Error]] = {"position": ("Error of positions, relative (RMS)", position_error)}
CURVES: dict[str, tuple[str, Error]] = {
    "rate": ("Error of the deployment rate (largest)", rate_error),
    "phase": ("Error of the phase [deg] (largest)", phase_error),
}
