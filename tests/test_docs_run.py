"""Every Python block and every command of README.md and of docs/ is run, page by page, in an empty folder.

`documented.py` says by which comments a page has a block shortened, written into a file, or left out.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from documented import PAGES, ROOT, Block, blocks
from membrane_rs import Simulation
from membrane_rs.cli import app
from typer.testing import CliRunner

NOT_RUN = {"studies.md": 1, "sweeps.md": 1, "viewer.md": 1}
"""How many blocks of a page are not run; those of any other page all are."""
RUNNABLE = [page for page in PAGES if any(block.is_code for block in blocks(page))]


def test_code_is_found() -> None:
    assert {"README.md", "ten_minutes.md"} <= {page.name for page in RUNNABLE}


def test_blocks_that_are_not_run_are_counted_and_give_a_reason() -> None:
    left_out = [block for page in PAGES for block in blocks(page) if block.how == "not run"]
    assert Counter(block.page.name for block in left_out) == Counter(NOT_RUN)
    for block in left_out:
        assert len(block.what.split()) >= 3, f"{block.place}: why is it not run?"


@pytest.mark.parametrize("page", RUNNABLE, ids=lambda page: str(page.relative_to(ROOT)))
def test_code_of_a_page(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    namespace: dict[str, Any] = {"__name__": "__page__"}
    for block in blocks(page):
        if block.how == "file":
            with Path(block.what).open("a", encoding="utf-8") as file:
                file.write(block.text)
    for block in blocks(page):
        if block.how != "not run" and block.language == "python":
            run_python(block, namespace, monkeypatch)
        elif block.how not in ("not run", "file"):
            for words in block.commands:
                run_command(block, words)


def run_python(block: Block, namespace: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """Run a block after those before it; lines of its text are those of its errors."""
    whole, end = Simulation.run, block.until

    def short(self: Simulation, until: float | None = None, *arguments: Any, **others: Any) -> Any:
        assert end is not None
        return whole(self, min(self.planned_end if until is None else until, self.time + end), *arguments, **others)

    with monkeypatch.context() as patch:
        if end is not None:
            patch.setattr(Simulation, "run", short)
        exec(compile("\n" * block.line + block.text, str(block.page), "exec"), namespace)


def run_command(block: Block, words: list[str]) -> None:
    """Run a command; it must succeed."""
    with pytest.MonkeyPatch.context() as patch:
        # Not the shell above this process: it has none where the one that started it has ended.
        patch.setattr("shellingham.detect_shell", lambda: ("bash", "/bin/bash"))
        result = CliRunner().invoke(app, words, env={"COLUMNS": "200", "NO_COLOR": "1", "TERM": "dumb"})
    assert result.exit_code == 0, f"{block.place}: {' '.join(words)}\n{result.output}"


@pytest.mark.parametrize(
    ("text", "commands"),
    [
        ("x\n\n    membrane-rs scenes   # all\n    make demo\n", [["scenes"]]),
        ("```sh\n$ membrane-rs run a --until \\\n  1\n```\n", [["run", "a", "--until", "1"]]),
        ("<!-- tested with: --until 2 -->\n```sh\nmembrane-rs run a\n```\n", [["run", "a", "--until", "2"]]),
        (
            "<!-- tested with: run: -n 2; check: -q -->\n```\nmembrane-rs run a\nmembrane-rs check a\n```\n",
            [["run", "a", "-n", "2"], ["check", "a", "-q"]],
        ),
        ("```text\nmembrane-rs scenes\n```\n", []),
    ],
)
def test_commands_of_a_page(text: str, commands: list[list[str]], tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(text)
    assert [words for block in blocks(page) for words in block.commands] == commands


def test_a_comment_without_a_block_is_refused(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("<!-- not run: it takes a night -->\n\nText.\n")
    with pytest.raises(AssertionError, match=r"1 comments say .*, and 0 stand before a block"):
        blocks(page)
