"""Links between files of the repository, and those of the built site, lead to what is there."""

from __future__ import annotations

import itertools
import re
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from documented import PAGES, ROOT
from markdown_it import MarkdownIt
from website.links import faults, main

OTHERS = [ROOT / name for name in ("CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md", "benchmarks/README.md")]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.md"))
MADE = ("docs/gallery/", "docs/reference/")
"""Folders that only a build of the site has."""


def links(page: Path) -> list[str]:
    """The addresses of links and pictures in a page of Markdown."""
    found = []
    for token in MarkdownIt("commonmark").enable("table").parse(page.read_text(encoding="utf-8")):
        for child in token.children or ():
            if child.type in ("link_open", "image"):
                found.append(str(child.attrGet("href") or child.attrGet("src")))
    return found


def places(page: Path) -> set[str]:
    """The names of headings, as a browser of the repository and the site make them."""
    tokens = MarkdownIt("commonmark").parse(page.read_text(encoding="utf-8"))
    titles = [after.content for token, after in itertools.pairwise(tokens) if token.type == "heading_open"]
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", [*PAGES, *OTHERS, *NOTEBOOKS], ids=lambda path: str(path.relative_to(ROOT)))
def test_links_of_a_page_lead_to_what_is_there(page: Path) -> None:
    for link in links(page):
        parts = urlsplit(link)
        if parts.scheme:
            continue
        target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
        if target.is_relative_to(ROOT) and target.relative_to(ROOT).as_posix().startswith(MADE):
            continue
        assert target.exists(), f"{link} is not there"
        if parts.fragment and target.suffix == ".md":
            assert parts.fragment in places(target), f"{link}: no heading of that name"


def test_a_site_whose_links_lead_somewhere_is_accepted(tmp_path: Path) -> None:
    (tmp_path / "index.html").write_text(
        '<a href="b.html#here">b</a><a href="#top" id="top"><a href="mailto:a@b.test">'
    )
    (tmp_path / "b.html").write_text('<p id="here"><a href="index.html"><a href="https://a.test/gone.html">')
    (tmp_path / "search.html").write_text("")
    assert list(faults(tmp_path)) == []
    assert main(tmp_path) == 0


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ('<a href="gone.html">', "b.html: gone.html is not there"),
        ('<img src="gone.png">', "b.html: gone.png is not there"),
        ('<a href="index.html#gone">', "b.html: index.html#gone names a place that its page lacks"),
        ('<a href="#gone">', "b.html: #gone names a place that its page lacks"),
    ],
)
def test_a_link_that_leads_nowhere_is_named(
    text: str, fault: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "index.html").write_text('<a href="b.html">')
    (tmp_path / "b.html").write_text(f'<a href="index.html">{text}')
    assert list(faults(tmp_path)) == [fault]
    assert main(tmp_path) == 1
    assert fault in capsys.readouterr().err


def test_a_page_that_nothing_links_to_is_named(tmp_path: Path) -> None:
    (tmp_path / "index.html").write_text('<a href="#" id="">')
    (tmp_path / "b.html").write_text('<a href="index.html"><a href="b.html">')
    assert list(faults(tmp_path)) == ["b.html: no page links to it"]


def test_a_folder_without_pages_has_no_links(tmp_path: Path) -> None:
    assert main(tmp_path) == 1
