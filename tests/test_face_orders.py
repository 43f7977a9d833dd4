"""The order of layers in FOLD files: against rays through the film, the rule for creases, and where there is none."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fold_specification import check_specification, frames_of
from membrane_rs import Mesh, scenes
from membrane_rs.errors import MeshError
from membrane_rs.folding import Miura, SpiralHexagon, SquareSail, Strip
from membrane_rs.mesh import face_orders as module
from membrane_rs.mesh import read_fold
from numpy.typing import NDArray
from same_mesh import check_same
from small_scenes import refused, rotation, turned

Orders = dict[tuple[int, int], int]


def miura(tilt: float, **changes: Any) -> Mesh:
    return Miura(0.02, 0.02, tilt, **{"columns": 5, "rows": 4, **changes}).mesh()


def zigzag(angle: float) -> Mesh:
    return Strip(0.1, 0.02, 10, 2, creases=(0.2, 0.4, 0.6, 0.8), fold_angle=angle).mesh()


def orders_of(mesh: Mesh, path: Path) -> Orders:
    """What the file says of the stowed frame, whose other keys keep the specification."""
    mesh.save(path)
    frame = frames_of(path)[-1]
    check_specification(frame)
    triples = frame.get("faceOrders", [])
    assert all(len(triple) == 3 and abs(triple[2]) == 1 for triple in triples)
    found = {(f, g): s for f, g, s in triples}
    assert len(found) == len(triples) == len({frozenset(pair) for pair in found})
    return found


def met(mesh: Mesh, origin: NDArray[np.float64], axis: NDArray[np.float64]) -> list[tuple[float, int]]:
    """Distance along a ray and number of each triangle that it goes through well inside, solved one by one."""
    found = []
    for k, corners in enumerate(mesh.positions[mesh.triangles]):
        sides = np.column_stack([corners[1] - corners[0], corners[2] - corners[0], -axis])
        u, v, t = np.linalg.solve(sides, origin - corners[0])
        if min(u, v, 1.0 - u - v) > 1e-3:
            found.append((float(t), k))
    return sorted(found)


@pytest.mark.parametrize(
    "mesh",
    [miura(math.radians(87.0)), miura(math.radians(89.5), divisions=2), zigzag(3.05), zigzag(-3.05)],
    ids=["miura", "fine miura", "valley first", "mountain first"],
)
def test_orders_are_those_of_rays_through_the_film(mesh: Mesh, tmp_path: Path) -> None:
    """At random places, in a frame that is turned in space: every pair that a ray meets is there, the right way."""
    mesh = turned(mesh, rotation((0.3, -0.5, 0.8), 1.1))
    orders = orders_of(mesh, tmp_path / "mesh.fold")
    corners = mesh.positions[mesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    axis = np.linalg.svd(normals)[2][0]
    rng, seen = np.random.default_rng(1), set()
    for triangle in rng.integers(len(corners), size=60):
        place = rng.dirichlet([1.0, 1.0, 1.0]) @ corners[triangle]
        layers = met(mesh, place, axis)
        for above, (t, f) in enumerate(layers):
            for _, g in layers[:above]:
                # f is met later than g: on the side of g to which the axis points.
                pair, side = ((f, g), 1) if (f, g) in orders else ((g, f), -1)
                assert orders[pair] == side * np.sign(normals[pair[1]] @ axis), (pair, t)
                seen.add(pair)
    assert len(seen) > 0.2 * len(orders) > 4


@pytest.mark.parametrize("mesh", [miura(math.pi / 2), miura(math.radians(89.0)), zigzag(math.pi), zigzag(3.1)])
def test_triangles_beside_a_crease_lie_as_valley_and_mountain_say(mesh: Mesh, tmp_path: Path) -> None:
    """A valley turns both normals towards the other triangle."""
    orders = orders_of(mesh, tmp_path / "mesh.fold")
    edges, _ = mesh.find_edges(mesh.creases)
    for edge, angle in zip(edges, mesh.fold_angles, strict=True):
        f, g = np.flatnonzero((mesh.triangle_edges == edge).any(axis=1)).tolist()
        assert orders[f, g] == np.sign(angle)
    if abs(mesh.fold_angles).min() == math.pi:
        assert len(orders) == len(mesh.creases)


@pytest.mark.parametrize(
    "mesh",
    [miura(1.0), zigzag(1.5), SquareSail().mesh(), SquareSail(stowage="wound").mesh(), SpiralHexagon(rows=10).mesh()],
    ids=["open", "open strip", "cross", "wound", "hexagon"],
)
def test_shapes_that_are_not_folded_flat_have_no_order(mesh: Mesh, tmp_path: Path) -> None:
    assert orders_of(mesh, tmp_path / "mesh.fold") == {}


def test_triangles_that_cross_have_no_order(tmp_path: Path) -> None:
    """Two layers of a strip that are tilted to each other by 6 degrees, through each other."""
    flat = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0], [3, 0, 0], [3, 1, 0.0]])
    stowed = flat.copy()
    stowed[[4, 5]] = [[0.0, 0.0, 0.5], [0.0, 1.0, 0.5]]
    stowed[[6, 7]] = [[1.0, 0.0, -0.05], [1.0, 1.0, -0.05]]
    stowed[[4, 5], 2] = 0.05
    triangles = [[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2], [4, 6, 7], [4, 7, 5]]
    orders = orders_of(Mesh(flat, triangles, positions=stowed), tmp_path / "mesh.fold")
    assert {pair for pair in orders if max(pair) < 4} == {(0, 2), (0, 3), (1, 2), (1, 3)}
    assert (0, 4) not in orders


def test_orders_are_told_as_skipped_and_written_again(tmp_path: Path) -> None:
    mesh = miura(math.radians(88.0))
    first = orders_of(mesh, tmp_path / "mesh.fold")
    read = read_fold(tmp_path / "mesh.fold")
    check_same(read, mesh)
    assert f"{len(first)} orders of faces skipped: those that the shape tells" in str(read.source)
    assert orders_of(read, tmp_path / "again.fold") == first
    table = json.loads((tmp_path / "mesh.fold").read_text())
    table["file_frames"][0]["faceOrders"] = 3
    (tmp_path / "mesh.fold").write_text(json.dumps(table))
    refused(lambda: read_fold(tmp_path / "mesh.fold"), MeshError, "frame 1: faceOrders = 3: must be a list")


def test_large_films_have_none(monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = miura(math.radians(88.0))
    for name in ("MOST_TRIANGLES", "MOST_PAIRS"):
        assert module.face_orders(mesh, mesh.positions, mesh.fold_angles)
        with monkeypatch.context() as patched:
            patched.setattr(module, name, 30)
            assert module.face_orders(mesh, mesh.positions, mesh.fold_angles) == []


def test_the_film_of_a_shut_crease_has_its_order(tmp_path: Path) -> None:
    mesh = scenes.load("single-crease").mesh
    assert mesh is not None
    assert set(orders_of(mesh, tmp_path / "mesh.fold").values()) == {int(np.sign(mesh.fold_angles[0]))}
