"""The end of a run by a measure: located, the same bits however it is reached, with stages and without, resumed."""

from __future__ import annotations

import pickle
import shutil
from dataclasses import replace
from functools import partial, wraps
from inspect import currentframe
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from killed_runs import contents, run_copied
from membrane_rs import InputError, Scene, Simulation, Stage, open_run, resume, run, scenes
from membrane_rs.cli.application import app
from membrane_rs.simulation import integrators
from numpy.testing import assert_array_equal
from small_scenes import hanging_strip
from typer.testing import CliRunner

CREASE = scenes.load("single-crease")
LEVEL = 9.5e-3
"""Height that the tip of the crease passes near 10 ms [m]."""


def height(sim: Simulation) -> float:
    return float(sim.positions[:, 2].max())


def passed(sim: Simulation) -> float:
    return height(sim) - LEVEL


def is_past(sim: Simulation) -> bool:
    return height(sim) > LEVEL


def staged(measure: str | None = None) -> Scene:
    """The crease in two stages, the first of which a measure may end."""
    ends: dict[str, Any] = {} if measure is None else {"measure": measure, "above": 7e-8}
    second = Stage("second", 0.016, scale={"laws.creases.stiffness": 2.0})
    return replace(CREASE, stages=[Stage("first", 4e-3, **ends), second])


@pytest.mark.parametrize("integrator", integrators())
def test_the_time_is_found_between_steps_and_outputs_do_not_change_it(integrator: str) -> None:
    few = run(CREASE, 0.02, integrator=integrator, stop_when=passed, frames=2, samples=2)
    many = run(CREASE, 0.02, integrator=integrator, stop_when=passed, frames=7, samples=111)
    truth = run(CREASE, 0.02, integrator=integrator, stop_when=is_past, frames=2, samples=2)
    assert few.outcome == f"stopped: passed, at {few.summary['stopped']['time']:.9g} s"
    end = few.history["time"][-1]
    assert 1e-3 < end < 0.02
    assert end == many.history["time"][-1] == few.frames.times[-1] == few.summary["stopped"]["time"]
    assert_array_equal(few.frames[-1].positions, many.frames[-1].positions)
    assert abs(few.frames[-1].positions[:, 2].max() - LEVEL) < 1e-12
    assert few.frames[-1].positions[:, 2].max() >= LEVEL
    assert abs(truth.history["time"][-1] - end) < 1e-12


def test_it_has_no_effect_on_the_motion() -> None:
    sim = Simulation(CREASE)
    sim.run(0.02, stop_when=passed)
    end = sim.time
    assert sim.stopped_by == "passed"
    free = Simulation(CREASE)
    free.reach(end)
    assert_array_equal(sim.positions, free.positions)
    sim.run(0.02)
    free.reach(0.02)
    assert sim.stopped_by is None
    assert_array_equal(sim.positions, free.positions)


def test_a_measure_of_stages_with_its_value() -> None:
    stopped = run(CREASE, 0.02, stop_when={"measure": "kinetic_energy", "above": 2e-7})
    stages = [Stage("only", 0.02, "kinetic_energy", above=2e-7)]
    assert stopped.outcome.startswith("stopped: kinetic_energy above 2e-07, at ")
    ended = run(replace(CREASE, stages=stages))
    assert ended.outcome == "finished"
    assert stopped.history["time"][-1] == pytest.approx(ended.history["time"][-1], rel=1e-12)


@pytest.mark.parametrize("text", ["kinetic_energy > 2e-7", "kinetic_energy>=0.2 uJ", " kinetic_energy above 2e-4mJ "])
def test_a_measure_of_stages_as_text(text: str) -> None:
    stopped = run(CREASE, 0.02, stop_when=text, frames=2, samples=2)
    assert stopped.summary["request"]["stop"] == {"measure": "kinetic_energy", "above": 2e-7}
    assert stopped.outcome.startswith("stopped: kinetic_energy above 2e-07, at ")


@pytest.mark.parametrize("measure", [None, "kinetic_energy"])
@pytest.mark.parametrize("level", [7.0e-3, 9e-3])
def test_with_stages(measure: Any, level: float) -> None:
    scene = staged(measure)
    free, result = Simulation(scene), run(scene, stop_when=lambda sim: height(sim) - level)
    free.run()
    end = result.history["time"][-1]
    assert result.outcome.startswith("stopped: ")
    assert result.history["stage"][-1] == result.frames[-1].stage == (0 if level < 7.1e-3 else 1)
    part = Simulation(scene)
    part.reach(end)
    assert_array_equal(part.positions, result.frames[-1].positions)
    past = len(result.stages) - 1
    assert [stage["end"] for stage in result.stages[:past]] == [stage.end for stage in free.stages[:past]]


