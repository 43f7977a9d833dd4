"""
The spread of an ensemble
=========================

Wrinkles are chaotic: runs from nearly equal starts part within a tenth of a second. So a curve is shown with the spread
of several starts, as their mean and a band of one standard deviation, or from the lowest to the highest.
"""

import membrane_rs
import numpy as np
from membrane_rs import Simulation, scenes
from membrane_rs.plotting import plot_comparison

SOFT = {
    "mesh.rows": 8, "mesh.columns": 8, "material.youngs_modulus": "0.1 GPa", "parts.1.segments": 8,
    "parts.1.axial_stiffness": "2 N", "run.integrator": "leapfrog", "run.samples": 101,
}  # fmt: skip
scene = scenes.load("okuizumi-model-2").with_values(SOFT)
rng = np.random.default_rng(1)


def perturbed() -> Simulation:
    """The start, each coordinate off by about ten micrometres."""
    sim = Simulation(scene)
    sim.positions = sim.positions + rng.normal(0.0, 1e-5, sim.positions.shape)
    return sim


runs = [membrane_rs.run(scene, start=perturbed(), until=0.25, frames=2) for _ in range(4)]

# %%
# Mean and spread
# ---------------

figure = plot_comparison(ensembles={"four starts": runs}, columns=["largest_film_stress"], style="paper")

# %%
# Each run over the range
# -----------------------

figure = plot_comparison(
    runs[:2],
    ["largest_film_stress"],
    ensembles={"four starts": runs},
    spread="range",
    labels=["first", "second"],
    style="paper",
)
