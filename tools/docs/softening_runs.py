"""Ensembles of the deployment for docs/softening.md: their runs, kept in files, and their curves."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from threading import Event

import numpy as np
from kept import kept, slug
from membrane_rs import Scene, Simulation, UnstableError
from membrane_rs._arrays import Floats
from membrane_rs.analysis.deployment import Corners
from membrane_rs.study.common.executor import run_parallel
from membrane_rs.study.common.perturbation import perturbation
from softening_cases import SHARE, Case
from softening_symmetry import Petals

RATE, PHASE = "deployment_rate", "phase_difference_deg"
CURVES = {RATE: "rate", PHASE: "phase [deg]"}
"""Columns, and what tables call them."""
INSTANTS = 400
Run = Mapping[str, Floats]


@dataclass(frozen=True)
class Extent:
    """How much is run: `starts` of each ensemble, and the `share` of each run that is made [-]."""

    starts: int
    share: float = 1.0


@dataclass(frozen=True)
class Runs:
    """Runs by their names, each made once and kept in a folder, so many of them at a time."""

    folder: Path
    extent: Extent
    workers: int | None = None

    def of(self, jobs: Mapping[str, Callable[[], Run]]) -> dict[str, Run]:
        """The results of jobs, in parallel, begun in their order."""
        calls = [partial(kept, self.folder / f"{slug(name)}.npz", job) for name, job in jobs.items()]
        found = run_parallel(calls, list(jobs), Event(), workers=self.workers, tell=partial(print, flush=True))
        return dict(zip(jobs, found, strict=True))


@dataclass(frozen=True)
class Ensemble:
    """Runs of one case from several starts; those that were stopped have no curves.

    Attributes
    ----------
    runs : sequence of mapping
        As `deployed` gives them.
    """

    runs: Sequence[Run]

    @property
    def is_whole(self) -> bool:
        """Whether all runs came to their end."""
        return bool(self.runs) and all(len(run) for run in self.runs)

    @property
    def time(self) -> Floats:
        """(samples,) [s]"""
        return np.asarray(self.runs[0]["time"])

    def curves(self, column: str) -> Floats:
        """(starts, samples) of a column."""
        return np.array([run[column] for run in self.runs])

    def typical(self, name: str) -> float:
        """Median of a number over the starts."""
        return statistics.median(float(run[name]) for run in self.runs)


def ensembles(runs: Runs, cases: Mapping[str, Mapping[str, Case]]) -> dict[str, dict[str, Ensemble]]:
    """The ensemble of each case, by group and label.

    All cases of a start are run before the next start, so that other load on the machine has the same effect on the
    processor times of each.
    """
    extent = runs.extent
    jobs = {
        f"{group} {label} {start} {extent.share:g}": partial(deployed, case, case.first_seed + start, extent.share)
        for start in range(extent.starts)
        for group, own in cases.items()
        for label, case in own.items()
    }
    found = runs.of(jobs)
    return {
        group: {
            label: Ensemble([found[f"{group} {label} {start} {extent.share:g}"] for start in range(extent.starts)])
            for label in own
        }
        for group, own in cases.items()
    }


@cache
def prepared(case: Case) -> tuple[Scene, float]:
    """The scene of a case, and its step [s]: that which the scene gives, or `SHARE` of the limit."""
    scene = case.make()
    return scene, scene.run.dt or SHARE * Simulation(scene).stable_dt()


def deployed(case: Case, seed: int, share: float = 1.0) -> dict[str, Floats]:
    """Rate and phase of a run from a displaced start, steps, processor time of the stepping [s], energy error [-].

    Empty where the monitor stops the run. Of petals alike, steps and energy error are those since the last averaging.
    """
    scene, dt = prepared(case)
    sim = Simulation(scene, dt=dt)
    petals = Petals(sim.positions) if case.alike else None
    displacement = perturbation(scene, seed, case.shift)
    sim.positions = sim.positions + (petals.alike(displacement) if petals else displacement)
    corners, rows, seconds = Corners(sim.assembly), [], 0.0
    for instant in scene.run.until * share * np.linspace(0.0, 1.0, INSTANTS + 1):
        began = time.thread_time()
        try:
            sim.reach(float(instant))
        except UnstableError as error:
            print(f"{case.label}: {error}", flush=True)
            return {}
        seconds += time.thread_time() - began
        shape = sim.positions
        rows.append((sim.time, corners.deployment_rate(shape), corners.phase_difference(shape)))
        if petals:
            petals.average(sim)
    times, rate, phase = np.array(rows).T
    numbers = {"steps": sim.step_count, "seconds": seconds, "error": sim.ledger()["error"]}
    return {"time": times, RATE: rate, PHASE: phase, **{name: np.array(value) for name, value in numbers.items()}}
