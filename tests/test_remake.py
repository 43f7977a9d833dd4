"""`make accuracy`: every part stands, can be made alone, and one that fails loses nothing of the others."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest
from studies import NAMES

ROOT = Path(__file__).parent.parent
REMAKE = ROOT / "benchmarks" / "remake.py"


def loaded(path: Path) -> ModuleType:
    """A script as a module."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def remake() -> ModuleType:
    return loaded(REMAKE)


def test_every_part_names_scripts_and_targets_that_are_there(remake: ModuleType) -> None:
    for part in remake.PARTS:
        for words in part.commands:
            assert words[0] == "-m" or (ROOT / words[0]).is_file(), words
        for target in part.copies.values():
            assert (ROOT / target).is_file()
        assert (ROOT / part.what.split(":")[0]).is_file()


def test_the_parts_make_all_diagrams_and_ablations(remake: ModuleType) -> None:
    made = [word for part in remake.PARTS for words in part.commands for word in words if word in NAMES]
    assert made == NAMES


def test_a_part_that_fails_loses_nothing_of_the_others(
    remake: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    first, kept = tmp_path / "first", tmp_path / "kept"
    parts = (
        remake.Part("breaks", "nothing", [("-c", "print('halfway'); raise SystemExit(3)"), ("-c", "1/0")], {}, True),
        remake.Part("writes", "a file", [("-c", f"open({str(first)!r}, 'w').write('x')")], {str(first): str(kept)}),
    )
    monkeypatch.setattr(remake, "PARTS", parts)
    monkeypatch.setattr(sys, "argv", ["remake.py"])
    with pytest.raises(SystemExit, match="make accuracy PART=breaks"):
        remake.main()
    assert kept.read_text() == "x"
    said = capfd.readouterr().out
    assert "breaks         | halfway" in said
    assert "ZeroDivision" not in said  # nothing of a part after its first failure
    assert re.search(r"breaks +\d+ s  FAILED", said)
    assert re.search(r"writes +\d+ s  done", said)


def test_parts_are_listed_and_wrong_ones_refused() -> None:
    listed = subprocess.run([sys.executable, REMAKE, "--list"], capture_output=True, text=True, check=True).stdout
    assert "docs/limits.md" in listed
    wrong = subprocess.run([sys.executable, REMAKE, "limitz"], capture_output=True, text=True, check=False)
    assert wrong.returncode == 2
    assert "there is no part 'limitz'; did you mean 'limits'?" in wrong.stderr
    none = subprocess.run(
        [sys.executable, ROOT / "tools" / "docs" / "studies.py", "--only", "releas-work-precision"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert none.returncode == 2
    assert "did you mean release-work-precision?" in none.stderr
