"""Nothing that a user slips in is ignored: neither an attribute that no public class has, nor an entry of a state."""

from __future__ import annotations

import importlib
import pkgutil
from enum import Enum
from pathlib import Path
from typing import Any

import membrane_rs
import numpy as np
import pytest
from membrane_rs import InputError, Mesh, RunSettings, Scene, Simulation, UnknownAttributeError, scenes
from membrane_rs._known_attributes import KnownAttributes
from membrane_rs.folding import Strip
from membrane_rs.runs import RunFolder


def public_classes() -> list[type]:
    """The classes that the packages export, but for errors, protocols and texts."""
    packages = [membrane_rs.__name__]
    packages += [
        f"{membrane_rs.__name__}.{found.name}"
        for found in pkgutil.iter_modules(membrane_rs.__path__)
        if found.ispkg and not found.name.startswith("_")
    ]
    classes = {
        item
        for module in map(importlib.import_module, packages)
        for item in (getattr(module, name) for name in getattr(module, "__all__", ()))
        if isinstance(item, type)
        and not issubclass(item, BaseException | Enum | str)
        and not getattr(item, "_is_protocol", False)
    }
    return sorted(classes, key=lambda kind: kind.__name__)


@pytest.mark.parametrize("kind", public_classes())
def test_no_public_class_takes_an_unknown_attribute(kind: Any) -> None:
    parameters = getattr(kind, "__dataclass_params__", None)
    assert issubclass(kind, KnownAttributes | tuple) or (parameters is not None and parameters.frozen)


def test_the_walk_finds_them() -> None:
    names = {kind.__name__ for kind in public_classes()}
    assert {"Mesh", "Scene", "Spin", "Tether", "Material", "RunSettings", "SquareSail", "Audit", "HubLoad"} <= names
    assert {"Simulation", "RunFolder", "WorkPrecision", "NetModuli"} <= names


SCENE = scenes.load("spinning-tether")
MESH = Strip(0.1, 0.02, 4, 1).mesh()


@pytest.mark.parametrize("thing", [*SCENE.laws, *SCENE.parts, SCENE, SCENE.run, MESH, Strip(0.1, 0.02, 4, 1)])
def test_a_typo_is_refused(thing: object) -> None:
    with pytest.raises(AttributeError, match="typo"):
        thing.typo = 3  # type: ignore[attr-defined]
    assert not hasattr(thing, "typo")


@pytest.mark.parametrize("name", ["positions", "reference", "fold_angles", "source", "edges", "node_count"])
def test_a_mesh_is_read_only(name: str) -> None:
    before = getattr(MESH, name)
    with pytest.raises(AttributeError):
        setattr(MESH, name, before)
    with pytest.raises(UnknownAttributeError, match=r"Mesh\.position: no such attribute; nothing can be set"):
        MESH.position = before  # type: ignore[attr-defined]


def test_a_class_of_a_user_may_have_more(tmp_path: Path) -> None:
    class Marked(Mesh):
        mark = 0

    own = Marked(MESH.reference, MESH.triangles)
    own.mark, own.name = 1, "mine"  # type: ignore[attr-defined]
    folder = RunFolder(tmp_path / "run")
    with pytest.raises(UnknownAttributeError, match=r"RunFolder\.picture: no such attribute"):
        folder.picture = False  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("velocity", "did you mean 'velocities'"),
        ("time", "no such entry"),
        ("history_spring_vectors", "no such entry; did you mean 'history_springs_vectors'"),
        (3, "3: no such entry"),
    ],
)
def test_an_entry_that_no_state_has_is_refused(name: Any, words: str) -> None:
    scene = Scene(MESH, membrane_rs.Material(1e6, 0.3, 1e3, 1e-4), [membrane_rs.Springs()], run=RunSettings(until=0.1))
    sim = Simulation(scene)
    before = sim.state()
    with pytest.raises(InputError, match=f"saved state: {words}" if words[0] == "3" else words):
        sim.set_state({**before, name: 1.0})
    sim.set_state(before)


@pytest.mark.parametrize("method", list(membrane_rs.integrators()))
def test_what_a_state_has_is_known(method: str) -> None:
    sim = Simulation(SCENE, method)
    sim.step(3)
    sim.reach(sim.time + 0.5 * sim.dt)
    other = Simulation(SCENE, method)
    other.set_state(sim.state())
    assert (other.positions == sim.positions).all()


def test_an_unknown_entry_of_a_file_is_told(tmp_path: Path) -> None:
    path = tmp_path / "state.npz"
    Simulation(SCENE).save(path)
    with np.load(path) as archive:
        entries = dict(archive)
    np.savez(path, **entries, velocity=np.zeros(3))
    with pytest.warns(UserWarning, match=r"state\.npz: velocity is ignored: no such entry; did you mean 'velocities'"):
        Simulation.restore(path)
