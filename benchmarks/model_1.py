"""Cost of a step of model 1, and the share of each law, through the public interface.

The cost of a law is the time of a step with all laws less the time without that law, over the four evaluations of an
RK4 step: the saving from leaving it out. Times are processor times, taken alternately; the median of the differences
is used, so that other load on the machine affects all variants equally.

The first tables compare the kernels with plain scalar loops and with the bounds of the machine; the benchmark of the
core measures them (`cargo bench --bench model_1`).
"""

from __future__ import annotations

import statistics
import subprocess
import time
from dataclasses import replace
from pathlib import Path

from machine import cpu
from membrane_rs import Scene, Simulation, scenes
from membrane_rs._markdown import table
from page import README, MarkedPart, options, show

ROOT = Path(__file__).resolve().parent.parent
PART = MarkedPart(README, "model-1")
EVALUATIONS = 4


def variants() -> dict[str, Scene]:
    """Model 1, and model 1 without each of its laws and without its tethers."""
    scene = scenes.load("okuizumi-model-1")
    without = {law.kind: replace(scene, laws=[other for other in scene.laws if other is not law]) for law in scene.laws}
    no_tethers = replace(scene, parts=[part for part in scene.parts if part.kind != "tethers"])
    return {"": scene, **without, "tethers": no_tethers}


def step_times(repeats: int, steps: int) -> dict[str, list[float]]:
    """Times of a step [us] of each variant, all from the stowed sail and with the same step, in turn."""
    dt = Simulation(variants()[""]).dt
    built = {name: Simulation(scene, dt=dt) for name, scene in variants().items()}
    starts = {name: (sim.positions, sim.velocities) for name, sim in built.items()}
    times: dict[str, list[float]] = {name: [] for name in built}
    for _ in range(repeats):
        for name, sim in built.items():
            sim.positions, sim.velocities = starts[name]
            sim.step(5)  # warm
            began = time.thread_time()
            sim.step(steps)
            times[name].append((time.thread_time() - began) / steps * 1e6)
    return times


def sail_table(times: dict[str, list[float]]) -> str:
    """Model 1 by law."""
    whole = statistics.median(times[""])
    saved = {
        name: statistics.median(a - b for a, b in zip(times[""], found, strict=True)) / EVALUATIONS
        for name, found in times.items()
        if name
    }
    rest = whole / EVALUATIONS - sum(saved.values())
    costs = [*sorted(saved.items(), key=lambda item: -item[1]), ("the method, and what laws share", rest)]
    costs.append((f"all; an RK4 step takes {whole:.0f} us", whole / EVALUATIONS))
    rows = [(name, f"{cost:.1f}", f"{100 * EVALUATIONS * cost / whole:.0f} %") for name, cost in costs]
    return table(("model 1 by law", "us per evaluation", "share of the step"), rows)


def scalar_table(*, quick: bool) -> str:
    """The kernels against scalar loops and the bounds of the machine, as printed by `cargo bench --bench model_1`."""
    command = ["cargo", "bench", "--package", "membrane-benches", "--bench", "model_1", "--"]
    done = subprocess.run(
        [*command, *(["quick"] if quick else [])], cwd=ROOT, check=True, capture_output=True, text=True
    )
    return done.stdout.strip() + "\n"


def main() -> None:
    """Measure, print, and write if asked."""
    chosen = options(__doc__).parse_args()
    repeats, steps = (9, 10) if chosen.quick else (161, 50)
    text = f"{scalar_table(quick=chosen.quick)}\n{sail_table(step_times(repeats, steps))}"
    show(PART, f"Processor: {cpu()}, one thread.\n\n{text}", write=chosen.write)


if __name__ == "__main__":
    main()
