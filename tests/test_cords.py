"""Cords between any two places, and along edges of the film: bridles by statics, a taut strip that shares its load."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from membrane_rs import (
    Boltrope,
    Cord,
    Fixed,
    Material,
    PointForces,
    Scene,
    SceneError,
    Simulation,
    Springs,
    TipMasses,
    Triangles,
)
from membrane_rs.folding import Strip
from membrane_rs.mesh import Mesh
from membrane_rs.mesh.edge_paths import path_of_set, path_through
from membrane_rs.scene.part import Part
from small_scenes import RUBBER, UNBUCKLED, patch, refused, rest

LIGHT: dict[str, Any] = {"segments": 1, "axial_stiffness": 1e3, "linear_density": 0.0}
ROPE: dict[str, Any] = {"segments": 4, "axial_stiffness": 100.0, "linear_density": 1e-3}


def strip(columns: int = 4, rows: int = 2) -> Mesh:
    """A strip along x with the node sets of its ends and its long side."""
    mesh = Strip(0.4, 0.2, columns, rows).mesh()
    low = np.flatnonzero(mesh.reference[:, 1] == mesh.reference[:, 1].min())
    sets = {**mesh.node_sets, "side": low, "border": np.unique(mesh.boundary_edges)}
    return Mesh(mesh.reference, mesh.triangles, node_sets=sets)


def assembled(*parts: Part, mesh: Mesh | None = None) -> Any:
    material = None if mesh is None else RUBBER
    return Scene(mesh, material, [] if mesh is None else [Springs()], list(parts)).assemble()


def test_a_bridle_bears_its_load_by_statics() -> None:
    # Two legs of 5 m and 13 m, at angles a and b to the vertical, bear a pendant with a load W at their joint, the
    # origin: their tensions are W sin(b)/sin(a + b) and W sin(a)/sin(a + b) (Lami). Each cord is as long without load
    # as makes it fit at that tension.
    load, sine_a, sine_b, sine_ab = 10.0, 3 / 5, 5 / 13, 56 / 65
    tensions = load * np.array([sine_b / sine_ab, sine_a / sine_ab, 1.0])
    long, short, own = np.array([5.0, 13.0, 1.0]) / (1.0 + tensions / LIGHT["axial_stiffness"])
    parts = [
        Cord((-3.0, 0.0, 4.0), (0.0, 0.0, 0.0), **LIGHT, length=long, name="leg"),
        Cord((5.0, 0.0, 12.0), "leg-end", **LIGHT, length=short),
        Cord("leg@1", (0.0, 0.0, -1.0), **LIGHT, length=own, name="pendant"),
        TipMasses(0.1, "leg-end"),
        TipMasses(0.1, "pendant-end"),
    ]
    sim = Simulation(Scene(None, None, [PointForces("pendant-end", (0.0, 0.0, -load))], parts))
    sets = sim.assembly.node_sets
    free = np.array([sets["leg-end"][0], sets["pendant-end"][0]])
    assert sim.cord_tensions() == pytest.approx(tensions, rel=1e-9)
    assert np.abs(sim.forces()[free]).max() < 1e-9 * load
    positions = sim.positions.copy()
    positions[free] += [[0.03, 0.0, -0.05], [0.01, 0.0, -0.1]]
    sim.positions = positions
    rest(sim, free, [0, 2], 1e-6, iterations=8)
    assert sim.positions[free] == pytest.approx(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0]]), abs=1e-6)
    assert sim.cord_tensions() == pytest.approx(tensions, rel=1e-6)


def test_cords_branch_at_places_of_each_other_and_of_the_film() -> None:
    parts = [
        Cord((0.0, 0.0, 1.0), (0.0, 0.0, 0.5), **ROPE, name="riser"),
        Cord("riser-end", 3, **ROPE, name="leg"),
        Cord("riser@0.5", "corners[0]", **ROPE, length=2.0),
        Cord("cord-2[-2]", "leg[1]", **ROPE, length=0.7, name="link"),
    ]
    found = assembled(*parts, mesh=patch())
    sets = found.node_sets
    assert sets["riser"].tolist() == [4, 5, 6, 7, 8]
    assert sets["leg"].tolist() == [8, 9, 10, 11, 3]
    assert sets["cord-2"].tolist() == [6, 12, 13, 14, 1]
    assert sets["link"].tolist() == [14, 15, 16, 17, 9]
    assert {"riser-start", "leg-end", "cord-2-start", "link-end"} <= sets.keys()
    assert found.fixed.tolist() == [4]
    assert len(found.cords) == 16
    assert found.cords.rest_length[8:12] == pytest.approx(0.5)
    # Each has its mass, also where it shares its nodes.
    lengths = found.cords.rest_length
    assert found.extra_masses.sum() == pytest.approx(1e-3 * lengths.sum(), rel=1e-12)
    assert found.extra_masses[8] == pytest.approx(0.5e-3 * (lengths[3] + lengths[4]), rel=1e-12)
    spans = np.linalg.norm(np.diff(found.positions[found.cords.nodes], axis=1)[:, 0], axis=1)
    assert (spans <= lengths * (1.0 + 1e-12)).all()


def test_a_cord_from_film_to_film_is_as_long_as_its_flat_span() -> None:
    mesh = patch(positions=[[0.1, 0, 0], [0.2, 0, 0], [0.2, 0.1, 0], [0.1, 0.09, 0.04]], fold_angles=None)
    found = assembled(Cord(1, 3, **{**LIGHT, "segments": 1}), mesh=mesh)
    assert found.cords.rest_length == pytest.approx(0.1 * np.sqrt(2.0))
    assert found.node_count == 4
    assert found.fixed.size == 0


@pytest.mark.parametrize("law", [UNBUCKLED, Triangles()], ids=["springs", "triangles"])
@pytest.mark.parametrize("softening", [1.0, 4.0])
def test_a_taut_strip_shares_its_load_with_boltropes_by_stiffness(law: Any, softening: float) -> None:
    # Both long sides have a rope; the ends move as wholes along x, so that film and ropes have one strain. With nu = 0
    # the film narrows nowhere, and bears E h w e; the ropes bear EA e each.
    film, mesh = Material(1e6, 0.0, 1000.0, 2e-4), strip(8, 4)
    high = np.flatnonzero(mesh.reference[:, 1] == mesh.reference[:, 1].max())
    ropes = [Boltrope("side", 15.0, 1e-3, name="low"), Boltrope(high[[0, -1]].tolist(), 15.0, 1e-3, name="high")]
    held = [Fixed("start"), Fixed("end")]
    scene = Scene(mesh, replace(film, softening=softening), [law], [*ropes, *held])
    sim = Simulation(scene)
    strain = 0.01
    positions = sim.positions.copy()
    positions[:, 0] *= 1.0 + strain
    sim.positions = positions
    pull = sim.forces()[sim.assembly.node_sets["end"]][:, 0].sum()
    of_ropes = sim.forces("tethers")[sim.assembly.node_sets["end"]][:, 0].sum()
    share = 2.0 * 15.0 / (2.0 * 15.0 + 1e6 * 2e-4 * 0.2)
    assert of_ropes == pytest.approx(-2.0 * 15.0 * strain / softening, rel=1e-9)
    assert of_ropes / pull == pytest.approx(share, rel=0.01)
    inner = np.setdiff1d(np.arange(mesh.node_count), np.concatenate([mesh.node_sets["start"], mesh.node_sets["end"]]))
    assert np.abs(sim.forces("tethers")[inner]).max() < 1e-9 * abs(of_ropes)


def test_a_boltrope_has_no_nodes_of_its_own_and_its_mass_by_length() -> None:
    mesh = strip()
    plain, roped = assembled(mesh=mesh), assembled(Boltrope("border", 10.0, 2e-3), mesh=mesh)
    assert roped.node_count == plain.node_count
    path = roped.node_sets["boltrope-0"]
    assert path[0] == path[-1] == roped.node_sets["boltrope-0-end"][0]
    assert np.unique(path[:-1]).tolist() == np.unique(mesh.boundary_edges).tolist()
    assert roped.extra_masses.sum() == pytest.approx(2e-3 * 1.2, rel=1e-12)
    assert roped.cords.rest_length == pytest.approx(0.1)
    gathered = assembled(Boltrope("border", 10.0, 2e-3, length=0.6), mesh=mesh)
    assert gathered.cords.rest_length == pytest.approx(0.05)


def test_paths_along_edges() -> None:
    mesh = strip()
    corners = [mesh.node_sets[name][[0, -1]] for name in ("start", "end")]
    (a, d), (b, c) = corners
    through = path_through(mesh, np.array([a, b, c, d]), closed=True)
    assert sorted(through[:-1].tolist()) == np.unique(mesh.boundary_edges).tolist()
    assert path_through(mesh, np.array([a, b])).tolist() == path_of_set(mesh, mesh.node_sets["side"]).tolist()
    reverse = path_of_set(mesh, mesh.node_sets["side"][::-1]).tolist()
    assert reverse == path_of_set(mesh, mesh.node_sets["side"]).tolist()[::-1]


@pytest.mark.parametrize(("critical_strain", "force"), [(0.0, 0.0), (0.05, 5.0), (1.0, 10.0)])
def test_a_boltrope_buckles_at_its_critical_strain(critical_strain: float, force: float) -> None:
    # EA = 100 N, shortened by 10 %.
    rope = Boltrope("side", 100.0, 0.0, critical_strain=critical_strain)
    sim = Simulation(Scene(strip(), RUBBER, [Springs()], [rope]))
    sim.positions = sim.positions * 0.9
    assert np.abs(sim.forces("tethers")).max() == pytest.approx(force, rel=1e-9, abs=1e-12)
    assert sim.energies()["tethers"] == pytest.approx(
        0.4 * 100.0 * (0.1 * min(critical_strain, 0.1) - 0.5 * min(critical_strain, 0.1) ** 2), rel=1e-9, abs=1e-12
    )


def test_scene_files_hold_cords(tmp_path: Path) -> None:
    text = """
    [laws.gravity]
    [[parts]]
    kind = "cord"
    start = ["10 cm", 0, 0]
    end = [0.5, 0.0, 0.0]
    segments = 4
    axial_stiffness = "1 kN"
    linear_density = "1 g/m"
    name = "riser"
    [[parts]]
    kind = "cord"
    start = "riser@0.5"
    end = 4
    segments = 2
    axial_stiffness = 10.0
    linear_density = 1e-3
    """
    path = tmp_path / "scene.toml"
    path.write_text(text)
    scene = Scene.from_toml(path)
    riser, link = scene.parts
    assert isinstance(riser, Cord)
    assert riser.start == (0.1, 0.0, 0.0)
    assert isinstance(link, Cord)
    assert (link.start, link.end, link.numbering_field, riser.numbering_field) == ("riser@0.5", 4, "end", None)
    scene.save(tmp_path / "again")
    assert Scene.from_toml(tmp_path / "again" / "scene.toml").parts == scene.parts
    assert scene.assemble().node_sets["cord-1"].tolist() == [2, 5, 4]


def test_a_strut_bears_compression() -> None:
    strut = Cord((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 1, 50.0, 0.1, critical_strain=1.0, name="strut")
    sim = Simulation(Scene(None, None, [PointForces("strut-end", (-1.0, 0.0, 0.0))], [strut]))
    sim.positions = np.array([[0.0, 0.0, 0.0], [0.98, 0.0, 0.0]])
    assert np.abs(sim.forces()[1]).max() < 1e-12


RISER = Cord((0.0, 0.0, 1.0), (0.0, 0.0, 0.5), **ROPE, name="riser")


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ([Cord("nowhere", 0, **ROPE)], "parts[0].start = 'nowhere': no such node set"),
        ([Cord("riser-end", 0, **ROPE), RISER], "parts[0].start = 'riser-end': no such node set"),
        ([Cord(0, 9, **ROPE)], "parts[0].end = [9]: node 9 is not there; must be from 0 to 3"),
        ([Cord(0, "corners", **ROPE)], "parts[0].end = 'corners': is a set of 2 nodes; name one of them: 'corners[0]'"),
        ([Cord(0, "corners[2]", **ROPE)], "parts[0].end = 'corners[2]': the set has 2 nodes; the index must be"),
        ([RISER, Cord(0, "riser@1.5", **ROPE)], "parts[1].end = 'riser@1.5': the share of the way along 5 nodes must"),
        ([Cord(1, "corners[0]", **ROPE)], "parts[0].end = 'corners[0]': is node 1, at which the cord starts"),
        ([RISER, Cord("riser-end", (0.0, 0.0, 0.5), **ROPE)], "parts[1].end = (0.0, 0.0, 0.5): lies where the cord"),
        ([RISER, Cord(0, 1, **ROPE, name="riser-end")], "parts[1].name = 'riser-end': there is a node set 'riser-end'"),
        (
            [Cord((0, 0, 0), 0, **ROPE, length=0.05)],
            "parts[0].length = 0.05: a cord of 0.05 m: its places are 0.1 m apart",
        ),
        ([replace(RISER, segments=10**9)], "parts[0].segments = 1000000000: "),
        ([Boltrope("corners", 1.0, 0.0)], "parts[0].nodes = 'corners': the edges between its nodes are no single path"),
        ([Boltrope([0], 1.0, 0.0)], "parts[0].nodes = (0,): a path needs two nodes or more"),
        ([Boltrope([0, 1, 2, 3, 9], 1.0, 0.0)], "parts[0].nodes = (0, 1, 2, 3, 9): node 9 is not there"),
        ([Boltrope([1, 3], 1.0, 0.0, closed=True)], "comes to node 0 twice"),
        ([RISER, Boltrope("riser", 1.0, 0.0)], "parts[1].nodes = 'riser': node 8 is not there"),
    ],
)
def test_refusals_name_part_and_place(parts: list[Part], words: str) -> None:
    refused(lambda: assembled(*parts, mesh=patch()), SceneError, re.escape(words))


def test_a_boltrope_needs_a_film() -> None:
    refused(lambda: assembled(RISER, Boltrope([0, 1], 1.0, 0.0)), SceneError, r"parts\[1\].nodes = \(0, 1\): ")


def test_a_path_needs_edges_that_join_its_nodes() -> None:
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [3, 0, 0], [4, 0, 0], [3, 1, 0]]
    mesh = Mesh(points, [[0, 1, 2], [3, 4, 5]], node_sets={"all": range(6), "three": [0, 1, 2]})
    refused(lambda: path_through(mesh, np.array([0, 4])), Exception, "no edges lead from node 0 to node 4")
    refused(lambda: path_of_set(mesh, np.arange(6)), Exception, "node 3 lies on another piece than node 0")
    assert path_of_set(mesh, np.arange(3)).tolist() == [0, 1, 2, 0]


@pytest.mark.parametrize("method", ["rk4", "leapfrog", "generalized_alpha"])
def test_a_roped_film_with_a_bridle_keeps_its_energy(method: str) -> None:
    # A kite: the film flies off under a push, its boltrope and bridle hold it. Springs and segments share node pairs.
    mesh, rope = strip(), {**ROPE, "strain_limit": 1.0}
    parts = [
        Boltrope("border", 20.0, 1e-3, strain_limit=1.0),
        Cord((0.2, 0.1, 0.5), (0.2, 0.1, 0.3), **rope, name="riser"),
        *(Cord("riser-end", f"{side}[{k}]", **rope) for side in ("start", "end") for k in (0, -1)),
    ]
    sim = Simulation(Scene(mesh, RUBBER, [Springs()], parts), method, 5e-5 if method == "generalized_alpha" else None)
    velocities = np.zeros_like(sim.positions)
    velocities[: mesh.node_count, 2] = -0.5
    sim.velocities = velocities
    sim.run(until=0.05, frames=2)
    assert abs(float(sim.ledger()["error"])) < 0.02
