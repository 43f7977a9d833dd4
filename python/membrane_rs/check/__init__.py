"""Checks of a scene before it runs: one audit of its mesh, laws and parts, and what limits the step."""

from __future__ import annotations

from membrane_rs.check.facts import facts
from membrane_rs.check.scene_audit import (
    CHECKS,
    COSTLY_CHECKS,
    STEPPING_CHECKS,
    Check,
    audit,
    audit_of_motion,
    unaccepted_errors,
)
from membrane_rs.check.softening import SofteningAdvice, softening_advice
from membrane_rs.mesh.findings import Audit, Finding

__all__ = [
    "CHECKS",
    "COSTLY_CHECKS",
    "STEPPING_CHECKS",
    "Audit",
    "Check",
    "Finding",
    "SofteningAdvice",
    "audit",
    "audit_of_motion",
    "facts",
    "softening_advice",
    "unaccepted_errors",
]
