"""The mesh study: one scene on several meshes, in both forms of the parameters."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from membrane_rs import InputError, Triangles, scenes
from membrane_rs.cli import app
from membrane_rs.study import mesh_study
from membrane_rs.study.mesh import distances, report
from small_scenes import refused
from typer.testing import CliRunner


def test_the_command_writes_curves_and_tables(tmp_path: Path) -> None:
    words = ["mesh-study", "okuizumi-model-1", "--rows", "16", "--rows", "8", "--until", "0.002"]
    result = CliRunner().invoke(app, [*words, "--out", str(tmp_path / "study")])
    assert result.exit_code == 0, result.output
    files = {path.name for path in (tmp_path / "study").iterdir()}
    assert files == {"mesh-study.md", "mesh-study.png", "mesh-study.csv"}
    table = (tmp_path / "study" / "mesh-study.md").read_text()
    assert [line.split(" | ")[:2] for line in table.splitlines()[2:6]] == [
        ["| paper", "22"],
        ["| paper", "11"],
        ["| physical", "22"],
        ["| physical", "11"],
    ]
    points = (tmp_path / "study" / "mesh-study.csv").read_text().splitlines()
    assert points[0] == "form,rows,time,deployment_rate,phase_difference_deg"
    assert len(points) == 1 + 4 * 3


def test_both_forms_of_springs_and_triangles() -> None:
    scene = scenes.load("okuizumi-model-1")
    runs = list(mesh_study(scene, [8], 0.002))
    assert [(run.form, run.rows, run.node_count) for run in runs] == [("paper", 8, 580), ("physical", 8, 580)]
    assert all(run.stopped is None and abs(run.energy_error) < 1e-2 for run in runs)
    rate, phase = distances(*runs)
    assert 0 < rate < 1e-3
    assert 0 < phase < 0.1
    film = replace(scene, laws=[Triangles(), *scene.laws[1:]])
    (one,) = mesh_study(film, [8], 0.001, forms=["physical"])
    assert "physical | 22 | 580" in report([one])


def test_what_cannot_be_refined_is_refused() -> None:
    sail = scenes.load("okuizumi-model-1")
    refused(lambda: list(mesh_study(scenes.load("single-crease"), [8])), InputError, "no square sail")
    refused(lambda: list(mesh_study(sail, [8], forms=["other"])), InputError, "paper, physical")
    with pytest.raises(InputError, match="multiple of 8"):
        list(mesh_study(sail, [9]))
