"""Where such models are known to fail: refused before the run with the right words, or survived in balance."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    Creases,
    Fixed,
    Material,
    Mesh,
    MeshError,
    PointForces,
    Rectangles,
    Scene,
    Simulation,
    SpringDamping,
    Springs,
    Tethers,
    Triangles,
    UnstableError,
    scenes,
)
from membrane_rs.check.redundancy import step_savings
from membrane_rs.cli import app
from membrane_rs.errors import InputError
from membrane_rs.folding import SquareSail, Strip
from membrane_rs.scene.run_settings import RunSettings
from membrane_rs.simulation import integrators
from small_scenes import FILM, RUBBER, refused
from typer.testing import CliRunner


def flat_sail(layout: Any, negative: Any, **changes: Any) -> Scene:
    """The paper's sail unfolded, without load, on one of three layouts of the same counts."""
    sail = SquareSail(layout=layout).mesh()
    mesh = Mesh(sail.reference, sail.triangles)
    laws = [Springs(buckling=1e9, negative=negative, **changes)]
    # White noise as a start is mostly vibrations that RK4 damps by itself.
    return Scene(mesh, FILM, laws, run=RunSettings(until=1.0, watch=20, snapshots=(), energy_loss=1.0))


@pytest.mark.parametrize(("layout", "count"), [("fan", 664), ("even", 32)])
def test_meshes_with_negative_springs_are_refused_with_their_number(layout: str, count: int) -> None:
    refused(lambda: Simulation(flat_sail(layout, "refuse")), MeshError, f"{count} of .* negative.* obtuse triangles")
    audit = flat_sail(layout, "refuse").mesh.audit(FILM)  # type: ignore[union-attr]
    assert not audit.ok
    found = audit.find("negative_springs")
    assert found is not None
    assert found.count == count


@pytest.mark.parametrize("layout", ["fan", "even"])
def test_their_dashpots_are_refused_by_name(layout: str) -> None:
    scene = flat_sail(layout, "keep")
    damped = replace(scene, laws=[*scene.laws, SpringDamping()])
    refused(lambda: Simulation(damped), InputError, "dashpot on spring .* undefined")


@pytest.mark.parametrize("layout", ["fan", "even"])
def test_kept_they_grow_from_rest_and_the_watch_names_them(layout: str) -> None:
    # The even mesh has a growing mode too: an e-fold in 0.54 ms.
    scene = flat_sail(layout, "keep", strain_limit=1e-3)
    sim = Simulation(scene)
    sim.velocities = 1e-4 * np.random.default_rng(1).normal(size=(sim.node_count, 3)) * [1, 1, 0]
    with pytest.raises(UnstableError, match="negative spring constants") as caught:
        sim.step(round(0.05 / sim.dt))
    assert caught.value.law == "springs"
    audit = scene.mesh.audit(FILM)  # type: ignore[union-attr]
    assert audit.find("growing_mode") is not None


def test_clipped_the_even_mesh_survives_in_balance() -> None:
    sim = Simulation(flat_sail("even", "clip"))
    sim.velocities = 1e-4 * np.random.default_rng(1).normal(size=(sim.node_count, 3)) * [1, 1, 0]
    sim.step(300)
    assert np.isfinite(sim.positions).all()
    assert -1.0 < sim.ledger()["error"] < 1e-6


def test_the_mesh_of_the_built_in_sail_has_none() -> None:
    mesh = SquareSail().mesh()
    assert (mesh.spring_constants(FILM) > 0).all()


@pytest.mark.parametrize(("angle", "is_negative"), [(89.0, False), (125.1, True), (150.0, True)])
def test_an_obtuse_triangle(angle: float, is_negative: bool) -> None:
    half = np.radians(angle / 2)
    points = np.array([[0.0, 0, 0], [np.cos(half), np.sin(half), 0], [np.cos(half), -np.sin(half), 0]])
    scene = Scene(Mesh(0.01 * points, [[0, 2, 1]]), FILM, [Springs()])
    if is_negative:
        refused(lambda: Simulation(scene), MeshError, "negative.* angles above 90 degrees")
    else:
        Simulation(scene).step(100)


@pytest.mark.parametrize("integrator", integrators())
@pytest.mark.parametrize("law", [Springs(), Triangles(), Rectangles()], ids=lambda law: str(law.kind))
@pytest.mark.parametrize("offset", [0.0, 10.0])
def test_rounding_stops_no_scene_at_rest(law: Any, integrator: str, offset: float) -> None:
    # Its accounts are some 1e-31 J: rounding alone, of which any share may appear from nowhere.
    mesh = Strip(0.1, 0.04, 6, 2).mesh()
    run = RunSettings(until=1.0, watch=1, snapshots=())
    scene = Scene(Mesh(mesh.reference + offset, mesh.triangles), RUBBER, [law, SpringDamping()], run=run)
    sim = Simulation(scene, integrator)
    sim.step(300)
    # Where steps are chosen by their error, they grow until that is seen.
    allowed = run.tolerance * run.tolerance_length if sim.is_adaptive else 1e-12
    assert np.abs(sim.positions - mesh.reference - offset).max() < allowed


