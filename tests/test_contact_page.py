"""The scripts of docs/contact.md: where a section passes through itself, times and features over starts, sheets."""

from __future__ import annotations

import contact_runs as runs
import contact_tables as tables
import numpy as np
import pytest
from contact_pictures import CUT, meetings, section
from contact_roll import INTERVAL, READINGS, roll, roll_table
from contact_sheets import sheets_table, thrown
from contact_strip import pressed, strip_table
from contact_whole import ROWS, deployed, whole_table
from membrane_rs import SelfContact, scenes


def test_lines_meet_where_they_pass_through_each_other_and_not_where_they_join() -> None:
    cross = np.array([[[0.0, 0.0], [2.0, 2.0]], [[0.0, 2.0], [2.0, 0.0]]])
    assert meetings(cross) == pytest.approx(np.array([[1.0, 1.0]]))
    chain = np.array([[[0.0, 0.0], [1.0, 0.1]], [[1.0, 0.1], [0.3, 0.7]], [[0.3, 0.7], [0.1, 0.9]]])
    assert len(meetings(chain)) == 0
    assert len(meetings(np.array([[[0.0, 0.0], [1.0, 0.0]], [[0.0, 1.0], [1.0, 1.0]]]))) == 0


def test_a_section_holds_one_line_of_each_triangle_that_it_cuts() -> None:
    tip = np.array([0.0, 0.2, 0.0])
    height = 0.2 - CUT
    shape = np.array([[-0.01, height - 0.01, 0.0], [0.01, height - 0.01, 0.0], [0.0, height + 0.01, 0.02], tip])
    lines = section(np.array([[0, 1, 2]]), shape, tip)
    assert lines.shape == (1, 2, 2)
    assert np.sort(np.abs(lines[0, :, 0])) == pytest.approx([0.005, 0.005])
    assert lines[0, :, 1] == pytest.approx([0.01, 0.01])
    assert len(section(np.array([[0, 1, 2]]), shape + np.array([0.0, 0.05, 0.0]), tip)) == 0


def test_ratios_are_medians_over_the_starts() -> None:
    steps = np.arange(11.0)
    kinds = {runs.OWN: [{"seconds": steps}] * 3, runs.WITH: [{"seconds": factor * steps} for factor in (2.0, 9.0, 3.0)]}
    assert tables.ratios(kinds, (0, 5, 10)) == pytest.approx([3.0, 3.0])


def test_what_contact_spends_is_that_of_a_step(monkeypatch: pytest.MonkeyPatch) -> None:
    steps = 4.0 * np.arange(11.0)
    own = [{"seconds": 3e-6 * steps, "steps": steps}] * 3
    spent = {name: steps * (k + 1) * (1.0 if k < 3 else 1e-6) for k, name in enumerate(runs.SPENT)}
    kinds = {runs.OWN: own, runs.WITH: [{**spent, "steps": steps, "seconds": 30e-6 * steps}] * 3}
    assert tables.per_step(own, "seconds", (0, 5, 10)) == pytest.approx([3e-6, 3e-6])
    assert tables.times_of_step(kinds, (0, 10)) == {
        "film": [pytest.approx(3.0)], "looks at pairs": [pytest.approx(5.0)], "lists of pairs": [pytest.approx(4.0)],
        "impulses": [pytest.approx(6.0)], "exact checks": [pytest.approx(7.0)],
    }  # fmt: skip
    monkeypatch.setattr(tables, "SHOWN", (0, 10))
    listed = [line.split(" | ") for line in tables.spent_table(kinds).splitlines()]
    assert [line[1].strip(" |") for line in listed[2:]] == ["3", "5", "4", "6", "7", "30", "1", "2", "3"]


def test_scenes_differ_by_the_law_alone_and_go_by_leapfrog() -> None:
    for name in (*runs.MODELS, runs.fast(runs.MODELS[0])):
        own, other = (runs.scene_of(name, with_contact=with_contact) for with_contact in (False, True))
        assert own.laws == scenes.load(name).laws
        assert other.laws == (*own.laws, SelfContact())
        assert own.run == other.run
        assert own.run.integrator == "leapfrog"
    assert roll(with_contact=True).laws == (*roll(with_contact=False).laws, SelfContact())


