"""`make bench`: every part stands, tables go where they belong, and what an earlier run left is not taken for new."""

from __future__ import annotations

import importlib
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import building
import kernels
import output
import page
import pytest

ROOT = Path(__file__).parent.parent
PARTS = re.search(r"PART_OF_BENCH := (.*)", (ROOT / "Makefile").read_text(encoding="utf-8"))


def test_every_part_has_a_script_that_writes_a_part_of_the_page() -> None:
    assert PARTS is not None
    for name in PARTS[1].split():
        part = importlib.import_module(name).PART
        assert part.page == page.README
        assert part.read(), name


def test_tables_are_shown_and_written_if_asked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    part = page.MarkedPart(tmp_path / "README.md", "a")
    part.page.write_text("<!-- a: begin -->\nold\n<!-- a: end -->\n")
    page.show(part, "shown only", write=False)
    assert "shown only" in capsys.readouterr().out
    assert part.read() == "old"
    page.show(part, "new", write=True)
    assert part.read() == "new"


def test_a_table_for_each_mesh_of_what_this_run_found(tmp_path: Path) -> None:
    found = [("evaluation", 2000, "all", "scalar", 80.0), ("evaluation", 2000, "all", "avx2", 20.0)]
    found += [("evaluation", 8000, "all", "scalar", 320.0), ("evaluation", 8000, "all", "avx2", 160.0)]
    found += [("evaluation", 2000, "gone", "avx2", 1.0), ("step", 2000, "rk4", "avx2", 100.0)]
    for what, nodes, row, column, microseconds in found:
        folder = tmp_path / f"{what}-{nodes}" / row / column / "new"
        folder.mkdir(parents=True)
        file = folder / "estimates.json"
        file.write_text(json.dumps({"median": {"point_estimate": 1e3 * microseconds}}))
        os.utime(file, (1.0, 1.0) if row == "gone" else (3.0, 3.0))
    tables = kernels.tables(kernels.medians(tmp_path, since=2.0))
    assert "gone" not in tables
    assert tables.index("| 2,000 nodes [us] | scalar | avx2 |") < tables.index("| 8,000 nodes [us] | scalar | avx2 |")
    assert "| evaluation: all | 80.0 | 20.0 (4.0x) |" in tables
    assert "| step: rk4 | - | 100.0 |" in tables
    assert "| evaluation: all, 8,000 nodes | 40.0 (1.0x) | 20.0 (2.0x) |" in tables


def test_steps_are_timed_without_peers_and_it_says_how_to_get_them() -> None:
    code = "import sys; sys.modules['mujoco'] = None; sys.argv = ['steps', '--quick']; import steps; steps.main()"
    shown = subprocess.run(
        [sys.executable, "-c", code], cwd=page.README.parent, capture_output=True, text=True, check=True
    )
    assert "| flat, springs: membrane_rs leapfrog |" in shown.stdout
    assert shown.stdout.count("`make peers` installs them") == 1
    assert "MuJoCo RK4" not in shown.stdout


def test_building_builds_a_sound_mesh_and_tells_each_part() -> None:
    times: building.Times = {}
    mesh = building.build(16, times)
    assert building.AIMS.keys() - times.keys() == {"import of membrane_rs"}
    shown = building.text(mesh, {**times, "import of membrane_rs": [0.1, 0.2, 0.4]})
    assert "1,836 nodes, 5,292 edges, 3,456 triangles, 756 creases." in shown
    assert "| import of membrane_rs | 0.20 | 0.3 |" in shown


def test_output_is_timed_with_a_folder_and_without_one(tmp_path: Path) -> None:
    case = output.CASES[0]
    times = [output.run(case, 0.001, folder) for folder in (None, tmp_path / "run")]
    assert all(found.wall > 0.0 for found in times)
    assert (tmp_path / "run" / "history.csv").is_file()
