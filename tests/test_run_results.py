"""Results in memory: the same arrays as those of a folder, to the bit, read in the same way."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import InputError, MembraneError, Run, Simulation, Stage, UnstableError, open_run, run, scenes
from membrane_rs.runs import RunFrame
from numpy.testing import assert_array_equal
from small_scenes import hanging_strip

FIELDS = ("on_nodes", "on_triangles", "on_lines")


def staged() -> Any:
    """A strip with two stages."""
    return replace(hanging_strip(), stages=[Stage("fall", 2e-3), Stage("damped", 2e-3, without=("gravity",))])


def assert_same_frame(one: RunFrame, other: RunFrame) -> None:
    assert (one.time, one.hub_angle, one.stage) == (other.time, other.hub_angle, other.stage)
    for name in ("positions", "velocities", "triangles", "lines"):
        assert_array_equal(getattr(one, name), getattr(other, name))
    for name in FIELDS:
        fields, others = getattr(one, name), getattr(other, name)
        assert list(fields) == list(others)
        for field, values in fields.items():
            assert values.dtype == others[field].dtype
            assert_array_equal(values, others[field])


@pytest.mark.parametrize("scene", ["spinning-tether", "single-crease", "spinning-disc", staged()])
def test_memory_and_folder_hold_the_same_arrays(scene: Any, tmp_path: Path) -> None:
    wanted: dict[str, Any] = {"until": 4e-3, "frames": 4, "samples": 7}
    kept = run(scene, **wanted)
    written = run(scene, **wanted, out=tmp_path / "run", pictures=False)
    assert kept.path is None
    assert written.path == tmp_path / "run"
    assert dict(kept.history.units) == dict(written.history.units)
    assert list(kept.history) == list(written.history)
    for name, column in kept.history.items():
        assert_array_equal(column, written.history[name])
    assert_array_equal(kept.frames.times, written.frames.times)
    for one, other in zip(kept.frames, written.frames, strict=True):
        assert_same_frame(one, other)
    times = {"process", "wall_time", "stage_starts", "stages"}
    assert kept.summary.keys() == written.summary.keys()
    assert all(kept.summary[key] == written.summary[key] for key in kept.summary.keys() - times)
    assert [stage["end"] for stage in kept.stages] == [stage["end"] for stage in written.stages]
    assert (kept.mesh is None) == (written.mesh is None)


def test_frames_show_the_instants_of_the_simulation() -> None:
    sim, result = Simulation(scenes.load("spinning-tether")), run("spinning-tether", 2e-3, frames=3, samples=2)
    for frame in result.frames:
        sim.reach(frame.time)
        assert_array_equal(frame.positions, sim.positions)
        assert_array_equal(frame.on_nodes["velocity"], sim.velocities)
        assert frame.hub_angle == sim.hub_angle


def test_a_frame_at_a_boundary_is_of_the_stage_that_begins() -> None:
    frames = run(staged(), 4e-3, frames=5, samples=5).frames
    assert [(frame.time, frame.stage) for frame in frames] == [(0.0, 0), (1e-3, 0), (2e-3, 1), (3e-3, 1), (4e-3, 1)]


@pytest.mark.parametrize("dt", [1.4e-5, 1.6e-5])
def test_an_unstable_run_keeps_what_it_had_recorded(dt: float, tmp_path: Path) -> None:
    """Each shape once, also where the last good one is that of the start."""
    for out in (None, tmp_path / "run"):
        with pytest.raises(UnstableError) as caught:
            run("single-crease", 0.1, dt=dt, frames=2, samples=1001, out=out)
        result = caught.value.run
        assert isinstance(result, Run)
        assert result.outcome.startswith("unstable: ")
        assert result.history.sample_count >= 1
        assert np.isfinite(result.frames[-1].positions).all()
        assert (np.diff(result.frames.times) > 0.0).all()
        assert pickle.loads(pickle.dumps(caught.value)).run is None


def test_what_is_not_there_is_refused() -> None:
    result = run("spinning-tether", 1e-3, frames=2, samples=2)
    with pytest.raises(InputError, match="did you mean 'hub_angle'"):
        result.history["hub_angel"]
    with pytest.raises(IndexError, match="there are 2"):
        result.frames[2]
    with pytest.raises(KeyError):
        result.history["no such"]
    assert result.history.get("no such") is None
    assert [frame.time for frame in result.frames[::-1]] == [1e-3, 0.0]
    assert result.frames.near(0.9e-3).time == 1e-3


def test_more_frames_than_memory_holds_are_refused() -> None:
    with pytest.raises(InputError, match="give out="):
        run("okuizumi-model-1", frames=100_000)


def test_more_samples_than_memory_holds_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    columns = len(run("spinning-tether", 1e-3, samples=2, frames=2).history)
    monkeypatch.setattr("membrane_rs.runs.memory.MOST_BYTES", 1000 * columns * 24)
    assert run("spinning-tether", 1e-3, samples=1000, frames=2).history.sample_count == 1000
    with pytest.raises(InputError, match=rf"samples: 1001 of {columns} numbers each are more than .* ask for fewer"):
        run("spinning-tether", 1e-3, samples=1001, frames=2)


def test_a_run_that_was_refused_leaves_no_result(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        run("spinning-tether", -1.0)
    assert caught.value.run is None
    with pytest.raises(FileNotFoundError):
        open_run(tmp_path)


def test_a_run_that_was_refused_has_not_the_results_of_an_earlier_one(tmp_path: Path) -> None:
    run("spinning-tether", 1e-3, frames=2, samples=2, out=tmp_path / "run", pictures=False)
    for until in (2e-3, -1.0):  # the folder is not empty; the time is none
        with pytest.raises(MembraneError) as caught:
            run("spinning-tether", until, out=tmp_path / "run", pictures=False)
        assert caught.value.run is None
    with pytest.raises(UnstableError) as ended:
        run("single-crease", 0.1, dt=1.6e-5, frames=2, out=tmp_path / "run", overwrite=True, pictures=False)
    assert ended.value.run.scene.name == "single-crease"


def test_options_of_a_folder_without_one_are_refused() -> None:
    for option in ({"overwrite": True}, {"crossings": True}, {"pictures": False}, {"checkpoint": 1.0}):
        with pytest.raises(InputError, match=f"{next(iter(option))} = .*without out nothing is written"):
            run("spinning-tether", 1e-3, **option)


@pytest.mark.parametrize("wrong", [True, 1, 3.0, "a", 10**8])
def test_what_is_no_number_of_frames_is_refused(wrong: Any) -> None:
    for every in (None, 5e-4):
        with pytest.raises(InputError, match=f"frames = {wrong!r}: must be"):
            run("spinning-tether", 1e-3, frames=wrong, every=every)
