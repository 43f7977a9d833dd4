"""The second stage of IKAROS on other meshes and with other values: the distance of their curves from its own."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from ikaros_runs import PHASE, RATE, ikaros, sail_of
from membrane_rs import Scene, Tethers
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table

MESHES = ((10, 6), (20, 12), (40, 24))
"""Rows and columns, each twice as fine as the one before."""
COLUMNS = (("rpm", "spin [rpm]", ".3f"), (RATE, "rate", ".4f"), (PHASE, "phase [deg]", ".2f"))
OWN, OTHER, HALF = "as it is", "another start", "half the step"
BODY, HEIGHT = 290.0, 0.9454
"""Dry mass of the body [kg], and its height as one account gives it [m]."""
LIGHT = 13.0 / 15.0
"""Mass of the film if the 15 kg of the sail hold its four tips, over that of the scene."""


def mesh_name(rows: int, columns: int) -> str:
    """What a table calls a mesh."""
    return f"{rows} rows, {columns} columns"


def of_mesh(scene: Scene, rows: int, columns: int) -> Scene:
    """The second stage on another mesh, by the default step."""
    mesh = replace(sail_of(scene), rows=rows, columns=columns).mesh()
    return replace(scene, mesh=mesh, run=replace(scene.run, dt=None))


def variants() -> dict[str, Scene]:
    """The scene with other values, by what is other."""
    scene = ikaros()
    radius = scene.value("parts.tethers.anchor_radius")
    transverse = BODY * (3.0 * radius**2 + HEIGHT**2) / 12.0
    changed = {
        "film softened 5": {"material.softening": 5.0},
        "film softened 30": {"material.softening": 30.0},
        "tips of 0.6 kg": {"parts.0.mass": 0.6},
        "tethers longer by half": {"parts.tethers.length": 1.5 * tether_length(scene)},
        "ten times the modulus of the tethers": {"parts.tethers.axial_stiffness": 2e4},
        "dashpots of ratio 0.005": {"laws.spring_damping.ratio": 0.005},
        "dashpots of ratio 0.1": {"laws.spring_damping.ratio": 0.1},
        "creases 1000 times as stiff": {"laws.creases.stiffness": 1e4},
        "hub in six degrees of freedom": {"laws.spin.mass": BODY, "laws.spin.transverse_inertia": transverse},
        "13 kg of film": {"material.density": LIGHT * scene.value("material.density")},
    }
    plain = replace(scene, run=replace(scene.run, dt=None))
    assert scene.run.dt is not None
    halved = {HALF: scene.with_values({"run.dt": 0.5 * scene.run.dt})}
    return halved | {label: plain.with_values(values) for label, values in changed.items()}


def tether_length(scene: Scene) -> float:
    """That of the scene's tethers, from the rim of the hub to the inner corners of the flat sail [m]."""
    tethers = next(part for part in scene.parts if isinstance(part, Tethers))
    return float(sail_of(scene).inner_width) / math.sqrt(2.0) - float(tethers.anchor_radius)


def distance(one: Mapping[str, Floats], other: Mapping[str, Floats], column: str) -> float:
    """Root of the mean square of the difference of two curves."""
    return float(np.sqrt(np.mean((one[column] - other[column]) ** 2)))


def variant_table(runs: Mapping[str, Mapping[str, Floats]], reference: str) -> str:
    """Features of each run, and the distances of its curves from those of the reference."""
    body = [(label, *_features(run), *_distances(run, runs[reference])) for label, run in runs.items()]
    heads = (
        "run", "nodes", "step [us]", "processor time a second [s]", "least spin [rpm]", "mean, last 20 s [rpm]",
        "trough of the phase [deg]", "at [s]", "largest strain [%]", "largest tilt [deg]",
        *(f"{name}: distance" for _, name, _ in COLUMNS),
    )  # fmt: skip
    return table(heads, body, words=(0,))


def _features(run: Mapping[str, Floats]) -> Sequence[str]:
    time, trough = run["time"], int(run[PHASE].argmin())
    return (
        f"{run['nodes'][0]:,.0f}", f"{1e6 * run['step'][0]:.1f}", f"{run['cpu'].sum() / run['end'][-1]:.2f}",
        f"{run['rpm'].min():.2f}", f"{run['rpm'][time >= time[-1] - 20.0].mean():.2f}", f"{run[PHASE][trough]:.1f}",
        f"{time[trough]:.1f}", f"{100.0 * run['strain'].max():.2f}",
        f"{run['tilt'].max():.3f}" if "tilt" in run and run["tilt"].any() else "-",
    )  # fmt: skip


def _distances(run: Mapping[str, Floats], reference: Mapping[str, Floats]) -> Sequence[str]:
    if run is reference:
        return ("-",) * len(COLUMNS)
    return [f"{distance(run, reference, column):{form}}" for column, _, form in COLUMNS]
