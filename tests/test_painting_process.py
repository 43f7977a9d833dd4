"""Drawing in a process of its own: whatever happens to it, pictures are drawn and nothing of a run is lost."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_simulation import FakeSimulation, small_sail
from membrane_rs.plotting import painter, process
from membrane_rs.plotting.matplotlib import MatplotlibPainter
from membrane_rs.plotting.painter import ProcessPainter, forget_probe, pyvista_works
from membrane_rs.plotting.picture import Subject
from membrane_rs.runs import RunFolder

WORKS = pyvista_works()
HEAD = (
    "import os, sys, pickle, numpy; out = os.fdopen(os.dup(1), 'wb');"
    "say = lambda value: (pickle.dump((True, value), out), out.flush());"
)
CRASHES = {
    "at once": "import os; os.abort()",
    "at its first subject": HEAD + "say(None); pickle.load(sys.stdin.buffer); os.abort()",
    "at a picture": HEAD + "say(None); pickle.load(sys.stdin.buffer); say(None); pickle.load(sys.stdin.buffer);"
    "os.kill(os.getpid(), 11)",
    "by an error": HEAD + "say(None); pickle.load(sys.stdin.buffer); pickle.dump((False, 'no'), out); out.flush();"
    "sys.stdin.buffer.read()",
    "by nonsense": "print('nonsense')",
}  # fmt: skip


@pytest.fixture(autouse=True)
def forgotten() -> Iterator[None]:
    forget_probe()
    yield
    forget_probe()


def kill() -> None:
    held: Any = painter._pyvista.process()
    held._process.kill()
    held._process.wait()


def subject() -> tuple[Any, Subject]:
    sim: Any = FakeSimulation()
    return sim, Subject.of(sim, [sim.positions])


@pytest.mark.skipif(not WORKS, reason="VTK cannot render here")
def test_a_process_that_was_killed_is_started_again() -> None:
    sim, what = subject()
    artist = ProcessPainter(what, 120)
    first = artist.paint(sim.positions)
    kill()
    assert np.array_equal(artist.paint(sim.positions), first)
    assert pyvista_works()
    # Also between two painters.
    kill()
    assert np.array_equal(ProcessPainter(what, 120).paint(sim.positions), first)


@pytest.mark.skipif(not WORKS, reason="VTK cannot render here")
def test_painters_take_turns() -> None:
    sim, what = subject()
    flat = sim.assembly.reference
    one, other = ProcessPainter(what, 120), ProcessPainter(Subject(**{**vars(what), "spool": None}), 120)
    first = one.paint(flat)
    second = other.paint(flat)
    assert not np.array_equal(first, second)
    assert np.array_equal(one.paint(flat), first)


@pytest.mark.parametrize("how", CRASHES)
def test_a_process_that_crashes_leaves_the_picture_to_matplotlib(how: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process, "COMMAND", [sys.executable, "-c", CRASHES[how]])
    sim, what = subject()
    picture = ProcessPainter(what, 100).paint(sim.positions)
    assert np.array_equal(picture, MatplotlibPainter(what, 100).paint(sim.positions))
    assert not pyvista_works()


@pytest.mark.parametrize("how", ["at once", "at a picture"])
def test_a_run_loses_nothing_by_a_crash(how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process, "COMMAND", [sys.executable, "-c", CRASHES[how]])
    folder = RunFolder(tmp_path / "run")
    sim: Any = FakeSimulation(small_sail(snapshots=[0.0]))
    folder.start(sim)
    folder.sample(sim)
    folder.finish(sim, None)
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["pictures"] == "matplotlib"
    assert (tmp_path / "run" / "snapshots" / "turning-0.000s.png").is_file()


def test_a_process_that_hangs_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process, "COMMAND", [sys.executable, "-c", "import time; time.sleep(60)"])
    monkeypatch.setattr(painter, "PROBE_SECONDS", 0.2)
    assert not pyvista_works()
