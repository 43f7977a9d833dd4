"""The mesh study: runs that are kept, orders of convergence out of curves, verdicts, calibration."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from membrane_rs import InputError, OutputError, Region, Scene, Springs, scenes
from membrane_rs.cli import app
from membrane_rs.study import FORMS, jobs_of, match_scene, mesh_study, write_mesh_study
from membrane_rs.study.convergence import CURVES, densities, limit, orders, overall_order, steps
from membrane_rs.study.mesh import MeshRun, kept
from membrane_rs.study.mesh_report import report
from small_scenes import refused
from typer.testing import CliRunner

RATE, PHASE = CURVES
END = 0.002


@pytest.fixture(scope="module")
def sail() -> Scene:
    return scenes.load("okuizumi-model-1")


def made_up(rows: int, power: float, member: int = 0, shift: float = 0.0, form: str = "physical") -> MeshRun:
    """A run whose curves are off by h^power."""
    time = np.linspace(0.0, 0.8, 101)
    cell = 0.176 / rows
    off = (cell / 0.022) ** power + shift
    table = {
        "time": time,
        "deployment_rate": 0.7 + time * (1 - time) + 0.02 * off * np.sin(7 * time),
        "phase_difference_deg": -100 * np.sin(math.pi * time / 0.76) + 20 * off * np.sin(3 * time),
    }
    return MeshRun(form, rows, cell, member, 100, 1e-6, 0.0, 1.0, None, table)


@pytest.mark.parametrize("power", [1.0, 2.0])
def test_the_order_of_curves_that_are_off_by_a_power_of_the_cell(power: float) -> None:
    meshes = densities([made_up(rows, power) for rows in (8, 16, 32, 64)])["physical"]
    found = steps(meshes)
    assert [step.ratio for step in found] == [2.0, 2.0, 2.0]
    for column in CURVES:
        assert orders(found, column) == pytest.approx([power, power], rel=1e-9)
        assert overall_order(found, column) == pytest.approx(power, rel=1e-9)
    # The trough's own error goes with the power up to the shift of its place.
    endless = densities([made_up(10**6, power)])["physical"][0].feature("phase_trough_deg")[0]
    last = meshes[-1].feature("phase_trough_deg")[0]
    assert abs(limit(meshes, "phase_trough_deg", power) - endless) < 0.1 * abs(last - endless)
    text = report([made_up(rows, power) for rows in (8, 16, 32, 64)])
    assert f"physical: approaches a limit: over 4 meshes, order {power:.1f} in the rate" in text


def test_curves_that_run_away_have_no_limit() -> None:
    runs = [made_up(rows, -1.0) for rows in (8, 16, 32)]
    assert orders(steps(densities(runs)["physical"]), RATE) == pytest.approx([-1.0])
    assert math.isnan(limit(densities(runs)["physical"], "phase_trough_deg", -1.0))
    assert "no limit in sight: over 3 meshes, order -1.0 in the rate" in report(runs)
    slow = [made_up(rows, 1.0, shift=shift) for rows, shift in ((8, 0.0), (16, 0.1), (32, 0.0), (64, -0.175))]
    assert "- physical: undecided" in report(slow)


def test_meshes_of_no_common_ratio_give_no_order_by_threes() -> None:
    found = steps(densities([made_up(rows, 1.0) for rows in (8, 16, 24)])["physical"])
    assert math.isnan(orders(found, RATE)[0])


def test_the_mean_over_starts_stands_for_a_mesh_and_their_spread_for_its_noise() -> None:
    runs = [made_up(8, 1.0, k, shift) for k, shift in enumerate((-0.1, 0.1))] + [made_up(16, 1.0)]
    (step,) = steps(densities(runs)["physical"], until=0.4)
    times = np.linspace(0.0, 0.4, 2001)
    assert step.distance[PHASE] == pytest.approx(np.sqrt(np.mean((10 * np.sin(3 * times)) ** 2)), rel=1e-3)
    one = np.sqrt(np.mean((20 * 0.1 * np.sqrt(2) * np.sin(3 * times)) ** 2))
    # The finer mesh has one start: its spread is taken to be the coarser one's.
    assert step.noise[PHASE] == pytest.approx(one * math.hypot(1 / math.sqrt(2), 1), rel=1e-3)
    (alone,) = steps(densities([made_up(8, 1.0), made_up(16, 1.0)])["physical"])
    assert math.isnan(alone.noise[PHASE])
    assert "+-" not in report([made_up(8, 1.0), made_up(16, 1.0)])
    assert "+-" in report(runs)


def test_runs_are_kept_and_those_that_are_there_are_not_made_again(sail: Scene, tmp_path: Path) -> None:
    said: list[str] = []
    jobs = jobs_of([8], ["paper", "physical"], members=2, until=END)
    first = mesh_study(sail, jobs, tmp_path / "runs", tell=said.append)
    assert [(run.form, run.rows, run.member, run.node_count) for run in first] == [
        ("paper", 8, 0, 580), ("paper", 8, 1, 580), ("physical", 8, 0, 580), ("physical", 8, 1, 580),
    ]  # fmt: skip
    assert len(said) == 4
    assert all(run.stopped is None and abs(run.energy_error) < 0.05 for run in first)
    assert [len(run.table["time"]) for run in first] == [3] * 4
    files = {path: path.stat().st_mtime_ns for path in (tmp_path / "runs").iterdir()}
    assert len(files) == 4
    more = jobs_of([8], ["paper", "physical", "strain"], members=2, until=END)
    assert kept(sail, more, tmp_path / "runs") == jobs
    again = mesh_study(sail, jobs, tmp_path / "runs", workers=1)
    assert {path: path.stat().st_mtime_ns for path in (tmp_path / "runs").iterdir()} == files
    for a, b in zip(first, again, strict=True):
        assert replace(a, table={}) == replace(b, table={})
        np.testing.assert_array_equal(a.table["phase_difference_deg"], b.table["phase_difference_deg"])
    # Another sail is another run, though it has the same name.
    stiff = replace(sail, laws=[Springs(buckling=200.0), *sail.laws[1:]])
    mesh_study(stiff, jobs[:1], tmp_path / "runs")
    assert len(list((tmp_path / "runs").iterdir())) == 5


def test_what_cannot_be_refined_is_refused(sail: Scene, tmp_path: Path) -> None:
    crease = scenes.load("single-crease")
    refused(lambda: mesh_study(crease, jobs_of([8]), tmp_path), InputError, "no pattern in rows")
    refused(lambda: jobs_of([8], ["other"]), InputError, "must be one of paper, strain, physical, tension")
    refused(lambda: jobs_of([8], members=0), InputError, "members = 0: must be from 1 to")
    patch = replace(sail, parts=[*sail.parts, Region([0, 1], thickness=1e-5)])
    refused(lambda: mesh_study(patch, jobs_of([8]), tmp_path), InputError, r"parts.\d.triangles .* names triangles by")
    refused(lambda: mesh_study(sail, jobs_of([16, 9]), tmp_path / "runs"), InputError, "multiple of 8")
    assert not (tmp_path / "runs").exists()
    (tmp_path / "file").write_text("")
    refused(lambda: mesh_study(sail, jobs_of([8]), tmp_path / "file"), OutputError, "file")


def test_tables_curves_and_points_are_written(tmp_path: Path) -> None:
    runs = [
        made_up(rows, 1.0, member, form=form) for form in ("paper", "physical") for rows in (8, 16) for member in (0, 1)
    ]
    text = write_mesh_study(runs, tmp_path / "study")
    assert {path.name for path in (tmp_path / "study").iterdir()} == {
        "mesh-study.md", "mesh-study.png", "mesh-study.csv",
    }  # fmt: skip
    assert (tmp_path / "study" / "mesh-study.md").read_text() == text
    assert [line.split(" | ")[:2] for line in text.splitlines()[2:6]] == [
        ["| paper", "22"], ["| paper", "11"], ["| physical", "22"], ["| physical", "11"],
    ]  # fmt: skip
    points = (tmp_path / "study" / "mesh-study.csv").read_text().splitlines()
    assert points[0] == "form,rows,member,time,deployment_rate,phase_difference_deg"
    assert len(points) == 1 + 8 * 101


@pytest.mark.parametrize("words", [["mesh-study"], ["work-precision", "--mesh"], ["chart", "--mesh"]])
def test_the_command_and_its_other_name(words: list[str], tmp_path: Path) -> None:
    given = [*words, "okuizumi-model-1", "--rows", "8", "--until", "0.001", "--out", str(tmp_path / "study")]
    result = CliRunner().invoke(app, given)
    assert result.exit_code == 0, result.output
    assert "| physical | 22 | 580 | 1 |" in result.output
    assert len(list((tmp_path / "study" / "runs").iterdir())) == len(FORMS)
    wrong = CliRunner().invoke(app, [*given, "--rows", "8.5"])
    assert wrong.exit_code == 2
    assert "--rows = 8.5: must be whole numbers from 1 on" in wrong.output


def test_a_match_finds_the_value_that_the_target_has(sail: Scene, tmp_path: Path) -> None:
    coarse = replace(sail.mesh.source, rows=8).mesh()  # type: ignore[union-attr, type-var]
    target = replace(sail, mesh=coarse)
    said: list[str] = []
    found = match_scene(
        replace(target, laws=[Springs(buckling=20.0), *sail.laws[1:]]),
        "laws.springs.buckling",
        (20.0, 500.0),
        target,
        tmp_path,
        first=(20.0,),
        tries=7,
        until=0.01,
        tell=said.append,
    )
    assert 85.0 < found.best.value < 118.0
    worst = next(tried for tried in found.tried if tried.value == 20.0)
    assert worst.misfit > 10 * found.best.misfit
    table = found.table().splitlines()
    assert table[0].startswith("| laws.springs.buckling | distance of the rates")
    assert [float(line.split("|")[1]) for line in table[2:-1]] == sorted(tried.value for tried in found.tried)
    assert any("laws.springs.buckling = 20.0: misfit" in line for line in said)


def test_a_match_that_cannot_be_is_refused(sail: Scene, tmp_path: Path) -> None:
    def wrong(between: tuple[float, float] = (1.0, 2.0), starts: int = 2) -> None:
        match_scene(sail, "laws.springs.buckling", between, sail, tmp_path, starts=starts)

    refused(lambda: wrong((2.0, 1.0)), InputError, "two numbers above 0, the lower one first")
    refused(lambda: wrong((0.0, 1.0)), InputError, "two numbers above 0")
    refused(lambda: wrong(starts=1), InputError, "starts = 1")
