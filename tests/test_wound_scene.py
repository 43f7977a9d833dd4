"""A scene of the wound sail: its tethers, its energies, what `check` tells of it."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import Simulation, scenes
from membrane_rs.analysis.deployment import Corners
from membrane_rs.check import audit, facts
from membrane_rs.check.stowed_energy import stowed_energy
from membrane_rs.errors import SceneError
from membrane_rs.folding import SquareSail
from membrane_rs.folding._wound_petal import WoundPath
from membrane_rs.mesh import Mesh
from membrane_rs.scene import Scene
from membrane_rs.scene.laws import Springs
from membrane_rs.scene.parts import Tethers, TipMasses
from membrane_rs.simulation.measures import stowed_turn
from membrane_rs.simulation.stepper import Stepper


def scene_of(model: int, **dimensions: Any) -> Scene:
    scene = scenes.load(f"okuizumi-model-{model}")
    sail = mesh_of(scene).source
    assert isinstance(sail, SquareSail)
    return replace(scene, mesh=replace(sail, stowage="wound", **dimensions).mesh())


def mesh_of(scene: Scene) -> Mesh:
    assert scene.mesh is not None
    return scene.mesh


def path_of(scene: Scene) -> WoundPath:
    sail = mesh_of(scene).source
    assert isinstance(sail, SquareSail)
    return sail._wound_path()


def with_tethers(scene: Scene, **values: Any) -> Scene:
    return replace(scene, parts=[replace(part, **values) if part.kind == "tethers" else part for part in scene.parts])


@pytest.mark.parametrize("columns", [10, 11, 13])
def test_tethers_lie_along_the_arms_and_hang_below_the_sail(columns: int) -> None:
    scene = scene_of(1, columns=columns)
    assembly = scene.assemble()
    path = path_of(scene)
    for p in range(4):
        nodes = assembly.node_sets[f"tether-{p}"]
        points = assembly.positions[nodes]
        azimuth = np.unwrap((np.arctan2(points[:, 1], points[:, 0]) - math.pi / 2 * p) % (2 * math.pi))
        np.testing.assert_allclose(azimuth[0], math.pi / 4, rtol=1e-12)
        assert (np.diff(azimuth) > -1e-9).all()
        assert np.hypot(*points[:, :2].T).min() >= 0.025 * (1.0 - 1e-12)
        # All film lies at z >= 0.
        assert points[1:-1, 2].max() < -1e-3
        assert np.allclose(points[[0, -1], 2], 0.0)
        corner = path.arm[path.free]
        np.testing.assert_allclose(np.hypot(*points[-1, :2]), corner[1], rtol=1e-12)
        np.testing.assert_allclose(azimuth[-1] - math.pi / 4, corner[0], rtol=1e-12)
        # In plan each node lies on the straight line from the rim to the hairpin, or on the middle of the arm.
        radii = np.interp(azimuth[1:-1] - math.pi / 4, path.arm[:, 0], path.arm[:, 1])
        on_arm = azimuth[1:-1] - math.pi / 4 > 1e-9
        assert np.abs(np.hypot(*points[1:-1, :2].T) - radii)[on_arm].max() < 1e-3
    pairs = assembly.positions[assembly.cords.nodes]
    lengths = np.linalg.norm(pairs[:, 1] - pairs[:, 0], axis=1)
    assert (lengths <= assembly.cords.rest_length * (1.0 + 1e-12)).all()
    assert Stepper(scene).energies()["tethers"] < 1e-20


def test_tethers_to_other_nodes_and_taut_ones() -> None:
    scene = scene_of(1, columns=10)
    path = path_of(scene)
    short = with_tethers(scene, length=0.02).assemble()
    pairs = short.positions[short.cords.nodes]
    lengths = np.linalg.norm(pairs[:, 1] - pairs[:, 0], axis=1)
    assert lengths.max() == pytest.approx((path.hub_radius - 0.025 + 0.0309) / 19, rel=1e-3)
    outer = with_tethers(scene, nodes="corners", length=1.0).assemble()
    points = outer.positions[outer.node_sets["tether-0"]]
    assert np.unwrap(np.arctan2(points[:, 1], points[:, 0]))[-1] == pytest.approx(math.pi / 4 + path.arm[-1, 0])
    # Off the diagonals there is no arm to follow.
    middle = int(np.argmin(np.linalg.norm(mesh_of(scene).reference - [0.0515, 0.0, 0.0], axis=1)))
    straight = with_tethers(scene, nodes=(middle,), length=1e-3).assemble()
    ends = straight.positions[straight.node_sets["tether-0"]]
    np.testing.assert_allclose(ends, np.linspace(ends[0], ends[-1], 20), atol=1e-15)
    with pytest.raises(SceneError, match=r"segments = 1: a cord of length .* give it 2 segments or more"):
        with_tethers(scene, segments=1).assemble()


ENERGIES = [
    # Elastic energy [mJ] of springs whose creases buckle as the film does, as an independent construction gave it.
    (1, {"columns": 10, "layer_gap": 7.5e-6}, 3.19),
    (1, {"columns": 10}, 0.264),
    (1, {"columns": 20, "rows": 32, "layer_gap": 7.5e-6}, 3.81),
    (2, {"columns": 10, "layer_gap": 7.5e-6}, 0.98),
]


@pytest.mark.parametrize(("model", "dimensions", "elastic"), ENERGIES)
def test_energy_of_winding_beside_that_of_unwinding(model: int, dimensions: dict[str, Any], elastic: float) -> None:
    scene = scene_of(model, **dimensions)
    springs = Springs(buckling=100.0, buckling_on_creases=100.0)
    scene = replace(scene, laws=[springs if law.kind == "springs" else law for law in scene.laws])
    start = Stepper(scene)
    assert 1e3 * start.energies()["springs"] == pytest.approx(elastic, rel=5e-3)
    (found,) = stowed_energy(scene)
    assert (found.severity, found.kind) == ("info", "stowed_energy")
    numbers = re.fullmatch(
        r"energy held by the stowed shape (\S+) J; set free by the spin from the start to the flat shape (\S+) J, "
        r"(\S+) % of that \((\S+) J by the film alone\)",
        found.message,
    )
    assert numbers is not None
    held, freed, share, film = map(float, numbers.groups())
    assert 1e3 * held == pytest.approx(elastic, rel=5e-3)
    assert share == pytest.approx(100.0 * held / freed, rel=5e-3)
    assert 1e3 * film == pytest.approx(13.2, abs=0.03)
    tips = 4 * 0.36e-3 * (0.455**2 / 2 - path_of(scene).arm[-1, 1] ** 2)
    assert freed == pytest.approx(film + 0.5 * (6 * math.pi) ** 2 * tips, rel=1e-2)


def test_no_energy_is_told_of_what_does_not_turn_or_begins_flat() -> None:
    scene = scene_of(1)
    assert list(stowed_energy(replace(scene, laws=[law for law in scene.laws if law.kind != "spin"]))) == []
    flat = SquareSail().mesh()
    flat = Mesh(flat.reference, flat.triangles, creases=flat.creases, fold_angles=flat.fold_angles)
    parts = [TipMasses(mass=1e-3, nodes=(0,))]
    assert list(stowed_energy(replace(scene, mesh=flat, parts=parts))) == []
    assert list(stowed_energy(scenes.load("spinning-tether"))) == []


@pytest.mark.parametrize("model", [1, 2])
def test_the_audit_is_clean_and_tells_the_roll(model: int) -> None:
    scene = scene_of(model)
    found = audit(scene)
    assert [one.kind for one in found.without_facts().findings if one.kind != "step_accuracy"] == [], str(found)
    assert facts(scene)["roll"].startswith("radius 0.029928 to 0.03")
    assert "roll" not in facts(scenes.load(f"okuizumi-model-{model}"))


def test_a_wound_scene_survives_its_file(tmp_path: Path) -> None:
    scene = scene_of(2, columns=10)
    scene.save(tmp_path)
    text = (tmp_path / "scene.toml").read_text()
    assert 'stowage = "wound"' in text
    again = Scene.from_toml(tmp_path / "scene.toml")
    assert (again.assemble().positions == scene.assemble().positions).all()
    assert mesh_of(again).source == mesh_of(scene).source


@pytest.mark.filterwarnings("ignore:relax. not at rest")
def test_relaxation_holds_the_roll_and_moves_the_tethers() -> None:
    scene = scene_of(2, columns=10)
    sim = Simulation(scene)
    start = sim.positions
    sim.relax(2e-3)
    count = mesh_of(scene).node_count
    assert (sim.positions[:count] == start[:count]).all()
    assert np.abs(sim.positions[count:] - start[count:]).max() > 0.0


def test_tethers_of_a_mesh_without_its_pattern_are_straight() -> None:
    scene = scene_of(1)
    mesh = mesh_of(scene)
    bare = Mesh(
        mesh.reference,
        mesh.triangles,
        positions=mesh.positions,
        creases=mesh.creases,
        fold_angles=mesh.fold_angles,
        node_sets=mesh.node_sets,
    )
    assembly = replace(scene, mesh=bare, parts=[Tethers(length=0.02)]).assemble()
    ends = assembly.positions[assembly.node_sets["tether-0"]]
    np.testing.assert_allclose(ends, np.linspace(ends[0], ends[-1], 20), atol=1e-15)


def test_the_phase_of_a_roll_counts_its_turns() -> None:
    """From some 427 degrees at the start, so that it comes to 0 as the sail is flat; of a cross it is 0."""
    scene = scenes.load("okuizumi-whole").staged(0)
    sail = scene.mesh.source if scene.mesh else None
    assert isinstance(sail, SquareSail)
    sim = Simulation(scene)
    assert stowed_turn(sim) == sail.corner_turn == 2.0 * math.pi * (sail.turns or 0.0)
    corners = Corners(sim.assembly, stowed_turn(sim))
    assert corners.phase_difference(sim.positions) == pytest.approx(math.degrees(sail.corner_turn), abs=1e-9)
    flat = np.array(sim.positions)
    flat[: len(scene.mesh.reference)] = scene.mesh.reference  # type: ignore[union-attr]
    sim.positions = flat
    assert stowed_turn(sim) == 0.0
    assert replace(sail, stowage="cross").corner_turn == 0.0
