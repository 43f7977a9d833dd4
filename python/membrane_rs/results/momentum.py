"""The balance of angular momentum of a free hub and its sail, by the history of a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs.scene import Scene
from membrane_rs.scene.hub import Hub, hub_of
from membrane_rs.scene.schedule import Schedule

COLUMNS = ("hub_momentum", "sail_momentum")
IN_SPACE = ("momentum_x", "momentum_y", "momentum_z")
"""Of the whole, of a hub in six degrees of freedom, all of which are constant without a torque on it."""


def momentum_error(table: Mapping[str, Floats], scene: Scene, starts: Sequence[float] = ()) -> float | None:
    """Error of the angular momentum of hub and sail about the axis, of a hub that turns freely [-].

    In each stage with a free hub, the largest change of the total since the first sample, less the impulse of the
    torque on the hub; of all stages the largest, over the largest part, of hub or sail. With a hub in six degrees of
    freedom without a torque, the change is that of the vector in space. None where there is none: with
    a driven hub, while loads from outside such as air drag exert a torque too, and where nothing turns.

    `table` holds (samples,) columns of a history, `starts` the start of each stage that was reached [s].
    """
    if not all(name in table for name in COLUMNS):
        return None
    hub_part, sail_part = (table[name] for name in COLUMNS)
    errors, parts = [], []
    for rows, hub in _free_stages(table, scene, starts):
        if hub.mass is None:
            time, total = table["time"][rows], (hub_part + sail_part)[rows]
            torque = hub.torque or Schedule((0.0,), (0.0,))
            given = np.array([torque.integral(float(time[0]), float(now)) for now in time])
            change = np.abs(total - total[0] - given)
        elif hub.torque is None:
            whole = np.stack([table[name][rows] for name in IN_SPACE], axis=1)
            change = np.linalg.norm(whole - whole[0], axis=1)
        else:
            continue  # a torque about an axis that moves in space
        errors.append(float(change.max()))
        parts.append(float(max(np.abs(hub_part[rows]).max(), np.abs(sail_part[rows]).max())))
    largest = max(parts, default=0.0)
    return max(errors) / largest if largest > 0.0 else None


def _free_stages(table: Mapping[str, Floats], scene: Scene, starts: Sequence[float]) -> list[tuple[Ints, Hub]]:
    """The rows of each stage in which momentum is conserved but for a torque on the free hub, and that hub."""
    count = len(table["time"])
    stages = [(np.arange(count), scene)]
    if scene.stages:
        index = table["stage"]
        stages = [
            (np.flatnonzero(index == k), scene.staged(k, starts[: k + 1]))
            for k in range(min(len(starts), len(scene.stages)))
        ]
    found = []
    for rows, staged in stages:
        hub = hub_of(staged)
        if len(rows) < 2 or hub is None or hub.inertia is None:
            continue
        if not any(law.turns_whole(hub) and law.why_idle(staged) is None for law in staged.laws):
            found.append((rows, hub))
    return found
