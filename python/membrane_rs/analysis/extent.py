"""The extent of a shape."""

from __future__ import annotations

import numpy as np

from membrane_rs._arrays import Floats


def span(points: Floats) -> float:
    """The largest side of the box around points (n, 3), along the axes [m]; 0 without points."""
    return float(np.max([np.ptp(along) for along in points.T])) if len(points) else 0.0
