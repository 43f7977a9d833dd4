"""Tables of Markdown."""

from __future__ import annotations

from collections.abc import Collection, Sequence


def table(head: Sequence[str], rows: Sequence[Sequence[str]], words: Collection[int] = (0,)) -> str:
    """A table, its last line ended.

    Parameters
    ----------
    head, rows : a cell for each column
    words : columns of words, which stand left; the others hold numbers, which stand right
    """
    rule = ["---" if column in words else "---:" for column in range(len(head))]
    return "".join(f"| {' | '.join(row)} |\n" for row in (head, rule, *rows))
