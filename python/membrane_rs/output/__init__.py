"""What a run leaves behind: one file per format, and the folder that holds them all.

pyvista, matplotlib, Pillow and meshio are imported where they are used, not here.
"""

from __future__ import annotations

from membrane_rs.output.history import read_history
from membrane_rs.output.plots import compare_runs, plot_deployment
from membrane_rs.output.run_folder import RunFolder
from membrane_rs.output.vtk import read_frame, read_pvd, write_frame, write_pvd

__all__ = [
    "RunFolder",
    "compare_runs",
    "plot_deployment",
    "read_frame",
    "read_history",
    "read_pvd",
    "write_frame",
    "write_pvd",
]
