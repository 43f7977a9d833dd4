"""Marked parts of pages: what is written where, and that every one has its script."""

from __future__ import annotations

import importlib
import re
from collections import Counter
from pathlib import Path

import marked
import pytest
from marked import DOCS, ROOT, MarkedPart, make_parts
from membrane_rs import OutputError
from membrane_rs._markdown import table

SCRIPTS = sorted([*(ROOT / "benchmarks").glob("*.py"), *(ROOT / "tools" / "docs").glob("*.py")])
PAGES = sorted([*ROOT.glob("*.md"), *DOCS.glob("*.md"), *(ROOT / "benchmarks").glob("*.md")])


@pytest.fixture
def page(tmp_path: Path) -> Path:
    path = tmp_path / "page.md"
    path.write_text("before\n<!-- a: begin -->\nold\n<!-- a: end -->\n<!-- b: begin -->\n<!-- b: end -->\nafter\n")
    return path


def parts_of(script: Path) -> list[MarkedPart]:
    """Those that a script names as constants, alone or by a name."""
    values = vars(importlib.import_module(script.stem)).values()
    named = [part for value in values if isinstance(value, dict) for part in value.values()]
    return [part for part in [*values, *named] if isinstance(part, MarkedPart)]


def test_every_marked_part_is_written_by_one_script_and_every_script_finds_its_parts() -> None:
    named = Counter(part for script in SCRIPTS for part in parts_of(script))
    begun = [
        MarkedPart(path, name)
        for path in PAGES
        for name in re.findall(r"<!-- (\S+): begin -->", path.read_text(encoding="utf-8"))
    ]
    assert named == Counter(begun)
    for part in begun:
        assert part.read(), part


def test_only_what_is_between_the_marks_is_replaced(page: Path) -> None:
    part = MarkedPart(page, "a")
    part.write("\nnew\n")
    assert part.read() == "new"
    text = "before\n<!-- a: begin -->\n\nnew\n\n<!-- a: end -->\n<!-- b: begin -->\n<!-- b: end -->\nafter\n"
    assert page.read_text() == text
    part.write(part.read())
    assert page.read_text() == text
    assert MarkedPart(page, "b").read() == ""


@pytest.mark.parametrize(
    ("marks", "fault"),
    [
        ("", "lacks the mark <!-- c: begin -->"),
        ("<!-- c: begin -->", "lacks the mark <!-- c: end -->"),
        ("<!-- c: begin --> <!-- c: begin --> <!-- c: end -->", "has 2 times the mark <!-- c: begin -->"),
        ("<!-- c: begin --> <!-- c: end --> <!-- c: end -->", "has 2 times the mark <!-- c: end -->"),
        ("<!-- c: end --> <!-- c: begin -->", "has the mark <!-- c: end --> before <!-- c: begin -->"),
    ],
)
def test_a_page_with_other_marks_is_refused_by_name_and_left_as_it_is(page: Path, marks: str, fault: str) -> None:
    page.write_text(text := page.read_text() + marks)
    with pytest.raises(SystemExit, match=re.escape(f"{page} {fault}")):
        MarkedPart(page, "c").write("nowhere")
    assert page.read_text() == text


def test_a_page_that_cannot_be_written_stays_whole(page: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(self: Path, *_: object, **__: object) -> int:
        raise OSError(28, "No space left on device")

    text = page.read_text()
    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(OutputError, match="No space left"):
        MarkedPart(page, "a").write("new")
    assert page.read_text() == text
    assert list(page.parent.iterdir()) == [page]


def test_a_table_sets_words_left_and_numbers_right() -> None:
    assert table(("law", "cost"), [("drag", "1.0")]) == "| law | cost |\n| --- | ---: |\n| drag | 1.0 |\n"
    assert table(("x", "y", "set by"), [], words=(2,)) == "| x | y | set by |\n| ---: | ---: | --- |\n"


def test_the_parts_of_a_page_are_made_on_demand(
    page: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """Those that --only names; written with --write alone, and the picture with the part that it belongs to."""
    monkeypatch.chdir(tmp_path)
    parts = {name: MarkedPart(page, name) for name in ("a", "b")}
    drawn: list[Path] = []
    shown: list[str] = []
    monkeypatch.setattr(marked, "copy_small", lambda path, name: shown.append(name))
    for options, written in (
        ([], ("old", "")),
        (["--only", "b", "--write"], ("old", "two")),
        (["--write"], ("one", "two")),
    ):
        monkeypatch.setattr("sys.argv", ["script", *options])
        make_parts("What it does.", parts, {"a": lambda: "one", "b": lambda: "two"}, ("a", "a.png", drawn.append))
        assert (parts["a"].read(), parts["b"].read()) == written
        assert "two" in capsys.readouterr().out
    assert drawn == [Path("out/a.png")]
    assert shown == ["a.png"]
    monkeypatch.setattr("sys.argv", ["script", "--only", "c"])
    with pytest.raises(SystemExit):
        make_parts(None, parts, {})
