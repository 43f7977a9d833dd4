"""The command that folds a pattern: what it writes, says and refuses."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from folding_cases import SQUARE_TWIST, square_twist
from membrane_rs import Mesh, Scene, fold
from test_cli import call


@pytest.fixture
def pattern(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    shutil.copy(SQUARE_TWIST, tmp_path / "twist.fold")
    return tmp_path / "twist.fold"


def test_a_pattern_is_folded_into_a_file(pattern: Path) -> None:
    code, shown = call("fold", pattern, "--fraction", "0.9")
    assert code == 0
    assert "Folded to 0.9 of the pattern's angles" in shown
    found = Mesh.load(pattern.with_name("twist-folded.npz"))
    assert found.positions.tobytes() == fold(square_twist(), 0.9).mesh.positions.tobytes()
    code, shown = call("fold", pattern, "--fraction", "0.9")
    assert code == 2
    assert "is there already" in shown
    code, shown = call("fold", pattern, "--fraction", "0.5", "--overwrite", "--json", "--increments", "4")
    assert code == 0
    document = json.loads(shown)
    assert document["fraction"] == 0.5
    assert len(document["angles"]) == 12


def test_divided_and_as_a_fold_file(pattern: Path) -> None:
    code, shown = call("fold", pattern, "--fraction", "0.9", "--divide", "2", "--out", "folded.fold")
    assert code == 0
    assert "Wrote folded.fold: 37 nodes, 56 triangles" in shown
    found = Mesh.load("folded.fold")
    assert len(found.creases) == 24
    assert np.abs(found.fold_angles).min() > 1.0


def test_a_scene_takes_what_was_folded(pattern: Path) -> None:
    assert call("fold", pattern, "--fraction", "0.9", "--out", "folded.npz")[0] == 0
    words = """
[mesh]
file = "folded.npz"
[material]
youngs_modulus = "3.2 GPa"
poisson_ratio = 0.34
density = 1420.0
thickness = "25 um"
[laws.triangles]
[laws.creases]
fold_fraction = 0.2
[run]
until = "0.1 ms"
"""
    Path("twist.toml").write_text(words, encoding="utf-8")
    assert Scene.from_toml("twist.toml").mesh is not None
    assert call("run", "twist.toml", "--no-pictures", "--out", "runs/twist")[0] == 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("twist.fold", "--fraction", "1.5"), "fraction = 1.5: must be above 0"),
        (("twist.fold", "--fraction", "much"), "'much': must be a number"),
        (("twist.fold", "--out", "folded.obj"), "must end in .npz or .fold"),
        (("twist.fold", "--divide", "0"), "count = 0: must be from 1"),
        (("none.fold",), "none.fold: there is no such mesh file"),
        (("wrong.fold",), "does not fold to 1 of its angles: creases["),
    ],
)
def test_what_is_refused(words: tuple[str, ...], said: str, pattern: Path) -> None:
    wrong = pattern.read_text(encoding="utf-8").replace('"M"', '"V"')
    pattern.with_name("wrong.fold").write_text(wrong, encoding="utf-8")
    code, shown = call("fold", *words)
    assert code == 2
    assert said in shown
    assert list(pattern.parent.glob("*.npz")) == []


def test_what_does_not_fold_is_written_by_force(pattern: Path) -> None:
    pattern.write_text(pattern.read_text(encoding="utf-8").replace('"M"', '"V"'), encoding="utf-8")
    code, shown = call("fold", pattern, "--force", "--out", "folded.npz")
    assert code == 0
    assert "Fault: creases[" in shown
    assert Mesh.load("folded.npz").node_count == 12
