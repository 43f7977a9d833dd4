"""Studies: many runs of one scene, compared: what accuracy costs, what a scene can do without, what a mesh changes."""

from __future__ import annotations

from membrane_rs.study.ablation import Ablation, ablate
from membrane_rs.study.accuracy import Chart, chart
from membrane_rs.study.calibration import Calibration, calibrate
from membrane_rs.study.lengths import FORMS, Lengths, agreeing
from membrane_rs.study.mesh import MeshRun, jobs_of, mesh_study
from membrane_rs.study.mesh_report import write_mesh_study

__all__ = [
    "FORMS",
    "Ablation",
    "Calibration",
    "Chart",
    "Lengths",
    "MeshRun",
    "ablate",
    "agreeing",
    "calibrate",
    "chart",
    "jobs_of",
    "mesh_study",
    "write_mesh_study",
]