def test_a_run_is_read_at_its_instants(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runs, "INSTANTS", 2)
    monkeypatch.setattr(runs, "COUNTED", (1, 2))
    scene = runs.scene_of(runs.fast(runs.MODELS[1]), with_contact=False).with_values({"run.until": 0.002})
    run = runs.unfolded(scene, 3)
    assert run["time"].tolist() == pytest.approx([0.0, 1e-3, 2e-3])
    assert run["counted"].tolist() == pytest.approx([0.0, 1e-3, 2e-3])
    assert run["crossings"][0] == 0 < run["crossings"][-1]
    assert np.all(np.diff(run["seconds"][1:]) > 0.0)
    assert np.isfinite([run[runs.RATE], run[runs.PHASE]]).all()
    assert run["work"].tolist() == [0.0, 0.0, 0.0]
    assert run["steps"][0] == 0 < run["steps"][1] < run["steps"][2]
    assert not any(run[name].any() for name in runs.SPENT)


def test_sheets_stop_each_other_by_contact_alone() -> None:
    without, run = (thrown(1.0, with_contact=with_contact, aligned=True) for with_contact in (False, True))
    assert without["below"] == 1.0
    assert without["energy"] == pytest.approx(1.0)
    assert run["below"] == run["crossings"] == run["stopped"] == 0.0
    assert [float(run[name][0]) for name in ("lower", "upper", "energy")] == pytest.approx([-0.5, -0.5, 0.5])
    assert abs(run["residual"]) < 1e-9
    assert sheets_table({"a": (without, run)}).splitlines()[2].startswith("| a | 100 | 0 | -0.500, -0.500 | 0.500 |")


def test_a_strip_that_is_folded_on_itself_lies_layer_by_layer() -> None:
    without, run = (pressed(with_contact=with_contact) for with_contact in (False, True))
    assert without["crossings"].max() > 50
    assert without["height"][-1] < 1e-3
    assert run["time"][-1] == pytest.approx(0.06)
    assert not run["crossings"].any()
    assert 1e-3 < run["height"][-1] < 0.4 * run["height"][0]
    assert np.abs(run["residual"]).max() < 3e-3
    listed = strip_table(without, {name: values[:-1] for name, values in run.items()}).splitlines()
    assert [line.split(" | ")[4].strip(" |") for line in listed[2:]] == ["0", "0", "0", "stopped"]


def test_a_roll_that_is_stopped_has_no_numbers_after_that() -> None:
    def at(*instants: float) -> dict[str, np.ndarray]:
        time = np.array(instants)
        return {
            "time": time, "crossings": 0.0 * time, "residual": 0.01 + 0.0 * time, "seconds": 2.0 * time,
        }  # fmt: skip

    every = np.arange(1, round(READINGS[-1] / INTERVAL) + 1) * INTERVAL
    rows = roll_table(at(*every), at(*every[:1])).splitlines()[2:]
    assert len(rows) == len(READINGS)
    assert rows[0] == f"| {INTERVAL:g} | 0 | +1.00 | 0 | +1.00 | 1 |"
    assert all("| stopped | - | - |" in row for row in rows[1:])


def test_the_whole_deployment_is_read_each_millisecond_up_to_its_time() -> None:
    runs_of = {kind: deployed(with_contact=kind, budget=0.05) for kind in (False, True)}
    for run in runs_of.values():
        assert run["time"] == pytest.approx(1e-3 * np.arange(1, len(run["time"]) + 1))
        assert run["seconds"][-1] > 0.05
        assert np.all(np.diff(run["seconds"]) > 0.0)
    assert len(runs_of[True]["time"]) <= len(runs_of[False]["time"])
    assert runs_of[True]["crossings"].max() == 0.0 < runs_of[False]["crossings"].max()
    rows = whole_table(runs_of[False], runs_of[True]).splitlines()[2:]
    assert len(rows) == min(ROWS, len(runs_of[True]["time"]))
    assert rows[-1].startswith(f"| {runs_of[True]['time'][-1]:.3f} | ")
