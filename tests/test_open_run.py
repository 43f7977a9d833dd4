"""Runs read from folders: frames one at a time, units, an error for what is damaged; tables of other libraries."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import InputError, MembraneError, MissingFileError, OutputError, Run, Simulation, open_run, run, scenes
from membrane_rs._extras import EXTRAS
from membrane_rs.errors import MissingExtraError
from membrane_rs.results.history_table import HistoryTable, column_units
from membrane_rs.results.vtk import read_frame_data
from membrane_rs.scenes import names
from numpy.testing import assert_array_equal

TETHER = "spinning-tether"
UNITS = {"", "s", "deg", "rad", "rad/s", "m", "J", "W", "N", "N m", "kg m2/s", "Pa"}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run."""
    folder = tmp_path_factory.mktemp("made") / "run"
    run(
        "single-crease",
        2e-3,
        frames=3,
        samples=5,
        out=folder,
        pictures=False,
        record={"now": (lambda sim: sim.time, "s")},
    )
    return folder


@pytest.fixture
def folder(made: Path, tmp_path: Path) -> Path:
    """A copy of it to damage."""
    return Path(shutil.copytree(made, tmp_path / "run"))


@pytest.mark.parametrize("name", names())
def test_every_column_has_a_known_unit(name: str) -> None:
    columns = HistoryTable(Simulation(scenes.load(name))).columns
    units = column_units(columns, {})
    assert set(units.values()) <= UNITS
    without = {column for column, unit in units.items() if not unit}
    assert without <= {"deployment_rate", "energy_error", "stage"}


