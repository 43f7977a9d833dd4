"""A run that was killed goes on from its last checkpoint, and ends as the run that nobody stopped, bit by bit.

What a killed process leaves is a copy of the folder at that moment: nothing clears up behind it.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_simulation import summary
from killed_runs import RUN, contents, run_copied
from membrane_rs import InputError, MissingFileError, OutputError, Simulation, UnstableError, scenes
from membrane_rs.cli import app
from membrane_rs.results import read_history, read_pvd, read_summary
from membrane_rs.results.vtk import FrameWriter
from membrane_rs.runs import resume
from membrane_rs.simulation import integrators
from membrane_rs.simulation.checkpoint import StateFile
from typer.testing import CliRunner

SCENE = scenes.load("single-crease")


@pytest.mark.parametrize("integrator", integrators())
def test_killed_at_any_frame(tmp_path: Path, integrator: str) -> None:
    whole = tmp_path / "whole"
    sim = Simulation(SCENE, integrator)
    run_copied(sim, whole)
    wanted, times = contents(whole), []
    for number in range(9):
        left = tmp_path / f"left-{number}"
        assert (summary(left)["outcome"], read_summary(left)["outcome"]) == ("running", "killed")
        times.append(Simulation.restore(left / "state.npz").time)
        again = resume(left)
        assert np.array_equal(again.positions, sim.positions)
        assert contents(left) == wanted
        found = read_summary(left)
        assert (found["outcome"], found["resumed"]) == ("finished", 1)
        assert {key: found[key] for key in ("steps", "evaluations", "dt", "samples", "frames", "curves")} == {
            key: summary(whole)[key] for key in ("steps", "evaluations", "dt", "samples", "frames", "curves")
        }
    assert len(set(times)) > 5  # not from the start alone


def test_killed_while_a_frame_or_a_checkpoint_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole, count = tmp_path / "whole", 0
    write_frame, write_state = FrameWriter.write, StateFile.write

    def half_written(path: Path) -> None:
        nonlocal count
        part = path.with_name(path.name + ".part")
        part.write_bytes(b"half")
        if (whole / "summary.json").exists():
            shutil.copytree(whole, tmp_path / f"left-{count}")
            count += 1
        part.unlink()

    def frame(self: FrameWriter, path: Path, *words: Any) -> None:
        half_written(path)
        write_frame(self, path, *words)

    def state(self: StateFile, path: Path, *words: Any) -> None:
        half_written(path)
        write_state(self, path, *words)

    monkeypatch.setattr(FrameWriter, "write", frame)
    monkeypatch.setattr(StateFile, "write", state)
    Simulation(SCENE).run(**RUN, out=whole)
    monkeypatch.undo()
    assert count > 10
    wanted = contents(whole)
    for folder in tmp_path.glob("left-*"):
        assert any(folder.rglob("*.part"))
        resume(folder)
        assert contents(folder) == wanted


def test_checkpoints_are_as_far_apart_as_was_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # By a clock that goes on by a second at each look, and there is one at each of the 40 samples before the end.
    seconds = 0
    times: list[float] = []
    write = StateFile.write

    def clock() -> float:
        nonlocal seconds
        seconds += 1
        return seconds

    def state(self: StateFile, path: Path, values: dict[str, Any]) -> None:
        times.append(float(values["step_count"]))
        write(self, path, values)

    monkeypatch.setattr("membrane_rs.runs.run_folder.monotonic", clock)
    monkeypatch.setattr("membrane_rs.results.background.Background.is_idle", True)  # however busy the machine is
    monkeypatch.setattr(StateFile, "write", state)
    monkeypatch.setattr("membrane_rs.simulation.stepper.CHUNK", 1e3)
    counts = []
    for k, interval in enumerate((0.0, 10.0, 1e9)):
        Simulation(SCENE).run(**RUN | {"checkpoint": interval}, out=tmp_path / f"run-{k}")
        counts.append(len(times))
        times.clear()
    # Before the start, after it, and at the end; and between these.
    assert counts[2] == 3
    assert 3 < counts[1] <= 3 + 40 / 10
    assert counts[0] > counts[1]


def test_killed_while_it_is_relaxed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = replace(SCENE, run=replace(SCENE.run, relax=0.002))
    whole, sims = tmp_path / "whole", [Simulation(scene, dt=2e-6) for _ in range(2)]
    for sim in sims:
        sim.positions = sim.positions + 1e-4 * np.sin(np.arange(3 * sim.node_count)).reshape(-1, 3)
    relax = Simulation.relax

    def late(self: Simulation, *words: Any) -> float:
        shutil.copytree(whole, tmp_path / "left-0")
        return relax(self, *words)

    monkeypatch.setattr(Simulation, "relax", late)
    sims[0].run(**RUN, out=whole)
    monkeypatch.undo()
    assert not (tmp_path / "left-0" / "scene.toml").exists()
    resume(tmp_path / "left-0")
    assert contents(tmp_path / "left-0") == contents(whole)
    keys = ("stable_dt", "limiting_part", "start_time", "integrator")
    assert [summary(tmp_path / "left-0")[key] for key in keys] == [summary(whole)[key] for key in keys]


def test_instants_that_were_given_as_lists(tmp_path: Path) -> None:
    whole = tmp_path / "whole"
    instants: dict[str, Any] = {"frames": [0.0031, 0.0077], "samples": np.array([0.001, 0.0055, 0.0077])}
    run_copied(Simulation(SCENE), whole, **instants)
    for left in sorted(tmp_path.glob("left-*")):
        resume(left)
        assert contents(left) == contents(whole)
    assert {0.0031, 0.0077, 0.02} < {when for when, _ in read_pvd(whole / "frames.pvd")}
    assert {0.001, 0.0055, 0.0077, 0.02} < set(read_history(whole)["time"])


def test_pictures_are_those_of_the_run_that_nobody_stopped(tmp_path: Path) -> None:
    scene = replace(SCENE, run=replace(SCENE.run, snapshots=(0.0, 0.01, 0.02)))
    whole = tmp_path / "whole"
    run_copied(Simulation(scene), whole, pictures=True)
    resume(tmp_path / "left-6")
    assert contents(tmp_path / "left-6") == contents(whole)
    assert len(list((whole / "snapshots").glob("*.png"))) == 4  # no hub turns: one view


def test_a_finished_run_stays_and_goes_on_to_a_later_end(tmp_path: Path) -> None:
    path = tmp_path / "run"
    Simulation(SCENE).run(**RUN, out=path)
    before = contents(path) | {"summary": (path / "summary.json").read_bytes()}
    assert resume(path).time == 0.02
    assert contents(path) | {"summary": (path / "summary.json").read_bytes()} == before
    sim = resume(path, until=0.03)
    longer = Simulation(SCENE)
    longer.run(0.03, frames=13, samples=61, out=tmp_path / "longer", pictures=False)
    assert np.array_equal(sim.positions, longer.positions)
    assert [when for when, _ in read_pvd(path / "frames.pvd")] == pytest.approx(np.linspace(0.0, 0.03, 13))
    assert (path / "history.csv").read_bytes() == (tmp_path / "longer" / "history.csv").read_bytes()
    assert summary(path)["request"]["until"] == 0.03
    with pytest.raises(InputError, match=r"until = 0\.01 s: the run has come to 0\.03 s already"):
        resume(path, until=0.01)


def test_a_run_that_another_error_ended_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Simulation(SCENE).run(**RUN, out=tmp_path / "whole")
    write = FrameWriter.write

    def full(self: FrameWriter, path: Path, *words: Any) -> None:
        if path.stem == "frame-0005":
            raise OutputError(f"cannot write {path}: no space left")
        write(self, path, *words)

    monkeypatch.setattr(FrameWriter, "write", full)
    with pytest.raises(OutputError, match="no space left"):
        Simulation(SCENE).run(**RUN, out=tmp_path / "run")
    monkeypatch.undo()
    resume(tmp_path / "run")
    assert contents(tmp_path / "run") == contents(tmp_path / "whole")


def test_what_cannot_be_resumed_is_named(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match="no summary at"):
        resume(tmp_path)
    path = tmp_path / "unstable"
    with pytest.raises(UnstableError):
        Simulation(SCENE, dt=2 * Simulation(SCENE).stable_dt()).run(out=path, pictures=False)
    with pytest.raises(InputError, match=r"the run ended unstable: .*cannot go on: change the scene or its step"):
        resume(path)
    whole, path = tmp_path / "whole", tmp_path / "left-4"
    run_copied(Simulation(SCENE), whole)
    content = bytearray((path / "state.npz").read_bytes())
    content[len(content) // 2] ^= 1
    (path / "state.npz").write_bytes(content)
    with pytest.raises(InputError, match=r"left-4/state\.npz: .*damaged|left-4/state\.npz: is no saved state"):
        resume(path)
    (path / "state.npz").unlink()
    with pytest.raises(MissingFileError, match=r"state\.npz: there is no such saved state"):
        resume(path)
    told = json.loads((tmp_path / "left-5" / "summary.json").read_text())
    del told["request"]
    (tmp_path / "left-5" / "summary.json").write_text(json.dumps(told))
    with pytest.raises(OutputError, match="does not say what the run was asked for"):
        resume(tmp_path / "left-5")
    history = tmp_path / "left-6" / "history.csv"
    history.write_text(history.read_text().replace("work_springs", "work_of_springs", 1))
    with pytest.raises(OutputError, match="holds other columns than this run writes"):
        resume(tmp_path / "left-6")


def test_a_run_counts_how_often_it_was_resumed(tmp_path: Path) -> None:
    run_copied(Simulation(SCENE), tmp_path / "whole")
    left = tmp_path / "left-3"
    resume(left)
    resume(left, 0.021)
    assert (read_summary(left)["resumed"], "resumed" in read_summary(tmp_path / "whole")) == (2, False)


def test_half_a_file_that_nobody_writes_again_is_removed(tmp_path: Path) -> None:
    run_copied(Simulation(SCENE), tmp_path / "whole")
    left = tmp_path / "left-3"
    (left / "deployment.png.part").write_bytes(b"half")
    resume(left)
    assert contents(left) == contents(tmp_path / "whole")


def test_a_run_does_not_begin_without_its_first_checkpoint(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write, count = StateFile.write, 0

    def fail_once(self: StateFile, *words: Any) -> None:
        nonlocal count
        count += 1
        if count == 1:
            raise OutputError("of a test")
        write(self, *words)

    monkeypatch.setattr(StateFile, "write", fail_once)
    sim = Simulation(SCENE)
    with pytest.raises(OutputError, match="of a test"):
        sim.run(**RUN, out=tmp_path / "run")
    assert sim.step_count == 0
    assert read_summary(tmp_path / "run")["outcome"].startswith("failed: OutputError")


def test_the_command_goes_on_without_being_told_again(tmp_path: Path) -> None:
    def call(*words: object) -> tuple[int, str]:
        result = CliRunner().invoke(app, [str(word) for word in words])
        return result.exit_code, " ".join(result.output.split())

    whole = tmp_path / "whole"
    run_copied(Simulation(SCENE, "leapfrog"), whole)
    left = tmp_path / "left-3"
    assert call("resume", left, "--out", tmp_path / "x")[0] == 2
    assert call("resume", left, "--frames", 3)[0] == 2
    code, shown = call("resume", left)
    assert code == 0
    assert "left-3: killed (process" in shown
    assert contents(left) == contents(whole)
    code, shown = call("resume", left)
    assert (code, "is finished, at 0.02 s; nothing is left to do" in shown) == (0, True)
    assert call("resume", left, "--until", 0.025)[0] == 0
    assert read_history(left)["time"][-1] == 0.025
    code, shown = call("resume", tmp_path / "nowhere")
    assert (code, shown.count("Error:")) == (2, 1)


def test_killed_by_signals() -> None:
    script = Path(__file__).parent.parent / "benchmarks" / "interruption.py"
    done = subprocess.run([sys.executable, script, "--quick"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "Different files: none" in done.stdout
