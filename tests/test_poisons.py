"""Two hundred poisoned runs: none ends quietly wrong, and every error names the true cause."""

from __future__ import annotations

from pathlib import Path

import pytest
from poisoned import EACH, ending, endings, table
from poisons import POISONS


@pytest.mark.parametrize("poison", POISONS, ids=lambda poison: str(poison.__name__))
def test_no_poison_ends_quietly_wrong(poison: object) -> None:
    for seed in range(EACH):
        found = ending(poison, seed)  # type: ignore[arg-type]
        assert found.outcome in ("refused", "caught", "intact"), found


def test_there_are_two_hundred_and_the_table_is_theirs() -> None:
    assert len(POISONS) * EACH == 200
    written = (Path(__file__).parents[1] / "docs" / "poisoned.md").read_text(encoding="utf-8")
    rows = [line for line in table(endings()).splitlines() if line.startswith("| ")]
    counts = [line.split("|")[1:7] for line in rows]
    assert [line.split("|")[1:7] for line in written.splitlines() if line.startswith("| ")] == counts
