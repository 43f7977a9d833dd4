"""The largest stable step: what is predicted, and what is measured on the method's own steps.

The measurement knows nothing of the prediction's matrices. Around the scene's start (x0, at rest) one step of the
method maps a small disturbance (p, q) of positions and velocities to

    J (p, q) = step(x0 + p, q) - step(x0, 0)

and a step is stable if no disturbance grows under J, again and again, faster than it does at a fraction of the step:
a free body drifts, and a compressed film buckles, at any step. Rigid motions keep their velocity, so growth is
measured on velocities. What the start pulls at does not enter, but what is slack at the start, buckled or out
of contact, is measured as it is; the prediction takes it for taut and in contact, and is then the smaller one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from membrane_rs.scene import Scene
from membrane_rs.simulation import Simulation, integrators

Floats = NDArray[np.float64]

STEPS = 800
"""Steps over which growth is watched: enough for 0.3 % beyond the limit to show."""
RESOLUTION = 0.003
"""Relative width at which the bisection ends."""
CALM = 0.3
"""Share of the predicted limit at which the growth that belongs to the scene itself is measured."""
SIZE = 1e-6
"""Largest disturbance, as a share of the shortest spring."""
UNBROKEN = 1e-9, 1e-3
"""The same at the start and at the end of a run without breaks."""
LOOKS = 40
NEVER_CHECK = 10**9


@dataclass(frozen=True)
class Limits:
    """A scene's largest stable step under one method [s], and what sets it."""

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
    """The largest step under which no small disturbance of the scene's start grows [s]; inf where none was found.

    Found by bisection, to 0.3 %, from steps around the predicted one.
    """
    calm = replace(scene, run=replace(scene.run, watch=NEVER_CHECK))
    predicted = Simulation(calm, integrator).stable_dt()
    if not math.isfinite(predicted):
        return math.inf
    slow = CALM * predicted
    own = max(0.0, _growth(calm, integrator, slow, seed, round(steps / CALM))) / slow

    def grows(dt: float) -> bool:
        # Twice the scene's own growth, and e-fold in a third of the steps watched.
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
    """How much a disturbance grows per step, as a logarithm, in the second half of `steps`."""
    sim = Simulation(scene, integrator, dt)
    if integrators()[sim.integrator].evaluations_at_start:
        return _unbroken_growth(sim, Simulation(scene, integrator, dt), seed, steps)
    start, rest = sim.positions, np.zeros((sim.node_count, 3))
    sim.velocities = rest
    sim.step(1)
    ahead, pace = sim.positions, sim.velocities
    ends = sim.spring_pairs
    size = SIZE * float(np.linalg.norm(start[ends[:, 1]] - start[ends[:, 0]], axis=1).min())
    p, q = rest, np.random.default_rng(seed).normal(size=rest.shape)
    q[sim.assembly.fixed] = 0.0
    q *= size / dt / np.abs(q).max()
    growth = 0.0
    for k in range(steps):
        before = float(np.linalg.norm(q))
        sim.positions, sim.velocities = start + p, q
        sim.step(1)
        p, q = sim.positions - ahead, sim.velocities - pace
        after = float(np.linalg.norm(q))
        if not (math.isfinite(after) and np.isfinite(p).all()):
            return math.inf
        if after == 0.0:
            return -math.inf
        if k >= steps // 2:
            growth += math.log(after / before)
        scale = size / max(float(np.abs(p).max()), dt * float(np.abs(q).max()))
        p, q = p * scale, q * scale
    return growth / (steps - steps // 2)


def _unbroken_growth(sim: Simulation, other: Simulation, seed: int, steps: int) -> float:
    """The same for a method that keeps something from step to step: two runs side by side, never set back."""
    ends = sim.spring_pairs
    spans = np.linalg.norm(sim.positions[ends[:, 1]] - sim.positions[ends[:, 0]], axis=1)
    small, large = (share * float(spans.min()) for share in UNBROKEN)
    q = np.random.default_rng(seed).normal(size=(sim.node_count, 3))
    other.velocities = q * (small / sim.dt / np.abs(q).max())
    sizes: list[float] = []
    for _ in range(LOOKS):
        sim.step(max(1, steps // LOOKS))
        other.step(max(1, steps // LOOKS))
        size = float(np.linalg.norm(other.velocities - sim.velocities))
        if not (math.isfinite(size) and np.isfinite(other.positions).all()):
            return math.inf
        sizes.append(size)
        if float(np.abs(other.positions - sim.positions).max()) > large:
            break
    half = len(sizes) // 2
    if len(sizes) < LOOKS // 4:
        return math.inf
    return math.log(sizes[-1] / sizes[half]) / ((len(sizes) - 1 - half) * max(1, steps // LOOKS))


def limits(scene: Scene, methods: Sequence[str], name: str | None = None) -> list[Limits]:
    """Predicted and measured limits of a scene, one row for each method that has a limit."""
    rows: list[Limits] = []
    for integrator in methods:
        sim = Simulation(scene, integrator)
        predicted = sim.stable_dt()
        if math.isfinite(predicted):
            measured = measured_limit(scene, integrator)
            rows.append(Limits(name or scene.name, integrator, predicted, measured, sim.limiting_part))
    return rows
