"""Studies of scenes with a free hub: methods that do not move it are left out, and named by the keys of the scene."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from membrane_rs import InputError, RunSettings, Scene, Simulation, Spin, Tether, integrators
from membrane_rs.scene.parts import Moved
from membrane_rs.scene.schedule import Schedule
from membrane_rs.study import work_precision
from membrane_rs.study.common.methods import methods_of
from membrane_rs.study.stability import explicit_integrators, stability_map, write_map
from membrane_rs.study.variants import variants
from small_scenes import refused
from test_cli import call

MOVE = ["rk4", "leapfrog"]
"""Methods that move a free hub."""
TETHER = Tether((0.1, 0.0, 0.0), (0.2, 0.0, 0.0), 2, 17.0, 1e-3, tip_mass=0.05, strain_limit=10.0)
FREE = Scene(None, None, [Spin(2.0, inertia=0.01)], [TETHER], run=RunSettings(until=0.01), name="free")
DRIVEN = replace(FREE, laws=[Spin(2.0)])
KEY = "parts.0.tip_mass"


def test_methods_that_do_not_move_a_free_hub_are_left_out_with_the_reason() -> None:
    fitting, left_out = methods_of(FREE, integrators())
    assert sorted(fitting) == sorted(MOVE)
    assert {*fitting, *left_out} == {*integrators()}
    assert left_out["dopri5"].startswith("run.integrator = 'dopri5': does not go with a free hub; take leapfrog or rk4")
    assert "leave laws.spin.inertia out" in left_out["dopri5"]
    assert methods_of(DRIVEN, integrators()) == (list(integrators()), {})
    refused(
        lambda: methods_of(FREE, ["dopri5", "generalized_alpha"]), InputError, "run.integrator = 'dopri5': does not"
    )


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"run.integrator": "generalized_alpha"}, "run.integrator = 'generalized_alpha': does not go with a free hub"),
        ({"run.integrator": "leapfrog", "run.substeps": 3}, "run.substeps = 3: does not go with a free hub; take one"),
    ],
)
def test_what_a_free_hub_excludes_is_named_by_its_key(values: dict[str, Any], words: str) -> None:
    refused(lambda: Simulation(FREE.with_values(values)), InputError, words)


def test_moved_nodes_are_named_as_the_parts_that_they_are() -> None:
    moved = replace(FREE, parts=[TETHER, Moved("tether-0-start", x=Schedule((0.0, 1.0), (0.0, 0.01)))])
    refused(lambda: Simulation(moved), InputError, "parts of kind 'moved': does not go with a free hub; move bodies")


def test_a_stability_map_has_a_refused_cell_for_a_method_that_does_not_fit(tmp_path: Path) -> None:
    assert explicit_integrators(FREE) == explicit_integrators(DRIVEN)
    told: list[Any] = []
    cells = stability_map(
        FREE, KEY, [0.05, 0.1], methods=["leapfrog", "dopri5"], shares=[0.5], until=0.002, progress=told.append
    )
    outcomes = [(cell.integrator, cell.value, cell.outcome) for cell in cells]
    assert outcomes == [
        ("dopri5", 0.05, "refused"),
        ("dopri5", 0.1, "refused"),
        ("leapfrog", 0.05, "fine"),
        ("leapfrog", 0.1, "fine"),
    ]
    assert len(told) == 4
    assert math.isnan(cells[0].dt)
    files = write_map(cells, KEY, tmp_path)
    assert [file.name for file in files] == ["stability.csv", "stability-leapfrog.png"]
    rows = list(csv.DictReader((tmp_path / "stability.csv").open(encoding="utf-8")))
    assert rows[0]["message"].startswith("run.integrator = 'dopri5'")
    refused(lambda: stability_map(FREE, KEY, [0.1], methods=["dopri5"]), InputError, "run.integrator = 'dopri5'")


def test_a_work_precision_diagram_says_which_methods_it_leaves_out(tmp_path: Path) -> None:
    found = work_precision(FREE, until=0.002, steps=2, instants=2, repeats=1)
    assert sorted(found.orders) == sorted(MOVE)
    assert sorted(found.left_out) == sorted({*integrators()} - {*MOVE})
    assert "Left out: dopri5. run.integrator = 'dopri5': does not go with a free hub" in found.summary()
    found.save(tmp_path)
    rows = list(csv.DictReader((tmp_path / "chart.csv").open(encoding="utf-8")))
    last = {row["integrator"]: row for row in rows if row["failure"] and not row["dt"]}
    assert {name: row["failure"] for name, row in last.items()} == found.left_out
    assert all(None not in row and None not in row.values() for row in rows)
    assert json.loads((tmp_path / "chart.json").read_text())["left_out"] == found.left_out
    plain = work_precision(DRIVEN, ["rk4"], until=0.002, steps=2, instants=2, repeats=1)
    assert plain.left_out == {}
    assert "Left out" not in plain.summary()


def test_commands_say_it_in_a_line(tmp_path: Path) -> None:
    (tmp_path / "free.toml").write_text(FREE.to_toml())
    words = [
        "--parameter",
        KEY,
        "--values",
        "0.1",
        "--steps",
        "0.5",
        "--until",
        "0.001",
        "--out",
        str(tmp_path / "map"),
    ]
    code, shown = call("stability", str(tmp_path / "free.toml"), *words)
    assert code == 0
    assert f"{KEY} = 0.1        refused: run.integrator = 'dopri5': does not go with a free hub" in shown
    code, shown = call("run", str(tmp_path / "free.toml"), "--integrator", "dopri5", "--out", str(tmp_path / "run"))
    assert code != 0
    assert "run.integrator = 'dopri5': does not go with a free hub" in shown


def test_variants_of_a_free_hub_are_made() -> None:
    names = {variant.name: variant.scene for variant in variants(FREE)}
    assert names["law spin"] is not None
    assert names["all but 1 of 2 segments in part tether"] is not None
