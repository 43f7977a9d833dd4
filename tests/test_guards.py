"""Guards of single lines: each test fails where its line is left out or reversed."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from membrane_rs import InputError, RunSettings, Simulation, UnstableError, scenes
from membrane_rs._files import PART, replacing, write_text
from membrane_rs.mesh import Mesh
from membrane_rs.mesh.triangulation import NO_AREA
from membrane_rs.results import read_history
from membrane_rs.runs import RunFolder
from small_scenes import hanging_strip


def test_an_error_while_a_file_is_written_leaves_no_partial_one(tmp_path: Path) -> None:
    file = tmp_path / "notes.txt"
    write_text(file, "old")

    def fail() -> None:
        with replacing(file) as part:
            part.write_text("half")
            assert part.name == "notes.txt" + PART
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert file.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


@pytest.mark.parametrize("dt", [0.0, -1e-6])
def test_a_saved_state_whose_step_is_not_above_zero_is_refused(tmp_path: Path, dt: float) -> None:
    settings = RunSettings(until=0.1, integrator="dopri5")
    path, damaged = tmp_path / "state.npz", tmp_path / "damaged.npz"
    Simulation(replace(hanging_strip(), run=settings)).save(path)
    with np.load(path) as file:
        np.savez(damaged, **{**file, "dt": np.float64(dt)})
    with pytest.raises(InputError, match="damaged"):
        Simulation.restore(damaged)


def test_a_restored_simulation_knows_whether_it_was_relaxed(tmp_path: Path) -> None:
    sim = Simulation(hanging_strip())
    for is_relaxed in (False, True):
        sim.is_relaxed = is_relaxed
        sim.save(tmp_path / "state.npz")
        assert Simulation.restore(tmp_path / "state.npz").is_relaxed is is_relaxed


class Seen:
    """Keeps the times of what it is shown, and whether the last shape was finite."""

    def __init__(self) -> None:
        self.samples: list[float] = []
        self.frames: list[float] = []
        self.is_finite = True

    def start(self, sim: Simulation) -> None:
        """Nothing."""

    def sample(self, sim: Simulation) -> None:
        self.samples.append(sim.time)

    def frame(self, sim: Simulation) -> None:
        self.frames.append(sim.time)
        self.is_finite = bool(np.isfinite(sim.positions).all())

    def finish(self, sim: Simulation, error: BaseException | None) -> None:
        """Nothing."""


def test_an_unstable_run_shows_its_last_good_state() -> None:
    sim = Simulation(hanging_strip(), dt=1.01 * Simulation(hanging_strip()).stable_dt())
    sim.velocities = 1e-9 * np.random.default_rng(1).normal(size=(sim.node_count, 3))
    seen = Seen()
    with pytest.raises(UnstableError):
        sim.run(until=40_000 * sim.dt, frames=[0.0], samples=2, observers=[seen])
    assert seen.frames == [0.0, sim.time]
    assert sim.time > 0
    assert seen.is_finite


def test_a_state_shown_again_is_not_written_again(tmp_path: Path) -> None:
    sim, folder = Simulation(hanging_strip()), RunFolder(tmp_path / "run", pictures=False)
    folder.start(sim)
    for steps in (0, 0, 5, 0):
        sim.step(steps)
        folder.sample(sim)
        folder.frame(sim)
    folder.finish(sim, None)
    assert read_history(tmp_path / "run")["time"].tolist() == [0.0, sim.time]
    assert len(list((tmp_path / "run" / "frames").iterdir())) == 2


@pytest.mark.parametrize(("height", "is_refused"), [(0.5 * NO_AREA, True), (2.0 * NO_AREA, False)])
def test_a_triangle_has_no_area_below_a_billionth_of_its_longest_side(height: float, is_refused: bool) -> None:
    assert NO_AREA == 1e-9
    mesh = Mesh([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, height, 0.0]], [[0, 1, 2]])
    found = mesh.audit().find("degenerate")
    assert found is not None
    assert found.severity == ("error" if is_refused else "warning")


def test_ctrl_c_before_a_command_begins_gives_its_exit_code() -> None:
    # As a shell does: the exit code of a program that SIGINT ended.
    program = (
        "import sys, signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
        "from membrane_rs import scenes; "
        "scenes.names = lambda: signal.raise_signal(signal.SIGINT); "
        "from membrane_rs.cli import main; sys.argv = ['membrane-rs', 'scenes']; main()"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 130, done.stderr
    assert "Traceback" not in done.stderr
    assert scenes.names()
