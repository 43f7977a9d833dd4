"""Stability limits, predicted from the eigenvalues and measured on the method's own steps.

The measurement is independent of the matrices of the prediction. Around the scene's start (x0, at rest) one step of the
method maps a small disturbance (p, q) of positions and velocities to

    J (p, q) = step(x0 + p, q) - step(x0, 0)

together with the history that the method keeps from step to step. A step is stable if no disturbance grows under
repeated application of J faster than it does at a fraction of the step, since a free body drifts and a compressed film
buckles at any step. Rigid motions keep their velocity, so growth is measured on velocities. The acceleration of the
undisturbed start cancels; the geometric stiffness of a prestressed start is included. Elements that are slack, buckled
or out of contact at the start are measured as they are; the prediction takes them as taut and in contact, and is then
mostly the smaller one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.runs import Simulation
from membrane_rs.scene import Scene
from membrane_rs.study.common.stages import refuse_stages

STEPS = 800
"""Number of steps over which growth is measured: enough to detect a step 0.3 % beyond the limit."""
RESOLUTION = 0.003
"""Relative width at which the bisection ends."""
CALM = 0.3
"""Share of the predicted limit at which the scene's own growth is measured."""
SIZE = 1e-6
"""Largest disturbance over the length of the shortest spring."""
NEVER_CHECK = 10**9


@dataclass(frozen=True)
class Limits:
    """A scene's largest stable step under one method [s], and the part that sets it."""

    scene: str
    integrator: str
    predicted: float
    measured: float
    part: str

    @property
    def ratio(self) -> float:
        """Measured over predicted: above 1 the prediction is on the safe side."""
        return self.measured / self.predicted


def measured_limit(scene: Scene, integrator: str | None = None, seed: int = 1, steps: int = STEPS) -> float:
    """The largest step at which no small disturbance of the scene's start grows [s]; inf if none was found.

    By bisection to 0.3 %, starting from steps around the predicted limit.
    """
    refuse_stages(scene)
    calm = replace(scene, run=replace(scene.run, watch=NEVER_CHECK))
    predicted = Simulation(calm, integrator).stable_dt()
    if not math.isfinite(predicted):
        return math.inf
    slow = CALM * predicted
    own = max(0.0, _growth(calm, integrator, slow, seed, round(steps / CALM))) / slow

    def grows(dt: float) -> bool:
        # Twice the scene's own growth, and e-fold in a third of the steps.
        return _growth(calm, integrator, dt, seed, steps) > 2.0 * own * dt + 3.0 / steps

    low, high = 0.9 * predicted, 1.1 * predicted
    while grows(low):
        low, high = low / 1.5, low
    while not grows(high):
        low, high = high, high * 1.5
        if high > 50 * predicted:
            return math.inf
    while high / low > 1.0 + RESOLUTION:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if grows(middle) else (middle, high)
    return math.sqrt(low * high)


def _growth(scene: Scene, integrator: str | None, dt: float, seed: int, steps: int) -> float:
    """Logarithmic growth of a disturbance per step, in the second half of `steps`."""
    sim = Simulation(scene, integrator, dt)
    ends, start = sim.spring_pairs, sim.positions
    size = SIZE * float(np.linalg.norm(start[ends[:, 1]] - start[ends[:, 0]], axis=1).min())
    q = np.random.default_rng(seed).normal(size=start.shape)
    q[sim.assembly.fixed] = 0.0
    q *= size / dt / np.abs(q).max()
    # Positions, velocities, and the method's history, which exists after one step.
    sim.step(1)
    saved = sim.state() | {"positions": start, "velocities": np.zeros_like(start)}
    parts = [name for name in ("positions", "velocities", "history_vectors") if name in saved]

    def stepped(disturbance: Sequence[Floats]) -> list[Floats]:
        moved = {name: saved[name] + part for name, part in zip(parts, disturbance, strict=True)}
        sim.set_state(saved | moved)
        sim.step(1)
        after = sim.state()
        return [after[name] for name in parts]

    disturbance = [np.zeros_like(saved[name]) for name in parts]
    undisturbed = stepped(disturbance)
    disturbance[1] = q
    growth = 0.0
    for k in range(steps):
        before = float(np.linalg.norm(disturbance[1]))
        disturbance = [moved - still for moved, still in zip(stepped(disturbance), undisturbed, strict=True)]
        after = float(np.linalg.norm(disturbance[1]))
        if not all(np.isfinite(part).all() for part in disturbance):
            return math.inf
        if after == 0.0:
            return -math.inf
        if k >= steps // 2:
            growth += math.log(after / before)
        scale = size / max(float(np.abs(disturbance[0]).max()), dt * float(np.abs(disturbance[1]).max()))
        disturbance = [part * scale for part in disturbance]
    return growth / (steps - steps // 2)


def limits(scene: Scene, methods: Sequence[str], name: str | None = None) -> list[Limits]:
    """Predicted and measured limits of a scene, one row for each method with a limit."""
    rows: list[Limits] = []
    for integrator in methods:
        sim = Simulation(scene, integrator)
        predicted = sim.stable_dt()
        if math.isfinite(predicted):
            measured = measured_limit(scene, integrator)
            rows.append(Limits(name or scene.name, integrator, predicted, measured, sim.limiting_part))
    return rows
