"""Parameters of a scene from measured curves."""

from __future__ import annotations

from membrane_rs.study.fitting.fit import fit
from membrane_rs.study.fitting.result import Fit

__all__ = ["Fit", "fit"]
