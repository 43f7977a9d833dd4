"""
A fit to measured curves
========================

`study.calibrate` finds values of a scene with which its curves are nearest to measured ones. It says how far each is
known, and what the data leave open. The measurement is made up here, of a known spin and a known tip mass, with noise:
so the fit can be judged.
"""

import membrane_rs
import numpy as np
from membrane_rs import scenes, study
from membrane_rs.results import Experiment

tether = scenes.load("spinning-tether").with_values({"parts.0.segments": 4})
true = tether.with_values({"laws.spin.frequency": "3 Hz", "parts.0.tip_mass": "10 g"})
history = membrane_rs.run(true, until=0.15, samples=16, frames=2).history
noise = {"phase_difference_deg": 0.05, "largest_cord_tension": 0.01}
rng = np.random.default_rng(1)
measured = Experiment(
    "measured",
    history["time"],
    {name: history[name] + size * rng.standard_normal(16) for name, size in noise.items()},
    {name: history.units[name] for name in noise},
)

# %%
# The fit
# -------
# It begins at other values, 4 Hz and 5 g, and searches the ranges.

start = tether.with_values({"laws.spin.frequency": "4 Hz", "parts.0.tip_mass": "5 g"})
ranges = {"laws.spin.frequency": "2 Hz:5 Hz", "parts.0.tip_mass": "2 g:50 g:log"}
found = study.calibrate(start, measured, ranges, samples=151, uncertainty=noise)
print(found.table())

# %%
# Data and curves
# ---------------

figure = found.plot()
