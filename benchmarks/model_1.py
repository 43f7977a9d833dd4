"""What a step of model 1 costs, and what each law has of it, through the public interface.

A law's cost is the step's time with all laws less the time without that law, over the four evaluations of an
RK4 step: what a user saves by leaving it out. Processor time is counted, all are timed in turn, and the median
of the differences is taken, so that a slow moment of the machine falls on all alike.

Before it come the kernels against plain scalar loops, which the core's own benchmark measures (`cargo bench`). With
--write the tables and criterion's medians of the kernels, if there are any, go into README.md beside it.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import time
from dataclasses import replace
from pathlib import Path

from machine import cpu
from membrane_rs import Scene, Simulation, scenes

HERE = Path(__file__).resolve().parent
CRITERION = HERE.parent / "target" / "criterion"
BEGIN, END = "<!-- make bench: begin -->", "<!-- make bench: end -->"
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
    lines = ["| model 1 by law | us per evaluation | share of the step |", "|---|---:|---:|"]
    rows = [*sorted(saved.items(), key=lambda item: -item[1]), ("left over", rest)]
    for name, cost in rows:
        lines.append(f"| {name} | {cost:.1f} | {100 * EVALUATIONS * cost / whole:.0f} % |")
    lines.append(f"| all; an RK4 step takes {whole:.0f} us | {whole / EVALUATIONS:.1f} | 100 % |")
    return "\n".join(lines) + "\n"


def kernel_table() -> str:
    """Criterion's medians, if `cargo bench` has left any: a column for each set of vector instructions."""
    medians: dict[str, dict[str, float]] = {}
    for group in ("evaluation", "step"):
        for file in sorted((CRITERION / group).glob("*/*/new/estimates.json")):
            law, width = file.parts[-4:-2]
            median = json.loads(file.read_text(encoding="utf-8"))["median"]["point_estimate"] / 1e3
            medians.setdefault(f"{group}: {law}", {})[width] = median
    if not medians:
        return ""
    slowest = max(medians.values(), key=lambda row: max(row.values()))
    widths = sorted(slowest, key=lambda width: -slowest[width])
    lines = ["| on the sheet [us] | " + " | ".join(widths) + " |", "|---|" + "---:|" * len(widths)]
    for label, row in sorted(medians.items(), key=lambda item: -item[1][widths[0]]):
        lines.append(f"| {label} | " + " | ".join(f"{row[width]:.1f}" for width in widths) + " |")
    return "\n".join(lines) + "\n"


def scalar_table() -> str:
    """The kernels against plain scalar loops, as `cargo bench --bench model_1` prints them."""
    command = ["cargo", "bench", "--package", "membrane-core", "--bench", "model_1"]
    done = subprocess.run(command, cwd=HERE.parent, check=True, capture_output=True, text=True)
    return done.stdout.strip() + "\n"


def main() -> None:
    """Measure, print, and write if asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--repeats", type=int, default=161, help="how often each variant is timed")
    parser.add_argument("--steps", type=int, default=50, help="steps in each timing")
    parser.add_argument("--write", action="store_true", help="put the tables into README.md beside this file")
    options = parser.parse_args()

    sail = sail_table(step_times(options.repeats, options.steps))
    text = f"Processor: {cpu()}, one thread.\n\n{scalar_table()}\n{sail}"
    kernels = kernel_table()
    if kernels:
        text += f"\n{kernels}"
    print(text)
    if options.write:
        readme = HERE / "README.md"
        before, _, rest = readme.read_text(encoding="utf-8").partition(BEGIN)
        after = rest.partition(END)[2]
        readme.write_text(f"{before}{BEGIN}\n\n{text}\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
