"""Studies: comparisons of many runs of one scene, on accuracy and cost, on its laws and parts, and on its mesh."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

from membrane_rs._moved import Moved
from membrane_rs._on_demand import OnDemand
from membrane_rs.errors import AuditWarning

if TYPE_CHECKING:
    from membrane_rs.plotting.ensemble import Band
    from membrane_rs.study.ablation import ablate
    from membrane_rs.study.ablation_result import Ablation, Change, Item
    from membrane_rs.study.accuracy import work_precision
    from membrane_rs.study.calibration.analysis import Analysis, FittedParameter
    from membrane_rs.study.calibration.fitting import calibrate
    from membrane_rs.study.calibration.model import DataColumn
    from membrane_rs.study.calibration.result import Calibration
    from membrane_rs.study.common.one_run import RunPoint
    from membrane_rs.study.common.vary import Parameter
    from membrane_rs.study.compared_curves import Curves
    from membrane_rs.study.comparison import compare
    from membrane_rs.study.comparison_result import Comparison, Difference
    from membrane_rs.study.convergence import Density
    from membrane_rs.study.ensembles import Ensemble, ensemble, open_ensemble
    from membrane_rs.study.length_scales import FORMS, LengthScales, agreeing
    from membrane_rs.study.mesh import Job, MeshRun, jobs_of, mesh_study
    from membrane_rs.study.mesh_report import write_mesh_study
    from membrane_rs.study.refinement import Best, Point
    from membrane_rs.study.scene_match import SceneMatch, Tried, match_scene
    from membrane_rs.study.sweep_result import Sweep
    from membrane_rs.study.sweeping import open_sweep, sweep
    from membrane_rs.study.work_precision_result import WorkPrecision

__all__ = [
    "FORMS",
    "Ablation",
    "Analysis",
    "Band",
    "Best",
    "Calibration",
    "Change",
    "Comparison",
    "Curves",
    "DataColumn",
    "Density",
    "Difference",
    "Ensemble",
    "FittedParameter",
    "Item",
    "Job",
    "LengthScales",
    "MeshRun",
    "Parameter",
    "Point",
    "RunPoint",
    "SceneMatch",
    "Sweep",
    "Tried",
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

if not TYPE_CHECKING:  # a type checker would take every name for one that is there
    _on_demand = OnDemand(
        __name__,
        {
            "membrane_rs.plotting.ensemble": ("Band",),
            "membrane_rs.study.ablation": ("ablate",),
            "membrane_rs.study.ablation_result": ("Ablation", "Change", "Item"),
            "membrane_rs.study.accuracy": ("work_precision",),
            "membrane_rs.study.calibration.analysis": ("Analysis", "FittedParameter"),
            "membrane_rs.study.calibration.fitting": ("calibrate",),
            "membrane_rs.study.calibration.model": ("DataColumn",),
            "membrane_rs.study.calibration.result": ("Calibration",),
            "membrane_rs.study.common.one_run": ("RunPoint",),
            "membrane_rs.study.common.vary": ("Parameter",),
            "membrane_rs.study.compared_curves": ("Curves",),
            "membrane_rs.study.comparison": ("compare",),
            "membrane_rs.study.comparison_result": ("Comparison", "Difference"),
            "membrane_rs.study.convergence": ("Density",),
            "membrane_rs.study.ensembles": ("Ensemble", "ensemble", "open_ensemble"),
            "membrane_rs.study.length_scales": ("FORMS", "LengthScales", "agreeing"),
            "membrane_rs.study.mesh": ("Job", "MeshRun", "jobs_of", "mesh_study"),
            "membrane_rs.study.mesh_report": ("write_mesh_study",),
            "membrane_rs.study.refinement": ("Best", "Point"),
            "membrane_rs.study.scene_match": ("SceneMatch", "Tried", "match_scene"),
            "membrane_rs.study.sweep_result": ("Sweep",),
            "membrane_rs.study.sweeping": ("open_sweep", "sweep"),
            "membrane_rs.study.work_precision_result": ("WorkPrecision",),
        },
        Moved(
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
        ),
    )
    __getattr__, __dir__ = _on_demand, _on_demand.names
