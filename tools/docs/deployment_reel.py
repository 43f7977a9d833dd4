"""Reeling out of the whole sail: the first stage of both models, for several durations and ways of holding."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from deployment_plane import EASE, FREQUENCY, WINDOW, lead_of_tip
from membrane_rs import Mesh, Scene, Schedule, Simulation, scenes
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from membrane_rs.simulation.motion import Motion

MODELS = ("model 1", "model 2")
DURATIONS = (1.0, 2.0, 4.0, 8.0)
"""Of the reeling out [s]."""
SAMPLES = 400
REEL = 1
"""Index of the stage in which the sail is reeled out."""
IN_ORDER = 5e-3
"""Difference of the reach of four arms above which they are out of order [m]."""
STICKING = 2.5e-6
"""Step of a sail that friction holds [s]; m e/(mu N) of almost all that touches is longer."""
FILM = ("springs", "creases")
"""The laws by which the film pulls at a tip."""


def whole(model: str, duration: float | None = None) -> Scene:
    """The whole deployment of a model, reeled out over `duration` [s]; default: the scene's own."""
    scene = scenes.load("okuizumi-whole" if model == MODELS[0] else "okuizumi-whole-model-2")
    if duration is None:
        return scene
    stages = list(scene.stages)
    turn = replace(turn_of(scene), times=(0.0, duration))
    stages[REEL] = replace(stages[REEL], duration=duration, set={**stages[REEL].set, "bodies.bars.turn": turn})
    return replace(scene, stages=stages)


def turn_of(scene: Scene) -> Schedule:
    """By how much the bars turn while the sail is reeled out [rad]."""
    turn = scene.stages[REEL].set["bodies.bars.turn"]
    assert isinstance(turn, Schedule)
    return turn


def not_softened(scene: Scene) -> Scene:
    """The scene with the film's own modulus in all stages."""
    return replace(scene, stages=[replace(stage, scale={}) for stage in scene.stages])


def held_by_friction(scene: Scene, friction: float) -> Scene:
    """The scene without its hold: the film is held by Coulomb's friction on the spool and on the bars, in steps that
    resolve what sticks.
    """
    stages = [replace(stage, without=tuple(name for name in stage.without if name != "hold")) for stage in scene.stages]
    for k, stage in enumerate(stages[:-1]):
        stages[k] = replace(stage, set={**stage.set, "run.dt": STICKING, "run.substeps": 1})
    return replace(
        scene,
        parts=[part for part in scene.parts if part.name != "hold"],
        bodies=[replace(body, friction=friction) for body in scene.bodies],
        stages=stages,
    )


def pull_at_tips(sim: Motion) -> Floats:
    """Tension with which the film pulls at each corner [N]."""
    corners = sim.assembly.node_sets["corners"]
    pull: Floats = np.linalg.norm(sum(sim.forces(law)[corners] for law in FILM), axis=1)
    return pull


def reel_out(scene: Scene, samples: int = SAMPLES) -> tuple[Simulation, dict[str, Floats]]:
    """The simulation at the end of the reeling out, and what was sampled in it, by name.

    Of each sample: "share" of the reeling out, mean "radius" of the corners [m] and its "spread" over the four arms
    [m], mean "lead" of the corners over their bars [deg] and its spread ("lead_spread"), mean "tension" at the tips
    over m Omega^2 R, "kinetic" energy [J] and centrifugal energy set "free" [J], "low" and "high" of all nodes of the
    film [m], and the largest "strain" of a spring.
    """
    sim = Simulation(scene)
    corners, nodes = sim.assembly.node_sets["corners"], len(scene.mesh.reference) if scene.mesh else 0
    start, length = scene.stages[0].duration, scene.stages[REEL].duration
    sim.reach(start)
    bars = next(body for body in sim.stage_scene.bodies if body.name == "bars")
    turn = bars.turn
    assert isinstance(turn, Schedule)
    azimuth = math.atan2(bars.centre[1], bars.centre[0])
    weight = sim.masses[corners] * (2.0 * math.pi * FREQUENCY) ** 2
    stowed = sim.energies()["spin"]
    rows = []
    for share in np.linspace(0.0, 1.0, samples + 1)[1:-1]:
        sim.reach(start + length * float(share))
        x = sim.positions
        radius, angle = np.hypot(x[corners, 0], x[corners, 1]), np.arctan2(x[corners, 1], x[corners, 0])
        apart = angle - azimuth - turn.at(sim.time) - 0.5 * math.pi * np.arange(len(corners))
        lead = np.degrees(np.angle(np.exp(1j * apart)))
        pull = pull_at_tips(sim)
        energies, film = sim.energies(), x[:nodes, 2]
        rows.append((
            share, radius.mean(), np.ptp(radius), lead.mean(), np.ptp(lead), (pull / (weight * radius)).mean(),
            energies["kinetic"], stowed - energies["spin"], film.min(), film.max(), sim.spring_strains().max(),
        ))  # fmt: skip
    sim.reach(start + length)
    names = (
        "share", "radius", "spread", "lead", "lead_spread", "tension", "kinetic", "free", "low", "high", "strain",
    )  # fmt: skip
    return sim, dict(zip(names, np.array(rows).T, strict=True))


def reel_row(label: str, duration: float, turn: float, mesh: Mesh, run: Mapping[str, Floats]) -> Sequence[str]:
    """Means over the window of one reeling out by bars that turn by `turn` [rad], as a row of the table, with the
    crossings of triangles at the start of the release.
    """
    inside = (run["share"] >= WINDOW[0]) & (run["share"] <= WINDOW[1])
    mean = {name: float(run[name][inside].mean()) for name in ("radius", "tension", "lead", "kinetic", "free")}
    rate = turn / (duration * (1.0 - EASE))
    omega = 2.0 * math.pi * FREQUENCY
    is_ordered = run["spread"].max() < IN_ORDER and np.abs(run["lead"]).max() < 90.0
    return (
        label,
        f"{duration:g}",
        f"{abs(rate) / omega:.2f}",
        f"{mean['tension']:.3f}",
        f"{(1.0 - abs(rate) / omega) ** 2:.3f}",
        f"{mean['lead']:.1f} +- {run['lead'][inside].std():.1f}",
        f"{lead_of_tip(abs(rate), mean['radius'], reach_of_bars()):.1f}",
        f"{1e3 * run['spread'].max():.2f}",
        f"{1e3 * run['low'].min():.1f} to {1e3 * run['high'].max():.1f}",
        f"{100.0 * mean['kinetic'] / mean['free']:.2g}",
        f"{100.0 * run['strain'].max():.2f}",
        f"{mesh.crossings(run['positions'][: len(mesh.reference)], limit=0).count:,d}",
        "in order" if is_ordered else "out of order",
    )


def reach_of_bars() -> float:
    """Distance of the bars from the hub's axis [m]."""
    bars = next(body for body in whole(MODELS[0]).bodies if body.name == "bars")
    return math.hypot(*bars.centre[:2])


def reel_table(rows: Sequence[Sequence[str]]) -> str:
    """The rows of `reel_row` as a table."""
    heads = (
        "sail", "duration [s]", "b/Omega", "tension of the tips", "(1 - b/Omega)^2", "tips ahead of the bars [deg]",
        "predicted [deg]", "arms differ by [mm]", "z of the film [mm]", "kinetic energy [%]", "largest strain [%]",
        "crossings", "outcome",
    )  # fmt: skip
    return table(heads, rows, words=(0, 12))
