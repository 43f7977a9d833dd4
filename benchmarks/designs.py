"""Designs per minute: sweeps and ensembles of a fast scene and of its full model, by threads and by processes.

    sweep       the deployment of the sail from the cross to the end of the paper's figures, each design with another
                stiffness of its creases
    ensemble    the same from several starts, with mean and band of its curves

Runs are kept in memory. Beside the fast scene there is a coarse one, with every other line of the mesh and softened
more, for designs that need no more than docs/softening.md says of it; and the full model, stepped as the fast scene is,
and as its own file says. Threads and processes alternate; times are medians. Then what a run of the fast scene takes
beside its steps, in one thread.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from statistics import median
from typing import Literal

from building import import_time
from machine import cpu
from membrane_rs import Scene, Simulation, scenes
from membrane_rs._markdown import table
from membrane_rs.scene.softened import with_softening
from membrane_rs.study import RunPoint, Sweep, ensemble, sweep
from membrane_rs.study.common.one_run import RunSetup, RunTask, make_run, packed
from page import README, MarkedPart, options, show
from softening_cases import COARSE, coarse

PART = MarkedPart(README, "designs")
FAST, FULL, KEY = "okuizumi-model-1-fast", "okuizumi-model-1", "laws.creases.stiffness"
COARSE_SOFTENING = 10.0
"""That of the coarse scene [-]; charted in docs/softening.md, "Error against cost"."""
AIM = 100.0
"""Designs a minute on two cores."""
Where = Literal["threads", "processes"]
WHERE: tuple[Where, ...] = ("threads", "processes")


@dataclass(frozen=True)
class Case:
    """A study that is timed: `make` runs it at so many designs or starts, more than once unless it is long."""

    study: str
    model: str
    scene: Scene
    make: Callable[[Scene, int, Where], Sweep]
    count: int
    aim: float | None = None
    is_long: bool = False


def swept(scene: Scene, count: int, where: Where) -> Sweep:
    """Designs of other stiffness, of which none has the scene's own."""
    values = [5.0 + 10.0 * (k + 0.25) / count for k in range(count)]
    return sweep(scene, {KEY: values}, executor=where)


def started(scene: Scene, count: int, where: Where) -> Sweep:
    """Starts of the scene, with mean and band."""
    found = ensemble(scene, count, executor=where)
    for column in ("deployment_rate", "phase_difference_deg"):
        found.band(column)
    return found.runs


