"""Balances of momentum and energy, reeling out, and cost of the runs of IKAROS."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from ikaros_runs import REEL, RPM, stage_ends
from membrane_rs import Scene, Schedule
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table


def balance_table(runs: Mapping[str, Mapping[str, Floats]]) -> str:
    """Of each run: angular momentum and its largest change, and the terms of the energy balance at its end."""
    body = []
    for label, run in runs.items():
        momentum = run["momentum"]
        kinetic, stored, work, error = (float(run[term][-1]) for term in ("kinetic", "stored", "work", "error"))
        energy = kinetic + stored
        start = float(run["kinetic"][0] + run["stored"][0])
        body.append((
            label, f"{momentum[0]:.2f}", f"{np.abs(momentum / momentum[0] - 1.0).max():.1e}", f"{energy - start:.2f}",
            f"{work:.2f}", f"{100.0 * error:+.3f}",
        ))  # fmt: skip
    heads = (
        "run", "momentum [kg m2/s]", "largest change", "change of the energy [J]", "work [J]", "residual [%]",
    )  # fmt: skip
    return table(heads, body, words=(0,))


def reeling_table(scene: Scene, runs: Mapping[str, Mapping[str, Floats]]) -> str:
    """The reeling out on each mesh: rate of the bars, order of the arms, largest strain, spin in the cross."""
    turn = scene.stages[REEL].set["bodies.bars.turn"]
    assert isinstance(turn, Schedule)
    rate = abs(turn.last) / (turn.times[-1] * (1.0 - turn.ease))
    body = []
    for label, run in runs.items():
        ends = stage_ends(run)
        reel = slice(ends[REEL - 1], ends[REEL] + 1)
        spin = run["rpm"][reel] / RPM
        body.append((
            label, f"{run['nodes'][0]:,.0f}", f"{rate / spin.max():.3f} to {rate / spin.min():.3f}",
            f"{1e3 * run['spread'][reel].max():.1f}", f"{100.0 * run['strain'][reel].max():.2f}",
            f"{run['reach'][ends[REEL + 1]]:.3f}", f"{run['moment'][0]:.2f}", f"{run['moment'][ends[0]]:.2f}",
            f"{run['moment'][ends[REEL + 1]]:.1f}", f"{run['rpm'][ends[REEL + 1]]:.3f}",
        ))  # fmt: skip
    heads = (
        "mesh", "nodes", "b/Omega", "arms differ by [mm]", "largest strain [%]", "reach of the cross [m]", "J wound",
        "J settled", "J of the cross [kg m2]", "spin of the cross [rpm]",
    )  # fmt: skip
    return table(heads, body, words=(0,))


def cost_table(scene: Scene, runs: Mapping[str, Mapping[str, Floats]]) -> str:
    """Steps and processor time of each stage."""
    names = [stage.name for stage in scene.stages]
    body = []
    for label, run in runs.items():
        start, own = 0.0, names if len(run["end"]) > 1 else ["release"]
        for name, end, step, steps, cpu in zip(own, run["end"], run["step"], run["steps"], run["cpu"], strict=True):
            length = end - start
            body.append((
                label, name, f"{length:g}", f"{1e6 * step:.1f}", f"{steps:,.0f}", f"{cpu:.1f}", f"{cpu / length:.2f}",
            ))  # fmt: skip
            start = end
    heads = ("run", "stage", "simulated [s]", "step [us]", "steps", "processor time [s]", "ratio")
    return table(heads, body, words=(0, 1))
