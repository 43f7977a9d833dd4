"""Old names of attributes, fields and keys: each leads to the new one, and its warning says which that is."""

from __future__ import annotations

import pickle
from dataclasses import replace
from inspect import signature
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from membrane_rs import InputError, Mesh, RunSettings, Scene, SceneError, Simulation, scenes
from membrane_rs._renamed import new_names
from membrane_rs.results import Experiment
from membrane_rs.simulation import Motion
from membrane_rs.study import LengthScales, calibrate, compare


def test_settle_is_now_relax() -> None:
    by_new_name, by_old_name = (Simulation(scenes.load("spinning-tether")) for _ in range(2))
    speed = by_new_name.relax(1e-4, 50.0)
    with pytest.warns(DeprecationWarning, match=r"Simulation\.settle is deprecated .*; use relax") as warned:
        assert by_old_name.settle(1e-4, 50.0) == speed
    old = [warning for warning in warned if warning.category is DeprecationWarning]
    assert [warning.filename for warning in old] == [__file__]
    assert (by_old_name.positions == by_new_name.positions).all()


def test_figure_of_a_comparison_is_now_plot() -> None:
    times, values = np.arange(3.0), np.array([1.0, 2.0, 3.0])
    found: Any = compare([Experiment(name, times, {"hub_force": values}, {"hub_force": "N"}) for name in "ab"])
    with pytest.warns(DeprecationWarning, match=r"Comparison\.figure is deprecated .*; use plot") as warned:
        figure = found.figure(title="forces")
    assert [warning.filename for warning in warned] == [__file__]
    assert len(figure.axes) == len(found.plot().axes) == 1


@pytest.mark.parametrize("kind", [RunSettings, Simulation, Motion], ids=lambda kind: kind.__name__)
def test_old_attributes_lead_to_the_new_ones(kind: Any) -> None:
    one: Any = RunSettings() if kind is RunSettings else kind(scenes.load("spinning-tether"))
    assert new_names(kind)
    for old, new in new_names(kind).items():
        with pytest.warns(DeprecationWarning, match=f"{kind.__name__}.{old} is deprecated .*; use {new}$") as warned:
            assert getattr(one, old) == getattr(one, new)
        assert [warning.filename for warning in warned] == [__file__]


def test_old_settings_are_read_where_they_were_written(tmp_path: Path) -> None:
    old: dict[str, Any] = {"short_steps": 4, "settle": 0.01, "settle_rate": 50.0}
    settings = RunSettings(substeps=4, relax=0.01, relax_rate=50.0)
    for name, value in old.items():
        new = new_names(RunSettings)[name]
        with pytest.warns(DeprecationWarning, match=f"RunSettings.{name} is deprecated .*; use {new}"):
            assert getattr(RunSettings(**{name: value}), new) == value
        with pytest.warns(DeprecationWarning, match=f"; use {new}"):
            assert getattr(replace(settings, **{name: 2 * value}), new) == 2 * value
    scene = scenes.load("spinning-tether")
    text = scene.to_toml() + "short_steps = 4\n"
    (tmp_path / "both.toml").write_text(text)
    with pytest.raises(SceneError, match=r"run\.short_steps: is the old name of substeps, which is there too"):
        Scene.from_toml(tmp_path / "both.toml")
    (tmp_path / "old.toml").write_text(text.replace("substeps = 1\n", ""))
    with pytest.warns(DeprecationWarning, match="run.short_steps is deprecated .*; write substeps"):
        assert Scene.from_toml(tmp_path / "old.toml").run.substeps == 4
    assert scene.with_values({"run.short_steps": 3}).run.substeps == 3


def test_a_call_of_calibrate_as_it_was_leads_to_match_scene(tmp_path: Path) -> None:
    """It fitted one parameter to another scene; the call is refused by `match_scene`, before anything runs."""
    sail, old = scenes.load("okuizumi-model-1"), cast("Any", calibrate)
    by_place = (sail, "laws.springs.buckling", (2.0, 1.0), sail, tmp_path)
    names = ("scene", "parameter", "between", "target", "folder")
    calls: list[tuple[tuple[Any, ...], dict[str, Any]]] = [
        (by_place, {"tries": 2}),
        ((), dict(zip(names, by_place, strict=True))),
    ]
    for args, named in calls:
        with (
            pytest.warns(
                DeprecationWarning, match=r"arguments of match_scene is deprecated .*; call match_scene"
            ) as warned,
            pytest.raises(InputError, match=r"between = .*the lower one first"),
        ):
            old(*args, **named)
        assert [warning.filename for warning in warned] == [__file__]
    with pytest.raises(InputError, match="vary"):
        old(sail, "data.csv", (2.0, 1.0))
    assert list(signature(calibrate).parameters)[:3] == ["scene", "data", "vary"]


