"""Deployments with contact between layers and without it: what is read of each run, and what is kept of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np
from contact_followed import followed
from membrane_rs import Scene, SelfContact, Simulation, scenes
from membrane_rs._arrays import Floats
from membrane_rs.analysis.deployment import Corners
from membrane_rs.study.common.perturbation import perturbation
from page_of_runs import Runs

RATE, PHASE = "deployment_rate", "phase_difference_deg"
MODELS = ("okuizumi-model-1", "okuizumi-model-2")
OWN, WITH = "without", "with contact"
"""What tables call the scene as it is, and the same with contact."""
SPENT = ("looked_at", "near", "pressed", "list_time", "look_time", "impulse_time", "check_time")
"""Of `Motion.contact_statistics`: pairs, and time [s]."""
STARTS = 8
SHIFT = 1e-7
"""Standard deviation of the perturbation of each coordinate [m]: small against the distance of the layers."""
INSTANTS = 800
"""Of the readings of rate and phase."""
COUNTED = (*range(5, 100, 5), *range(100, 801, 10))
"""Instants at which crossings are counted [ms], beside the start."""
SHOWN = 0.03
"""Instant of the arm that is drawn [s]."""


def fast(model: str) -> str:
    """The softened form of a scene, for many runs."""
    return f"{model}-fast"


def scene_of(name: str, *, with_contact: bool) -> Scene:
    """A built-in scene by leapfrog, as it is or with contact."""
    scene = scenes.load(name)
    laws = [*scene.laws, SelfContact()] if with_contact else scene.laws
    return replace(scene, laws=laws, run=replace(scene.run, integrator="leapfrog"))


def unfolded(scene: Scene, seed: int) -> dict[str, Floats]:
    """A release from a start, from its own with the seed 0: rate and phase at each millisecond, NaN after a stop.

    "counted" and "crossings" are instants [s] and pairs of triangles that cross; at the same instants, "energy" is the
    residual of the balance, "work" that of contact and "reference" the reference energy [J]. "seconds" is the processor
    time up to each reading [s], "steps" the steps, and `SPENT` what contact has spent.
    """
    sim = Simulation(scene)
    if seed:
        sim.positions = sim.positions + perturbation(scene, seed, SHIFT)
    corners = Corners(sim.assembly)
    times = np.linspace(0.0, scene.run.until, INSTANTS + 1)
    counts = [_counted(sim)]

    def read() -> tuple[float, ...]:
        if round(1e3 * sim.time) in COUNTED:
            counts.append(_counted(sim))
        x = sim.positions
        spent = sim.contact_statistics
        return corners.deployment_rate(x), corners.phase_difference(x), sim.step_count, *(spent[key] for key in SPENT)

    names = (RATE, PHASE, "steps", *SPENT)
    found = followed(sim, f"{scene.name}, start {seed}", times.tolist(), read, names)
    padding = np.full(len(times) - len(found["seconds"]), np.nan)
    counted, crossings, energy, work, reference = np.array(counts).T
    return {name: np.concatenate([column, padding]) for name, column in found.items()} | {
        "time": times, "counted": counted, "crossings": crossings, "energy": energy, "work": work,
        "reference": reference,
    }  # fmt: skip


def _counted(sim: Simulation) -> tuple[float, ...]:
    """Time [s], crossings, residual of the energy balance, work of contact and reference energy [J]."""
    ledger = sim.ledger()
    work = ledger["work_by_law"].get(SelfContact.kind, 0.0)
    return sim.time, float(sim.crossings(limit=0).count), ledger["error"], work, ledger["reference_energy"]


def shape_of(name: str, *, with_contact: bool) -> dict[str, Floats]:
    """The positions at `SHOWN`."""
    sim = Simulation(scene_of(name, with_contact=with_contact))
    sim.reach(SHOWN)
    return {"shape": sim.positions}


def both(runs: Runs, name: str, run: Callable[..., Mapping[str, Floats]]) -> dict[str, Mapping[str, Floats]]:
    """A run without contact, and the same with it."""
    jobs: dict[str, Callable[[], Mapping[str, Floats]]] = {
        f"{name} {kind}": partial(run, with_contact=kind == WITH) for kind in (OWN, WITH)
    }
    return dict(zip((OWN, WITH), runs.of(jobs).values(), strict=True))


def arm_of(runs: Runs) -> dict[str, Floats]:
    """The shape of the first model at `SHOWN`, without and with contact."""
    return {kind: run["shape"] for kind, run in both(runs, "arm", partial(shape_of, MODELS[0])).items()}


def job(name: str, with_contact: bool, seed: int) -> tuple[str, Callable[[], Mapping[str, Floats]]]:
    """The name of a run, and the run."""
    label = f"{name} {WITH if with_contact else OWN} {seed}"
    return label, partial(_made, name, with_contact, seed)


def _made(name: str, with_contact: bool, seed: int) -> dict[str, Floats]:
    return unfolded(scene_of(name, with_contact=with_contact), seed)


def single(runs: Runs, name: str) -> dict[str, Mapping[str, Floats]]:
    """The run of a scene from its own start, without and with contact."""
    jobs = dict(job(name, with_contact, 0) for with_contact in (False, True))
    return dict(zip((OWN, WITH), runs.of(jobs).values(), strict=True))


def ensembles(runs: Runs) -> dict[str, dict[str, list[Mapping[str, Floats]]]]:
    """The runs of both sails from all starts, by model, without and with contact."""
    kinds = [(model, with_contact) for model in MODELS for with_contact in (False, True)]
    jobs = {kind: dict(job(*kind, seed) for seed in range(STARTS)) for kind in kinds}
    found = runs.of({name: run for own in jobs.values() for name, run in own.items()})
    made: dict[str, dict[str, list[Mapping[str, Floats]]]] = {model: {} for model in MODELS}
    for (model, with_contact), own in jobs.items():
        made[model][WITH if with_contact else OWN] = [found[name] for name in own]
    return made
