"""No source file has more than 400 lines, no line of the pages for contributors more than 120 characters; and the files
that CONTRIBUTING.md names are there.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FOLDERS = ("benchmarks", "docs", "examples", "python", "rust", "tests", "tools")
MOST_LINES = 400
SOURCES = sorted(file for name in FOLDERS for end in ("py", "pyi", "rs") for file in (ROOT / name).rglob(f"*.{end}"))


def test_sources_are_found() -> None:
    assert {file.suffix for file in SOURCES} == {".py", ".pyi", ".rs"}


@pytest.mark.parametrize("file", SOURCES, ids=lambda file: str(file.relative_to(ROOT)))
def test_no_source_file_is_too_long(file: Path) -> None:
    lines = file.read_text(encoding="utf-8").splitlines()
    assert len(lines) <= MOST_LINES


@pytest.mark.parametrize("name", ["CONTRIBUTING.md", "CODE_OF_CONDUCT.md"])
def test_no_line_of_a_page_is_too_long(name: str) -> None:
    lines = (ROOT / name).read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if len(line) > 120 and not line.startswith("|")] == []


def test_files_that_contributors_are_led_to_are_there() -> None:
    tree = (
        (ROOT / "CONTRIBUTING.md")
        .read_text(encoding="utf-8")
        .partition("\n## Where things are")[2]
        .partition("\n## ")[0]
    )
    named = set(re.findall(r"[\w/]*\w\.(?:py|rs)\b", tree))
    assert len(named) > 100
    there = [f"/{file.relative_to(ROOT)}" for file in SOURCES]
    assert [name for name in sorted(named) if not any(file.endswith(f"/{name}") for file in there)] == []