def test_slivers_of_little_more_than_a_right_angle_can_turn_negative() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [-0.0007, 0.02, 0]])
    assert np.degrees(np.arctan2(0.02, -0.0007)) < 92.1
    constants = Mesh(points, [[0, 1, 2]]).spring_constants(Material(3.2e9, 0.34, 1420.0, 7.5e-6))
    assert constants.min() < 0


def collapsed(collapse: float) -> Simulation:
    """Two wings on a held crease; one apex has come to lie 5e-7 m from it. The step is that of the flat wings."""
    points = np.array([[0, 0, 0], [0.02, 0, 0], [0.01, 0.02, 0], [0.01, -0.02, 0]])
    mesh = Mesh(points, [[0, 1, 2], [1, 0, 3]], creases=[[0, 1]], fold_angles=[1.0])
    # The first steps turn over 1e-13 J, of which a third is lost; that is nothing beside what follows.
    run = RunSettings(until=1.0, watch=20, snapshots=(), energy_loss=1.0)
    scene = Scene(mesh, FILM, [Creases(natural_angle=1.0, collapse=collapse)], [Fixed((0, 1, 3))], run=run)
    sim = Simulation(scene, dt=0.2 * Simulation(scene).stable_dt())
    positions = sim.positions.copy()
    positions[2] = [0.01, 3e-7, 4e-7]
    sim.positions = positions
    return sim


def test_a_collapsed_wing_without_the_regularisation_is_caught() -> None:
    sim = collapsed(0.0)
    with pytest.raises(UnstableError, match="a spurious gain of") as caught:
        sim.step(2000)
    assert caught.value.law == "creases"
    for words in ("as the shape changed, the stability limit fell", "creases near node", "set collapse to 0.05"):
        assert words in str(caught.value)


def test_a_collapsed_wing_with_it_stays_in_balance() -> None:
    sim = collapsed(0.05)
    sim.step(2000)
    # Beside the crease's kappa, 2e-6 J, nothing has come loose.
    assert sim.energies()["kinetic"] < 1e-10
    assert abs(sim.ledger()["error"] * sim.ledger()["reference_energy"]) < 1e-10


def test_a_stiff_tether_is_named_as_what_sets_the_step() -> None:
    # 19 segments of 0.3 mm in the film's material: EA = 226 N.
    whole = scenes.load("okuizumi-model-1")
    parts = [replace(part, axial_stiffness=226.0) if isinstance(part, Tethers) else part for part in whole.parts]
    scene = replace(whole, parts=parts)
    soft, stiff = Simulation(whole), Simulation(scene)
    assert stiff.limiting_part.startswith("tethers near node")
    assert 3.0 < soft.stable_dt() / stiff.stable_dt() < 4.5
    best = step_savings(scene)[0]
    assert best.part == "tethers"
    assert best.gain == pytest.approx(soft.stable_dt() / stiff.stable_dt(), rel=0.1)
    assert "axial_stiffness of" in best.advice
    assert "segments in place of 19" in best.advice


def test_check_says_so(tmp_path: Any) -> None:
    text = scenes.load("okuizumi-model-1").to_toml().replace("axial_stiffness = 17.0", "axial_stiffness = 226.0")
    (tmp_path / "stiff.toml").write_text(text)
    result = CliRunner().invoke(app, ["check", str(tmp_path / "stiff.toml"), "--until", "0.01"])
    assert result.exit_code == 0
    assert "limited by tethers" in result.output
    assert "savings      tethers: without it" in result.output


@pytest.mark.parametrize("method", integrators())
def test_a_motion_that_is_not_finite_is_not_shown(method: str) -> None:
    """Between two regular checks too."""
    pull = PointForces((0,), (0.0, 0.0, 1e306))
    scene = Scene(Strip(0.1, 0.05, columns=4, rows=2).mesh(), RUBBER, [Springs(), pull], [Fixed((4,))])
    sim = Simulation(scene, method, dt=1e-4)
    start = sim.positions.copy()
    with pytest.raises(UnstableError, match=r"no longer finite|finds no step"):
        sim.reach(5e-4)
    assert np.array_equal(sim.positions, start)
