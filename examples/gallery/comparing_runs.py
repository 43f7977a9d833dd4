"""
Runs and an experiment
======================

Runs are lines, measured values are marks, with bars where their standard deviation is known. Here the measurement is
made up: a tether on a turning hub whose tip was followed with some error.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import membrane_rs
import numpy as np
from membrane_rs import scenes
from membrane_rs.plotting import plot_comparison
from membrane_rs.results import read_experiment

slow = membrane_rs.run(scenes.load("spinning-tether").with_values({"laws.spin.frequency": "1.9 Hz"}), until=0.6)
fast = membrane_rs.run(scenes.load("spinning-tether").with_values({"laws.spin.frequency": "2.1 Hz"}), until=0.6)

# %%
# The measured curve
# ------------------
# A CSV file with names and units in its first line; "<column>_std" is the standard deviation of a column.

rng = np.random.default_rng(1)
time = np.linspace(0.03, 0.57, 13)
phase = np.interp(time, slow.history["time"], slow.history["phase_difference_deg"]) + rng.normal(0.0, 0.8, len(time))
with TemporaryDirectory() as folder:
    file = Path(folder) / "camera.csv"
    lines = [f"{1e3 * t:.0f},{p:.2f},0.8" for t, p in zip(time, phase, strict=True)]
    file.write_text("\n".join(["time [ms],phase_difference_deg,phase_difference_deg_std", *lines]))
    camera = read_experiment(file)

# %%
# Both together
# -------------

figure = plot_comparison(
    {"1.9 Hz": slow, "2.1 Hz": fast}, ["phase_difference_deg"], experiments={"camera": camera}, style="paper"
)
