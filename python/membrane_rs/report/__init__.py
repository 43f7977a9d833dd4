"""A page of runs: one HTML file that opens without a network."""

from __future__ import annotations

from typing import TYPE_CHECKING

from membrane_rs._on_demand import OnDemand

if TYPE_CHECKING:
    from membrane_rs.report.writing import write_report

__all__ = ["write_report"]

if not TYPE_CHECKING:  # a type checker would take every name for one that is there
    _on_demand = OnDemand(
        __name__,
        {
            "membrane_rs.report.writing": ("write_report",),
        },
    )
    __getattr__, __dir__ = _on_demand, _on_demand.names
