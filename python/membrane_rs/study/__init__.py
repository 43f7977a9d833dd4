"""Studies: many runs of one scene, compared: what accuracy costs, and what a scene can do without."""

from __future__ import annotations

from membrane_rs.study.ablation import Ablation, ablate
from membrane_rs.study.accuracy import Chart, chart

__all__ = ["Ablation", "Chart", "ablate", "chart"]
