"""README.md beside this file, where each script of `make bench` writes its tables into a marked part."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
README = HERE / "README.md"
__all__ = ["DOCS", "README", "MarkedPart", "options", "show"]
sys.path.append(str(HERE.parent / "tools" / "docs"))  # where `marked` is

from marked import DOCS, MarkedPart  # noqa: E402


def options(doc: str | None) -> argparse.ArgumentParser:
    """The options of every script of `make bench`."""
    parser = argparse.ArgumentParser(description=doc.splitlines()[0] if doc else None)
    parser.add_argument("--write", action="store_true", help="put the tables into README.md beside this file")
    parser.add_argument("--quick", action="store_true", help="few repeats: for a check, not for measurements")
    return parser


def show(part: MarkedPart, text: str, *, write: bool) -> None:
    """Print the tables, and put them into their part if asked."""
    print(text, flush=True)
    if write:
        part.write(text)
