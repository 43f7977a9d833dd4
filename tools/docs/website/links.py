"""Links of a built site: each leads to a file of the site, and to a place that is there; each page is linked to.

python -m website.links FOLDER
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

ADDRESSES = ("href", "src", "data", "poster")
"""Attributes that name a file."""
NO_PAGES = ("_static", "_sources", "_downloads")
"""Folders of a site whose files are no pages: templates, sources."""
NOT_LINKED = ("search.html", "genindex.html", "py-modindex.html")
"""Pages that need no link."""


class _Page(HTMLParser):
    """The names of places in a page, and the addresses in it."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.places: set[str] = set()
        self.addresses: list[str] = []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self.places |= {given[name] for name in ("id", "name") if given.get(name)}
        self.addresses += [given[name] for name in ADDRESSES if given.get(name)]


def faults(folder: Path) -> Iterator[str]:
    """Each page with a link of it that leads nowhere, and each page that no other leads to."""
    folder = folder.resolve()
    paths = [path for path in sorted(folder.rglob("*.html")) if path.relative_to(folder).parts[0] not in NO_PAGES]
    pages = {path: _Page(path) for path in paths}
    linked: set[Path] = set()
    for path, page in pages.items():
        name = path.relative_to(folder).as_posix()
        for address in page.addresses:
            parts = urlsplit(address)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.exists():
                yield f"{name}: {address} is not there"
            elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].places:
                yield f"{name}: {address} names a place that its page lacks"
            linked |= {target} - {path}
    yield from (
        f"{path.relative_to(folder).as_posix()}: no page links to it"
        for path in sorted(pages.keys() - linked)
        if path.name not in NOT_LINKED
    )


def main(folder: Path) -> int:
    """Name what leads nowhere, and what nothing leads to; the exit code."""
    if not any(folder.rglob("*.html")):
        print(f"{folder}: holds no page; build the site first: make docs", file=sys.stderr)
        return 1
    found = list(faults(folder))
    for fault in found:
        print(fault, file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
