"""The stages of a run, as its simulation or its summary has them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import MISSING, fields

from membrane_rs.simulation.timeline import StageRecord

_NAMES = tuple(field.name for field in fields(StageRecord))
_NEEDED = tuple(field.name for field in fields(StageRecord) if field.default is MISSING)
"""What a summary of an earlier version has, too."""


def stage_records(given: Iterable[object]) -> list[StageRecord]:
    """Records of stages: those that are such, and those of a summary that have all that a record has."""
    found = []
    for stage in given:
        if isinstance(stage, StageRecord):
            found.append(stage)
        elif isinstance(stage, Mapping) and all(name in stage for name in _NEEDED):
            found.append(StageRecord(**{name: stage[name] for name in _NAMES if name in stage}))
    return found
