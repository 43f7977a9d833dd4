"""What docs/compatibility.md says of older and newer files."""

from __future__ import annotations

import pkgutil
import re
from collections.abc import Callable
from dataclasses import fields, replace
from importlib import import_module
from pathlib import Path

import membrane_rs
import numpy as np
import pytest
from membrane_rs import (
    InputError,
    RunSettings,
    Scene,
    SceneError,
    Simulation,
    SpringDamping,
    Springs,
    integrators,
    scenes,
)
from membrane_rs.folding import Disc
from small_scenes import RUBBER

SCENE = scenes.load("spinning-tether")
SPARE = """
[[parts]]
kind = "tether"
start = [0, 0, 0]
end = [1, 0, 0]
segments = 2
axial_stiffness = 10.0
linear_density = 1e-3
[laws.spring_damping]
[run]
until = 1.0
"""
Entries = dict[str, np.ndarray]


def saved(folder: Path, change: Callable[[Entries], object]) -> Path:
    """A saved state with other entries."""
    sim = Simulation(SCENE)
    sim.step(3)
    sim.save(folder / "state.npz")
    with np.load(folder / "state.npz") as file:
        entries: Entries = dict(file)
    change(entries)
    np.savez(folder / "state.npz", **entries)  # type: ignore[arg-type]
    return folder / "state.npz"


def test_public_names_are_those_of_the_packages_that_the_page_lists() -> None:
    page = (Path(__file__).parent.parent / "docs" / "compatibility.md").read_text(encoding="utf-8")
    first = page.split("Public are:")[1].split(";")[0]
    listed = sorted(
        name if name == "membrane_rs" else f"membrane_rs.{name}" for name in re.findall("`([a-z_.]+)`", first)
    )
    listed.remove("membrane_rs.__all__")
    found = ["membrane_rs"]
    for info in pkgutil.walk_packages(membrane_rs.__path__, "membrane_rs."):
        if info.ispkg and info.name != "membrane_rs.cli" and hasattr(import_module(info.name), "__all__"):
            found.append(info.name)
    assert set(found) <= set(listed), "every package with public names is listed, and some modules"
    for place in listed:
        module = import_module(place)
        assert all(hasattr(module, name) for name in module.__all__)


def test_an_older_scene_takes_defaults_for_keys_that_came_later(tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(SPARE, encoding="utf-8")
    scene = Scene.from_toml(file)
    assert scene.law("spring_damping") == SpringDamping()
    assert scene.run.tolerance == RunSettings(until=1.0).tolerance


@pytest.mark.parametrize("name", scenes.names())
def test_a_written_scene_holds_every_value(name: str, tmp_path: Path) -> None:
    scene = scenes.load(name)
    scene.save(tmp_path)
    text = (tmp_path / "scene.toml").read_text(encoding="utf-8")
    held = {line.removeprefix("# ").split(" = ")[0].split(":")[0] for line in text.splitlines()}
    for item in (scene.material, *scene.laws, *scene.parts, scene.run):
        if item is not None:
            # The end of a run in stages is that of the last stage.
            assert {entry.name for entry in fields(item)} - held <= ({"until"} if scene.stages else set())


def test_a_newer_scene_is_refused_by_the_key_that_is_not_known(tmp_path: Path) -> None:
    SCENE.save(tmp_path)
    file = tmp_path / "scene.toml"
    file.write_text(file.read_text(encoding="utf-8") + "until_rest = 1.0\n", encoding="utf-8")
    with pytest.raises(SceneError, match=r"run\.until_rest: no such key"):
        Scene.from_toml(file)


def test_an_older_state_is_refused_by_the_entry_that_it_lacks(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="origin is missing"):
        Simulation.restore(saved(tmp_path, lambda entries: entries.pop("origin")))


LATER = ("hub_phase", "scene_digest", "start_internal_kinetic")
"""Entries of a state that version 0.1 did not write."""


@pytest.mark.parametrize("method", integrators())
def test_a_state_of_version_0_1_is_read(tmp_path: Path, method: str) -> None:
    scene = replace(scenes.load("spinning-tether"), run=RunSettings(until=0.1, integrator=method))
    before = Simulation(scene)
    before.step(30)
    before.save(tmp_path / "new.npz")
    with np.load(tmp_path / "new.npz") as file:
        np.savez(tmp_path / "old.npz", **{name: value for name, value in file.items() if name not in LATER})
    sim = Simulation.restore(tmp_path / "old.npz")
    for one in (before, sim):
        one.run(until=0.1)
    assert before.state().keys() == sim.state().keys()
    assert all(np.array_equal(value, sim.state()[name]) for name, value in before.state().items())
    assert sim.ledger() == before.ledger()


def test_a_state_of_version_0_1_in_which_nothing_is_held_is_refused_by_name(tmp_path: Path) -> None:
    free = Scene(Disc(0.1, 1).mesh(), RUBBER, [Springs()], run=RunSettings(until=0.1))
    Simulation(free).save(tmp_path / "new.npz")
    with np.load(tmp_path / "new.npz") as file:
        np.savez(tmp_path / "old.npz", **{name: value for name, value in file.items() if name not in LATER})
    with pytest.raises(InputError, match="holds no 'start_internal_kinetic', which a scene needs that nothing holds"):
        Simulation.restore(tmp_path / "old.npz")


def test_an_entry_of_a_newer_state_is_passed_over(tmp_path: Path) -> None:
    sim = Simulation.restore(saved(tmp_path, lambda entries: entries.update(later=np.zeros(2))))
    plain = Simulation(SCENE)
    plain.step(3)
    np.testing.assert_array_equal(sim.positions, plain.positions)


def test_a_newer_state_is_refused_by_a_key_of_its_scene(tmp_path: Path) -> None:
    def change(entries: Entries) -> None:
        text = entries["scene/scene.toml"].tobytes() + b"until_rest = 1.0\n"
        entries["scene/scene.toml"] = np.frombuffer(text, np.uint8)

    with pytest.raises(InputError, match=r"run\.until_rest: no such key"):
        Simulation.restore(saved(tmp_path, change))
