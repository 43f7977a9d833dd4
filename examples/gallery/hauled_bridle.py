"""
A bridle and its winch
======================

A strip of film hangs on three cords that meet at a node, with a spreader bar between its upper corners and a hem. A
winch hauls the riser in. The scene is the built-in one of that name: `membrane-rs run bridle` makes its results folder.
"""

import membrane_rs
import numpy as np
from membrane_rs import Simulation, scenes
from membrane_rs.plotting import Style, plot_history, plot_snapshots

run = membrane_rs.run(scenes.load("bridle"), frames=41)

# %%
# Before, while and after the riser is hauled in
# ----------------------------------------------

figure = plot_snapshots(run, [0.0, 0.8, 1.0, 1.2, 2.0], style=Style(width="double"))

# %%
# Statics
# -------
# At rest the riser bears all that hangs on its end, and each leg half of that, without the weight of the node at which
# they meet, over the cosine of its angle.

scene = scenes.load("bridle")
sim, sets = Simulation(scene), scene.assemble().node_sets
sim.relax(3.0, 10.0)
joint, corner = sets["left"][:2]
down = sim.positions[corner] - sim.positions[joint]
cosine = down[0] / np.linalg.norm(down)
tensions = sim.cord_tensions()
by_statics = 0.5 * (tensions[4] - 9.81 * sim.masses[joint]) / cosine
print(f"riser {tensions[4]:.5f} N, leg {tensions[5]:.5f} N, by statics {by_statics:.5f} N")

# %%
# The work of the winch
# ---------------------
# Half of the riser, 0.125 m, times the weight, and what the cord had stored in it.

figure = plot_history(run.history, ["work_winches", "largest_cord_tension"])
