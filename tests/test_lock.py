"""One run in a folder: a second one is refused, and the first notices when its folder is taken away."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from child_processes import started, wait_until
from fake_simulation import FakeSimulation, run, summary
from membrane_rs import OutputError, Simulation, scenes
from membrane_rs.results import read_summary
from membrane_rs.results.lock import LOCK, FolderLock, is_locked
from membrane_rs.runs import RunFolder, resume
from observers import At

SCENE = scenes.load("single-crease")


def run_with(path: Path, act: Callable[[], object]) -> None:
    Simulation(SCENE).run(0.02, frames=9, out=path, pictures=False, observers=[At(3, act)])


def test_a_second_run_is_refused_by_the_process_that_holds_the_folder(tmp_path: Path) -> None:
    path = tmp_path / "run"
    words = [sys.executable, "-m", "membrane_rs.cli", "run", "okuizumi-model-1", "--until", "1000", "--no-pictures"]
    with started([*words, "--out", str(path)]) as process:  # it goes on until it is killed
        wait_until((path / "frames.pvd").exists, "a frame is written", process)
        found = read_summary(path)
        assert (found["outcome"], found["process"]["pid"]) == ("running", process.pid)
        refusal = rf"another run goes on there \(process {process.pid} on .*, since 20.*\); wait for its end"
        for overwrite in (False, True):
            with pytest.raises(OutputError, match=refusal):
                Simulation(SCENE).run(0.001, out=path, overwrite=overwrite, pictures=False)
        with pytest.raises(OutputError, match=refusal):
            resume(path)
    assert (summary(path)["outcome"], read_summary(path)["outcome"]) == ("running", "killed")
    Simulation(SCENE).run(0.001, out=path, overwrite=True, pictures=False)
    assert read_summary(path)["outcome"] == "finished"
    assert not (path / LOCK).exists()


def test_in_the_same_process_too(tmp_path: Path) -> None:
    def second() -> None:
        for overwrite in (False, True):
            with pytest.raises(OutputError, match="another run goes on there"):
                Simulation(SCENE).run(0.001, out=tmp_path / "run", overwrite=overwrite)

    run_with(tmp_path / "run", second)
    assert summary(tmp_path / "run")["frames"] == 9


def test_a_folder_that_is_taken_away_is_noticed_and_not_made_again(tmp_path: Path) -> None:
    path = tmp_path / "run"
    with pytest.raises(OutputError, match=r"cannot write into .*run: the folder was removed or renamed"):
        run_with(path, lambda: path.rename(tmp_path / "elsewhere"))
    assert not path.exists()


@pytest.mark.parametrize("goes_on", [False, True])
def test_a_folder_that_another_run_has_taken_stays_as_that_has_it(tmp_path: Path, goes_on: bool) -> None:
    path, before = tmp_path / "run", dict[str, bytes]()
    second = RunFolder(tmp_path / "second", pictures=False)

    def take() -> None:
        sim: Any = FakeSimulation()
        second.start(sim)
        second.sample(sim)
        second.frame(sim)
        wait_until(lambda: second._record.background.is_idle, "the second run has written its frame")
        if not goes_on:
            second.finish(sim, None)
        shutil.move(path, tmp_path / "first")
        shutil.move(tmp_path / "second", path)
        before.update({file.name: file.read_bytes() for file in path.rglob("*") if file.is_file()})

    with pytest.raises(OutputError, match=r"cannot write into .*run: the folder was replaced, or taken by another run"):
        run_with(path, take)
    assert {file.name: file.read_bytes() for file in path.rglob("*") if file.is_file()} == before


def test_a_lock_that_is_removed_is_noticed(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=rf"its file {LOCK}, which keeps other runs out, was removed"):
        run_with(tmp_path / "run", (tmp_path / "run" / LOCK).unlink)


def test_a_lock_that_a_killed_process_left_keeps_nobody_out(tmp_path: Path) -> None:
    path = tmp_path / "run"
    path.mkdir()
    (path / LOCK).touch()
    assert not is_locked(path)
    run(RunFolder(path, pictures=False), [0.0])
    assert not (path / LOCK).exists()
    # Killed before its summary was written, a run has left a lock, by which its files are known as a run's.
    (path / "summary.json").unlink()
    (path / LOCK).touch()
    run(RunFolder(path, overwrite=True, pictures=False), [0.0])
    assert summary(path)["outcome"] == "finished"


def test_the_lock_is_held_by_one_and_given_back(tmp_path: Path) -> None:
    first, second = FolderLock(tmp_path), FolderLock(tmp_path)
    assert first.acquire()
    assert is_locked(tmp_path)
    assert not second.acquire()
    first.release()
    assert not (tmp_path / LOCK).exists()
    assert second.acquire()
    first.release()  # a second time: the other's stays
    assert is_locked(tmp_path)
    second.release()


def test_a_summary_is_read_or_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "run"
    run(RunFolder(path, pictures=False), [0.0])
    assert read_summary(path) == read_summary(str(path / "summary.json")) == summary(path)
    for text in ("", "[]", "{}", json.dumps({"outcome": 3})):
        (path / "summary.json").write_text(text)
        with pytest.raises(OutputError, match=r"summary\.json is no summary of a run"):
            read_summary(path)
    (path / "summary.json").write_bytes(b"\xff\xfe")
    with pytest.raises(OutputError, match="is no summary of a run"):
        read_summary(path)
