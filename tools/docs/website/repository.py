"""Pages that are read in the repository and on the site: their links between files become links between pages."""

from __future__ import annotations

import re
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata

PAGES = {"benchmarks/README.md": "times.md"}
"""Pages that include a file which stands outside docs/."""


def setup(app: Sphinx) -> ExtensionMetadata:
    """Change sources and the files that they include when they are read."""
    app.connect("source-read", lambda app, page, content: _change(app, content))
    app.connect("include-read", lambda app, path, page, content: _change(app, content))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _change(app: Sphinx, content: list[str]) -> None:
    content[0] = as_page(content[0], Path(app.srcdir))


def as_page(text: str, docs: Path) -> str:
    """A file of the repository as it stands on the site, whose pages are in the folder `docs`.

    Links lead to pages, and one whose text is the path of a page has its title instead.
    """
    for path, page in PAGES.items():
        text = re.sub(rf"\]\((\.\./)?{re.escape(path)}", f"]({page}", text)
    text = re.sub(r"\]\((\.\./)?docs/", "](", text)
    return re.sub(r"\[(?:docs/)?([\w-]+\.md)\](?=\()", lambda found: f"[{title(docs / found[1])}]", text)


def title(page: Path) -> str:
    """The heading of a page, or its name where there is none."""
    text = page.read_text(encoding="utf-8") if page.is_file() else ""
    found = re.search(r"^# (.+)$", text, flags=re.MULTILINE)
    return found[1] if found else page.name
