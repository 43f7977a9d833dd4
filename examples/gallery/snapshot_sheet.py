"""
A sheet of snapshots
====================

Shapes of a run side by side, seen by one camera, with letters, times in seconds and a scale bar. They are spread over
the time that the run has come to, however it ended.
"""

import membrane_rs
from membrane_rs import scenes
from membrane_rs.plotting import Style, plot_snapshots

SOFT = {
    "mesh.rows": 8, "mesh.columns": 8, "material.youngs_modulus": "0.1 GPa", "parts.1.segments": 8,
    "parts.1.axial_stiffness": "2 N", "run.integrator": "leapfrog", "run.samples": 101,
}  # fmt: skip
run = membrane_rs.run(scenes.load("okuizumi-model-2").with_values(SOFT), until=0.3, frames=31)

# %%
# One column
# ----------

figure = plot_snapshots(run, 6, style="paper")

# %%
# Both columns, at chosen times
# -----------------------------
# In the frame that turns with the hub, the nearest frames to the times that are given.

figure = plot_snapshots(run, [0.0, 0.05, 0.1, 0.2, 0.3], view="turning", style=Style(width="double"))
