"""Pictures of a run in stages: sheets for each, a camera that follows, and files that are the run's own."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_simulation import small_sail
from killed_runs import contents
from membrane_rs import Cylinder, Fixed, Schedule, Simulation, Stage
from membrane_rs.plotting import animation
from membrane_rs.plotting.animation import NEARBY, Picture, smoothed, write_animation
from membrane_rs.plotting.sheets import OF_STAGE, contact_sheet, stage_prefix
from membrane_rs.results import read_pvd
from membrane_rs.results.vtk import read_frame
from membrane_rs.runs import RunFolder, resume
from PIL import Image

STAGES = (
    Stage("Hold: still", 2e-4, frames=8),
    Stage("let go", 4e-4, without=("bars", "hold"), frames=4),
)
TIMES = (0.0, 1e-4, 2e-4, 3e-4, 4e-4, 5e-4, 6e-4)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Simulation, Path]:
    scene = small_sail(snapshots=TIMES, frames=2, samples=13, dt=2e-6, integrator="leapfrog")
    bars = Cylinder("bars", 0.004, centre=(0.12, 0.0, 0.0), copies=4, turn=Schedule((0.0, 2e-4), (0.0, 0.02)))
    parts = [*scene.parts, Fixed((0, 1), name="hold")]
    sim = Simulation(replace(scene, bodies=[bars], parts=parts, stages=STAGES))
    path = tmp_path_factory.mktemp("runs") / "run"
    told: list[tuple[int, int]] = []
    sim.run(observers=[RunFolder(path, progress=lambda _, done, count: told.append((done, count)))])
    assert told == [(k, told[-1][0]) for k in range(1, told[-1][0] + 1)]
    return sim, path


def test_each_stage_has_its_sheets_and_its_times(run: tuple[Simulation, Path]) -> None:
    _, path = run
    found = {file.name for file in (path / "snapshots").iterdir()}
    expected = {f"{view}.png" for view in ("turning", "fixed")}
    # The first comes to fewer snapshots than four, so frames are spread over it; both ends are there.
    frames = [time for time, _ in read_pvd(path / "frames.pvd") if time <= 2e-4]
    assert len(frames) == 8
    spread = [frames[k] for k in (0, 1, 3, 4, 6, 7)]
    for prefix, times, digits in (("00-hold-still-", spread, 5), ("01-let-go-", TIMES[2:], 4)):
        for view in ("turning", "fixed"):
            expected |= {f"{prefix}{view}.png", *(f"{prefix}{view}-{time:.{digits}f}s.png" for time in times)}
    assert found == expected
    with Image.open(path / "snapshots" / "turning.png") as sheet, Image.open(path / "animation.gif") as film:
        assert sheet.width == 5 * 360
        # 6 and 5 pictures, that at the boundary once.
        assert sheet.height < 56 + 3 * 440
        assert sheet.height > 56 + 2 * 360
        assert getattr(film, "n_frames", 1) == 11


def test_the_files_are_its_own(run: tuple[Simulation, Path], tmp_path: Path) -> None:
    sim, path = run[0], tmp_path / "run"
    shutil.copytree(run[1], path)
    others = ["snapshots/mine-turning.png", "snapshots/turning-mine.png", "snapshots/00-mine.png"]
    for name in others:
        (path / name).write_bytes(b"mine")
    assert set((path / "snapshots").glob(f"{OF_STAGE}turning.png")) == {
        path / "snapshots" / f"{prefix}turning.png" for prefix in ("00-hold-still-", "01-let-go-")
    }
    Simulation(sim.scene).run(1e-5, out=path, overwrite=True, pictures=False)
    assert sorted(file.name for file in (path / "snapshots").iterdir()) == sorted(Path(name).name for name in others)


def test_a_resumed_run_draws_the_same(tmp_path: Path) -> None:
    scene = small_sail(snapshots=TIMES, frames=2, samples=13, dt=2e-6, integrator="leapfrog")
    stages = (Stage("one", 2e-4, frames=5), Stage("two", 2e-4, frames=3))
    scene = replace(scene, stages=stages)
    whole, part = tmp_path / "whole", tmp_path / "part"
    Simulation(scene).run(out=whole, frames=5, samples=5)
    Simulation(scene).run(3e-4, out=part, frames=4, samples=4)
    resume(part, 4e-4)
    pictures = [{name: data for name, data in contents(path).items() if "snapshots" in name} for path in (whole, part)]
    assert pictures[0]
    assert pictures[0].keys() == pictures[1].keys()
    assert pictures[0] == pictures[1]


@pytest.mark.parametrize(
    ("index", "name", "prefix"),
    [
        (0, "settle in the roll", "00-settle-in-the-roll-"),
        (7, "../../etc/passwd\\*?[0-9]", "07-etc-passwd-0-9-"),
        (99, "広げる", "99-stage-"),
        (3, "x" * 100, f"03-{'x' * 40}-"),
    ],
)
def test_names_of_files(index: int, name: str, prefix: str) -> None:
    assert stage_prefix(index, name) == prefix


def test_the_camera_follows_slowly_and_sees_all() -> None:
    reaches = [*np.full(40, 0.03), *np.linspace(0.03, 0.3, 60), *np.full(60, 0.32)]
    found = smoothed(reaches)
    assert len(found) == len(reaches)
    assert all(seen >= reach * (1.0 - 1e-12) for seen, reach in zip(found, reaches, strict=True))
    assert found[0] == pytest.approx(0.03)
    assert found[-1] == pytest.approx(0.32)
    steps = np.abs(np.diff(np.log(found)))
    assert steps.max() < np.log(0.32 / 0.03) / NEARBY
    assert smoothed([0.1]) == pytest.approx([0.1])
    assert smoothed([0.0, 0.0]) == pytest.approx([0.0, 0.0])


def test_a_large_animation_takes_fewer_colours(
    run: tuple[Simulation, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, path = run
    frames = [Picture((time, file), label="stage") for time, file in read_pvd(path / "frames.pvd")[:2]]
    noise = np.random.default_rng(1).integers(0, 255, (480, 480, 3), dtype=np.uint8)

    class Noisy:
        def paint(self, positions: Any, turn: Any = 0.0, around: Any = None) -> Any:
            return noise

        def close(self) -> None:
            pass

    assert read_frame(frames[0].frame[1]).shape[1] == 3
    sizes = []
    for most in (10**9, 100):
        monkeypatch.setattr(animation, "MOST_BYTES", most)
        write_animation(tmp_path / "a.gif", frames, Noisy(), lambda: None)
        sizes.append((tmp_path / "a.gif").stat().st_size)
    assert sizes[1] < 0.8 * sizes[0]


def test_six_pictures_are_two_rows_of_three() -> None:
    images = [np.zeros((70, 70, 3), dtype=np.uint8)] * 6
    one = contact_sheet(images[:1], [""], "")
    assert contact_sheet(images, [""] * 6, "").shape[1] == 3 * one.shape[1]
    assert contact_sheet(images[:1], ["(a)\nname"], "").shape[0] > one.shape[0]
