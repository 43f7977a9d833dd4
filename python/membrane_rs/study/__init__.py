"""Studies: many runs of one scene, compared: what accuracy costs, what a scene can do without, what a mesh changes."""

from __future__ import annotations

from membrane_rs.study.ablation import Ablation, ablate
from membrane_rs.study.accuracy import Chart, chart
from membrane_rs.study.mesh import MeshRun, mesh_study

__all__ = ["Ablation", "Chart", "MeshRun", "ablate", "chart", "mesh_study"]
