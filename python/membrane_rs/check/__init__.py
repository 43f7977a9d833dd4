"""Checks of a scene before it runs: one audit of its mesh, laws and parts, and what limits the step."""

from __future__ import annotations

from membrane_rs.check.facts import facts
from membrane_rs.check.scene_audit import CHECKS, COSTLY_CHECKS, Check, audit, unaccepted_errors
from membrane_rs.mesh.findings import Audit, Finding

__all__ = ["CHECKS", "COSTLY_CHECKS", "Audit", "Check", "Finding", "audit", "facts", "unaccepted_errors"]
