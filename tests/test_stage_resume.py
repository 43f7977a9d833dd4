"""A staged run is the same, bit by bit, whatever its outputs, in pieces, copied, saved, killed and resumed."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from killed_runs import contents, run_copied
from membrane_rs import Fixed, InputError, InputTypeError, Scene, Simulation, Spin, Stage, Tether
from membrane_rs.results import read_history, read_pvd, read_summary
from membrane_rs.runs import resume
from small_scenes import hanging_strip, refused
from staged_scenes import free, oscillator, started

METHODS = ("rk4", "leapfrog", "dopri5", "generalized_alpha")
STAGES = (
    Stage("damped", 0.1003),
    free("until fast", 0.5, measure="kinetic_energy", above=0.05, scale={"parts.spring.axial_stiffness": 0.7}),
    Stage("until slow", 0.5, "phase_difference_deg", above=1e9, set={"laws.mass_damping.rate": 5.0}),
    free("fall", 0.05, measure="largest_speed", above=3.0, without=("hold",)),
)
"""The third ends by its duration."""


def strip() -> Scene:
    """A strip of rubber that falls, is let go by a measure, and is caught."""
    scene = hanging_strip()
    parts = [replace(part, name="hold") for part in scene.parts] + [Fixed("end", name="other")]
    stages = (
        Stage("settle", 0.004, without=("other",), scale={"material.youngs_modulus": 0.5}),
        Stage("swing", 0.02, "kinetic_energy", above=2e-6, without=("other",), set={"run.integrator": "leapfrog"}),
        Stage("caught", 0.003),
        Stage("fall", 0.004, without=("hold",)),
    )
    return replace(scene, parts=parts, stages=stages)


def last(sim: Simulation) -> tuple[Any, ...]:
    """What two runs that are the same share."""
    return sim.time, sim.positions.tobytes(), sim.velocities.tobytes(), sim.ledger(), sim.stages


@pytest.fixture(params=[100, 0], ids=["each step", "some steps"])
def _checks(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Measures are evaluated after each step, or as in large scenes."""
    monkeypatch.setattr("membrane_rs.simulation.stage_end.FEW_NODES", request.param)


@pytest.mark.usefixtures("_checks")
@pytest.mark.parametrize("integrator", METHODS)
def test_outputs_change_no_bit(integrator: str) -> None:
    scene, found = oscillator(*STAGES), []
    for frames, samples in ((2, 2), (7, 801), ([0.1003, 0.2], [0.15, 0.150001, 0.30003])):
        sim = started(scene, integrator, None if integrator == "dopri5" else 7e-4)
        sim.run(frames=frames, samples=samples)
        assert sim.is_over
        found.append(last(sim))
    assert [stage.ended_by for stage in found[0][-1]] == ["duration", "measure", "duration", "measure"]
    assert found[0] == found[1] == found[2]


@pytest.mark.usefixtures("_checks")
@pytest.mark.parametrize("integrator", METHODS)
def test_copied_pickled_saved_and_restored_at_any_time(integrator: str, tmp_path: Path) -> None:
    scene = oscillator(*STAGES)
    whole = started(scene, integrator, None if integrator == "dopri5" else 7e-4)
    whole.run(frames=2, samples=2)
    sim = started(scene, integrator, None if integrator == "dopri5" else 7e-4)
    times = [*np.linspace(0.013, whole.time - 1e-4, 23), *whole.boundaries]
    for k, time in enumerate(sorted(times)):
        sim.reach(float(time))
        path = tmp_path / f"{k}.npz"
        sim.save(path)
        ways = [copy.copy(sim), pickle.loads(pickle.dumps(sim)), Simulation.restore(path)]
        ways.append(started(scene, integrator, None if integrator == "dopri5" else 7e-4))
        ways[-1].set_state(sim.state())
        for other in ways:
            assert (other.time, other.stage, other.stage_end) == (sim.time, sim.stage, sim.stage_end)
            assert last(other) == last(sim)
        again = ways[k % len(ways)]
        again.run(frames=3, samples=5)
        assert last(again) == last(whole)


@pytest.mark.usefixtures("_checks")
def test_an_angle_is_followed_on_through_more_than_a_turn(tmp_path: Path) -> None:
    cord = Tether((0.2, 0.0, 0.0), (0.5, 0.0, 0.0), 2, 0.1, 1e-4, fixed=False)
    stages = (Stage("turn back", 1.0, "phase_difference_deg", below=-500.0), Stage("go on", 0.1))
    sim = Simulation(Scene(None, None, [Spin(2.0)], [cord], stages=stages), "rk4", 1e-3)
    velocities = np.zeros_like(sim.positions)
    velocities[:, 1] = -4.0 * np.pi * sim.positions[:, 0]  # at rest in space
    sim.velocities = velocities
    sim.reach(0.6)  # -432 degrees
    sim.save(tmp_path / "state.npz")
    for other in (sim, Simulation.restore(tmp_path / "state.npz")):
        other.run(frames=2, samples=2)
        assert other.boundaries == [pytest.approx(500.0 / 720.0, abs=1e-9)]


