"""Where the deployed sail of IKAROS rests in sunlight, with devices that curl it and without, and its variants."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from ikaros_runs import sail_of
from marked import ROOT
from membrane_rs import Region, Scene, Simulation, SolarPressure, Stage
from membrane_rs._arrays import Floats, Ints

RPM = 0.055
"""Spin of the scene: the least that was reported [rpm]."""
AT_REST = 0.1
"""Share of the last stage at its end, over which the sail still drifts by little [-]."""
ROWS = {"coarse": 20, "as it is": 30}
"""Of cells in each petal, by what a table calls the mesh."""


def own() -> Scene:
    """The scene of the example."""
    return Scene.from_toml(ROOT / "examples" / "ikaros_devices.toml")


def on_mesh(scene: Scene, name: str) -> Scene:
    """The scene on a mesh of another density; its step goes with the cells."""
    sail = sail_of(scene)
    assert sail.rows is not None
    assert scene.run.dt is not None
    density = ROWS[name] / sail.rows
    return replace(scene, mesh=sail.refined(density).mesh(), run=replace(scene.run, dt=scene.run.dt / density))


def without_devices(scene: Scene) -> Scene:
    """The film alone."""
    return replace(scene, parts=tuple(part for part in scene.parts if not isinstance(part, Region)))


def stiffened(scene: Scene, bending_stiffness: float) -> Scene:
    """Devices of another bending stiffness [N m], which buckle in proportion."""
    factor = bending_stiffness / number(scene, "parts.devices.bending_stiffness")
    buckling = factor * number(scene, "parts.devices.buckling")
    return scene.with_values({"parts.devices.bending_stiffness": bending_stiffness, "parts.devices.buckling": buckling})


def with_modulus(scene: Scene, modulus: float) -> Scene:
    """Film and tethers of another Young's modulus [Pa]; devices bend and buckle as before."""
    assert scene.run.dt is not None
    factor = modulus / number(scene, "material.youngs_modulus")
    values = {"material.youngs_modulus": modulus, "run.dt": scene.run.dt / math.sqrt(factor)}
    values["parts.tethers.axial_stiffness"] = factor * number(scene, "parts.tethers.axial_stiffness")
    if any(isinstance(part, Region) for part in scene.parts):
        values["parts.devices.buckling"] = number(scene, "parts.devices.buckling") / factor
    return scene.with_values(values)


def at_spin(scene: Scene, rpm: float, modulus: float) -> Scene:
    """The scene at another spin [rpm], with a film of this modulus [Pa].

    Stages are shorter by the root of the spin, and friction is stronger by it.
    """
    faster = math.sqrt(rpm / RPM)
    curl, rest = scene.stages
    rate = faster * float(rest.set["laws.mass_damping.rate"])
    stages = (_shorter(curl, faster), replace(_shorter(rest, faster), set={"laws.mass_damping.rate": rate}))
    found = scene.with_values({"laws.spin.frequency": rpm / 60.0})
    return with_modulus(replace(found, stages=stages), modulus)


def number(scene: Scene, name: str) -> float:
    """A value of a scene that is a number."""
    return float(scene.value(name))


def areal_mass(scene: Scene) -> float:
    """Of the film [kg/m2]."""
    return number(scene, "material.density") * number(scene, "material.thickness")


def light_on(scene: Scene) -> float:
    """Force of sunlight on the flat sail along the axis [N]."""
    law = next(law for law in scene.laws if isinstance(law, SolarPressure))
    return float(np.abs(Simulation(scene).forces(law)[:, 2].sum()))


def pull_of_quarter(scene: Scene, rate: float) -> float:
    """What the inner corner of a quarter of the flat sail would hold at a spin [rad/s], were it cut off [N]."""
    sim = Simulation(scene)
    out = np.abs(sim.positions[:, :2]).sum(axis=1) / math.sqrt(2.0)
    return rate**2 * float(sim.masses @ out) / 4.0


def rested(scene: Scene) -> Mapping[str, Floats]:
    """The scene at its end: positions of the film [m], tension of each tether [N], how far the film has moved along the
    axis in the last part of the run [m], and nodes and steps.
    """
    sim = Simulation(replace(scene, run=replace(scene.run, snapshots=())))
    count = 0 if scene.mesh is None else scene.mesh.node_count
    sim.reach(sim.planned_end - AT_REST * scene.stages[-1].duration)
    before = sim.positions[:count, 2]
    sim.reach(sim.planned_end)
    after = sim.positions[:count]
    tensions = sim.cord_tensions().reshape(4, -1).mean(axis=1)
    return {
        "positions": after, "tensions": tensions, "drift": np.array([(after[:, 2] - before).mean()]),
        "nodes": np.array([float(count)]), "steps": np.array([float(sim.step_count)]),
    }  # fmt: skip


def places(scene: Scene) -> dict[str, Ints]:
    """Nodes of the film at which it is compared: inner corners, corners, middles of the outer edges, all."""
    assert scene.mesh is not None
    plan, half = scene.mesh.reference[:, :2], 0.5 * sail_of(scene).outer_width
    middles = np.array([(half, 0.0), (0.0, half), (-half, 0.0), (0.0, -half)])
    nearest = np.linalg.norm(plan[:, None] - middles, axis=2).argmin(axis=0)
    sets = scene.mesh.node_sets
    return {
        "inner corners": sets["inner_corners"], "corners": sets["corners"], "middles of outer edges": nearest,
        "mean": np.arange(len(plan)),
    }  # fmt: skip


def _shorter(stage: Stage, faster: float) -> Stage:
    assert stage.duration is not None
    return replace(stage, duration=stage.duration / faster)
