"""Studies: comparisons of many runs of one scene, on accuracy and cost, on its laws and parts, and on its mesh."""

from __future__ import annotations

import warnings

from membrane_rs._moved import Moved
from membrane_rs.errors import AuditWarning
from membrane_rs.study.ablation import ablate
from membrane_rs.study.ablation_result import Ablation
from membrane_rs.study.accuracy import work_precision
from membrane_rs.study.calibration.fitting import calibrate
from membrane_rs.study.calibration.result import Calibration
from membrane_rs.study.comparison import compare
from membrane_rs.study.comparison_result import Comparison, Difference
from membrane_rs.study.ensembles import Ensemble, ensemble, open_ensemble
from membrane_rs.study.length_scales import FORMS, LengthScales, agreeing
from membrane_rs.study.mesh import MeshRun, jobs_of, mesh_study
from membrane_rs.study.mesh_report import write_mesh_study
from membrane_rs.study.scene_match import SceneMatch, match_scene
from membrane_rs.study.sweep_result import Sweep
from membrane_rs.study.sweeping import open_sweep, sweep
from membrane_rs.study.work_precision_result import WorkPrecision

__all__ = [
    "FORMS",
    "Ablation",
    "Calibration",
    "Comparison",
    "Difference",
    "Ensemble",
    "LengthScales",
    "MeshRun",
    "SceneMatch",
    "Sweep",
    "WorkPrecision",
    "ablate",
    "agreeing",
    "calibrate",
    "compare",
    "ensemble",
    "jobs_of",
    "match_scene",
    "mesh_study",
    "open_ensemble",
    "open_sweep",
    "sweep",
    "work_precision",
    "write_mesh_study",
]

# A study builds many simulations of scenes that it varies on purpose; the audit is for the user's own scene.
warnings.filterwarnings("ignore", category=AuditWarning, module=r"membrane_rs\.study\.")

__getattr__ = Moved(
    __name__,
    {
        __name__: {
            "Chart": "WorkPrecision",
            "Fit": "Calibration",
            "Lengths": "LengthScales",
            "chart": "work_precision",
            "fit": "calibrate",
        }
    },
)