@pytest.mark.usefixtures("_checks")
@pytest.mark.parametrize("scene", [oscillator(*STAGES), strip()], ids=["oscillator", "strip"])
def test_killed_in_each_stage_and_at_each_boundary(scene: Scene, tmp_path: Path) -> None:
    run: dict[str, Any] = {"until": None, "frames": 8, "samples": 31, "checkpoint": 0.0, "pictures": False}
    sim, whole = Simulation(scene), tmp_path / "whole"
    run_copied(sim, whole, **run)
    wanted, seen = contents(whole), set()
    table = read_history(whole)
    assert set(sim.boundaries) <= set(table["time"])
    assert set(sim.boundaries) <= {when for when, _ in read_pvd(whole / "frames.pvd")}
    assert table["time"][-1] == sim.time
    assert (np.diff(table["time"]) > 0).all()
    assert (np.diff(table["stage"]) >= 0).all()
    for left in sorted(tmp_path.glob("left-*")):
        restored = Simulation.restore(left / "state.npz")
        seen.add((restored.stage, restored.time in restored.boundaries))
        again = resume(left)
        assert last(again) == last(sim)
        assert contents(left) == wanted
        stages, expected = read_summary(left)["stages"], read_summary(whole)["stages"]
        for stage in (*stages, *expected):
            assert stage.pop("wall_time") >= 0.0
        assert stages == expected
    assert {stage for stage, _ in seen} == {0, 1, 2, 3}


def test_a_run_to_an_earlier_end_goes_on_to_the_end_of_the_stages(tmp_path: Path) -> None:
    scene = oscillator(free("a", 0.1), free("b", 0.2, scale={"parts.spring.axial_stiffness": 0.5}))
    whole, sim = started(scene, dt=1e-3), started(scene, dt=1e-3)
    whole.run(out=tmp_path / "whole", frames=7, samples=13, pictures=False)
    sim.run(0.15, out=tmp_path / "part", frames=4, samples=7, pictures=False)
    assert sim.stage == 1
    assert not sim.is_over
    assert last(resume(tmp_path / "part", until=0.3)) == last(whole)
    assert (tmp_path / "part/history.csv").read_bytes() == (tmp_path / "whole/history.csv").read_bytes()
    refused(lambda: resume(tmp_path / "part", until=0.4), InputError, "the last stage ends at 0.3 s")
    refused(whole.step, InputError, "the last stage, 'b', has ended at 0.3 s")
    refused(lambda: whole.reach(0.31), InputError, "the last stage, 'b', has ended at 0.3 s")
    refused(lambda: started(scene).run(1.0), InputError, "until = 1.0 s: the last stage ends at 0.3 s")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"stage_index": 4}, "stage_index = 4: must be from 0 to 3"),
        ({"stage_index": -1}, "stage_index = -1"),
        ({"stage_index": "1"}, "stage_index = '1'"),
        ({"stage_index": 2}, "stage_starts: is no array of numbers of shape"),
        ({"stage_starts": np.array([0.0, np.nan])}, "stage_starts: holds a value that is not finite"),
        ({"stage_starts": np.array([0.0, 0.2])}, r"stage_starts\[1\] = 0.2: is no end of 'damped'"),
        ({"stage_starts": None}, "stage_starts: is no array"),
        ({"stage_counts": np.array([[1, -1, 0]])}, "stage_counts: holds a value below 0"),
        ({"stage_counts": np.full((1, 3), 1e300)}, "stage_counts: is no array of whole numbers"),
        ({"stage_dt": np.array([0.0])}, "stage_dt: holds a step that is not above 0"),
        ({"stage_balances": np.array([[-1.0, 1e300]])}, "stage_balances: holds a value below 0"),
        ({"stage_ended_by_measure": np.array([7])}, "stage_ended_by_measure: holds a value that is neither 0 nor 1"),
        ({"stage_is_over": np.array([1, 2])}, "stage_is_over = array"),
        ({"stage_is_armed": np.array([1, 1])}, "stage_is_armed = array"),
        ({"stage_work": np.zeros((1, 7))}, "stage_work: is no array of numbers of shape"),
        ({"stage_is_over": 1}, "stage_is_over = 1: must be 0, 1 or 2, and 0 before the last stage"),
        ({"stage_is_armed": 2}, "stage_is_armed = 2"),
        ({"stage_now": 0.0}, "stage_now = 0 s: must be from"),
        ({"stage_now": 1e300}, "stage_now = 1e.300 s: must be from"),
        ({"stage_now": "a"}, "stage_now = 'a': must be a number"),
        ({"stage_now": 0.28}, "its stage has ended before stage_now"),
        ({"positions": None}, "positions"),
        ({"dt": -1.0}, "dt"),
        ({"dt": "x"}, "dt = 'x': must be a number"),
        ({"strange": 1}, "strange: no such entry"),
    ],
)
def test_values_that_no_state_has_are_refused_by_name(change: dict[str, Any], words: str) -> None:
    sim = started(oscillator(*STAGES), "rk4")
    sim.reach(0.17)
    assert sim.stage == 1
    before, state = last(sim), sim.state()
    refused(lambda: sim.set_state({**state, **change}), (InputError, InputTypeError), words)  # type: ignore[arg-type]
    assert last(sim) == before
    sim.set_state(state)
    assert last(sim) == before


@pytest.mark.parametrize("entry", [name for name in started(oscillator(*STAGES)).state() if name.startswith("stage")])
def test_a_state_without_one_of_its_entries_is_refused(entry: str, tmp_path: Path) -> None:
    sim = started(oscillator(*STAGES), "rk4")
    sim.reach(0.17)
    state = sim.state()
    del state[entry]
    if entry in ("stage_method", "stage_given_dt"):
        return
    refused(lambda: sim.set_state(state), (InputError, InputTypeError), entry)  # type: ignore[arg-type]
