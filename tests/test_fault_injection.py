"""Two hundred poisoned scenes by each explicit method: none ends quietly wrong, every error names the true cause."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from poisoned import EACH, METHODS, ending, endings, page
from poisons import POISONS, Dice, Poisoned


@pytest.mark.parametrize("poison", POISONS, ids=lambda poison: str(poison.__name__))
@pytest.mark.parametrize("method", METHODS)
def test_no_poison_ends_quietly_wrong(poison: Callable[[Dice], Poisoned], method: str) -> None:
    for seed in range(EACH):
        found = ending(poison, seed, method)
        assert found.outcome in ("refused", "caught", "intact"), found


def test_there_are_two_hundred_and_the_table_is_theirs() -> None:
    assert len(POISONS) * EACH == 200
    written = (Path(__file__).parents[1] / "docs" / "poisoned.md").read_text(encoding="utf-8")
    rows = [line for line in page(endings()).splitlines() if line.startswith("| ")]
    counts = [line.split("|")[1:7] for line in rows]
    assert [line.split("|")[1:7] for line in written.splitlines() if line.startswith("| ")] == counts
