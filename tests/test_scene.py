"""Scenes: what is built in, what they are assembled to, and what they refuse."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import Simulation, scenes
from membrane_rs.errors import InputError, InputTypeError, SceneError
from membrane_rs.scene import Scene
from membrane_rs.scene.laws import Spin, SpoolContact, Springs
from membrane_rs.scene.parts import Bridges, Fixed, Tether, Tethers, TipMasses
from membrane_rs.scene.run_settings import RunSettings
from small_scenes import FILM, patch

CORD = Tether((0.1, 0, 0), (0.4, 0, 0), segments=3, axial_stiffness=100.0, linear_density=1e-4, tip_mass=0.01)


@pytest.mark.parametrize("name", scenes.names())
def test_built_in_scenes_survive_their_own_toml(name: str, tmp_path: Path) -> None:
    scene = scenes.load(name)
    assert scene.name == name
    scene.save(tmp_path)
    again = Scene.from_toml(tmp_path / "scene.toml")
    assert again.to_toml() == scene.to_toml()
    assert (again.laws, again.parts, again.run, again.material) == (
        scene.laws,
        scene.parts,
        scene.run,
        scene.material,
    )
    for field in dataclasses.fields(scene.assemble()):
        mine, theirs = getattr(scene.assemble(), field.name), getattr(again.assemble(), field.name)
        if isinstance(mine, np.ndarray):
            assert mine.dtype == theirs.dtype
            assert (mine == theirs).all()


@pytest.mark.parametrize("name", ["okuizumi-model-1", "okuizumi-model-2"])
def test_counts_of_table_2(name: str) -> None:
    counts = scenes.load(name).counts()
    assert (counts["masses"], counts["springs"], counts["elements"]) == (1980, 5432, 3456)
    assert (counts["nodes"], counts["edges"], counts["triangles"]) == (1980 - 68, 5432 - 64, 3456)


@pytest.mark.parametrize("name", ["okuizumi-model-1", "okuizumi-model-2"])
def test_tethers_of_the_sail(name: str) -> None:
    assembly = scenes.load(name).assemble()
    ends = assembly.positions[assembly.cords.nodes]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    assert lengths == pytest.approx(assembly.cords.rest_length, rel=1e-12)  # no strain when stowed
    assert assembly.cords.rest_length * 19 == pytest.approx(47.8e-3, abs=0.05e-3)  # Table 1
    assert np.hypot(*assembly.positions[assembly.contacts.nodes, :2].T).min() > 0.025
    anchors = assembly.positions[assembly.fixed]
    assert np.hypot(anchors[:, 0], anchors[:, 1]) == pytest.approx(0.025)
    assert np.degrees(np.arctan2(anchors[:, 1], anchors[:, 0])) % 360 == pytest.approx([45, 135, 225, 315])
    assert assembly.extra_masses.sum() == pytest.approx(4 * (0.36e-3 + 1.004e-4 * 47.83e-3), rel=1e-5)


def test_every_scene_says_what_it_is() -> None:
    assert {
        "okuizumi-model-1",
        "okuizumi-model-2",
        "spinning-tether",
        "spinning-disc",
        "single-crease",
    } < set(scenes.names())
    assert all(len(text) > 30 and text.endswith(".") for text in map(scenes.describe, scenes.names()))
    with pytest.raises(SceneError, match="did you mean 'okuizumi-model-1'"):
        scenes.load("okuizumi-mode-1")


def test_assembly_of_mesh_and_cord() -> None:
    scene = Scene(patch(), FILM, [SpoolContact()], [CORD, Fixed([0]), TipMasses(1.0), TipMasses(2.0, "tether-0-end")])
    assembly = scene.assemble()
    assert assembly.node_count == 8
    assert assembly.cords.nodes.tolist() == [[4, 5], [5, 6], [6, 7]]
    assert assembly.cords.rest_length == pytest.approx(0.1)
    assert assembly.cords.stiffness == pytest.approx(1000.0)
    assert assembly.fixed.tolist() == [0, 4]
    assert assembly.creases.fold_signs.tolist() == [-1.0]
    assert assembly.contacts.nodes.tolist() == [5, 6, 7]
    assert assembly.extra_masses == pytest.approx([0, 1, 0, 1, 0.5e-5, 1e-5, 1e-5, 2.01 + 0.5e-5])
    assert assembly.node_sets["tether-0"].tolist() == [4, 5, 6, 7]
    assert not assembly.positions.flags.writeable
    assert scene.assemble() is assembly
    assert scene.counts() == {
        "masses": 8,
        "springs": 8,
        "elements": 2,
        "nodes": 8,
        "edges": 8,
        "triangles": 2,
        "hinges": 1,
    }
    touched = Scene(patch(), FILM, [SpoolContact(membrane=True)], [CORD]).assemble()
    assert touched.contacts.nodes.tolist() == [0, 1, 2, 3, 5, 6, 7]


def test_tethers_hold_mesh_nodes() -> None:
    assembly = Scene(patch(), FILM, (), [Tethers([0, 2], anchor_radius=0.02, segments=2)]).assemble()
    assert assembly.cords.nodes.tolist() == [[4, 5], [5, 0], [6, 7], [7, 2]]
    assert assembly.fixed.tolist() == [4, 6]
    assert assembly.positions[6] == pytest.approx(0.02 * np.array([2, 1, 0]) / np.sqrt(5))
    assert assembly.node_sets["tether-1-end"].tolist() == [2]


def test_bridges_need_their_stiffness_and_the_other_way_round() -> None:
    bridged = patch(bridges=[[1, 3]])
    assert Scene(bridged, FILM, (), [Bridges(1e4)]).assemble().bridges.stiffness == 1e4
    with pytest.raises(SceneError, match="1 bridges; add a part of kind 'bridges'"):
        Scene(bridged, FILM)
    with pytest.raises(SceneError, match="no bridges; leave that part out"):
        Scene(patch(), FILM, (), [Bridges(1e4)])
    with pytest.raises(SceneError, match="one part of kind 'bridges'"):
        Scene(bridged, FILM, (), [Bridges(1e4), Bridges(1e4)])


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ((None, None), SceneError, "a scene needs nodes"),
        ((patch(), None), SceneError, "material: is missing"),
        ((patch(), FILM, [Springs(), Springs()]), SceneError, "laws.springs: is there 2 times"),
        ((patch(), FILM, [Springs]), InputTypeError, r"laws\[0\] = .*with its brackets"),
        ((patch(), FILM, Springs()), InputTypeError, "must be a list of laws"),
        ((patch(), FILM, [CORD]), InputTypeError, r"laws\[0\]"),
        ((patch(), FILM, (), [Spin()]), InputTypeError, r"parts\[0\]"),
        (("mesh", FILM), InputTypeError, "Scene.mesh = 'mesh': must be a Mesh"),
        ((patch(), "film"), InputTypeError, "Scene.material"),
        ((patch(), FILM, (), [Fixed("cornes")]), SceneError, "no such node set; did you mean 'corners'"),
        ((patch(), FILM, (), [Fixed([9])]), SceneError, "node 9 is not there; must be from 0 to 3"),
        ((patch(), FILM, (), [Tethers([4])]), SceneError, "node 4 is not there"),
        ((None, None, (), [Tethers([4])]), SceneError, "there is no mesh"),
        ((None, None, (), [Tethers()]), SceneError, "this scene has none"),
        ((patch(), FILM, (), [Tethers([0], anchor_radius=0.1)]), SceneError, "lies on the rim"),
        ((patch(), FILM, (), [Tethers([0], length=1.0, segments=1)]), SceneError, "2 segments or more"),
        ((patch(node_sets={"tether-0": [1]}), FILM, (), [CORD]), SceneError, "'tether-0' is taken"),
        (
            (None, None, (), [Tether((0, 0, 0), (1, 0, 0), 2, 1.0, 0.0, tip_mass=1.0)]),
            SceneError,
            "node 1 has no mass",
        ),
        ((patch(), FILM, (), (), "positional"), TypeError, "positional"),
    ],
)
def test_bad_scenes(arguments: tuple[Any, ...], error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        Scene(*arguments)


def test_bad_name_and_run() -> None:
    with pytest.raises(InputTypeError, match=r"Scene\.run"):
        Scene(patch(), FILM, run={"until": 1})  # type: ignore[arg-type]
    with pytest.raises(InputTypeError, match=r"Scene\.name"):
        Scene(patch(), FILM, name=3)  # type: ignore[arg-type]
    for name in ("", ".", "..", "a/b", "/a", "a\\b", "a\0b", 101 * "a"):
        with pytest.raises(SceneError, match=r"Scene\.name = .*must be 1 to 100 characters without slash"):
            Scene(patch(), FILM, name=name)
    assert Scene(patch(), FILM, name=100 * "a").name == 100 * "a"


def test_cords_that_fit_no_memory_are_refused_before_they_are_made() -> None:
    words = r"parts\[0\]\.segments = 500000000: makes .* cord nodes .* at most 10000000"
    with pytest.raises(SceneError, match=words):
        Scene(patch(), FILM, parts=[Tethers("corners", segments=5 * 10**8)])
    with pytest.raises(SceneError, match=words):
        Scene(None, None, parts=[dataclasses.replace(CORD, segments=5 * 10**8)])
    with pytest.raises(InputError, match="segments = 1000000001: must be at least 1 and at most"):
        Tethers(segments=10**9 + 1)


def test_node_indices_beyond_all_bounds() -> None:
    with pytest.raises(InputError, match="none below 0 or above 1000000000"):
        Fixed([10**23])


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"until": 0}, r"until = 0: must be greater than 0 \(s\)"),
        ({"dt": 0}, r"dt = 0: must be greater than 0 \(s\)"),
        ({"until": 5e-324}, r"until = 5e-324: must be from 1e-15 to 1e\+12 \(s\)"),
        ({"until": 1e300}, r"until = 1e\+300: must be from 1e-15 to 1e\+12 \(s\)"),
        ({"dt": float("nan")}, "dt = nan: must be finite"),
        ({"frames": 1}, "frames = 1: must be at least 2"),
        ({"frames": 10**7 + 1}, r"frames = 10000001: must be at least 2 and at most 1e\+07"),
        ({"samples": 10**12}, r"samples = 1000000000000: must be at least 2 and at most 1e\+07"),
        ({"watch": 10**20}, r"watch = 10+: must be at least 1 and at most 1e\+09"),
        ({"samples": 2.5}, "whole number"),
        ({"snapshots": [-1]}, "at least 0"),
        ({"relax": -1}, "at least 0"),
        ({"integrator": 4}, "integrator"),
    ],
)
def test_bad_run_settings(values: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        RunSettings(**values)


def motion(name: str, until: float, node: int, axis: int) -> tuple[np.ndarray[Any, Any], Simulation]:
    """One coordinate of one node at 200 instants, and the simulation at the end."""
    sim = Simulation(scenes.load(name))
    values = []
    for _ in range(200):
        sim.step(round(until / 200 / sim.dt))
        values.append(sim.positions[node, axis])
    return np.array(values), sim


def test_small_scenes_give_their_known_answers() -> None:
    tip, sim = motion("spinning-tether", 2.0, -1, 1)
    crossings = np.flatnonzero(np.diff(np.sign(tip)))
    period = 2 * np.diff(crossings).mean() * sim.time / 200
    assert period == pytest.approx(0.577, rel=0.03)  # ten degrees is not quite small

    tip, sim = motion("hanging-strip", 4.0, -2, 0)
    spectrum = np.abs(np.fft.rfft((tip - tip.mean()) * np.hanning(200), 8000))
    assert spectrum.argmax() / (8000 * sim.time / 200) == pytest.approx(6.88 / (2 * np.pi), rel=0.01)

    _, sim = motion("single-crease", 0.3, -1, 2)
    assert sim.crease_angles() == pytest.approx(np.pi, abs=0.01)
