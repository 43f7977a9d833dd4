"""Wound sails softened in all stages, for docs/softening.md: reeling out and release."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from deployment_reel import IN_ORDER, REEL, not_softened, pull_at_tips, whole
from membrane_rs import Scene, Schedule, Simulation, UnstableError
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from membrane_rs.analysis.deployment import Corners
from membrane_rs.scene.softened import with_softening
from membrane_rs.study.common.perturbation import MODEL_SHIFT, perturbation
from softening_cases import FULL, soft
from softening_distance import mean_distance, spread, standard_error
from softening_runs import PHASE, RATE, Ensemble, Runs

MODEL, DURATION = "model 1", 2.0
"""Of the sail, and of its reeling out [s]."""
STARTS = 3
FACTORS = (3, 10, 30)
OWN = "its stages' own modulus over 10, full in the release"
REELED, RELEASED = 200, 400
"""Samples of the reeling out and of the release."""
SHORTEST = 0.02
"""Of a stage in a brief run [s]."""
READINGS = {"reach": 1e3, "apart": 1e3, "lead": 1.0, "tension": 1.0}
"""Samples of the reeling out, and their factors in the table."""


@dataclass(frozen=True)
class WoundCase:
    """A wound sail. `share`: how much of each stage is run [-]."""

    make: Callable[[], Scene]
    share: float = 1.0

    def scene(self) -> Scene:
        """The scene, its stages as short as the share says."""
        scene = self.make()
        if self.share == 1.0:
            return scene
        stages = []
        for stage in scene.stages:
            duration = max(SHORTEST, self.share * stage.duration)
            shorter = {
                key: _in_time(value, duration / stage.duration) if isinstance(value, Schedule) else value
                for key, value in stage.set.items()
            }
            stages.append(replace(stage, duration=duration, set=shorter))
        return replace(scene, stages=stages)


def wound_cases(share: float) -> dict[str, WoundCase]:
    """The sail with its own modulus, with that of its stages, and softened in all stages."""

    def plain() -> Scene:
        return not_softened(whole(MODEL, DURATION))

    cases: dict[str, Callable[[], Scene]] = {FULL: plain, OWN: lambda: whole(MODEL, DURATION)}
    for factor in FACTORS:
        cases[soft(factor)] = lambda factor=factor: with_softening(plain(), factor)  # type: ignore[misc]
    return {label: WoundCase(make, share) for label, make in cases.items()}


def wound_ensembles(runs: Runs) -> dict[str, Ensemble]:
    """The runs of each wound sail."""
    cases, starts = wound_cases(runs.extent.share), min(STARTS, runs.extent.starts)
    names = {
        (label, start): f"wound {label} {start} {runs.extent.share:g}" for start in range(starts) for label in cases
    }
    found = runs.of({name: partial(unwound, cases[label], start) for (label, start), name in names.items()})
    return {label: Ensemble([found[names[label, start]] for start in range(starts)]) for label in cases}


def unwound(case: WoundCase, seed: int) -> dict[str, Floats]:
    """Samples of the reeling out and of the release, steps, processor time [s], energy error.

    "reach" [m], mean radius of the corners, and "apart" [m], their largest difference; "lead" [deg] of the corners over
    the bars, mean; "tension" at the tips over m Omega^2 R. Empty where the monitor stops the run.
    """
    scene = case.scene()
    sim = Simulation(scene)
    sim.positions = sim.positions + perturbation(scene, seed, MODEL_SHIFT)
    began = time.thread_time()
    try:
        found = _samples(sim, scene)
    except UnstableError as error:
        print(f"{scene.name}: {error}", flush=True)
        return {}
    # Of the sampling it contains some milliseconds.
    seconds = time.thread_time() - began
    steps, residual = sum(record.steps for record in sim.stages), sim.ledger()["error"]
    return found | {
        name: np.array(value) for name, value in (("steps", steps), ("seconds", seconds), ("error", residual))
    }


def _samples(sim: Simulation, scene: Scene) -> dict[str, Floats]:
    start, stage = scene.stages[0].duration, scene.stages[REEL]
    sim.reach(start)
    nodes = sim.assembly.node_sets["corners"]
    bars = next(body for body in sim.stage_scene.bodies if body.name == "bars")
    assert isinstance(bars.turn, Schedule)
    azimuth = np.arctan2(bars.centre[1], bars.centre[0])
    weight = sim.masses[nodes] * (2.0 * np.pi * scene.value("laws.spin.frequency")) ** 2
    rows = []
    for instant in np.linspace(start, start + stage.duration, REELED + 1)[1:-1]:
        sim.reach(float(instant))
        x, y, _ = sim.positions[nodes].T
        radius = np.hypot(x, y)
        turned = np.arctan2(y, x) - azimuth - bars.turn.at(sim.time) - 0.5 * np.pi * np.arange(len(nodes))
        lead = np.degrees(np.angle(np.exp(1j * turned)))
        rows.append((radius.mean(), np.ptp(radius), lead.mean(), (pull_at_tips(sim) / (weight * radius)).mean()))
    found = dict(zip(READINGS, np.array(rows).T, strict=True))
    begin = sum(one.duration for one in scene.stages[:-1])
    sim.reach(begin)
    corners, curves = Corners(sim.assembly), []
    for instant in np.linspace(begin, begin + scene.stages[-1].duration, RELEASED + 1)[1:]:
        sim.reach(float(instant))
        shape = sim.positions
        curves.append((sim.time - begin, corners.deployment_rate(shape), corners.phase_difference(shape)))
    return found | dict(zip(("time", RATE, PHASE), np.array(curves).T, strict=True))


def wound_table(found: Mapping[str, Ensemble]) -> str:
    """Distance of the mean curves from those of the full model and its standard error, spread of its starts, cost."""
    body: list[tuple[str, ...]] = []
    full = found[FULL]
    for label, own in found.items():
        if not own.is_whole:
            body.append((label, *("stopped",) * 10))
            continue
        cells = []
        for name, factor, form in (*((name, factor, ".2f") for name, factor in READINGS.items()), *OF_RELEASE):
            mine, other = factor * own.curves(name), factor * full.curves(name)
            if label == FULL:
                own_spread = spread(mine)
                cells.append("-" if np.isnan(own_spread) else f"spread {own_spread:{form}}")
            else:
                error = standard_error(other, mine)
                chance = "" if np.isnan(error) else f" ± {error:{form}}"
                cells.append(f"{mean_distance(other, mine):{form}}{chance}")
        is_ordered = own.curves("apart").max() < IN_ORDER
        seconds = own.typical("seconds")
        body.append((
            label, *cells, "in order" if is_ordered else "out of order", f"{own.typical('steps'):,.0f}",
            f"{seconds:.1f}", f"{full.typical('seconds') / seconds:.2f}",
        ))  # fmt: skip
    heads = (
        "film", "reach [mm]", "arms differ by [mm]", "lead over the bars [deg]", "tension of the tips", "rate",
        "phase [deg]", "arms", "steps", "processor time [s]", "less by",
    )  # fmt: skip
    return table(heads, body, words=(0, 7))


OF_RELEASE = ((RATE, 1.0, ".4f"), (PHASE, 1.0, ".2f"))
"""Curves of the release, their factors and forms in the table."""


def _in_time(schedule: Schedule, factor: float) -> Schedule:
    return replace(schedule, times=tuple(factor * time for time in schedule.times))
