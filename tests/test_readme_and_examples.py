"""What a newcomer tries first: targets of make and examples; `test_docs_run.py` runs README's code and commands."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from readme_numbers import TABLES

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
UPKEEP = ROOT / "tools" / "docs" / "readme_numbers.py"
"""It keeps docs/accuracy.md in step with the demo."""
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
STUDIES = [ROOT / "tools" / "docs" / f"{name}.py" for name in ("accuracy", "dashpots", "mesh_parameters", "studies")]
"""They make tables of docs/, and can be tried as an example can."""
SHORT = 0.004
"""Where runs of README and examples are made to end [s]: to see them work, not to see them deploy."""


def commands(program: str) -> list[list[str]]:
    """The words behind `program` in each line of README's code that calls it."""
    code = re.findall(r"^```(?:sh|bash|console|shell)\n(.*?)^```", README, flags=re.DOTALL | re.MULTILINE)
    lines = "\n".join(code).splitlines() + re.findall(r"^    (\S.*)", README, flags=re.MULTILINE)
    words = [shlex.split(line.removeprefix("$ "), comments=True) for line in lines if program in line.split()]
    return [line[line.index(program) + 1 :] for line in words if program in line]


def test_there_is_something_to_try() -> None:
    assert commands("membrane-rs"), "README.md shows no command"
    assert commands("make"), "README.md shows no make"
    assert EXAMPLES, "examples/ holds no example"


def test_files_that_the_readme_names_are_there() -> None:
    links = re.findall(r"\]\(([^)#\s]+)[^)]*\)|<img[^>]*src=\"([^\"]+)\"", README)
    for link in (first or second for first, second in links):
        assert link.startswith(("http://", "https://", "mailto:")) or (ROOT / link).exists(), link


def test_make_targets_of_the_readme_exist() -> None:
    targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.MULTILINE)
    for words in commands("make"):
        assert set(words) <= set(targets)


@pytest.mark.parametrize("example", [*EXAMPLES, *STUDIES], ids=lambda path: path.stem)
def test_examples(example: Path, tmp_path: Path) -> None:
    words = [sys.executable, str(example)]
    text = example.read_text(encoding="utf-8")
    words += ["--until", str(SHORT)] if '"--until"' in text else []
    words += ["--no-pictures"] if '"--no-pictures"' in text else []
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip(), "an example should say what it did"
    assert "Traceback" not in done.stderr
    assert not (example.parent / "out").exists()  # it writes where it is called


def test_numbers_that_are_stale_are_reported(tmp_path: Path) -> None:
    for name, part in TABLES.items():
        (tmp_path / name).write_text(part.read(), encoding="utf-8")
    words = [sys.executable, str(UPKEEP), "--out", str(tmp_path)]
    assert subprocess.run(words, cwd=tmp_path, check=False).returncode == 0
    (tmp_path / next(iter(TABLES))).write_text("| other |", encoding="utf-8")
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "other numbers than the last demo" in done.stderr
    assert all(part.read() != "| other |" for part in TABLES.values())
