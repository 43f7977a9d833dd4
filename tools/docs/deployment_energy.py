"""Energy balance and cost of each stage of a whole deployment, the work of bars and motor among them.

The hub turns at a constant rate. So its motor does the work Omega times the angular momentum that hub, spool and bars
give to the sail,

    W = Omega (L(end) - L(start)) - Omega integral of the air's torque dt
    L = sum m (x (v_y + Omega x) - y (v_x - Omega y))                                      [N m s]

with velocities relative to the hub. The torque of the air is summed over samples; all else is exact.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from deployment_plane import FREQUENCY
from membrane_rs import Scene, Simulation
from membrane_rs._markdown import table
from membrane_rs.simulation.timeline import StageRecord

OMEGA = 2.0 * math.pi * FREQUENCY
SAMPLE = 2e-3
"""Time between two samples of the torque of the air [s]."""
WORKS = ("bars", "spring_damping", "mass_damping", "air_drag")


@dataclass(frozen=True)
class StageCost:
    """A stage, the work of the motor in it [J], and the processor time that it took [s]."""

    record: StageRecord
    motor: float
    seconds: float


def angular_momentum(sim: Simulation) -> float:
    """Of all nodes about the hub's axis, in inertial space [N m s]."""
    (x, y, _), (u, v, _) = sim.positions.T, sim.velocities.T
    return float(sim.masses @ (x * (v + OMEGA * x) - y * (u - OMEGA * y)))


def torque_of_air(sim: Simulation) -> float:
    """About the hub's axis [N m]; 0 where no air is at work."""
    if sim.stage_scene.law("air_drag") is None:
        return 0.0
    (x, y, _), (f, g, _) = sim.positions.T, sim.forces("air_drag").T
    return float(np.sum(x * g - y * f))


def stage_costs(scene: Scene) -> list[StageCost]:
    """Run all stages of a scene, and account for each."""
    sim, found = Simulation(scene), []
    for index, stage in enumerate(scene.stages):
        start, momentum, impulse, seconds = sim.time, angular_momentum(sim), 0.0, 0.0
        count = max(1, math.ceil(stage.duration / SAMPLE))
        torque = torque_of_air(sim)
        for k in range(1, count + 1):
            began = time.thread_time()
            sim.reach(start + stage.duration * (k / count))
            seconds += time.thread_time() - began
            torque, last = (torque_of_air(sim) if k < count else torque), torque
            impulse += 0.5 * (torque + last) * stage.duration / count
        motor = OMEGA * (angular_momentum(sim) - momentum - impulse)
        found.append(StageCost(sim.stages[index], motor, seconds))
    return found


def energy_table(models: Mapping[str, Sequence[StageCost]]) -> str:
    """Work in each stage, what its beginning put in, and the residual of its balance."""
    body = []
    for model, stages in models.items():
        for one in stages:
            record = one.record
            works = [f"{1e3 * record.work_by_law[law]:.3f}" if law in record.work_by_law else "-" for law in WORKS]
            changed = math.fsum(record.changes.values())
            body.append((
                model, record.name, f"{1e3 * one.motor:.3f}", *works, f"{1e3 * changed:.4f}",
                f"{1e3 * record.reference_energy:.3f}", f"{100.0 * record.error:+.3f}",
            ))  # fmt: skip
    heads = (
        "sail", "stage", "motor", "bars", "dashpots", "mass damping", "air", "put in at the start", "reference energy",
        "residual [%]",
    )  # fmt: skip
    return table(heads, body, words=(0, 1))


def cost_table(models: Mapping[str, Sequence[StageCost]]) -> str:
    """Steps and processor time of each stage beside its simulated time."""
    body = []
    for model, stages in models.items():
        for one in stages:
            record = one.record
            length = record.end - record.start
            body.append((
                model, record.name, f"{length:.2f}", f"{1e6 * record.dt:.2f}", f"{record.steps:,d}",
                f"{one.seconds:.1f}", f"{one.seconds / length:.1f}",
            ))  # fmt: skip
        seconds, length = math.fsum(one.seconds for one in stages), stages[-1].record.end
        steps = sum(one.record.steps for one in stages)
        body.append((model, "all", f"{length:.2f}", "-", f"{steps:,d}", f"{seconds:.1f}", f"{seconds / length:.1f}"))
    heads = ("sail", "stage", "simulated [s]", "step [us]", "steps", "processor time [s]", "ratio")
    return table(heads, body, words=(0, 1))
