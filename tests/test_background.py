"""Frames are written while the core steps: none is lost, none is wrong, and what fails is told."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from fake_simulation import FakeSimulation
from membrane_rs import OutputError, Simulation, UnstableError, scenes
from membrane_rs.results import read_frame, read_pvd
from membrane_rs.results.background import MOST_WAITING, Background
from membrane_rs.results.vtk import FrameWriter
from membrane_rs.runs import RunFolder
from numpy.testing import assert_array_equal

SECONDS = 60.0
"""After which a test that waits has failed."""


def hold(gate: threading.Event) -> Callable[[], None]:
    """A task that waits for `gate`."""

    def task() -> None:
        assert gate.wait(SECONDS)

    return task


def test_tasks_are_done_in_their_order_in_another_thread() -> None:
    background, done = Background(), list[tuple[int, int]]()

    def note(number: int) -> None:
        done.append((number, threading.get_ident()))

    for k in range(50):
        background.add(partial(note, k))
    assert background.close() is None
    assert [number for number, _ in done] == list(range(50))
    threads = {thread for _, thread in done}
    assert len(threads) == 1
    assert threads != {threading.get_ident()}


def test_so_many_wait_and_no_more() -> None:
    background, gate = Background(), threading.Event()
    background.add(hold(gate))
    for _ in range(MOST_WAITING):
        background.add(lambda: None)
    over = threading.Thread(target=background.add, args=(lambda: None,))
    over.start()
    over.join(0.05)
    assert over.is_alive()
    gate.set()
    over.join(SECONDS)
    assert not over.is_alive()
    assert background.close() is None


def test_an_error_reaches_the_caller_once_and_those_behind_it_are_done() -> None:
    background, gate, done = Background(), threading.Event(), list[str]()

    def fail() -> None:
        raise OutputError("no space left")

    background.add(hold(gate))
    background.add(fail)
    background.add(lambda: done.append("behind"))
    background.look()  # nothing is known yet
    gate.set()
    background.add(lambda: done.append("later"))  # waits for the first task alone
    with pytest.raises(OutputError, match="no space"):
        background.add(lambda: done.append("refused"))
    assert background.close() is None
    assert done == ["behind", "later"]


def test_an_error_that_nobody_was_told_comes_with_the_end() -> None:
    background = Background()
    background.add(lambda: json.loads("no"))
    assert isinstance(background.close(), ValueError)


def slow(monkeypatch: pytest.MonkeyPatch, gate: threading.Event) -> None:
    """Frames are written only once `gate` is open."""
    write = FrameWriter.write

    def late(*words: Any) -> None:
        assert gate.wait(SECONDS)
        write(*words)

    monkeypatch.setattr(FrameWriter, "write", late)


def test_a_frame_shows_the_instant_at_which_it_was_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gate = threading.Event()
    slow(monkeypatch, gate)
    sim: Any = FakeSimulation()
    folder = RunFolder(tmp_path / "run", pictures=False)
    folder.start(sim)
    shape = sim.positions.copy()
    folder.frame(sim)
    assert not (tmp_path / "run" / "frames.pvd").exists()
    sim.positions += 1.0
    sim.time = 0.1
    gate.set()
    folder.finish(sim, None)
    assert_array_equal(read_frame(tmp_path / "run" / "frames" / "frame-0000.vtu"), shape)
    assert [time for time, _ in read_pvd(tmp_path / "run" / "frames.pvd")] == [0.0]


class Stops:
    """An observer that ends the run at its `count`-th frame, when those before it may still wait to be written."""

    def __init__(self, count: int, error: BaseException) -> None:
        self._left, self._error = count, error

    def start(self, sim: Simulation) -> None: ...

    def sample(self, sim: Simulation) -> None: ...

    def frame(self, sim: Simulation) -> None:
        self._left -= 1
        if self._left == 0:
            raise self._error

    def finish(self, sim: Simulation, error: BaseException | None) -> None: ...


@pytest.mark.parametrize("error", [KeyboardInterrupt(), UnstableError("gone"), ZeroDivisionError("oh")])
def test_whatever_ends_a_run_frames_that_wait_are_written(tmp_path: Path, error: BaseException) -> None:
    folder = RunFolder(tmp_path / "run", pictures=False)
    sim = Simulation(scenes.load("single-crease"))
    with pytest.raises(type(error)):
        sim.run(0.02, frames=9, samples=9, observers=[folder, Stops(6, error)])
    frames = read_pvd(tmp_path / "run" / "frames.pvd")
    assert len(frames) == 6
    assert_array_equal(read_frame(frames[-1][1]), sim.positions)
    assert not list((tmp_path / "run").rglob("*.part"))


def test_a_run_stops_soon_after_a_frame_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*words: Any) -> None:
        raise OutputError("cannot write frame: no space left")

    monkeypatch.setattr(FrameWriter, "write", full)
    sim = Simulation(scenes.load("single-crease"))
    with pytest.raises(OutputError, match="no space"):
        sim.run(0.4, frames=9, samples=2001, out=tmp_path / "run", pictures=False)
    assert sim.time < 0.4
    summary = cast(dict[str, Any], json.loads((tmp_path / "run" / "summary.json").read_text()))
    assert summary["outcome"].startswith("failed: OutputError")


def test_an_interrupted_run_that_goes_on_leaves_the_same_frames(tmp_path: Path) -> None:
    scene = scenes.load("single-crease")
    whole, parts = Simulation(scene), Simulation(scene)
    whole.run(0.02, frames=9, out=tmp_path / "whole", pictures=False)
    folder = RunFolder(tmp_path / "first", pictures=False)
    with pytest.raises(KeyboardInterrupt):
        parts.run(0.02, frames=9, observers=[folder, Stops(5, KeyboardInterrupt())])
    resumed = Simulation.restore(tmp_path / "first" / "state.npz")
    resumed.run(0.02, frames=9, out=tmp_path / "second", pictures=False)
    by_time = {
        name: {time: file.read_bytes() for time, file in read_pvd(tmp_path / name / "frames.pvd")}
        for name in ("whole", "first", "second")
    }
    assert by_time["first"] | by_time["second"] == by_time["whole"]
    assert len(by_time["first"]) == 5
    assert np.array_equal(resumed.positions, whole.positions)
