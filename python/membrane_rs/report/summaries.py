"""Entries of a summary, which may be of any kind: it is a file that anybody can write."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeGuard

from membrane_rs.plotting.stage_records import stage_records
from membrane_rs.simulation.timeline import StageRecord


def is_number(value: Any) -> TypeGuard[float]:
    """Whether a value is a number."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def table_of(summary: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """An entry of a summary that is a table; an empty one where it is something else."""
    found = summary.get(name)
    return found if isinstance(found, dict) else {}


def tables_of(summary: Mapping[str, Any], name: str) -> list[Mapping[str, Any]]:
    """Those parts of an entry of a summary that are tables."""
    found = summary.get(name)
    return [entry for entry in found if isinstance(entry, dict)] if isinstance(found, list) else []


def sound_stage_records(summary: Mapping[str, Any]) -> list[StageRecord]:
    """The records of the stages of a run; none where a summary lacks what a balance needs, or has other kinds of it."""
    entries = tables_of(summary, "stages")
    names = ("start", "end", "reference_energy", "error")
    for entry in entries:
        tables = [entry.get(name) for name in ("changes", "work_by_law")]
        numbers = [entry.get(name) for name in names]
        if not all(isinstance(table, dict) and all(map(is_number, table.values())) for table in tables):
            return []
        if not all(map(is_number, numbers)) or not (entry.get("motor_work") is None or is_number(entry["motor_work"])):
            return []
    records = stage_records(entries)
    return records if len(records) == len(entries) else []
