"""The whole deployment of model 1: its cost, and its distance from a finer run; and that of its fast scene.

The motion is chaotic, so that a run is as good as any where its curves lie no further from a finer run's than those of
an ensemble of perturbed starts lie from each other. That spread is the one of the diagram in docs/studies.md.

Processor times are taken in turns with steps of another program, so that a slow moment of the machine affects both.
"""

from __future__ import annotations

import re
import time
from dataclasses import dataclass, replace

from membrane_rs import Scene, Simulation, scenes
from membrane_rs.study.common.differences import CURVES
from membrane_rs.study.common.run import StudyCase, run_case, study_case
from page import DOCS, MarkedPart

from peers.program import Program

STUDIES = DOCS / "studies.md"
UNTIL = 0.8
"""End [s]."""
INSTANTS = 100
"""At which the curves are compared, as in the diagram, and the programs take turns."""
SLICE = 5
"""Steps of the other program in a turn."""
METHOD, SHARE = "leapfrog", 0.9
"""The cheapest method of the diagram, and its step over its limit."""
SUBSTEPS = 4
"""Substeps in a step; slow laws are evaluated once a step."""
FINER, FINER_SHARE = "rk4", 0.25
"""Method and step of the finer run."""
FAST = "okuizumi-model-1-fast"
"""The softened scene, by its own method and step. README.md has its distance."""
REPEATS = 5
"""How often a deployment is timed."""


@dataclass(frozen=True)
class Timed:
    """`processor`: time of a deployment, scaled to 0.8 s; `other`: of a step of the other program meanwhile [s]."""

    processor: float
    other: float


@dataclass(frozen=True)
class Deployment:
    """`dt`, `limit`: of the run [s]; `finer_dt` [s]; `steps` of a run.

    `errors`, `spreads`: by curve ("rate", "phase" [deg]), the largest difference from the finer run and between the
    perturbed starts of the diagram.
    """

    dt: float
    limit: float
    steps: int
    timed: Timed
    finer_dt: float
    errors: dict[str, float]
    spreads: dict[str, float]

    @property
    def is_within(self) -> bool:
        """Whether no curve is further from the finer run's than perturbed starts are from each other."""
        return all(error <= self.spreads[name] for name, error in self.errors.items())


@dataclass(frozen=True)
class FastDeployment:
    """The fast scene: `dt` of its run [s], its `substeps` and `softening`, and its `steps`."""

    dt: float
    substeps: int
    softening: float
    steps: int
    timed: Timed


def in_turns(case: StudyCase, method: str, dt: float, other: Program) -> Timed:
    """Deployments of a case, each in turns with the other program: to the next instant, then some of its steps.

    Of the repeats, that whose ratio of both times is the median.
    """
    repeats = []
    for _ in range(REPEATS):
        sim, own, others = Simulation(case.scene, integrator=method, dt=dt), 0.0, 0.0
        sim.positions = case.start
        for instant in case.times:
            began = time.process_time()
            sim.reach(instant)
            between = time.process_time()
            other.step(SLICE)
            own, others = own + between - began, others + time.process_time() - between
        repeats.append(Timed(own * UNTIL / case.until, others / (case.instants * SLICE)))
    return sorted(repeats, key=lambda timed: timed.other / timed.processor)[REPEATS // 2]


def deploy_fast(other: Program, until: float = UNTIL) -> FastDeployment:
    """Run the fast scene to its end, or to an earlier one; times are then scaled."""
    scene = scenes.load(FAST)
    assert scene.material is not None
    dt, softening = Simulation(scene).dt, scene.material.softening or 1.0
    timed = in_turns(study_case(scene, until, INSTANTS), scene.run.integrator, dt, other)
    return FastDeployment(dt, scene.run.substeps, softening, round(until / dt), timed)


def deploy(scene: Scene, other: Program, until: float = UNTIL) -> Deployment:
    """Run model 1 to its end, or to an earlier one; times are then scaled."""
    scene = replace(scene, run=replace(scene.run, substeps=SUBSTEPS))
    case = study_case(scene, until, INSTANTS)
    limits = {method: Simulation(scene, integrator=method).stable_dt() for method in (METHOD, FINER)}
    finer = run_case(case, FINER, FINER_SHARE * limits[FINER]).completed()
    run = run_case(case, METHOD, SHARE * limits[METHOD]).completed()
    return Deployment(
        dt=run.dt,
        limit=limits[METHOD],
        steps=run.steps,
        timed=in_turns(case, METHOD, run.dt, other),
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