def test_a_jump_at_a_boundary_ends_the_run_there() -> None:
    scene = replace(hanging_strip(), stages=[Stage("one", 2e-3), Stage("two", 2e-3, scale={"material.thickness": 2.0})])
    result = run(scene, stop_when=lambda sim: sim.stage == 1)
    assert result.history["time"][-1] == result.summary["stopped"]["time"] == 2e-3
    assert result.frames.times[-1] == 2e-3
    # Also where the run comes to its end there.
    sim = Simulation(scene)
    sim.run(2e-3, frames=2, samples=2, stop_when=lambda sim: sim.stage == 1)
    assert (sim.time, sim.stage, sim.stopped_by is None) == (2e-3, 1, False)


@pytest.mark.parametrize("integrator", integrators())
@pytest.mark.parametrize("scene", [CREASE, staged(), staged("kinetic_energy")], ids=["plain", "stages", "measure"])
def test_resumed_to_the_same_bits(integrator: str, scene: Scene, tmp_path: Path) -> None:
    whole = tmp_path / "whole"
    sim = Simulation(scene, integrator)
    run_copied(sim, whole, stop_when=passed, frames=7, samples=31, until=0.015)
    assert open_run(whole).outcome.startswith("stopped")
    wanted, lefts = contents(whole), sorted(tmp_path.glob("left-*"))
    assert len(lefts) > 2
    for left in lefts:
        with pytest.raises(InputError, match=r"by the function 'passed'.*resume\(folder, stop_when=...\)"):
            resume(left)
        again = resume(left, stop_when=passed)
        assert again.time == sim.time
        assert contents(left) == wanted
        assert open_run(left).outcome == open_run(whole).outcome


def test_a_run_that_was_stopped_goes_on_beyond(tmp_path: Path) -> None:
    run(CREASE, 0.012, stop_when=passed, out=tmp_path / "run", pictures=False, frames=4, samples=13)
    end = open_run(tmp_path / "run").history["time"][-1]
    assert resume(tmp_path / "run").time == end
    shutil.copytree(tmp_path / "run", tmp_path / "again")
    assert resume(tmp_path / "again", 0.013, stop_when=passed).time == 0.013
    assert open_run(tmp_path / "again").outcome == "finished"
    assert resume(tmp_path / "run", 0.013).time == 0.013
    free = Simulation(CREASE)
    free.reach(0.013)
    result = open_run(tmp_path / "run")
    assert result.outcome == "finished"
    assert "stopped" not in result.summary
    assert_array_equal(result.frames[-1].positions, free.positions)


def test_a_measure_by_name_is_resumed_by_the_file_alone(tmp_path: Path) -> None:
    whole = tmp_path / "whole"
    sim = Simulation(CREASE)
    run_copied(sim, whole, stop_when={"measure": "kinetic_energy", "above": 4e-7})
    for left in sorted(tmp_path.glob("left-*")):
        assert resume(left).time == sim.time
        assert contents(left) == contents(whole)


def test_a_saved_state_of_such_a_run_is_one_of_any_run(tmp_path: Path) -> None:
    seen: list[Any] = []

    def save(sim: Simulation) -> None:
        sim.save(tmp_path / f"{len(seen)}.npz")
        seen.append((sim.time, sim.positions, pickle.loads(pickle.dumps(sim)).positions))

    run(CREASE, 0.02, stop_when=passed, frames=2, samples=11, progress=save)
    for number, (time, positions, copied) in enumerate(seen):
        path = tmp_path / f"{number}.npz"
        for other in (Simulation.restore(path), Simulation(CREASE, start=path)):
            assert other.time == time
            assert_array_equal(other.positions, positions)
        assert_array_equal(copied, positions)


