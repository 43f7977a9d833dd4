"""Runs of the built-in scenes of IKAROS: what is sampled of sail and hub, and the variants that are compared."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from membrane_rs import Cylinder, Scene, Schedule, Simulation, scenes
from membrane_rs._arrays import Floats
from membrane_rs.analysis.deployment import Corners
from membrane_rs.folding import SquareSail

RPM = 60.0 / math.tau
"""Turns per minute of 1 rad/s."""
INTERVAL = 0.1
"""Between two samples [s]."""
SHIFT = 1e-6
"""Standard deviation by which nodes are displaced in another start [m]."""
CLEARANCE, FREE = 0.03, 0.7
"""Of the bars from the roll, and length of an arm beyond its bar at the start [m]."""
REEL = 1
"""Index of the stage in which the sail is reeled out."""
RATE, PHASE = "deployment_rate", "phase_difference_deg"
TERMS = ("kinetic", "stored", "work", "error")
NAMES = ("time", "rpm", "moment", "film", "momentum", "reach", "spread", RATE, PHASE, "strain", "tilt", *TERMS)


def ikaros() -> Scene:
    """The second stage."""
    return scenes.load("ikaros")


def whole() -> Scene:
    """The whole deployment."""
    return scenes.load("ikaros-whole")


def of_inertia(scene: Scene, inertia: float) -> Scene:
    """The scene with a hub of another inertia [kg m2]."""
    return scene.with_values({"laws.spin.inertia": inertia})


def sail_of(scene: Scene) -> SquareSail:
    """The folding pattern of a scene."""
    sail = None if scene.mesh is None else scene.mesh.source
    assert isinstance(sail, SquareSail)
    return sail


def hub_inertia(scene: Scene) -> float:
    """Moment of inertia of the scene's hub [kg m2]."""
    inertia = scene.value("laws.spin.inertia")
    assert isinstance(inertia, float)
    return inertia


def roll_of(scene: Scene) -> tuple[float, float, float]:
    """Azimuth of the bars at the start, the angle by which they turn [rad], and their distance from the axis [m]: with
    the scene's clearance from the roll and free length of the arms, until the arms lie on their diagonals.
    """
    sail, bars = sail_of(scene), bars_of(scene)
    outer = sail.wound_outer_radius
    assert outer is not None
    reach, turned = outer + bars.radius + CLEARANCE, sail.corner_turn - FREE / outer
    return 0.25 * math.pi + turned, -(turned + math.asin(bars.radius / reach)), reach


def bars_of(scene: Scene) -> Cylinder:
    """The guide bars."""
    found = next(body for body in scene.bodies if body.name == "bars")
    assert isinstance(found, Cylinder)
    return found


def finer(scene: Scene) -> Scene:
    """The whole deployment with twice as many rows and columns, and bars where its roll has them."""
    assert scene.mesh is not None
    scene = replace(scene, mesh=sail_of(scene).refined(2.0).mesh())
    azimuth, turn, reach = roll_of(scene)
    centre = (reach * math.cos(azimuth), reach * math.sin(azimuth), 0.0)
    bodies = [replace(body, centre=centre) if body.name == "bars" else body for body in scene.bodies]
    stages = list(scene.stages)
    schedule = stages[REEL].set["bodies.bars.turn"]
    assert isinstance(schedule, Schedule)
    turned = replace(schedule, values=(0.0, turn))
    stages[REEL] = replace(stages[REEL], set={**stages[REEL].set, "bodies.bars.turn": turned})
    return replace(scene, bodies=bodies, stages=stages)


def in_time(scene: Scene, duration: float) -> Scene:
    """The whole deployment, reeled out in another time [s]."""
    stages = list(scene.stages)
    schedule = stages[REEL].set["bodies.bars.turn"]
    assert isinstance(schedule, Schedule)
    turned = replace(schedule, times=(0.0, duration))
    stages[REEL] = replace(stages[REEL], duration=duration, set={**stages[REEL].set, "bodies.bars.turn": turned})
    return replace(scene, stages=stages)


def film_masses(scene: Scene) -> Floats:
    """Masses of the nodes of the mesh by the film alone [kg]."""
    assert scene.mesh is not None
    assert scene.material is not None
    return scene.mesh.masses(scene.material)


