"""
Looking at a run
================

`run.view()` opens a window with a slider for the time, in a notebook a page with the same. Here it gives pictures,
which need no display.
"""

import membrane_rs
from membrane_rs import scenes

SOFT = {
    "mesh.rows": 8, "mesh.columns": 8, "material.youngs_modulus": "0.1 GPa", "parts.1.segments": 8,
    "parts.1.axial_stiffness": "2 N", "run.integrator": "leapfrog", "run.samples": 101,
}  # fmt: skip
run = membrane_rs.run(scenes.load("okuizumi-model-2").with_values(SOFT), until=0.15, frames=16)

# %%
# As in snapshots
# ---------------
# One tone for each petal, and a greyer one for its lower face.

film = run.view(time=0.1, where="picture")

# %%
# By a field
# ----------
# The colours span the values of the whole run; a field of the triangles, such as the largest principal stress here, is
# one colour for each.

stress = "largest_principal_stress"
view = run.view(color=stress, time=0.1, where="picture")

# %%
# Wrinkled, slack or taut
# -----------------------

state = run.view(color="state", time=0.1, where="picture")
