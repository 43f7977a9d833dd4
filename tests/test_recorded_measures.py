"""Measures that a run records: columns of its history, in memory and in a folder, checked, and resumed."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from killed_runs import contents, run_copied
from membrane_rs import InputError, InputTypeError, Simulation, open_run, resume, run, scenes
from numpy.testing import assert_array_equal

TETHER = "spinning-tether"


def speed(sim: Simulation) -> float:
    return float(np.linalg.norm(sim.velocities, axis=1).max())


def stepping(sim: Simulation) -> float:
    sim.step()
    return 1.0


def setting(sim: Simulation) -> float:
    sim.positions = sim.positions
    return 1.0


RECORD: dict[str, Any] = {"speed": (speed, "m/s"), "twice": lambda sim: 2.0 * sim.time}


def test_measures_are_columns_with_their_units(tmp_path: Path) -> None:
    kept = run(TETHER, 2e-3, samples=5, frames=2, record=RECORD)
    written = run(TETHER, 2e-3, samples=5, frames=2, record=RECORD, out=tmp_path / "run", pictures=False)
    assert list(kept.history)[-2:] == ["speed", "twice"]
    assert (kept.history.units["speed"], kept.history.units["twice"]) == ("m/s", "")
    assert_array_equal(kept.history["twice"], 2.0 * kept.history["time"])
    sim = Simulation(scenes.load(TETHER))
    sim.reach(2e-3)
    assert kept.history["speed"][-1] == speed(sim)
    assert dict(written.history.units) == dict(kept.history.units)
    assert_array_equal(written.history["speed"], kept.history["speed"])
    assert open_run(tmp_path / "run").summary["request"]["record"] == {"speed": "m/s", "twice": ""}


def test_known_measures_by_their_names() -> None:
    given: list[Any] = [["largest_speed", "kinetic_energy"], {"kinetic_energy": None, "largest_speed": None}]
    for record in given:
        result = run(TETHER, 2e-3, samples=5, frames=2, record=record)
        assert list(result.history)[-1] == "largest_speed"
        assert list(result.history).count("kinetic_energy") == 1
        assert result.history.units["largest_speed"] == "m/s"
        assert result.summary["request"]["record"] == {"largest_speed": "m/s"}
        sim = Simulation(scenes.load(TETHER))
        sim.reach(2e-3)
        assert result.history["largest_speed"][-1] == speed(sim)
    both = run(TETHER, 2e-3, samples=5, frames=2, record={"speed": speed, "largest_speed": None})
    assert list(both.history)[-2:] == ["speed", "largest_speed"]
    assert_array_equal(both.history["speed"], both.history["largest_speed"])


@pytest.mark.parametrize("record", ["largest_speed", {"largest_speed"}, 3, [3], [["largest_speed"]]])
def test_what_is_no_list_of_names_is_refused(record: Any) -> None:
    with pytest.raises(InputTypeError, match=r"record.*: must be a"):
        run(TETHER, 1e-3, record=record)


def test_an_unknown_name_is_refused() -> None:
    for record in (["largest_sped"], {"largest_sped": None}):
        with pytest.raises(InputError, match="'largest_sped' is no known measure; did you mean 'largest_speed'"):
            run(TETHER, 1e-3, record=record)


def test_samples_at_an_interval() -> None:
    result = run(TETHER, 2.5e-3, every=1e-3, frames=2)
    assert result.history["time"].tolist() == [0.0, 1e-3, 2e-3, 2.5e-3]
    with pytest.raises(InputError, match="leave one of them out"):
        run(TETHER, 1e-3, every=1e-3, samples=3)


def test_an_interval_alone_says_when_samples_are() -> None:
    result = run(TETHER, 0.011, every=3e-3)  # the scene has frames at every half of a millisecond
    assert result.history["time"].tolist() == [0.0, 3e-3, 6e-3, 9e-3, 0.011]
    assert result.frames.times.tolist() == [0.0, 3e-3, 6e-3, 9e-3, 0.011]
    few = run(TETHER, 0.02, every=3e-3, frames=5)
    assert few.history["time"].tolist() == [0.0, 3e-3, 6e-3, 9e-3, 0.012, 0.015, 0.018, 0.02]
    assert few.frames.times.tolist() == [0.0, 6e-3, 9e-3, 0.015, 0.02]
    snapshots = replace(scenes.load(TETHER), run=replace(scenes.load(TETHER).run, snapshots=(0.0, 5e-3)))
    assert run(snapshots, 0.01, every=3e-3).history["time"].tolist() == [0.0, 3e-3, 6e-3, 9e-3, 0.01]
    named = run(TETHER, 0.01, every=3e-3, frames=[4e-3])
    assert named.history["time"].tolist() == [0.0, 3e-3, 4e-3, 6e-3, 9e-3, 0.01]


def test_frames_that_an_interval_leaves_out_are_told() -> None:
    with pytest.warns(UserWarning, match=r"frames = 50: a frame is a sample, of which every = 0.003 s gives fewer; 5"):
        result = run(TETHER, 0.01, every=3e-3, frames=50)
    assert result.frames.times.tolist() == result.history["time"].tolist()


@pytest.mark.parametrize("frames", [5, None])
def test_an_interval_goes_on_beyond_the_end(frames: Any, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    run(TETHER, 0.02, every=3e-3, frames=frames, out=folder, pictures=False)
    resume(folder, 0.035)
    result = open_run(folder)
    before = [0.0, 3e-3, 6e-3, 9e-3, 0.012, 0.015, 0.018, 0.02]
    assert result.history["time"].tolist() == [*before, 0.021, 0.024, 0.027, 0.03, 0.033, 0.035]
    assert set(result.frames.times) <= set(result.history["time"])
    assert {0.02, 0.035} <= set(result.frames.times)


def wordy(_: Any) -> float:
    raise ValueError("a\nb" * 1000)


@pytest.mark.parametrize(
    ("every", "words"),
    [(0.0, "must be above 0"), (-1.0, "above 0"), (1e-12, "longer"), (math.nan, "finite"), ("a", "number")],
)
def test_what_is_no_interval_is_refused(every: Any, words: str) -> None:
    with pytest.raises(InputError, match=f"every.*{words}"):
        run(TETHER, 1e-3, every=every)


@pytest.mark.parametrize(
    ("measure", "words"),
    [
        (lambda _: 1 / 0, r"record\['it'\] at t = 0 s: raised ZeroDivisionError: division by zero; mend"),
        (wordy, r"raised ValueError: a ba b.{1,300}\.\.\.; mend the function$"),
        (lambda _: math.nan, r"record\['it'\] at t = 0 s = nan: must be finite$"),
        (lambda _: None, r"record\['it'\] at t = 0 s = None: must be a number"),
        (lambda sim: sim.positions, r"gave an array of shape \(11, 3\); must give one number, such as its .max\(\)"),
        (stepping, "a measure only reads"),
        (setting, "a measure only reads"),
        (lambda sim: sim.reach(1.0) or 1.0, "a measure only reads"),
        (3.0, r"record\['it'\] = 3.0: must be a function"),
        ((speed, 3), "the unit 3: must be a text"),
        ((speed, "m\n"), "one line"),
    ],
)
def test_what_is_no_measure_is_refused(measure: Any, words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=words):
        run(TETHER, 1e-3, record={"it": measure}, out=tmp_path / "run")
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("name", ["time", "work_spin", "energy_turned_over", "", " a", "a\nb", "x" * 101, "\ud800", 3])
def test_names_that_no_column_can_have_are_refused(name: Any) -> None:
    with pytest.raises(InputError, match="record"):
        run(TETHER, 1e-3, record={name: speed})


def test_a_measure_that_fails_later_ends_the_run_and_loses_nothing() -> None:
    with pytest.raises(InputError, match=r"record\['it'\] at t = .* s: raised ValueError: late") as caught:
        run(TETHER, 2e-3, every=5e-4, frames=2, record={"it": _late})
    assert caught.value.run.history["time"].tolist() == [0.0, 5e-4]
    assert caught.value.run.outcome.startswith("failed: InputError")


def _late(sim: Simulation) -> float:
    if sim.time > 9e-4:
        raise ValueError("late")
    return 0.0


def test_record_needs_a_history() -> None:
    with pytest.raises(InputError, match="record"):
        Simulation(scenes.load(TETHER)).run(1e-3, record={"speed": speed})


def test_a_run_with_measures_is_resumed_with_them(tmp_path: Path) -> None:
    whole = tmp_path / "whole"
    run_copied(Simulation(scenes.load("single-crease")), whole, record=RECORD, samples=None, every=1e-3)
    left = tmp_path / "left-4"
    for record, words in (
        (None, r"records 'speed', a function.*record=\{'speed': ..., 'twice': ...\}"),
        ({"speed": (speed, "m/s")}, "records 'twice'"),
        ({**RECORD, "more": speed}, "does not record it"),
        ({**RECORD, "speed": (speed, "km/s")}, "give that unit"),
    ):
        with pytest.raises(InputError, match=words):
            resume(left, record=record)
    again = resume(left, record=RECORD)
    assert again.time == 0.02
    assert contents(left) == contents(whole)
    assert dict(open_run(left).history.units) == dict(open_run(whole).history.units)
    resume(left, 0.025, record=RECORD)
    assert open_run(left).history["time"][-2:].tolist() == [0.024, 0.025]


def test_known_measures_are_resumed_without_being_given(tmp_path: Path) -> None:
    whole = tmp_path / "whole"
    run_copied(Simulation(scenes.load("single-crease")), whole, record=["largest_speed", "hub_angle"])
    left = tmp_path / "left-4"
    for record, words in (
        ({"largest_speed": (speed, "m/s")}, "records the known measure of that name; leave it out"),
        (["contact_force"], "does not record it; leave it out"),
    ):
        with pytest.raises(InputError, match=words):
            resume(left, record=record)
    resume(left)
    assert contents(left) == contents(whole)
    resume(tmp_path / "left-5", record=["hub_angle", "largest_speed"])
    assert contents(tmp_path / "left-5") == contents(whole)


def test_a_function_with_the_name_of_a_known_measure_stays_a_function(tmp_path: Path) -> None:
    whole = tmp_path / "whole"
    record: dict[str, Any] = {"largest_speed": (lambda sim: sim.time, "m/s"), "contact_force": None}
    run_copied(Simulation(scenes.load("single-crease")), whole, record=record)
    with pytest.raises(InputError, match="records 'largest_speed', a function"):
        resume(tmp_path / "left-4")
    with pytest.raises(InputError, match="records 'largest_speed', a function"):
        resume(tmp_path / "left-4", record=["largest_speed"])
    resume(tmp_path / "left-4", record={"largest_speed": record["largest_speed"]})
    assert contents(tmp_path / "left-4") == contents(whole)


def test_columns_stand_in_the_order_of_the_run_whichever_way_they_are_given_again(tmp_path: Path) -> None:
    whole = tmp_path / "whole"
    record: dict[str, Any] = {"contact_force": None, "speed": (speed, "m/s"), "largest_speed": None}
    run_copied(Simulation(scenes.load("single-crease")), whole, record=record)
    again = resume(tmp_path / "left-4", record=dict(reversed(record.items())))
    assert again.time == 0.02
    assert contents(tmp_path / "left-4") == contents(whole)
    assert list(open_run(whole).history)[-3:] == list(record)


def test_more_measures_than_a_table_has_are_refused() -> None:
    with pytest.raises(InputError, match="record: 1001 measures; must be at most 1000"):
        run(TETHER, 1e-3, record={f"m{k}": speed for k in range(1001)})


def test_zero_has_no_sign() -> None:
    result = run(TETHER, 1e-3, samples=2, frames=2, record={"zero": lambda _: -0.0})
    assert not np.signbit(result.history["zero"]).any()
