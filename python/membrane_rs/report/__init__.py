"""A page of runs: one HTML file that opens without a network."""

from __future__ import annotations

from membrane_rs.report.writing import write_report

__all__ = ["write_report"]
