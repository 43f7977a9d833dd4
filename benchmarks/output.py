"""Cost of a results folder: runs of model 1 with and without it, alternately, in one process.

    leapfrog, near its limit    the fastest stepping, and so the most demanding case: the whole deployment
    rk4                         the default method and step: a part of the deployment, frames and samples as dense

Wall time includes waiting for the writing thread, which has a core of its own where one is free: the fastest run of
each kind, the least disturbed. Processor time, of stepping and writing together, is the time of a run on one core
only: the median of the ratios of runs that follow each other. A first short run, not counted, imports what is
needed. The pictures are drawn after the run, in a fresh process here, as a user does it, and timed apart. With
--write the table goes into README.md beside this file.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

from machine import cpu
from membrane_rs import Simulation, scenes
from membrane_rs._markdown import table
from page import README, MarkedPart, options, show

PART = MarkedPart(README, "output")
HERE = Path(__file__).resolve().parent
SCENE = scenes.load("okuizumi-model-1")
NEAR = 0.9
"""Share of its limit that leapfrog steps with."""


@dataclass(frozen=True)
class Case:
    """Runs to compare: until `until` [s], a step of `share` of the limit, or the default step."""

    name: str
    integrator: str
    share: float | None
    until: float


CASES = (Case("leapfrog", "leapfrog", NEAR, 0.8), Case("rk4", "rk4", None, 0.2))


@dataclass(frozen=True)
class Times:
    """Of one run: wall time and processor time of the whole process [s]."""

    wall: float
    processor: float


def ready(case: Case, until: float) -> Simulation:
    """The stowed sail, to be run until `until` [s]; frames and samples as dense as in the scene."""
    part, settings = until / SCENE.run.until, SCENE.run
    frames, samples = (max(2, 1 + round(part * (count - 1))) for count in (settings.frames, settings.samples))
    scene = replace(SCENE, run=replace(settings, until=until, frames=frames, samples=samples))
    dt = None if case.share is None else case.share * Simulation(scene, case.integrator).stable_dt()
    return Simulation(scene, case.integrator, dt)


def run(case: Case, until: float, folder: Path | None) -> Times:
    """One run, into a folder or without one."""
    sim = ready(case, until)
    wall, processor = time.perf_counter(), time.process_time()
    sim.run() if folder is None else sim.run(out=folder, pictures=False)
    return Times(time.perf_counter() - wall, time.process_time() - processor)


def pairs(repeats: int, part: float) -> dict[str, list[tuple[Times, Times]]]:
    """Times without and with a folder, of each case, in turn; each run `part` of its length."""
    found: dict[str, list[tuple[Times, Times]]] = {case.name: [] for case in CASES}
    with tempfile.TemporaryDirectory() as scratch:
        run(CASES[0], 0.01, Path(scratch) / "warm")
        for repeat in range(repeats):
            for case in CASES:
                folder = Path(scratch) / f"{case.name}-{repeat}"
                found[case.name].append((run(case, part * case.until, None), run(case, part * case.until, folder)))
    return found


def drawing(part: float) -> tuple[float, float]:
    """Wall time of a run with pictures [s], in a fresh process: until its summary, and of the pictures after it."""
    code = (
        "import sys, time; sys.path.insert(0, sys.argv[1]); from output import CASES, ready; from pathlib import Path; "
        "sim = ready(CASES[0], float(sys.argv[2]) * CASES[0].until); began = time.perf_counter(); "
        "sim.run(out=Path(sys.argv[3])); print(time.perf_counter() - began)"
    )
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "run"
        command = [sys.executable, "-c", code, str(HERE), str(part), str(folder)]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        stepping = float(json.loads((folder / "summary.json").read_text(encoding="utf-8"))["wall_time"])
    return stepping, float(done.stdout) - stepping


def rows(found: dict[str, list[tuple[Times, Times]]], part: float) -> list[list[str]]:
    """A row of the table for each case."""
    made = []
    for case in CASES:
        runs = found[case.name]
        bare, beside = (min(pair[k].wall for pair in runs) for k in (0, 1))
        processor = statistics.median(b.processor / a.processor for a, b in runs)
        slower = [f"{100 * (ratio - 1):+.1f} %" for ratio in (beside / bare, processor)]
        made.append([case.name, f"{part * case.until:g}", f"{bare:.2f}", f"{beside:.2f}", *slower])
    return made


def main() -> None:
    """Measure, print, and write if asked."""
    parser = options(__doc__)
    parser.add_argument("--repeats", type=int, default=4, help="pairs of runs of each case")
    chosen = parser.parse_args()

    part, repeats = (0.25, 2) if chosen.quick else (1.0, chosen.repeats)
    head = ["model 1", "simulated [s]", "without output, wall time [s]", "with output, wall time [s]"]
    head += ["increase of wall time", "increase of processor time"]
    times = table(head, rows(pairs(repeats, part), part))
    stepping, pictures = drawing(part)
    drawn = f"Pictures, in a fresh process: {pictures:.1f} s after a run of {stepping:.1f} s by leapfrog.\n"
    show(PART, f"Processor: {cpu()}.\n\n{times}\n{drawn}", write=chosen.write)


if __name__ == "__main__":
    main()