def moment(positions: Floats, masses: Floats) -> float:
    """Moment of inertia of nodes about the hub's axis [kg m2]."""
    return float(masses @ (positions[: len(masses), :2] ** 2).sum(axis=1))


def flat_moments(scene: Scene) -> tuple[float, float]:
    """Moments of inertia of the flat sail: film, and tips with cords [kg m2]."""
    assembly, film = scene.assemble(), film_masses(scene)
    rest = assembly.extra_masses
    return moment(assembly.reference, film), moment(assembly.reference, rest)


class Watch:
    """Samples of one simulation."""

    def __init__(self, scene: Scene, seed: int) -> None:
        self.sim = Simulation(scene)
        self.inertia, self.film = hub_inertia(scene), film_masses(scene)
        if seed:
            positions = np.array(self.sim.positions)
            free = np.setdiff1d(np.arange(len(positions)), self.sim.assembly.fixed)
            positions[free] += SHIFT * np.random.default_rng(seed).standard_normal((len(free), 3))
            self.sim.positions = positions
        self.corners = Corners(self.sim.assembly, sail_of(scene).corner_turn)
        self.rows: list[tuple[float, ...]] = []

    def sample(self, instant: float) -> None:
        """Go on to a time [s], and look."""
        sim = self.sim
        sim.reach(instant)
        x, v, m = sim.positions, sim.velocities, sim.masses
        omega, sail, ledger = sim.hub_rate, moment(x, m), sim.ledger()
        relative = float(m @ (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0]))
        reach = np.hypot(*x[self.corners.nodes, :2].T)
        self.rows.append((
            sim.time, RPM * omega, sail, moment(x, self.film), (self.inertia + sail) * omega + relative,
            float(reach.mean()), float(np.ptp(reach)), self.corners.deployment_rate(x),
            self.corners.phase_difference(x), float(sim.spring_strains().max()),
            math.degrees(sim.nutation_angle), *(float(ledger[term]) for term in TERMS),
        ))  # fmt: skip


def watched(scene: Scene, seed: int = 0) -> dict[str, Floats]:
    """Samples of a run, by name; with a seed each free node is displaced at random by `SHIFT` at the start.

    Of each sample: "time" [s], "rpm" of the hub, "moment" of the sail about the axis and that of its "film" alone [kg
    m2], angular "momentum" of sail and hub [kg m2/s], "reach" of the corners from the axis [m] and its "spread" over
    the four, deployment rate and phase, the largest "strain" of a spring, the "tilt" of the axis against the angular
    momentum [deg], and the terms of the energy balance. Of each stage: its "end" [s], "step" [s], "steps", and
    processor time, "cpu" [s]; and the number of "nodes".
    """
    watch = Watch(scene, seed)
    sim, costs, steps, counts, start = watch.sim, [], [], [], 0.0
    ends = np.cumsum([stage.duration for stage in scene.stages]) if scene.stages else np.array([scene.run.until])
    for end in ends.tolist():
        began = time.process_time()
        instants = np.linspace(start, end, round((end - start) / INTERVAL) + 1)
        for instant in instants[1 if start else 0 :]:
            watch.sample(float(instant))
        costs.append(time.process_time() - began)
        steps.append(sim.stages[len(costs) - 1].dt if scene.stages else sim.dt)
        counts.append(sim.stages[len(costs) - 1].steps if scene.stages else round(end / sim.dt))
        start = end
    return {
        **dict(zip(NAMES, np.array(watch.rows).T, strict=True)),
        "end": ends,
        "step": np.array(steps),
        "steps": np.array(counts, dtype=np.float64),
        "cpu": np.array(costs),
        "nodes": np.array([float(len(sim.positions))]),
    }


def stage_ends(run: Mapping[str, Floats]) -> list[int]:
    """Index of the last sample of each stage."""
    return [int(np.searchsorted(run["time"], end - 1e-9)) for end in run["end"]]


def first_beyond(run: Mapping[str, Floats], reach: float) -> int:
    """Index of the first sample from which on the corners stay so far from the axis [m], before the release."""
    near = np.flatnonzero(run["reach"][: stage_ends(run)[-2] + 1] < reach)
    return int(near[-1]) + 1 if len(near) else 0
