"""Crossings that are counted during a run, and told by the audit."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from membrane_rs import Mesh, OutputError, Scene, Simulation, folding, resume, scenes
from membrane_rs.check import audit
from membrane_rs.cli import app
from membrane_rs.folding import Strip
from membrane_rs.results import CrossingCounts, read_crossings
from membrane_rs.results.crossing_counts import CrossingsFile
from membrane_rs.results.record import Record
from observers import At
from typer.testing import CliRunner

END = 2e-3


@pytest.fixture(scope="module")
def scene() -> Scene:
    return scenes.load("okuizumi-model-1")


@pytest.fixture(scope="module")
def whole(scene: Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a short run that nobody stopped."""
    folder = tmp_path_factory.mktemp("runs") / "whole"
    Simulation(scene).run(END, frames=5, out=folder, crossings=True, pictures=False)
    return folder


def test_an_observer_counts_at_each_frame_or_sample(scene: Scene, whole: Path) -> None:
    sim, frames, samples = Simulation(scene), CrossingCounts(), CrossingCounts(samples=True)
    sim.run(END, frames=5, samples=9, observers=[frames, samples])
    counts = frames.table()
    assert counts["time"].tolist() == pytest.approx(np.linspace(0, END, 5))
    assert counts["crossing"][0] == 0
    assert counts["crossing"][-1] == sim.crossings(limit=0).count > 0
    assert samples.table()["crossing"][::2].tolist() == counts["crossing"].tolist()
    for name, values in read_crossings(whole).items():
        assert values.tolist() == counts[name].tolist()


def test_the_summary_tells_the_first_the_last_and_the_most(whole: Path) -> None:
    counts, summary = read_crossings(whole), json.loads((whole / "summary.json").read_text())
    most = int(np.argmax(counts["crossing"]))
    assert summary["request"]["crossings"] is True
    assert summary["crossings"] == {
        "first": counts["crossing"][0],
        "last": counts["crossing"][-1],
        "most": counts["crossing"][most],
        "time_of_most": counts["time"][most],
    }


def test_a_run_that_is_resumed_writes_the_same_file(scene: Scene, whole: Path, tmp_path: Path) -> None:
    folder = tmp_path / "stopped"

    def stop() -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        Simulation(scene).run(END, frames=5, out=folder, crossings=True, pictures=False, observers=[At(3, stop)])
    assert 1 <= len(read_crossings(folder)["time"]) < 5
    with (folder / "crossings.csv").open("a") as file:
        file.write("1.0,7,7,7\n0.5,3")
    resume(folder)
    assert (folder / "crossings.csv").read_bytes() == (whole / "crossings.csv").read_bytes()


def test_nothing_is_counted_unless_asked_for(tmp_path: Path) -> None:
    Simulation(scenes.load("spinning-tether")).run(1e-3, out=tmp_path / "run", pictures=False)
    assert not (tmp_path / "run" / "crossings.csv").exists()
    with pytest.raises(FileNotFoundError, match="--crossings"):
        read_crossings(tmp_path / "run")


def test_the_command_line_counts_them(tmp_path: Path) -> None:
    words = ["run", "single-crease", "--until", "0.001", "--frames", "2", "--no-pictures", "--crossings"]
    result = CliRunner().invoke(app, [*words, "--out", str(tmp_path / "run")])
    assert result.exit_code == 0, result.output
    assert read_crossings(tmp_path / "run")["crossing"].tolist() == [0, 0]


@pytest.mark.parametrize("text", ["", "time,crossing\n", "time,crossing,overlapping,touching\n0,x,0,0\n"])
def test_a_file_of_something_else_is_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "crossings.csv").write_text(text)
    with pytest.raises(OutputError, match=r"crossings\.csv"):
        read_crossings(tmp_path)


@pytest.mark.parametrize(("layout", "is_crossed"), [("ruled", False), ("equilateral", False), ("fan", True)])
def test_the_audit_tells_of_crossings_at_the_start(layout: str, is_crossed: bool) -> None:
    mesh = folding.SquareSail(layout=layout).mesh()  # type: ignore[arg-type]
    told = mesh.audit(growth=False).find("crossings")
    assert (told is not None) == is_crossed
    assert mesh.audit(growth=False, crossings=False).find("crossings") is None
    if told is not None:
        crossings = mesh.crossings(limit=1)
        assert (told.severity, told.count) == ("warning", crossings.count)
        assert f"first triangles {crossings.pairs[0, 0]} and {crossings.pairs[0, 1]} " in told.message


@pytest.mark.parametrize("columns", [10, 60])
def test_the_audit_of_a_scene_counts_in_small_meshes_always_and_in_large_ones_on_demand(columns: int) -> None:
    sheet = Strip(0.1, 0.04, columns, columns).mesh()
    flat = sheet.reference - sheet.reference.mean(axis=0)
    positions = np.concatenate([flat, flat[:, [0, 2, 1]] + np.array([1.0, 0.3, -0.7]) * 1e-3])
    triangles = np.concatenate([sheet.triangles, sheet.triangles + sheet.node_count])
    scene = Scene(Mesh(positions, triangles), scenes.load("single-crease").material)
    assert (audit(scene, costly=False).find("crossings") is None) == (len(triangles) > 5000)
    assert audit(scene).find("crossings") is not None


def test_the_count_at_the_instant_from_which_a_run_is_resumed_is_kept(tmp_path: Path) -> None:
    scene = scenes.load("single-crease")
    Simulation(scene).run(2e-3, frames=5, out=tmp_path / "whole", crossings=True, pictures=False)
    Simulation(scene).run(1e-3, frames=3, out=tmp_path / "part", crossings=True, pictures=False)
    sim = Simulation.restore(tmp_path / "part" / "state.npz")
    CrossingsFile().resume(sim, Record(tmp_path / "part"))
    assert read_crossings(tmp_path / "part")["time"][-1] == sim.time
    resume(tmp_path / "part", until=2e-3)
    whole, part = (read_crossings(tmp_path / name)["time"].tolist() for name in ("whole", "part"))
    assert part == whole == pytest.approx([0.0, 5e-4, 1e-3, 1.5e-3, 2e-3])
