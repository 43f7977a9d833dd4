"""Fault injection by each explicit method: no fault goes undetected, every error names the true cause."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from fault_injection import EACH, METHODS, ending, endings, page
from faults import FAULTS, Faulty, Generator


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: str(fault.__name__))
@pytest.mark.parametrize("method", METHODS)
def test_no_fault_goes_undetected(fault: Callable[[Generator], Faulty], method: str) -> None:
    for seed in range(EACH):
        found = ending(fault, seed, method)
        assert found.outcome in ("refused", "detected", "intact"), found


def test_there_are_two_hundred_and_the_table_is_theirs() -> None:
    assert len(FAULTS) * EACH == 200
    written = (Path(__file__).parents[1] / "docs" / "fault_injection.md").read_text(encoding="utf-8")
    rows = [line for line in page(endings()).splitlines() if line.startswith("| ")]
    counts = [line.split("|")[1:7] for line in rows]
    assert [line.split("|")[1:7] for line in written.splitlines() if line.startswith("| ")] == counts
