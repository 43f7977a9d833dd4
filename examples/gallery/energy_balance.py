"""
The energy balance
==================

What each law stores and what each one takes away, since the start: energies are solid lines, works dashed ones. A term
that stays below half a per cent of the largest one is left out.
"""

import membrane_rs
from membrane_rs.plotting import plot_energy

run = membrane_rs.run("single-crease", until=0.1, samples=201)
figure = plot_energy(run, style="paper")

# %%
# In another style
# ----------------
# A style sheet of matplotlib, by its name or its file, or parameters of matplotlib, change the look of a figure.

figure = plot_energy(run, style={"font.family": "serif", "axes.grid": False, "lines.linewidth": 0.8})
