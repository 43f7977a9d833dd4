"""
Deployment curves for a paper
=============================

A run returns its history as named columns, and `membrane_rs.plotting` draws them as figures of matplotlib. The style
"paper" is one column wide, has letters, no title, and lines that differ in a grey print.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import membrane_rs
from membrane_rs import scenes
from membrane_rs.plotting import plot_deployment, plot_history, save_figure

# %%
# A run in seconds
# ----------------
# The paper's second sail on a coarse mesh, of a film so soft that its step is long.

SOFT = {
    "mesh.rows": 8, "mesh.columns": 8, "material.youngs_modulus": "0.1 GPa", "parts.1.segments": 8,
    "parts.1.axial_stiffness": "2 N", "run.integrator": "leapfrog", "run.samples": 201,
}  # fmt: skip
run = membrane_rs.run(scenes.load("okuizumi-model-2").with_values(SOFT), until=0.4, frames=9)

# %%
# Rate and phase
# --------------
# The phase difference is a panel only where a hub turns.

figure = plot_deployment(run, style="paper")

# %%
# Any columns
# -----------
# Each is a panel, with its unit and a prefix that suits its values. Names in a list share a panel.

figure = plot_history(run, ["hub_torque", "largest_film_stress", ["energy_creases", "energy_springs"]], style="paper")

# %%
# The file
# --------
# PDF and SVG keep their text as text; the same figure gives the same bits.

with TemporaryDirectory() as folder:
    save_figure(figure, Path(folder) / "history.pdf")
    print(f"{(Path(folder) / 'history.pdf').stat().st_size} bytes")