def stepped_alike(scene: Scene, fast: Scene) -> Scene:
    """A scene by the method of the fast one, at the same share of its own limit."""
    run = replace(scene.run, snapshots=(), integrator=fast.run.integrator, substeps=fast.run.substeps)
    by_method = replace(scene, run=run)
    interval = scene.run.until / (scene.run.samples - 1)
    sim = Simulation(fast)
    dt = sim.dt / sim.stable_dt() * Simulation(by_method).stable_dt()
    return replace(by_method, run=replace(by_method.run, dt=interval / -(-interval // dt)))


def shortened(scene: Scene, share: float) -> Scene:
    """The scene up to a share of its end, its samples as dense."""
    samples = 1 + round(share * (scene.run.samples - 1))
    return replace(scene, run=replace(scene.run, until=share * scene.run.until, samples=samples))


def cases(fast: Scene, full: Scene, count: int, few: int) -> list[Case]:
    """All studies: of the fast scene with so many designs, of the full model with few."""
    alike = stepped_alike(full, fast)
    rough = stepped_alike(with_softening(coarse(full), COARSE_SOFTENING), fast)
    name = f"{COARSE}, softened {COARSE_SOFTENING:g}"
    return [
        Case("sweep", "fast scene", fast, swept, count, AIM),
        Case("ensemble", "fast scene", fast, started, count, AIM),
        Case("sweep", name, rough, swept, 4 * count, AIM),
        Case("ensemble", name, rough, started, 4 * count, AIM),
        Case("sweep", "full model, stepped alike", alike, swept, few),
        Case("ensemble", "full model, stepped alike", alike, started, few),
        Case("sweep", "full model, as its file says", full, swept, few, is_long=True),
    ]


def seconds_of(action: Callable[[], object]) -> float:
    """Wall time of an action [s]."""
    began = time.perf_counter()
    action()
    return time.perf_counter() - began


def timed(case: Case, where: Where) -> float:
    """Wall time of a study [s]. Raises RuntimeError where a run did not come to its end."""
    began = time.perf_counter()
    found = case.make(case.scene, case.count, where)
    seconds = time.perf_counter() - began
    if found.outcomes() != {"finished": case.count}:
        raise RuntimeError(f"{case.study}, {case.model}: not all runs came to their end: {found.outcomes()}")
    return seconds


def study_table(every: list[Case], times: Mapping[tuple[int, Where], list[float]]) -> str:
    """Runs a minute of each study, with its aim."""
    rows = []
    for k, case in enumerate(every):
        for where in WHERE:
            seconds = median(times[k, where])
            aim = "" if case.aim is None else f"{case.aim:g}"
            numbers = (f"{case.count}", f"{seconds:.1f}", f"{60.0 * case.count / seconds:.1f}", aim)
            rows.append((case.study, case.model, where, *numbers))
    return table(("study", "of", "by", "runs", "wall time [s]", "runs a minute", "aim"), rows, words=(0, 1, 2))


def parts_of_a_run(scene: Scene, repeats: int) -> list[tuple[str, float]]:
    """What a run of the fast scene takes, and of what, in one thread [s]."""
    whole, making, steps = [], [], []
    for k in range(repeats):
        values = {KEY: 6.0 + k}  # a design is made once
        task = RunTask(packed(scene), RunSetup(), RunPoint(values))
        whole.append(seconds_of(lambda task=task: make_run(task)))  # type: ignore[misc]
        design = scene.with_values({KEY: 6.5 + k})
        making.append(seconds_of(lambda design=design: Simulation(design)))  # type: ignore[misc]
        sim = Simulation(design)
        steps.append(seconds_of(lambda sim=sim: sim.step(round(scene.run.until / sim.dt))))  # type: ignore[misc]
    rest = median(whole) - median(making) - median(steps)
    return [
        ("a run", median(whole)),
        ("of it its steps", median(steps)),
        ("of it the simulation: core, stability limit, audit", median(making)),
        ("of it the rest: values, history, row", rest),
        (
            "beside it, once for each process: imports",
            median(import_time(f"import {make_run.__module__}") for _ in range(repeats)),
        ),
    ]


def main() -> None:
    """Measure, and print or write the tables."""
    parser = options(__doc__)
    parser.add_argument("--repeats", type=int, default=3, help="of each study")
    chosen = parser.parse_args()
    cores = os.cpu_count() or 1
    count, few, repeats, share = (2, 1, 1, 0.0025) if chosen.quick else (8, cores, chosen.repeats, 1.0)
    fast, full = (shortened(scenes.load(name), share) for name in (FAST, FULL))
    every = cases(fast, full, count, few)
    times: dict[tuple[int, Where], list[float]] = {(k, where): [] for k in range(len(every)) for where in WHERE}
    for repeat in range(repeats):
        for (k, where), found in times.items():
            if repeat == 0 or not every[k].is_long:
                found.append(timed(every[k], where))
    beside = [(what, f"{1e3 * seconds:.0f}") for what, seconds in parts_of_a_run(fast, repeats)]
    head = (
        f"Processor: {cpu()}, {cores} cores. Runs of {fast.run.until:g} s, medians of {repeats}; the full model as its "
        "file says once."
    )
    show(PART, f"{head}\n\n{study_table(every, times)}\n{table(('', '[ms]'), beside)}", write=chosen.write)


if __name__ == "__main__":
    main()
