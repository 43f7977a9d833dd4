"""What a built site loads from elsewhere: nothing. Plain links may lead anywhere.

python -m website.offline FOLDER
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

LOADED = {
    "script": ("src",),
    "img": ("src", "srcset"),
    "source": ("src", "srcset"),
    "iframe": ("src",),
    "embed": ("src",),
    "object": ("data",),
    "video": ("src", "poster"),
    "audio": ("src",),
    "track": ("src",),
    "input": ("src",),
    "image": ("href", "xlink:href"),
    "use": ("href", "xlink:href"),
    "link": ("href",),
    "base": ("href",),
}
"""Attributes by element whose address a browser loads when it shows the page."""
LINKS_ALONE = {"next", "prev", "search", "index", "author", "canonical", "license", "copyright"}
"""Relations of `link` that a browser does not load."""
ELSEWHERE = re.compile(r"\s*(?:[a-z][a-z0-9+.-]*:)?//", re.IGNORECASE)
IN_STYLE = re.compile(r"""url\(\s*['"]?([^'")]+)|@import\s+['"]([^'"]+)""")


class _Page(HTMLParser):
    """The addresses that a page loads."""

    def __init__(self) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self._is_style = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self._is_style = tag == "style"
        self.addresses += loaded_by_style(given.get("style", ""))
        if tag == "link" and set(given.get("rel", "").lower().split()) & LINKS_ALONE:
            return
        for name in LOADED.get(tag, ()):
            parts = given.get(name, "").split(",") if name == "srcset" else [given.get(name, "")]
            self.addresses += [part.strip() for part in parts if part.strip()]

    def handle_endtag(self, tag: str) -> None:
        self._is_style = False

    def handle_data(self, data: str) -> None:
        if self._is_style:
            self.addresses += loaded_by_style(data)


def loaded_by_style(text: str) -> list[str]:
    """The addresses that a style sheet loads."""
    return [first or second for first, second in IN_STYLE.findall(text)]


def loaded(path: Path) -> list[str]:
    """The addresses that a page or a style sheet loads."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".css":
        return loaded_by_style(text)
    page = _Page()
    page.feed(text)
    return page.addresses


def from_elsewhere(folder: Path) -> Iterator[tuple[Path, str]]:
    """Each page or style sheet of a built site with each address that it loads from another place than the site."""
    for path in sorted([*folder.rglob("*.html"), *folder.rglob("*.css"), *folder.rglob("*.svg")]):
        yield from ((path, address) for address in loaded(path) if ELSEWHERE.match(address))


def main(folder: Path) -> int:
    """Name what is loaded from elsewhere; the number of such addresses decides on success."""
    if not any(folder.rglob("*.html")):
        print(f"{folder}: holds no page; build the site first: make docs", file=sys.stderr)
        return 1
    found = list(from_elsewhere(folder))
    for path, address in found:
        print(f"{path.relative_to(folder)}: loads {address}; take a copy that the build brings along", file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
