"""Designs per minute: a sweep of the fast sail, by threads and by processes.

Each design is the deployment of `okuizumi-model-1-fast` with another stiffness of its creases, from the cross to the
end of the paper's figures. Threads and processes alternate; times are medians. What a run costs beside its steps, in
one thread: the scene from its file, the simulation with its stability limit.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from statistics import median
from typing import Literal

from machine import cpu
from membrane_rs import Simulation, scenes
from membrane_rs._markdown import table
from membrane_rs.study import sweep
from page import README, MarkedPart, options, show

PART = MarkedPart(README, "designs")
SCENE, KEY = "okuizumi-model-1-fast", "laws.creases.stiffness"
WHERE: tuple[Literal["threads", "processes"], ...] = ("threads", "processes")


def seconds_of(action: Callable[[], object]) -> float:
    """Wall time of an action [s]."""
    began = time.perf_counter()
    action()
    return time.perf_counter() - began


def designs(count: int) -> list[float]:
    """Values of the stiffness, of which none is the scene's own."""
    return [5.0 + 10.0 * (k + 0.25) / count for k in range(count)]


def sweep_once(where: Literal["threads", "processes"], count: int, until: float) -> float:
    """Wall time of a sweep of so many designs [s]. Raises RuntimeError where a run did not come to its end."""
    began = time.perf_counter()
    found = sweep(SCENE, {KEY: designs(count)}, until=until, executor=where)
    seconds = time.perf_counter() - began
    if found.outcomes() != {"finished": count}:
        raise RuntimeError(f"not all designs came to their end: {found.outcomes}")
    return seconds


def main() -> None:
    """Measure, and print or write the tables."""
    chosen = options(__doc__).parse_args()
    count, repeats, until = (2, 1, 0.002) if chosen.quick else (8, 3, scenes.load(SCENE).run.until)
    times: dict[str, list[float]] = {where: [] for where in WHERE}
    for _ in range(repeats):
        for where in WHERE:
            times[where].append(sweep_once(where, count, until))
    rows = [(where, f"{median(times[where]):.1f}", f"{60.0 * count / median(times[where]):.0f}") for where in WHERE]
    parts = {
        "the scene from its file": lambda: scenes.load(SCENE),
        "the simulation, with its stability limit": lambda: Simulation(scenes.load(SCENE)).stable_dt(),
    }
    beside = [(what, f"{1e3 * median(seconds_of(part) for _ in range(repeats)):.0f}") for what, part in parts.items()]
    head = f"Processor: {cpu()}, {os.cpu_count()} cores. {count} designs of {until:g} s, medians of {repeats}."
    first = table(("made by", "wall time [s]", "designs a minute"), rows)
    show(PART, f"{head}\n\n{first}\n{table(('of each run, in one thread', '[ms]'), beside)}", write=chosen.write)


if __name__ == "__main__":
    main()
