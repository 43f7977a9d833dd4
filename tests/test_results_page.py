"""docs/results.md lists the columns of the history with their units, and the fields of frames."""

from __future__ import annotations

import re

import membrane_rs
from documented import ROOT
from membrane_rs import scenes
from membrane_rs.results import frame_fields
from membrane_rs.results.history_table import column_units
from staged_scenes import free, oscillator

TEXT = (ROOT / "docs" / "results.md").read_text(encoding="utf-8")


def rows(heading: str) -> list[list[str]]:
    """The cells of the table below a heading, without its two first lines."""
    table = TEXT.partition(f"### {heading}\n")[2].partition("\n#")[0]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in re.findall(r"^\|.*$", table, re.M)][2:]


def test_columns_have_the_units_of_the_history() -> None:
    listed = {cells[0].strip("`"): cells[1] for cells in rows("Columns of the history")}
    of_laws = {"energy_<law>": "energy_springs", "work_<law>": "work_springs"}
    assert listed == {name: column_units([of_laws.get(name, name)], {})[of_laws.get(name, name)] for name in listed}


def test_all_columns_of_runs_are_listed() -> None:
    sail = membrane_rs.run("okuizumi-model-1-triangles", until=1e-5, frames=2, samples=2)
    staged = membrane_rs.run(oscillator(free("one", 0.01), free("two", 0.01)))
    whirled = membrane_rs.run(
        scenes.load("spinning-tether").with_values({"laws.spin.inertia": 0.01}), until=1e-3, samples=2
    )
    flown = membrane_rs.run("nutating-hub", until=0.01, samples=2)
    named = [*sail.history, *staged.history, *whirled.history, *flown.history]
    of_laws = {re.sub(r"^(energy|work)_(?!of_changes|error).*", r"\1_<law>", name) for name in named}
    assert of_laws == {cells[0].strip("`") for cells in rows("Columns of the history")}


def test_fields_are_those_of_frames() -> None:
    places = {"nodes": frame_fields.ON_NODES, "triangles": frame_fields.ON_TRIANGLES, "lines": frame_fields.ON_LINES}
    listed = [(name, cells[1]) for cells in rows("Fields of a frame") for name in re.findall(r"`(\w+)`", cells[0])]
    assert listed == [(name, place) for place, names in places.items() for name in names]
