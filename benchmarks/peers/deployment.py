"""The whole deployment of model 1: its cost, and its distance from a finer run; and that of its fast scene.

The motion is chaotic, so that a run is as good as any where its curves lie no further from a finer run's than those of
an ensemble of perturbed starts lie from each other. That spread is the one of the diagram in docs/studies.md.
"""

from __future__ import annotations

import re
import statistics
import time
from dataclasses import dataclass, replace

from membrane_rs import Scene, Simulation, scenes
from membrane_rs.study.common.differences import CURVES
from membrane_rs.study.common.run import run_case, study_case
from page import DOCS, MarkedPart

STUDIES = DOCS / "studies.md"
UNTIL = 0.8
"""End [s]."""
INSTANTS = 100
"""At which the curves are compared, as in the diagram."""
METHOD, SHARE = "leapfrog", 0.9
"""The cheapest method of the diagram, and its step over its limit."""
SUBSTEPS = 4
"""Substeps in a step; slow laws are evaluated once a step."""
FINER, FINER_SHARE = "rk4", 0.25
"""Method and step of the finer run."""
FAST, REPEATS = "okuizumi-model-1-fast", 5
"""The softened scene, by its own method and step, and how often it is timed. README.md has its distance."""


@dataclass(frozen=True)
class Deployment:
    """`dt`, `limit`: of the run [s]; `wall`, `processor`: times of it [s], scaled to 0.8 s; `finer_dt` [s].

    `errors`, `spreads`: by curve ("rate", "phase" [deg]), the largest difference from the finer run and between the
    perturbed starts of the diagram. `steps` of the run.
    """

    dt: float
    limit: float
    steps: int
    wall: float
    processor: float
    finer_dt: float
    errors: dict[str, float]
    spreads: dict[str, float]

    @property
    def is_within(self) -> bool:
        """Whether no curve is further from the finer run's than perturbed starts are from each other."""
        return all(error <= self.spreads[name] for name, error in self.errors.items())


@dataclass(frozen=True)
class FastDeployment:
    """The fast scene: `dt` of its run [s], its `substeps` and `softening`, and `processor`, the median of the times
    that `REPEATS` runs take, scaled to 0.8 s [s]. `steps` of a run.
    """

    dt: float
    substeps: int
    softening: float
    steps: int
    processor: float


def deploy_fast(until: float = UNTIL) -> FastDeployment:
    """Run the fast scene to its end, or to an earlier one; times are then scaled."""
    scene = scenes.load(FAST)
    assert scene.material is not None
    case = study_case(scene, until, INSTANTS)
    runs = [run_case(case, scene.run.integrator, Simulation(scene).dt).completed() for _ in range(REPEATS)]
    processor = statistics.median(run.seconds for run in runs) * UNTIL / until
    softening = scene.material.softening or 1.0
    return FastDeployment(runs[0].dt, scene.run.substeps, softening, runs[0].steps, processor)


def deploy(scene: Scene, until: float = UNTIL) -> Deployment:
    """Run model 1 to its end, or to an earlier one; times are then scaled."""
    scene = replace(scene, run=replace(scene.run, substeps=SUBSTEPS))
    case = study_case(scene, until, INSTANTS)
    limits = {method: Simulation(scene, integrator=method).stable_dt() for method in (METHOD, FINER)}
    finer = run_case(case, FINER, FINER_SHARE * limits[FINER]).completed()
    began = time.perf_counter()
    run = run_case(case, METHOD, SHARE * limits[METHOD]).completed()
    wall = time.perf_counter() - began
    return Deployment(
        dt=run.dt,
        limit=limits[METHOD],
        steps=run.steps,
        wall=wall * UNTIL / until,
        processor=run.seconds * UNTIL / until,
        finer_dt=finer.dt,
        errors={name: error(run, finer, case.start) for name, (_, error) in CURVES.items()},
        spreads=spreads(MarkedPart(STUDIES, "deployment-work-precision").read()),
    )


def spreads(diagram: str) -> dict[str, float]:
    """By curve, the spread of perturbed starts of the deployment in docs/studies.md."""
    found = {}
    for name, (label, _) in CURVES.items():
        of_curve = diagram.partition(f"{label}:")[2]
        spread = re.search(r"spread of \d+ starts perturbed by \S+ m: ([\d.e+-]+)", of_curve)
        if spread is None:
            raise ValueError(f"{STUDIES} holds no spread of {label!r}; remake it: make accuracy PART=work-precision")
        found[name] = float(spread[1])
    return found
