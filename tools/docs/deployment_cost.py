"""What each stage of a whole deployment costs: steps and processor time."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from deployment_reel import whole
from membrane_rs import Scene, Simulation
from membrane_rs._markdown import table
from membrane_rs.simulation.timeline import StageRecord


@dataclass(frozen=True)
class StageCost:
    """A stage, and the processor time that it took [s]."""

    record: StageRecord
    seconds: float


def stage_costs(scene: Scene) -> list[StageCost]:
    """Run all stages of a scene."""
    sim, seconds = Simulation(scene), []
    for stage in scene.stages:
        began = time.thread_time()
        sim.reach(sim.time + stage.duration)
        seconds.append(time.thread_time() - began)
    return [StageCost(record, own) for record, own in zip(sim.stages, seconds, strict=True)]


def cost_table(models: Mapping[str, Sequence[StageCost]]) -> str:
    """Steps and processor time of each stage, and of each built-in scene, beside its simulated time."""
    body = []
    for model, stages in models.items():
        for one in stages:
            record = one.record
            length = record.end - record.start
            body.append((
                model, record.name, f"{length:.2f}", f"{1e6 * record.dt:.2f}", f"{record.steps:,d}",
                f"{one.seconds:.1f}", f"{one.seconds / length:.1f}",
            ))  # fmt: skip
        name = whole(model).name
        for count, scene in ((len(stages) - 1, name.replace("whole", "stage-1")), (len(stages), name)):
            seconds, length = math.fsum(one.seconds for one in stages[:count]), stages[count - 1].record.end
            steps = sum(one.record.steps for one in stages[:count])
            body.append((
                model, f"{count} stages: {scene}", f"{length:.2f}", "-", f"{steps:,d}", f"{seconds:.1f}",
                f"{seconds / length:.1f}",
            ))  # fmt: skip
    heads = ("sail", "stage", "simulated [s]", "step [us]", "steps", "processor time [s]", "ratio")
    return table(heads, body, words=(0, 1))