def test_a_saved_state_with_old_names_is_read(tmp_path: Path) -> None:
    sim = Simulation(scenes.load("spinning-tether"))
    sim.relax(1e-4, 50.0)
    sim.save(tmp_path / "new.npz")
    with np.load(tmp_path / "new.npz") as file:
        entries = dict(file)
    entries["is_settled"] = entries.pop("is_relaxed")
    text = entries["scene/scene.toml"].tobytes().replace(b"\nrelax_rate =", b"\nsettle_rate =")
    entries["scene/scene.toml"] = np.frombuffer(text, np.uint8)
    np.savez(tmp_path / "old.npz", **entries)
    with pytest.warns(DeprecationWarning, match="run.settle_rate is deprecated"):
        again = Simulation.restore(tmp_path / "old.npz")
    assert again.is_relaxed
    assert (again.positions == sim.positions).all()


def test_a_saved_state_with_the_old_name_of_a_methods_history_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    whole, first = (Simulation(scenes.load("spinning-tether"), "leapfrog") for _ in range(2))
    whole.step(50)
    first.step(20)
    first.save(tmp_path / "new.npz")
    with np.load(tmp_path / "new.npz") as file:
        entries = {name.replace("history_", "memory_"): file[name] for name in file.files}
    assert {"memory_count", "memory_vectors", "memory_numbers"} < entries.keys()
    np.savez(tmp_path / "old.npz", **entries)
    again = Simulation.restore(tmp_path / "old.npz")
    again.step(30)
    assert (again.positions == whole.positions).all()
    assert (again.velocities == whole.velocities).all()


def test_an_old_attribute_of_findings() -> None:
    finding = Mesh(np.array([[0, 0, 0], [1, 0, 0], [0.5, 0.01, 0]]), [[0, 1, 2]]).audit().findings[0]
    with pytest.warns(DeprecationWarning, match=r"Finding\.cure is deprecated .*; use remedy"):
        assert getattr(finding, "cure") == finding.remedy != ""  # noqa: B009


def test_an_old_key_of_the_ledger() -> None:
    ledger = Simulation(scenes.load("spinning-tether")).ledger()
    with pytest.warns(DeprecationWarning, match="'turned_over'. is deprecated .*; use 'reference_energy'") as warned:
        assert ledger["turned_over"] == ledger.get("turned_over") == ledger["reference_energy"]
    assert {warning.filename for warning in warned} == {__file__}
    assert "turned_over" not in ledger
    assert ledger.get("nothing") is None
    with pytest.raises(KeyError, match="nothing"):
        ledger["nothing"]


def test_a_copy_of_a_ledger_answers_the_old_key_too() -> None:
    ledger = Simulation(scenes.load("spinning-tether")).ledger()
    with pytest.warns(DeprecationWarning, match="use 'reference_energy'"):
        assert ledger.copy()["turned_over"] == ledger["reference_energy"]


def test_an_old_attribute_is_set_under_its_new_name() -> None:
    sim: Any = Simulation(scenes.load("spinning-tether"))
    with pytest.warns(DeprecationWarning, match=r"Simulation\.is_settled is deprecated .*; use is_relaxed"):
        sim.is_settled = True
    assert sim.is_relaxed is True


def test_an_old_name_is_found_on_the_class() -> None:
    for kind, old in ((Simulation, "settle"), (RunSettings, "short_steps")):
        with pytest.warns(DeprecationWarning, match=rf"{kind.__name__}\.{old} is deprecated"):
            assert getattr(kind, old) == getattr(kind, new_names(kind)[old])


def test_settings_that_were_pickled_under_old_names_keep_their_values() -> None:
    settings = RunSettings()
    new = RunSettings.__new__(RunSettings)
    pickled = {**vars(settings), "short_steps": 4}
    del pickled["substeps"]
    new.__setstate__(pickled)  # type: ignore[attr-defined]
    assert new == replace(settings, substeps=4)
    assert pickle.loads(pickle.dumps(new)) == new


def test_length_scales_take_the_old_name_of_facet() -> None:
    with pytest.warns(DeprecationWarning, match=r"LengthScales\.wing is deprecated .*; use facet"):
        scales: Any = LengthScales(**{"wing": 0.01})  # type: ignore[arg-type]
    with pytest.warns(DeprecationWarning, match="use facet"):
        assert scales.wing == scales.facet == 0.01
