"""Balances of momentum and energy, reeling out, and cost of the runs of IKAROS."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from ikaros_momentum import SWING
from ikaros_runs import REEL, RPM, sail_of, stage_ends
from membrane_rs import Scene, Schedule
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table


def balance_table(runs: Mapping[str, Mapping[str, Floats]], names: Sequence[str]) -> str:
    """Of each stage of a run: the spin, the largest change of angular momentum since the start of the run, the energy
    given up, the work that the balance has for it, and the residual since the start of the run.
    """
    body = []
    for label, run in runs.items():
        momentum, energy, begin = run["momentum"], run["kinetic"] + run["stored"], 0
        for name, end in zip(stage_names(run, names), stage_ends(run), strict=True):
            change = np.abs(momentum[begin : end + 1] / momentum[0] - 1.0).max()
            body.append((
                label, name, f"{run['rpm'][begin]:.2f}", f"{run['rpm'][end]:.2f}", f"{momentum[end]:.2f}",
                f"{change:.1e}", f"{energy[end] - energy[begin]:.3f}", f"{run['work'][end] - run['work'][begin]:.3f}",
                f"{100.0 * run['error'][end]:+.3f}",
            ))  # fmt: skip
            begin = end
    heads = (
        "run", "stage", "spin from [rpm]", "to [rpm]", "momentum [kg m2/s]", "largest change",
        "change of the energy [J]", "work [J]", "residual [%]",
    )  # fmt: skip
    return table(heads, body, words=(0, 1))


def stage_names(run: Mapping[str, Floats], names: Sequence[str]) -> Sequence[str]:
    """Those of the stages of a run; of one without stages that of the last."""
    return names if len(run["end"]) > 1 else names[-1:]


def roll_table(scene: Scene, run: Mapping[str, Floats]) -> str:
    """What holds the roll together, wound and settled: the pull of a tip, m r Omega^2, and the tension lambda R^2
    Omega^2 of a layer of an arm at the rim of the roll without pressure on what lies below. Between its hairpins an arm
    has half a strip of each of two petals, lambda = density thickness (outer width - inner width).
    """
    sail, film = sail_of(scene), scene.material
    radius = sail.wound_outer_radius
    assert film is not None
    assert radius is not None
    weight = film.density * film.thickness * (sail.outer_width - sail.inner_width)
    tip = scene.value("parts.0.mass")
    body = []
    for label, k in (("wound", 0), ("tips let go, settled", stage_ends(run)[REEL - 1])):
        square, reach = (run["rpm"][k] / RPM) ** 2, run["reach"][k]
        body.append((
            label, f"{run['rpm'][k]:.2f}", f"{reach:.2f}", f"{tip * reach * square:.1f}",
            f"{weight * radius**2 * square:.1f}", f"{(tip * reach / weight) ** 0.5:.2f}",
        ))  # fmt: skip
    heads = (
        "sail", "spin [rpm]", "tips from the axis [m]", "pull of a tip [N]", "tension of a layer at the rim [N]",
        "a loop stands out beyond [m]",
    )  # fmt: skip
    return table(heads, body, words=(0,))


def reeling_table(runs: Mapping[str, tuple[Scene, Mapping[str, Floats]]]) -> str:
    """The reeling out of each scene: rate of the bars, order of the arms, largest strain, spin in the cross."""
    body = []
    for label, (scene, run) in runs.items():
        turn = scene.stages[REEL].set["bodies.bars.turn"]
        assert isinstance(turn, Schedule)
        rate = abs(turn.last) / (turn.times[-1] * (1.0 - turn.ease))
        ends = stage_ends(run)
        reel = slice(ends[REEL - 1], ends[REEL] + 1)
        spin = run["rpm"][reel] / RPM
        body.append((
            label, f"{run['nodes'][0]:,.0f}", f"{rate / spin.max():.3f} to {rate / spin.min():.3f}",
            f"{1e3 * run['spread'][reel].max():.1f}", f"{100.0 * run['strain'][reel].max():.2f}",
            f"{run['reach'][ends[REEL + 1]]:.3f}", f"{run['moment'][0]:.2f}", f"{run['moment'][ends[0]]:.2f}",
            f"{run['moment'][ends[REEL + 1]]:.1f}", f"{run['rpm'][ends[REEL + 1]]:.3f}",
            f"{run['rpm'][run['time'] >= run['time'][-1] - SWING].mean():.2f}",
        ))  # fmt: skip
    heads = (
        "run", "nodes", "b/Omega", "arms differ by [mm]", "largest strain [%]", "reach of the cross [m]", "J wound",
        "J settled", "J of the cross [kg m2]", "spin of the cross [rpm]", f"mean, last {SWING:g} s [rpm]",
    )  # fmt: skip
    return table(heads, body, words=(0,))


def cost_table(runs: Mapping[str, Mapping[str, Floats]], names: Sequence[str]) -> str:
    """Steps and processor time of each stage."""
    body = []
    for label, run in runs.items():
        start, own = 0.0, stage_names(run, names)
        for name, end, step, steps, cpu in zip(own, run["end"], run["step"], run["steps"], run["cpu"], strict=True):
            length = end - start
            body.append((
                label, name, f"{length:g}", f"{1e6 * step:.1f}", f"{steps:,.0f}", f"{cpu:.1f}", f"{cpu / length:.2f}",
            ))  # fmt: skip
            start = end
    heads = ("run", "stage", "simulated [s]", "step [us]", "steps", "processor time [s]", "ratio")
    return table(heads, body, words=(0, 1))
