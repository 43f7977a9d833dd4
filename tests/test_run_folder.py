"""Where results may go: a folder that holds anything of a user's is left as it is."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any, cast

import pytest
from fake_simulation import FakeSimulation, run, small_sail, summary
from membrane_rs import OutputError, Scene
from membrane_rs.results.history import History
from membrane_rs.runs import RunFolder


def test_folder_with_content_is_refused(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"not empty.*overwrite"):
        RunFolder(tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["notes.txt"]


def test_overwrite_removes_its_own_files_alone(tmp_path: Path) -> None:
    path = tmp_path / "run"
    run(RunFolder(path), [0.0, 0.05, 0.1])
    (path / "notes.txt").write_text("mine")
    (path / "frames" / "mine.vtu").write_text("mine")
    (path / "frames" / "frame-0009.vtu.part").write_text("half")
    run(RunFolder(path, overwrite=True, pictures=False), [0.0])
    assert (path / "notes.txt").read_text() == "mine"
    assert sorted(file.name for file in (path / "frames").iterdir()) == ["frame-0000.vtu", "mine.vtu"]
    assert not list((path / "snapshots").iterdir())
    assert not (path / "animation.gif").exists()


@pytest.mark.parametrize("name", ["scene.toml", "mesh.npz", "snapshots/fixed.png"])
def test_files_that_no_run_wrote_are_not_overwritten(tmp_path: Path, name: str) -> None:
    own = tmp_path / name
    own.parent.mkdir(exist_ok=True)
    own.write_text("mine")
    with pytest.raises(OutputError, match=f"{name} is there, but no summary.json, so no run wrote it"):
        RunFolder(tmp_path, overwrite=True)
    assert own.read_text() == "mine"
    assert sum(file.is_file() for file in tmp_path.rglob("*")) == 1


def test_a_folder_in_place_of_a_file_is_refused_before_anything_is_removed(tmp_path: Path) -> None:
    path = tmp_path / "run"
    run(RunFolder(path), [0.0, 0.05, 0.1])
    (path / "history.csv").unlink()
    (path / "history.csv").mkdir()
    before = sorted(path.rglob("*"))
    with pytest.raises(OutputError, match=r"history\.csv is a folder, where a run writes a file"):
        RunFolder(path, overwrite=True)
    assert sorted(path.rglob("*")) == before


def test_a_run_stopped_at_any_moment_can_be_overwritten(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "run"
    run(RunFolder(path, pictures=False), [0.0])
    remove, left = Path.unlink, 2

    def stopped(file: Path, missing_ok: bool = False) -> None:
        """The process is killed while it clears the folder."""
        nonlocal left
        left -= 1
        if left < 0:
            raise SystemExit
        remove(file, missing_ok)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "unlink", stopped)
        with pytest.raises(SystemExit):
            RunFolder(path, overwrite=True, pictures=False).start(cast(Any, FakeSimulation()))
    assert (path / "summary.json").exists()
    run(RunFolder(path, overwrite=True, pictures=False), [0.0, 0.1])
    assert summary(path)["outcome"] == "finished"


def test_a_run_killed_while_its_outputs_start_can_be_overwritten(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    left, start = tmp_path / "left", History.start

    def killed(self: History, sim: Any, record: Any) -> None:
        """What a process leaves that is killed here: nothing clears up behind it."""
        shutil.copytree(record.path, left)
        start(self, sim, record)

    with monkeypatch.context() as patch:
        patch.setattr(History, "start", killed)
        RunFolder(tmp_path / "run", pictures=False).start(cast(Any, FakeSimulation()))
    assert (left / "scene.toml").exists()
    run(RunFolder(left, overwrite=True, pictures=False), [0.0, 0.1])
    assert summary(left)["outcome"] == "finished"


def test_folder_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    for path in (tmp_path / "file", tmp_path / "file" / "run", tmp_path / "file" / "deep" / "run"):
        with pytest.raises(OutputError, match="is a file"):
            RunFolder(path)
    assert [file.name for file in tmp_path.iterdir()] == ["file"]


def test_start_that_fails_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = RunFolder(tmp_path / "a" / "b")

    def full_disk(self: Scene, path: Path) -> None:
        (Path(path) / "scene.toml").write_text("half")
        raise OutputError("no space left")

    monkeypatch.setattr(Scene, "save", full_disk)
    with pytest.raises(OutputError, match="no space"):
        folder.start(cast(Any, FakeSimulation()))
    assert not list(tmp_path.iterdir())


def test_two_runs_may_make_their_parent_at_the_same_moment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make = Path.mkdir

    def beaten(folder: Path, *words: Any, **named: Any) -> None:
        """Another process makes the folder between our look and our call."""
        make(folder, *words, **named)
        if folder.name == "shared":
            raise FileExistsError(17, "File exists", str(folder))

    monkeypatch.setattr(Path, "mkdir", beaten)
    results = RunFolder(tmp_path / "shared" / "one", pictures=False)
    results.start(cast(Any, FakeSimulation(small_sail())))
    assert (tmp_path / "shared" / "one" / "scene.toml").is_file()
