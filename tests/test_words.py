"""Standard terms: no private word of earlier versions stands in code or pages. docs/glossary.md defines the terms.

Identifiers and keys such as `short_steps` are no matches: aliases keep them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
TERMS = {
    "turned over": "reference energy",
    "from nowhere": "spurious gain",
    "books?": "energy balance",
    "booked": "counted in the energy balance",
    "told": "described, reported",
    "cures?": "remedy",
    "the watch": "the monitor",
    "unwatched": "without monitor",
    "quietly wrong": "undetected",
    "poison(s|ed)?": "fault, faulty",
    "in vain": "rejected",
    "rungs?": "refinement level",
    "short steps?": "substeps",
    "wings?": "facet",
    "fillers?": "padding lane",
    "runs and halves": "contiguous and split batches",
    "straight runs?": "contiguous batches",
    "stretch(es)? of (rows|nodes)": "row block",
}
"""Each private word, as a regular expression, and the term in its place."""
CLEAN = (
    "README.md",
    "CHANGELOG.md",
    "docs",
    "benchmarks",
    "examples",
    "tools",
    "rust",
    "python",
    "CONTRIBUTING.md",
    "CODE_OF_CONDUCT.md",
    "tests/fault_injection.py",
    "tests/faults.py",
    "tests/limit_cases.py",
    "tests/step_accuracy_cases.py",
)
"""Files, and folders of files, that hold none."""
SUFFIXES = {".md", ".py", ".rs", ".toml"}
BREAK = r"[\s/#!*>]+"
"""Between two words of a phrase: blanks, or the end of a line with the marks of a comment."""
PATTERN = re.compile(rf"(?<![\w-])(?:{'|'.join(TERMS).replace(' ', BREAK)})(?! = Renamed|[\w-])", flags=re.IGNORECASE)


def files() -> Iterator[Path]:
    """The files that are read."""
    for name in CLEAN:
        path = ROOT / name
        assert path.exists(), f"{name} is listed in CLEAN, and is not there"
        for file in [path] if path.is_file() else sorted(path.rglob("*")):
            if file.suffix in SUFFIXES:
                yield file


def term_for(found: str) -> str:
    """The term in place of a private word."""
    plain = re.sub(BREAK, " ", found)
    return next(term for word, term in TERMS.items() if re.fullmatch(word, plain, flags=re.IGNORECASE))


def places(text: str) -> list[str]:
    """Line, private word, and the term in its place."""
    return [f"{text.count(chr(10), 0, m.start()) + 1}: {m[0]!r}: {term_for(m[0])}" for m in PATTERN.finditer(text)]


@pytest.mark.parametrize("file", list(files()), ids=lambda file: str(file.relative_to(ROOT)))
def test_no_private_word_stands_in(file: Path) -> None:
    assert places(file.read_text(encoding="utf-8")) == []


def test_private_words_are_found_over_the_ends_of_lines() -> None:
    assert places("one\n/// the energy turned\n/// over") == ["2: 'turned\\n/// over': reference energy"]
    assert places("# Rungs of a\n# ladder; the watch stops it") == [
        "1: 'Rungs': refinement level",
        "2: 'the watch': the monitor",
    ]
    assert places('ledger["turned_over"], run.watch, short_steps, the watchful, growing, --short-steps') == []
