"""Checks of a scene before it runs: one audit of its mesh, laws and parts, and what limits the step."""

from __future__ import annotations

from typing import TYPE_CHECKING

from membrane_rs._on_demand import OnDemand

if TYPE_CHECKING:
    from membrane_rs.check.scene_audit import (
        CHECKS,
        COSTLY_CHECKS,
        STEPPING_CHECKS,
        Check,
        audit,
        audit_of_motion,
        unaccepted_errors,
    )
    from membrane_rs.check.scene_facts import facts
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

if not TYPE_CHECKING:  # a type checker would take every name for one that is there
    _on_demand = OnDemand(
        __name__,
        {
            "membrane_rs.check.scene_audit": (
                "CHECKS",
                "COSTLY_CHECKS",
                "Check",
                "STEPPING_CHECKS",
                "audit",
                "audit_of_motion",
                "unaccepted_errors",
            ),
            "membrane_rs.check.scene_facts": ("facts",),
            "membrane_rs.check.softening": ("SofteningAdvice", "softening_advice"),
            "membrane_rs.mesh.findings": ("Audit", "Finding"),
        },
    )
    __getattr__, __dir__ = _on_demand, _on_demand.names
