"""The map of step against a parameter: outcomes, files, command line."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import pytest
from membrane_rs import InputError
from membrane_rs.cli import app
from membrane_rs.study.stability import Cell, explicit_integrators, stability_map, write_map
from small_scenes import hanging_strip, refused
from typer.testing import CliRunner

RATIO = "laws.spring_damping.ratio"


@pytest.fixture(scope="module")
def cells() -> list[Cell]:
    return stability_map(hanging_strip(), RATIO, [0.02, 5.0], methods=["rk4"], shares=[0.3, 0.9, 1.2, 200], until=0.2)


def test_outcomes_follow_the_predicted_limit(cells: list[Cell]) -> None:
    assert [(cell.value, cell.outcome) for cell in cells[:3:2]] == [(0.02, "fine"), (0.02, "energy injected")]
    by_share = [cell.outcome for cell in cells[:4]]
    assert by_share[0] == by_share[1] == "fine"
    assert by_share[3] == "refused"
    for cell in cells:
        assert (cell.outcome in ("fine", "inaccurate")) == (cell.dt < cell.limit), cell
    caught = cells[2]
    assert 0 < caught.time < 0.2
    assert "stability limit" in caught.message
    # With a ratio of 5 the dashpots bring the limit down, and with it the steps that are fine.
    assert cells[4].limit < 0.3 * cells[0].limit


def test_cells_do_not_depend_on_the_number_of_jobs(cells: list[Cell]) -> None:
    shown: list[Cell] = []
    options: dict[str, Any] = {"methods": ["rk4"], "shares": [0.3, 0.9, 1.2, 200], "until": 0.2, "jobs": 1}
    assert list(map(str, stability_map(hanging_strip(), RATIO, [0.02, 5.0], progress=shown.append, **options))) == list(
        map(str, cells)
    )
    assert list(map(str, shown)) == list(map(str, cells))
    refused(
        lambda: stability_map(hanging_strip(), RATIO, [0.02], **{**options, "jobs": 0}), InputError, "jobs = 0: must be"
    )


def test_files(cells: list[Cell], tmp_path: Path) -> None:
    paths = write_map(cells, RATIO, tmp_path / "map", "strip")
    assert [path.name for path in paths] == ["stability.csv", "stability-rk4.png"]
    rows = list(csv.DictReader(paths[0].read_text().splitlines()))
    assert len(rows) == len(cells)
    assert rows[0][RATIO] == "0.02"
    assert paths[1].read_bytes().startswith(b"\x89PNG")


def test_methods_with_a_limit() -> None:
    assert "rk4" in explicit_integrators(hanging_strip())


def test_nothing_to_run() -> None:
    refused(
        lambda: stability_map(hanging_strip(), RATIO, [], methods=["rk4"]), InputError, "values = .*give at least one"
    )


def test_command(tmp_path: Path) -> None:
    words = ["stability", "single-crease", "--values", "0,0.1", "--steps", "0.5,1.5", "--integrators", "rk4"]
    result = CliRunner().invoke(app, [*words, "--jobs", "1", "--until", "0.002", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    assert "of the limit)" in result.output
    assert (tmp_path / "stability.csv").is_file()
    wrong = CliRunner().invoke(app, ["stability", "single-crease", "--values", "0,a"])
    assert (wrong.exit_code, "separated by commas" in wrong.output) == (2, True)