@pytest.mark.parametrize("entry", [{"stop_now": 1e9}, {"stop_now": -1.0}, {"stop_side": 7}, {"stop_now": "a"}])
def test_a_damaged_state_is_refused_and_changes_nothing(entry: dict[str, Any]) -> None:
    states: list[dict[str, Any]] = []
    run(CREASE, 5e-3, stop_when=passed, frames=2, samples=4, progress=lambda sim: states.append(sim.state()))
    state = states[-1]
    assert state["stop_now"] == 5e-3
    sim = Simulation(CREASE)
    before = sim.positions
    with pytest.raises(InputError, match="saved state: stop"):
        sim.set_state({**state, **entry})
    assert sim.time == 0.0
    assert_array_equal(sim.positions, before)
    sim.step(3)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (3, "must be a function of the simulation, or a known measure and its value"),
        ({"above": 1.0}, "lacks the measure"),
        ({"measure": "hub_angle"}, "neither below nor above"),
        ({"measure": "hub_angel", "above": 1.0}, r"stop_when.measure = 'hub_angel'.*did you mean 'hub_angle'"),
        ({"measure": "hub_angle", "over": 1.0}, "'over': no such key"),
        ("hub_angle", "must be a measure, < or >, and the value"),
        ("hub_angle = 3", "must be a measure, < or >, and the value"),
        ("hub_angle > 3 kg", "is a mass; must be an angle"),
        ("hub_angel > 3", "did you mean 'hub_angle'"),
        ("hub_angle > nan", r"stop_when.above = nan: must be finite"),
        ({"measure": height, "above": 1.0}, "give a function by itself"),
        (lambda _: 1 / 0, "raised ZeroDivisionError"),
        (lambda _: None, "gave None; must give one number, or true or false"),
        (lambda sim: sim.positions, "must give one number, or true or false"),
        (lambda _: np.nan, "finite"),
        (lambda sim: sim.step() or 1.0, "a measure only reads"),
        (lambda sim: sim.time > 1e-3 or -1.0, "must give the same kind always"),
    ],
)
def test_what_ends_no_run_is_refused(given: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        run(CREASE, 0.01, stop_when=given, frames=2, samples=2)


def test_what_is_met_at_the_start_must_be_met_anew() -> None:
    with pytest.warns(UserWarning, match="is met already"):
        result = run(CREASE, 2e-3, stop_when=lambda sim: sim.time < 1e-3)
    assert result.outcome == "finished"


def test_a_number_that_stands_for_a_truth_is_told() -> None:
    with pytest.warns(
        UserWarning, match="is 0 already, and so ends the run only as it passes 0 later; a condition gives"
    ):
        result = run(CREASE, 2e-3, stop_when=lambda sim: int(sim.time > 1e-3))
    assert result.outcome == "finished"


@pytest.mark.parametrize("kind", [bool, np.bool_, np.array, lambda value: np.array([value])[0]])
def test_all_kinds_of_truth_end_a_run(kind: Any) -> None:
    result = run(CREASE, 2e-3, stop_when=lambda sim: kind(sim.time > 1e-3), frames=2, samples=2)
    assert result.history["time"][-1] == pytest.approx(1e-3, rel=1e-12)
    result = run(CREASE, 2e-3, stop_when=partial(kind_of_number, np.array), frames=2, samples=2)
    assert result.outcome.startswith("stopped: kind_of_number, at 0.001")


def kind_of_number(kind: Any, sim: Simulation) -> Any:
    return kind(sim.time - 1e-3)


def setting(sim: Simulation) -> float:
    sim.velocities = 2.0 * sim.velocities
    return -1.0


def unknown(sim: Simulation) -> float:
    return float(sim.forces("no such").max())


@pytest.mark.parametrize(("function", "words"), [(setting, "a measure has set the motion"), (unknown, "no such")])
def test_what_this_program_refuses_in_a_function_names_the_function(function: Any, words: str) -> None:
    with pytest.raises(InputError, match=rf"^stop_when = {function.__name__} at t = 0 s: .*{words}"):
        run(CREASE, 2e-3, stop_when=function)


def test_an_error_later_loses_nothing() -> None:
    with pytest.raises(InputError, match="raised ZeroDivisionError") as caught:
        run(CREASE, 0.01, every=1e-3, frames=2, stop_when=lambda sim: 1 / (sim.time < 3e-3))
    assert caught.value.run.history["time"][-1] >= 2e-3


def test_the_command_has_nothing_to_resume_where_an_event_ended_the_run(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    run("spinning-tether", 0.5, frames=3, stop_when={"measure": "hub_angle", "above": 0.2}, out=folder, pictures=False)
    before = (folder / "history.csv").read_bytes()
    shown = CliRunner().invoke(app, ["resume", str(folder)])
    assert shown.exit_code == 0
    assert "nothing is left to do" in shown.stderr
    assert (folder / "history.csv").read_bytes() == before


def test_functions_are_named_as_a_reader_finds_them(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    line = currentframe().f_lineno + 1  # type: ignore[union-attr]
    result = run(CREASE, 0.01, stop_when=lambda sim: sim.time - 2e-3, frames=2, samples=3, out=folder, pictures=False)
    assert result.outcome == f"stopped: a lambda in line {line} of test_stop_when.py, at 0.002 s"
    run(CREASE, 2e-3, stop_when=passed, frames=2, samples=3, out=folder, pictures=False, overwrite=True)
    with pytest.raises(InputError, match=r"stop_when = a lambda: the run in .* has the function 'passed'; give that"):
        resume(folder, 4e-3, stop_when=lambda sim: sim.time)
    with pytest.raises(InputError, match=r"stop_when = passed at t = 0 s = inf: must be finite"):
        run(CREASE, 2e-3, stop_when=partial_named(passed))


def partial_named(function: Any) -> Any:
    """A function of the same name whose value is infinite."""
    return wraps(function)(lambda _: np.inf)
