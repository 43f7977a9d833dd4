"""The attitude of a hub: how vectors along its axes lie in space."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np

from membrane_rs._arrays import Floats

Turn: TypeAlias = float | Floats
"""An angle about z [rad], or a unit quaternion (4,), w first."""
COLUMNS = tuple(f"attitude_{name}" for name in "wxyz")
"""Of a history: the quaternion of a hub in six degrees of freedom."""


def rotation_of(attitude: Floats) -> Floats:
    """(..., 3, 3) rotation matrices of unit quaternions (..., 4), w first: from axes of the hub to those in space."""
    from scipy.spatial.transform import Rotation

    matrices: Floats = Rotation.from_quat(attitude[..., [1, 2, 3, 0]]).as_matrix()
    return matrices


def turned(points: Floats, turn: Turn) -> Floats:
    """Points (n, 3) turned as the hub is: from its frame to one that is fixed in space, about its origin."""
    if isinstance(turn, np.ndarray):
        upright: Floats = points @ rotation_of(turn).T
        return upright
    c, s = np.cos(turn), np.sin(turn)
    fixed: Floats = points @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return fixed


def attitude_at(table: Mapping[str, Floats], time: float) -> Floats | None:
    """The quaternion at a time [s] by the columns of a history, between two samples by their mean; None without them.

    Of a stage with a hub on its axis, which has no columns of its own, it is the turn about that axis.
    """
    if not all(name in table for name in COLUMNS) or not len(table["time"]):
        return None
    found = np.array([np.interp(time, table["time"], table[name]) for name in COLUMNS])
    length = float(np.linalg.norm(found))
    return found / length if length > 0.0 else np.array([1.0, 0.0, 0.0, 0.0])


def turn_at(table: Mapping[str, Floats], time: float) -> Turn:
    """How the hub has turned at a time [s], by the columns of a history."""
    attitude = attitude_at(table, time)
    return float(np.interp(time, table["time"], table["hub_angle"])) if attitude is None else attitude
