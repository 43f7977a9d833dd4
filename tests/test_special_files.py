"""A pipe or a device is neither replaced nor opened where a file is to be written: it is refused by name."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_simulation import run
from membrane_rs import MembraneError, OutputError, Simulation
from membrane_rs._files import PART, replacing, write_text
from membrane_rs.plotting import plot_deployment
from membrane_rs.results import read_history, write_pvd
from membrane_rs.results.lock import LOCK
from membrane_rs.runs import RunFolder, resume
from small_scenes import hanging_strip, patch, refused

WORDS = "pipe, a socket or a device"
TABLE = {
    "time": np.arange(3.0), "deployment_rate": np.ones(3), "phase_difference_deg": np.zeros(3),
}  # fmt: skip
WRITERS: dict[str, Callable[[Path], object]] = {
    "state.npz": lambda path: Simulation(hanging_strip()).save(path),
    "mesh.npz": lambda path: patch().save(path),
    "scene.toml": lambda path: hanging_strip().save(path.parent),
    "curves.png": lambda path: plot_deployment(TABLE, path),
    "frames.pvd": lambda path: write_pvd(path, [(0.0, "a.vtu")]),
    "table.md": lambda path: write_text(path, "text"),
}


@pytest.mark.parametrize("beside", ["", PART])
@pytest.mark.parametrize("name", WRITERS)
def test_no_writer_replaces_a_pipe(name: str, beside: str, tmp_path: Path) -> None:
    pipe = tmp_path / (name + beside)
    os.mkfifo(pipe)
    refused(lambda: WRITERS[name](tmp_path / name), OutputError, WORDS)
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert not (tmp_path / name).is_file()


def test_a_link_to_a_pipe_is_refused_and_one_to_a_file_replaced(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("pipe")
    refused(lambda: write_text(tmp_path / "link", "text"), OutputError, WORDS)
    assert (tmp_path / "link").is_symlink()
    (tmp_path / "none").symlink_to("nowhere")
    with replacing(tmp_path / "none") as part:
        part.write_text("text")
    assert (tmp_path / "none").read_text() == "text"


FILES = ["history.csv", "frames.pvd", "state.npz", "scene.toml", "summary.json", "deployment.png", LOCK]


@pytest.mark.parametrize("name", FILES)
def test_a_run_that_goes_on_opens_no_pipe(name: str, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    Simulation(hanging_strip()).run(until=0.001, frames=2, samples=3, out=folder, pictures=False)
    (folder / name).unlink(missing_ok=True)
    os.mkfifo(folder / name)
    code = "import sys; from membrane_rs.runs import resume; resume(sys.argv[1], 0.002)"
    words = [sys.executable, "-c", code, str(folder)]
    done = subprocess.run(words, check=False, capture_output=True, text=True, timeout=300)
    assert "OutputError" in done.stderr or "MissingFileError" in done.stderr or "InputError" in done.stderr
    assert name in done.stderr
    assert stat.S_ISFIFO((folder / name).stat().st_mode)


@pytest.mark.parametrize("name", ["history.csv", "frames.pvd", "frames/frame-0000.vtu"])
def test_an_overwrite_removes_no_pipe(name: str, tmp_path: Path) -> None:
    run(RunFolder(tmp_path / "run", pictures=False), [0.0, 0.05])
    pipe = tmp_path / "run" / name
    pipe.unlink()
    os.mkfifo(pipe)
    refused(lambda: RunFolder(tmp_path / "run", overwrite=True), OutputError, f"{name} is a {WORDS}")
    assert stat.S_ISFIFO(pipe.stat().st_mode)


def test_an_overwrite_removes_no_frames_behind_a_link(tmp_path: Path) -> None:
    folder, elsewhere = tmp_path / "run", tmp_path / "elsewhere"
    run(RunFolder(folder, pictures=False), [0.0, 0.05])
    (folder / "frames").rename(elsewhere)
    (folder / "frames").symlink_to(elsewhere)
    before = sorted(elsewhere.iterdir())
    words = f"{folder / 'frames'} is a link to {elsewhere}"
    refused(lambda: RunFolder(folder, overwrite=True, pictures=False), OutputError, words)
    assert sorted(elsewhere.iterdir()) == before != []
    assert (folder / "summary.json").is_file()


def test_an_interrupted_run_reads_no_pipe(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "summary.json")
    readers: list[Callable[[Any], object]] = [resume, read_history]
    for reader in readers:
        refused(lambda reader=reader: reader(tmp_path), MembraneError, str(tmp_path))  # type: ignore[misc]
