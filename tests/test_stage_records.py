"""Records of stages that are over: their energies, their wall-clock times, and a phase that goes on."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from membrane_rs import Scene, Simulation, Spin, Stage, Tether
from membrane_rs.results import read_history, read_summary
from membrane_rs.runs import resume
from staged_scenes import free, oscillator, started

SOFT = {"parts.spring.axial_stiffness": 0.5}


def test_motion_that_is_set_opens_the_balance_anew() -> None:
    """No energy of a stage before, of its end or of its changes, is in the balance from there on."""
    sim = started(oscillator(Stage("damped", 0.1), free("soft", 0.1, scale=SOFT), Stage("on", 0.1)), "rk4", 1e-3)
    sim.reach(0.15)
    assert sim.ledger()["work"] != 0.0
    assert sim.ledger()["changes"] != {}
    counts = sim.step_count, sim.evaluation_count
    sim.velocities = np.zeros_like(sim.velocities)
    found = sim.ledger()
    assert (found["work"], found["error"], found["reference_energy"], found["changes"]) == (0.0, 0.0, 0.0, {})
    for record in sim.stages:
        assert (record.changes, record.error, record.reference_energy) == ({}, 0.0, 0.0)
        assert not any(record.work_by_law.values())
    assert (sim.step_count, sim.evaluation_count) == counts
    first = sum(sim.energies().values())
    sim.reach(0.25)
    found = sim.ledger()
    now = sum(sim.energies().values())
    assert now - first == pytest.approx(found["work"] + sum(found["changes"].values()), abs=1e-9)


def test_the_wall_time_of_a_stage_is_from_its_beginning(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By a clock that shows the simulated time."""
    sim = started(oscillator(Stage("a", 0.1), free("b", 0.05), free("c", 0.2)), "rk4", 1e-3)
    monkeypatch.setattr("membrane_rs.results.run_summary.perf_counter", lambda: sim.time)
    sim.run(out=tmp_path, frames=4, samples=41, pictures=False)
    summary = read_summary(tmp_path)
    assert summary["stage_starts"] == pytest.approx([0.0, 0.1, 0.15])
    assert [stage["wall_time"] for stage in summary["stages"]] == pytest.approx([0.1, 0.05, 0.2])


def test_a_history_counts_the_turns_of_its_phase_on_where_it_is_resumed(tmp_path: Path) -> None:
    """Corners that turn back by more than a turn against the hub."""
    cord = Tether((0.2, 0.0, 0.0), (0.5, 0.0, 0.0), 2, 0.1, 1e-4, fixed=False)
    scene = Scene(None, None, [Spin(2.0)], [cord], stages=[Stage("back", 0.8)])

    def sim() -> Simulation:
        made = Simulation(scene, "rk4", 1e-3)
        velocities = np.zeros_like(made.positions)
        velocities[:, 1] = -4.0 * np.pi * made.positions[:, 0]  # at rest in space
        made.velocities = velocities
        return made

    sim().run(out=tmp_path / "whole", frames=2, samples=81, pictures=False)
    whole = read_history(tmp_path / "whole")["phase_difference_deg"]
    assert whole[-1] == pytest.approx(-576.0, abs=1.0)
    sim().run(0.6, out=tmp_path / "part", frames=2, samples=61, pictures=False)
    resume(tmp_path / "part", until=0.8)
    assert read_history(tmp_path / "part")["phase_difference_deg"] == pytest.approx(whole, abs=1e-9)


def test_a_start_is_relaxed_once_and_not_in_later_stages() -> None:
    scene = oscillator(Stage("a", 0.1), Stage("b", 0.1), relax=0.5)
    assert [scene.staged(k).run.relax for k in range(2)] == [0.5, 0.0]
    assert replace(scene, stages=()).run.relax == 0.5
