"""Code of README.md and of the pages of docs/, as it is run by `test_docs_run.py`.

A page's Python blocks, the commands in its other blocks and the files that it shows come in their order. A comment of
Markdown on the line before a block says how it is tested:

    <!-- not run: REASON -->                      not at all
    <!-- file: NAME -->                           written into a file that is there from the page's first block on
    <!-- tested with: until=SECONDS -->           Python; runs end after so long
    <!-- tested with: OPTIONS -->                 commands, with these options besides, the last value of one holds
    <!-- tested with: run: OPTIONS; check: OPTIONS -->   such options for some commands of the block
"""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

from markdown_it import MarkdownIt

ROOT = Path(__file__).resolve().parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
PROGRAM = "membrane-rs"
SHELLS = ("", "sh", "bash", "console", "shell")
COMMENT = re.compile(r"<!-- (?P<how>not run|file|tested with): (?P<what>.*?) -->\s*", flags=re.DOTALL)
MARK = re.compile(r"<!-- (?:not run|file|tested with)\b")


@dataclass(frozen=True)
class Block:
    """Code of a page, and how it is tested: by which comment, which says what."""

    page: Path
    line: int
    language: str
    text: str
    how: str
    what: str

    @property
    def place(self) -> str:
        """Where it stands."""
        return f"{self.page.relative_to(ROOT)}:{self.line}"

    @property
    def commands(self) -> list[list[str]]:
        """The words of each command, without the program, as it is tested."""
        if self.language not in SHELLS:
            return []
        lines = [line.strip().removeprefix("$ ") for line in self.text.replace("\\\n", " ").splitlines()]
        words = [shlex.split(line, comments=True) for line in lines if line.split()[:1] == [PROGRAM]]
        return [line[1:] + (self.options_of(line[1]) if self.how == "tested with" else []) for line in words]

    @property
    def is_code(self) -> bool:
        """Whether there is something to run."""
        return self.language == "python" or bool(self.commands)

    def options_of(self, command: str) -> list[str]:
        """Options that a command is tested with."""
        parts = [part.strip().partition(": ") for part in self.what.split(";")]
        found = [options for name, colon, options in parts if colon and name == command]
        return shlex.split(" ".join(found if any(colon for _, colon, _ in parts) else [self.what]))

    @property
    def until(self) -> float | None:
        """When runs of a Python block are made to end [s]."""
        found = re.fullmatch(r"until=([0-9.e-]+)", self.what) if self.how == "tested with" else None
        return float(found[1]) if found else None


def blocks(page: Path) -> list[Block]:
    """The code of a page, in its order."""
    text = page.read_text(encoding="utf-8")
    found: list[Block] = []
    comment: re.Match[str] | None = None
    for token in MarkdownIt("commonmark").parse(text):
        if token.type in ("fence", "code_block") and token.map:
            how, what = (comment["how"], " ".join(comment["what"].split())) if comment else ("", "")
            language = token.info.split()[0] if token.info.split() else ""
            found.append(Block(page, token.map[0] + 1, language, token.content, how, what))
        comment = COMMENT.fullmatch(token.content) if token.type == "html_block" else None
    marks, used = len(MARK.findall(text)), sum(block.how != "" for block in found)
    assert marks == used, f"{page.name}: {marks} comments say how code is tested, and {used} stand before a block"
    return found