def test_frames_are_read_one_at_a_time(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[str] = []
    reader = read_frame_data

    def noted(path: Path, most: int) -> Any:
        read.append(path.name)
        return reader(path, most)

    monkeypatch.setattr("membrane_rs.runs.frames.read_frame_data", noted)
    opened = open_run(folder / "summary.json")
    assert (len(opened.frames), opened.frames.times.tolist(), read) == (3, [0.0, 1e-3, 2e-3], [])
    assert opened.frames[1].time == 1e-3
    assert read == ["frame-0001.vtu"]


def test_a_killed_run_is_read_as_far_as_it_came(folder: Path) -> None:
    summary = json.loads((folder / "summary.json").read_text())
    (folder / "summary.json").write_text(json.dumps({"outcome": "running", "request": summary["request"]}))
    history = (folder / "history.csv").read_text().splitlines(keepends=True)
    (folder / "history.csv").write_text("".join(history[:3]) + "0.00")
    opened = open_run(folder)
    assert (opened.outcome, opened.history.sample_count, len(opened.frames)) == ("killed", 2, 3)
    for name in ("history.csv", "frames.pvd"):
        (folder / name).unlink()
    (folder / "summary.json").write_text(json.dumps({"outcome": "running", "request": summary["request"], "time": 1.0}))
    with pytest.raises(MissingFileError, match=r"history\.csv, though summary.json says: the run came to 1 s"):
        open_run(folder)
    (folder / "summary.json").write_text(json.dumps({"outcome": "running", "request": summary["request"]}))
    opened = open_run(folder)
    assert (opened.history.sample_count, len(opened.frames)) == (0, 0)
    assert "Run of single-crease" in opened._repr_html_()
    assert len(opened.to_pandas()) == 0


def test_a_run_that_has_not_begun_says_so(folder: Path) -> None:
    (folder / "scene.toml").unlink()
    with pytest.raises(MissingFileError, match=r"no scene at .*scene\.toml: the run has not come to its first step"):
        open_run(folder)


def damaged(name: str, change: Callable[[str], str]) -> Callable[[Path], None]:
    """What changes the text of a file."""

    def damage(folder: Path) -> None:
        (folder / name).write_text(change((folder / name).read_text(errors="replace")))

    return damage


def linked_to_itself(file: Path) -> None:
    """Put a link without an end in place of a file."""
    file.unlink()
    file.symlink_to(file.name)


@pytest.mark.parametrize(
    "damage",
    [
        damaged("summary.json", lambda _: "[]"),
        damaged("summary.json", lambda text: text.replace('"now": "s"', '"now": 3')),
        damaged("summary.json", lambda text: text.replace('"record": {', '"record": 3, "other": {')),
        damaged("scene.toml", lambda _: "a = ["),
        damaged("history.csv", lambda _: "a,b\n1,2\n"),
        damaged("history.csv", lambda text: text.replace("hub_angle", "hub_angel", 1)),
        damaged("frames.pvd", lambda _: "<html/>"),
        damaged("frames.pvd", lambda text: text.replace("frames/frame-0001.vtu", "../../other.vtu")),
        damaged("frames.pvd", lambda text: text.replace("frames/frame-0001.vtu", "/etc/passwd")),
        damaged("frames.pvd", lambda text: text.replace('timestep="0.001"', 'timestep="soon"')),
        damaged("frames.pvd", lambda text: text.replace('timestep="0.001"', 'timestep="nan"')),
        damaged("frames.pvd", lambda text: text.replace('timestep="0.001"', 'timestep="3.0"')),
        damaged("history.csv", lambda text: "\n".join([text.split("\n", 1)[0], *text.split("\n")[:0:-1]])),
        damaged("history.csv", lambda text: text.replace("\n0.0005,", "\nnan,")),
        lambda folder: (folder / "scene.toml").unlink(),
        lambda folder: linked_to_itself(folder / "frames/frame-0001.vtu"),
        lambda folder: (folder / "summary.json").unlink(),
    ],
)
def test_a_damaged_folder_is_refused(folder: Path, damage: Callable[[Path], None]) -> None:
    damage(folder)
    with pytest.raises(MembraneError, match=r"run|scene"):
        open_run(folder)


@pytest.mark.parametrize(
    "damage",
    [
        damaged("frames/frame-0001.vtu", lambda _: "no"),
        damaged("frames/frame-0001.vtu", lambda text: text.replace("velocity", "velocitx")),
        damaged("frames/frame-0001.vtu", lambda text: text[: len(text) // 2]),
        lambda folder: (folder / "frames/frame-0001.vtu").unlink(),
        lambda folder: (
            run(TETHER, 1e-3, frames=2, samples=2, out=folder / "other", pictures=False)
            and shutil.copy(folder / "other/frames/frame-0001.vtu", folder / "frames/frame-0001.vtu")
        ),
    ],
)
def test_a_damaged_frame_is_refused_and_others_are_read(folder: Path, damage: Callable[[Path], None]) -> None:
    damage(folder)
    opened = open_run(folder)
    with pytest.raises((OutputError, MissingFileError), match=r"frame-0001\.vtu"):
        opened.frames[1]
    assert opened.frames[2].time == 2e-3


def test_what_is_no_path_is_refused() -> None:
    for wrong in (3, "", None, "\0"):
        with pytest.raises(InputError):
            open_run(wrong)  # type: ignore[arg-type]


def same_tables(result: Run) -> None:
    table, data = result.to_pandas(), result.to_xarray()
    assert table.index.name == "time"
    assert table.attrs["units"] == dict(result.history.units)
    for name in (name for name in result.history if name != "time"):
        assert_array_equal(table[name].to_numpy(), result.history[name])
        assert_array_equal(data[name].values, result.history[name])
        assert data[name].attrs["units"] == result.history.units[name]
    assert data["positions"].dims == ("frame_time", "node", "axis")
    for k, frame in enumerate(result.frames):
        assert_array_equal(data["positions"].values[k], frame.positions)
        assert float(data["frame_hub_angle"][k]) == frame.hub_angle
    assert "positions" not in result.to_xarray(frames=False)


def test_tables_of_other_libraries(made: Path) -> None:
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    same_tables(open_run(made))
    same_tables(run(TETHER, 1e-3, frames=2, samples=3))
    with pytest.raises(InputError, match="'node' is the name of a recorded measure too"):
        run(TETHER, 1e-3, frames=2, samples=2, record={"node": lambda _: 1.0}).to_xarray()


def test_a_frame_as_a_mesh_of_pyvista(made: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    frame = open_run(made).frames[-1]
    mesh = frame.to_pyvista()
    assert isinstance(mesh, pyvista.PolyData)
    assert_array_equal(mesh.points, frame.positions)
    assert_array_equal(mesh.regular_faces, frame.triangles)
    lines = len(frame.lines)
    assert_array_equal(mesh.lines.reshape(-1, 3)[:, 1:], frame.lines)
    assert_array_equal(mesh.cell_data["von_mises"][lines:], frame.on_triangles["von_mises"])
    assert_array_equal(mesh.cell_data["spring_strain"][:lines], frame.on_lines["spring_strain"])
    assert np.isnan(mesh.cell_data["spring_strain"][lines:]).all()
    assert_array_equal(mesh.point_data["velocity"], frame.velocities)


@pytest.mark.parametrize(("library", "call"), [("pandas", Run.to_pandas), ("xarray", Run.to_xarray)])
def test_a_missing_library_is_named_with_its_extra(
    library: str, call: Callable[[Run], Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    result = run(TETHER, 1e-3, frames=2, samples=2)
    monkeypatch.setitem(__import__("sys").modules, library, None)
    with pytest.raises(MissingExtraError, match=rf"membrane_rs\[{EXTRAS[library]}\]"):
        call(result)


def test_tables_are_copies_and_histories_are_read_only(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    result = run(TETHER, 1e-3, frames=2, samples=3)
    before = result.history["kinetic_energy"].tolist()
    table, data = result.to_pandas(), result.to_xarray()
    table.loc[:, "kinetic_energy"] = 3.0
    data["kinetic_energy"].values[:] = 3.0
    assert result.history["kinetic_energy"].tolist() == before
    for column in (result.history["kinetic_energy"], result.frames.times):
        with pytest.raises(ValueError, match="read-only"):
            column[0] = 3.0
    monkeypatch.setattr("membrane_rs.runs.tables.MOST_BYTES", 2 * 11 * 24 - 1)
    with pytest.raises(InputError, match=r"positions of 2 of 11 nodes are .* GB, more than .*; give frames=False"):
        result.to_xarray()
    assert "positions" not in result.to_xarray(frames=False)


def test_a_column_at_a_time_is_that_of_a_sample_or_between_two() -> None:
    history = run(TETHER, 1e-3, frames=2, samples=3).history
    times, angles = history["time"], history["hub_angle"]
    assert [history.at(time, "hub_angle") for time in times] == angles.tolist()
    assert history.at(0.25 * times[1], "hub_angle") == pytest.approx(0.25 * angles[1])
