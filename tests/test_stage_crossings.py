"""Crossings over a run in stages: the file, the observer and the picture, resumed too."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from membrane_rs import (
    InputError,
    InputTypeError,
    Mesh,
    OutputError,
    RunSettings,
    Scene,
    Simulation,
    SpringDamping,
    Springs,
    Stage,
    resume,
)
from membrane_rs.folding import Strip
from membrane_rs.plotting import plot_crossings
from membrane_rs.results import CrossingCounts, read_crossings, read_pvd, read_summary
from membrane_rs.results.vtk import read_frame
from observers import At
from PIL import Image
from small_scenes import RUBBER, rotation

STAGES = (
    Stage("hold", 2e-3, without=("spring_damping",), frames=3),
    Stage("drift", 3e-3, scale={"material.youngs_modulus": 0.5}, frames=7),
    Stage("back", 2e-3, frames=3),
)
SPEED = 10.0
"""Of the sheet that moves [m/s]."""


def crossed() -> Scene:
    """Two sheets, one across the other, in three stages."""
    sheet = Strip(0.1, 0.04, 6, 3).mesh()
    flat = sheet.reference - sheet.reference.mean(axis=0)
    positions = np.concatenate([flat, flat[:, [0, 2, 1]] @ rotation((0.0, 0.0, 1.0), 0.3) + [0.0101, 0.0017, 0.03]])
    mesh = Mesh(positions, np.concatenate([sheet.triangles, sheet.triangles + sheet.node_count]))
    run = RunSettings(samples=8, snapshots=(), dt=1e-5, integrator="leapfrog")
    return Scene(mesh, RUBBER, [Springs(), SpringDamping()], stages=STAGES, run=run, name="sheets")


def thrown(scene: Scene) -> Simulation:
    """A simulation in which one sheet flies through the other."""
    sim = Simulation(scene)
    start = np.zeros(sim.velocities.shape)
    start[len(start) // 2 :, 2] = -SPEED
    sim.velocities = start
    return sim


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, CrossingCounts]:
    """The folder of a run that nobody stopped, and the counts of an observer in it."""
    path, counts = tmp_path_factory.mktemp("runs") / "whole", CrossingCounts()
    thrown(crossed()).run(out=path, crossings=True, observers=[counts])
    return path, counts


def test_each_frame_of_each_stage_is_counted_once(run: tuple[Path, CrossingCounts]) -> None:
    path, observer = run
    found, mesh = read_crossings(path), crossed().mesh
    assert mesh is not None
    frames = read_pvd(path / "frames.pvd")
    assert found["time"].tolist() == [time for time, _ in frames] == observer.table()["time"].tolist()
    assert found["time"] == pytest.approx([0, 1e-3, 2e-3, 2.5e-3, 3e-3, 3.5e-3, 4e-3, 4.5e-3, 5e-3, 6e-3, 7e-3])
    shapes = [read_frame(path / file)[: mesh.node_count] for _, file in frames]
    for name, kind in (("crossing", "count"), ("overlapping", "overlapping"), ("touching", "touching")):
        counts = [getattr(mesh.crossings(shape, limit=0), kind) for shape in shapes]
        assert found[name].tolist() == counts == observer.table()[name].tolist()
    assert len(set(found["crossing"].tolist())) > 3


def test_summary_has_the_most_of_all_stages(run: tuple[Path, CrossingCounts]) -> None:
    path, _ = run
    found, summary = read_crossings(path), read_summary(path)["crossings"]
    most = int(found["crossing"].argmax())
    assert summary["most"] == found["crossing"][most] > 0
    assert summary["time_of_most"] == found["time"][most]


@pytest.mark.parametrize("frame", [1, 2, 3, 6, 8, 9])
def test_stopped_in_any_stage_and_resumed_it_is_the_same_file(
    frame: int, run: tuple[Path, CrossingCounts], tmp_path: Path
) -> None:
    """At a boundary between two stages too."""

    def stop() -> None:
        raise KeyboardInterrupt

    out = tmp_path / "run"
    with pytest.raises(KeyboardInterrupt):
        thrown(crossed()).run(out=out, crossings=True, observers=[At(frame, stop)])
    assert len(read_crossings(out)["time"]) < 11
    assert not (out / "crossings.png").exists()
    with (out / "crossings.csv").open("a") as file:
        file.write("1.0,7,7,7\n0.5,3")
    resume(out)
    for name in ("crossings.csv", "crossings.png"):
        assert (out / name).read_bytes() == (run[0] / name).read_bytes()


def test_observer_counts_the_rest_of_a_run_that_goes_on(run: tuple[Path, CrossingCounts]) -> None:
    sim, first, second = thrown(crossed()), CrossingCounts(), CrossingCounts()
    sim.run(until=3e-3, observers=[first])
    sim.run(observers=[first, second])
    whole = run[1].table()
    for name, values in whole.items():
        assert first.table()[name].tolist() == values.tolist()
        assert second.table()[name].tolist() == values[4:].tolist()


def test_picture_is_drawn_where_they_are_counted(run: tuple[Path, CrossingCounts], tmp_path: Path) -> None:
    with Image.open(run[0] / "crossings.png") as picture:
        assert picture.size == (1400, 680)
        assert len(picture.convert("RGB").getcolors(2**24) or ()) > 10
    thrown(crossed()).run(until=1e-3, out=tmp_path / "plain")
    assert not (tmp_path / "plain" / "crossings.png").exists()


@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
def test_counts_of_an_observer_are_drawn(run: tuple[Path, CrossingCounts], ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"counts.{ending}"
    plot_crossings(run[1].table(), path, "$thrown_", dpi=50)
    assert path.stat().st_size > 1000


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"time": [0.0, 1.0]}, "crossing"),
        ({"crossing": [0, 1]}, "time"),
        ({"time": [0.0, 1.0], "crossing": [0]}, "equal length"),
        ({"time": [[0.0]], "crossing": [[0]]}, "equal length"),
        ({"time": ["a"], "crossing": [0]}, "numbers"),
        ([0.0], "counts by name"),
    ],
)
def test_what_are_no_counts_is_refused(table: object, words: str, tmp_path: Path) -> None:
    with pytest.raises(InputTypeError, match=words):
        plot_crossings(table, tmp_path / "counts.png")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="format"):
        plot_crossings({"time": [0.0], "crossing": [0]}, tmp_path / "counts.jpg")
    with pytest.raises(OutputError):
        plot_crossings({"time": [0.0], "crossing": [0]}, tmp_path / "none" / "counts.png")
