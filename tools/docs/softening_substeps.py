"""Designs of the fast scenes by substeps and step, for docs/softening.md: energy errors, times, runs stopped."""

from __future__ import annotations

import statistics
import time
from dataclasses import replace
from functools import partial

import numpy as np
from membrane_rs import Scene, Simulation, UnstableError, scenes
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from softening_cases import FAST_SCENES, SHARE
from softening_runs import Run, Runs

STEPS = (*((substeps, SHARE) for substeps in (1, 2, 3, 4)), (3, 0.91))
"""Substeps in a step, and the step over its limit: the last are those of the fast scenes."""
DESIGNS = tuple(5.0 + 1.25 * (k + 0.25) for k in range(8))
"""Stiffness parameters beta of the creases, about the 10 of the scenes."""


def design(name: str, substeps: int, beta: float) -> Scene:
    """A fast scene with creases of another stiffness, and so many substeps."""
    scene = scenes.load(name).with_values({"laws.creases.stiffness": beta})
    return replace(scene, run=replace(scene.run, substeps=substeps, dt=None, snapshots=()))


def deployed_design(name: str, substeps: int, of_limit: float, beta: float, share: float) -> dict[str, Floats]:
    """Processor time of the stepping [s] and energy error of a run; empty where the monitor stops it."""
    scene = design(name, substeps, beta)
    sim = Simulation(scene, dt=of_limit * Simulation(scene).stable_dt())
    began = time.thread_time()
    try:
        sim.reach(share * scene.run.until)
    except UnstableError as error:
        print(f"{name}, {substeps} substeps, {of_limit:g} of the limit, beta = {beta:g}: {error}", flush=True)
        return {}
    seconds = time.thread_time() - began
    return {"seconds": np.array(seconds), "error": np.array(sim.ledger()["error"])}


def substeps_table(runs: Runs) -> str:
    """Runs stopped, energy errors and processor time of each fast scene by substeps and step."""
    share = runs.extent.share
    jobs = {
        f"substeps {model} {substeps} {of_limit:g} {beta:g} {share:g}": partial(
            deployed_design, name, substeps, of_limit, beta, share
        )
        for beta in DESIGNS
        for model, name in FAST_SCENES.items()
        for substeps, of_limit in STEPS
    }
    found = runs.of(jobs)
    body = []
    for model, name in FAST_SCENES.items():
        plain = None
        for substeps, of_limit in STEPS:
            every: list[Run] = [
                found[f"substeps {model} {substeps} {of_limit:g} {beta:g} {share:g}"] for beta in DESIGNS
            ]
            ended = [run for run in every if len(run)]
            cells = ["-"] * 3
            if ended:
                errors = [abs(float(run["error"])) for run in ended]
                seconds = statistics.median(float(run["seconds"]) for run in ended)
                plain = plain or seconds
                cells = [f"{100.0 * number:.2f}" for number in (statistics.median(errors), max(errors))]
                cells.append(f"{plain / seconds:.2f}")
            step = (f"`{name}`", f"{substeps}", f"{of_limit:g}")
            body.append((*step, f"{len(every) - len(ended)} of {len(every)}", *cells))
    heads = ("runs stopped", "energy error, median [%]", "largest [%]", "times faster than without")
    return table(("scene", "substeps", "step over limit", *heads), body, words=(0,))
