"""README.md beside this file: each script writes its tables between two marks of its own."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

README = Path(__file__).resolve().parent / "README.md"


def options(doc: str | None) -> argparse.ArgumentParser:
    """What every script of `make bench` understands."""
    parser = argparse.ArgumentParser(description=doc.splitlines()[0] if doc else None)
    parser.add_argument("--write", action="store_true", help="put the tables into README.md beside this file")
    parser.add_argument("--quick", action="store_true", help="few repeats: to see it work, not to measure")
    return parser


def show(name: str, text: str, *, write: bool, page: Path = README) -> None:
    """Print the tables, and put them between the marks of that name if asked."""
    print(text, flush=True)
    if not write:
        return
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    before, found, rest = page.read_text(encoding="utf-8").partition(begin)
    _, closed, after = rest.partition(end)
    if not (found and closed):
        raise SystemExit(f"{page} has no lines {begin} and {end}: put them where the tables shall stand")
    page.write_text(f"{before}{begin}\n\n{text.strip()}\n\n{end}{after}", encoding="utf-8")


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table of numbers; the first column is words."""
    rule = ["---", *["---:"] * (len(head) - 1)]
    return "\n".join(f"| {' | '.join(row)} |" for row in [head, rule, *rows]) + "\n"
