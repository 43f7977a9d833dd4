"""What a shell completes: commands, scenes, runs, methods, dotted keys."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from membrane_rs import Simulation, integrators, scenes
from membrane_rs.cli import completion

PROGRAM = "import sys; from membrane_rs.cli import main; sys.argv = ['membrane-rs']; main()"


def completed(line: str, folder: Path) -> list[str]:
    """What bash is offered at the end of a line."""
    words = line.split(" ")
    asked = {"_MEMBRANE_RS_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(len(words) - 1)}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env=os.environ | asked,
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert done.stderr == ""
    return [line for line in done.stdout.splitlines() if line]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_text("")
    Path("runs/no-run").mkdir(parents=True)
    for out in ("runs/first", "runs/second", "third"):
        Simulation(scenes.load("spinning-tether")).run(1e-4, frames=2, out=out, pictures=False)
    return tmp_path


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("membrane-rs che", ["check"]),
        ("membrane-rs run spinning-t", ["spinning-tether"]),
        ("membrane-rs run mi", ["miura", "mine.toml"]),
        ("membrane-rs resume r", ["runs/first", "runs/second"]),
        ("membrane-rs compare third runs/s", ["runs/second"]),
        ("membrane-rs run spinning-tether --integrator leap", ["leapfrog"]),
        ("membrane-rs run spinning-tether --until 1 --set laws.spin.f", ["laws.spin.frequency="]),
        ("membrane-rs run nowhere --set laws.spin.f", []),
        (f"membrane-rs run {'x' * 300}.toml --set laws.spin.f", []),
        ("membrane-rs new own --from spinning-tether --set laws.spin.f", ["laws.spin.frequency="]),
        ("membrane-rs sweep spinning-tether --vary laws.spin.f", ["laws.spin.frequency="]),
        ("membrane-rs calibrate spinning-tether --data a.csv --vary laws.spin.f", ["laws.spin.frequency="]),
        ("membrane-rs run spinning-tether --overw", ["--overwrite"]),
        ("membrane-rs scenes too-many --js", ["--json"]),
    ],
)
def test_the_end_of_a_line(line: str, offered: list[str], folder: Path) -> None:
    assert completed(line, folder) == offered


def test_all_is_offered(folder: Path) -> None:
    assert [name for name, _ in completion.scenes("")] == [*scenes.names(), "mine.toml"]
    assert completion.methods("") == list(integrators())
    assert completion.runs("") == ["third", "runs/first", "runs/second"]
    assert completion.runs("nowhere/") == []


def test_a_name_with_a_space_is_one_word_of_bash(folder: Path) -> None:
    Path("odd one (1).toml").write_text("")
    assert completed("membrane-rs run od", folder) == ["odd\\ one\\ \\(1\\).toml"]
    assert ("odd one (1).toml", "scene file") in completion.scenes("")  # zsh and fish quote it themselves
