"""The whole deployment charted, for docs/deployment.md: shapes, curves, reeling out of an arm and of the sail, release,
energy, crossings, cost.

Finished runs are kept in the folder `out` and read again; remove it to repeat them, which takes an hour on two cores.
With `--write` the tables and pictures of docs/deployment.md are replaced.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from deployment_cost import cost_table, stage_costs
from deployment_energy import energy_table
from deployment_plane import COARSER, SEGMENTS, plane_table, reel_out_arm
from deployment_plane import DURATIONS as PLANE_DURATIONS
from deployment_reel import (
    DURATIONS,
    MODELS,
    REEL,
    held_by_friction,
    not_softened,
    reel_out,
    reel_row,
    reel_table,
    turn_of,
    whole,
)
from deployment_release import STARTS, distance_table, from_cross, release_of, release_table, released
from deployment_whole import copy_sheets, crossings_table, draw_crossings, draw_curves, stages_of, whole_run
from marked import DOCS, MarkedPart, copy_small
from membrane_rs import Scene, UnstableError
from membrane_rs._arrays import Floats
from membrane_rs.plotting.mesh_study import plot_meshes
from page_of_runs import Runs, make_page

NAMES = ("plane", "reel", "release", "energy", "crossings", "cost")
PARTS = {name: MarkedPart(DOCS / "deployment.md", name) for name in NAMES}
FRICTIONS = (0.3, 0.6)
CROSS, HOLD = "the ideal cross", "reeled out, held"
STIFF = 2.0
"""Duration of the reeling out of a film that is not softened [s]."""
FULL = f"{HOLD}, {STIFF:g} s, its own modulus"


def by_friction(friction: float) -> str:
    """What a table calls a sail without a hold."""
    return f"reeled out, friction {friction:g}"


def sail(scene: Scene) -> dict[str, Floats]:
    """Samples of a reeling out, and the motion at the start of the release; without it where the run is stopped."""
    try:
        sim, found = reel_out(scene)
        sim.reach(sum(stage.duration for stage in scene.stages[:-1]))
    except UnstableError as error:
        print(f"{scene.name}: {error}", flush=True)
        return {}
    return {**found, "positions": sim.positions, "velocities": sim.velocities}


def reelings(runs: Runs) -> dict[str, dict[str, tuple[float, Mapping[str, Floats]]]]:
    """Duration [s] and samples of each reeling out, by sail and by how it is held or how long it takes."""
    scenes: dict[str, dict[str, tuple[float, Scene]]] = {}
    for model in MODELS:
        own = scenes[model] = {}
        standard = whole(model).stages[REEL].duration
        is_first = model == MODELS[0]
        for duration in DURATIONS if is_first else DURATIONS[:-1]:
            own[HOLD if duration == standard else f"{HOLD}, {duration:g} s"] = duration, whole(model, duration)
        if is_first:
            own[FULL] = STIFF, not_softened(whole(model, STIFF))
        for friction in FRICTIONS if is_first else FRICTIONS[:1]:
            own[by_friction(friction)] = standard, held_by_friction(whole(model), friction)
    jobs = {
        f"reel {model} {label}": partial(sail, scene)
        for model, own in scenes.items()
        for label, (_, scene) in own.items()
    }
    found = runs.of(jobs)
    return {
        model: {label: (duration, found[f"reel {model} {label}"]) for label, (duration, _) in own.items()}
        for model, own in scenes.items()
    }


def reel_part(runs: Runs, _: Path) -> str:
    """The table of reelings out of both sails."""
    rows = []
    for model, found in reelings(runs).items():
        scene = whole(model)
        assert scene.mesh is not None
        for label, (duration, run) in found.items():
            if run:
                rows.append(
                    reel_row(f"{model}, {label.partition(', ')[2]}", duration, turn_of(scene).last, scene.mesh, run)
                )
    return reel_table(rows)


def release_part(runs: Runs, picture: Path) -> str:
    """The tables of releases from each start, and their curves."""
    jobs: dict[str, Callable[[], Mapping[str, Floats]]] = {}
    labels: dict[str, list[str]] = {}
    for model, found in reelings(runs).items():
        scene = whole(model)
        starts: dict[str, tuple[Scene, Mapping[str, Floats] | None]] = {CROSS: (from_cross(scene), None)}
        for label in (HOLD, by_friction(FRICTIONS[0])):
            if found[label][1]:
                starts[label] = release_of(scene), found[label][1]
        labels[model] = list(starts)
        for label, (plain, motion) in starts.items():
            for seed in range(STARTS):
                jobs[f"release {model} {label} {seed}"] = partial(released, plain, seed, motion)
    made = runs.of(jobs)
    found_runs = {
        model: {label: [made[f"release {model} {label} {seed}"] for seed in range(STARTS)] for label in own}
        for model, own in labels.items()
    }
    plot_meshes({model: list(own.items()) for model, own in found_runs.items()}, picture, legend="start")
    return f"{release_table(found_runs)}\n{distance_table(found_runs, CROSS)}"


def plane_part(runs: Runs, _: Path) -> str:
    """The table of reelings out in the plane."""
    arms = [(SEGMENTS, PLANE_DURATIONS), *COARSER.items()]
    jobs = {
        f"plane {segments} segments {duration:g} s": partial(reel_out_arm, duration, segments=segments)
        for segments, durations in arms
        for duration in durations
    }
    return plane_table(list(runs.of(jobs).values()))


def wholes(runs: Runs) -> dict[str, Path]:
    """The folder of the whole run of each model."""
    return {model: whole_run(runs.folder, model) for model in MODELS}


def energy_part(runs: Runs, _: Path) -> str:
    """The table of balances."""
    return energy_table({model: stages_of(folder) for model, folder in wholes(runs).items()})


def crossings_part(runs: Runs, picture: Path) -> str:
    """The table of crossings, and their curves."""
    folders = wholes(runs)
    draw_crossings(folders, picture)
    return crossings_table(folders)


def cost_part(*_: object) -> str:
    """The table of costs, of runs that are never kept."""
    return cost_table({model: stage_costs(whole(model)) for model in MODELS})


def write_shapes(runs: Runs) -> None:
    """Contact sheets of all stages, their balances, and the curves of the whole, into docs/."""
    folders, curves = wholes(runs), runs.folder / "deployment-curves.png"
    draw_curves(folders, curves)
    copy_small(curves, curves.name)
    for model, folder in folders.items():
        copy_sheets(folder, model)


MAKERS: dict[str, Callable[[Runs, Path], str]] = {
    "plane": plane_part,
    "reel": reel_part,
    "release": release_part,
    "energy": energy_part,
    "crossings": crossings_part,
    "cost": cost_part,
}


if __name__ == "__main__":
    make_page("deployment", __doc__, runs_in=Runs, parts=PARTS, makers=MAKERS, write_shapes=write_shapes)
