"""Each triangle of a mesh divided into smaller ones of its own shape."""

from __future__ import annotations

from typing import Any

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs._bounds import check_nodes
from membrane_rs._validation import count_of
from membrane_rs.errors import MeshError
from membrane_rs.mesh.triangulation import Triangulation

MOST = 1000
"""Parts of a side at most."""


def divided(mesh: Triangulation, count: int, positions: Floats, fold_angles: Floats) -> dict[str, Any]:
    """Nodes, triangles, creases and fold angles of a mesh, all sides in `count` equal parts; see `Mesh.divided`.

    The nodes that were there keep their numbers; those on the sides follow, edge by edge, then those inside.
    """
    count = count_of("count", count, 1, MOST)
    if len(mesh.bridges):
        raise MeshError(f"divided: the mesh has {len(mesh.bridges)} bridges, which join nodes; divide it without them")
    inner = (count - 1) * (count - 2) // 2
    total = mesh.node_count + float(len(mesh.edges)) * (count - 1) + float(len(mesh.triangles)) * inner
    check_nodes(total, f"divided: count = {count}", "take a smaller count", MeshError)
    on_sides = _on_sides(mesh, count)
    nodes = _lattice(mesh, count, on_sides)
    rising = [[nodes[i, j], nodes[i + 1, j], nodes[i, j + 1]] for i in range(count) for j in range(count - i)]
    falling = [
        [nodes[i + 1, j], nodes[i + 1, j + 1], nodes[i, j + 1]] for i in range(count - 1) for j in range(count - 1 - i)
    ]
    creases = on_sides[mesh.find_edges(mesh.creases)[0]]
    return {
        "reference": _points(mesh, mesh.reference, count),
        "triangles": np.array([*rising, *falling]).transpose(2, 0, 1).reshape(-1, 3),
        "positions": _points(mesh, positions, count),
        "creases": np.stack([creases[:, :-1], creases[:, 1:]], axis=-1).reshape(-1, 2),
        "fold_angles": np.repeat(fold_angles, count),
    }


def divided_nodes(mesh: Triangulation, count: int, nodes: Ints) -> Ints:
    """Nodes of a set, and the new ones on sides both of whose ends it holds."""
    between = _on_sides(mesh, count)[np.isin(mesh.edges, nodes).all(axis=1), 1:-1]
    return np.concatenate([nodes, between.ravel()])


def divided_triangles(count: int, triangles: Ints) -> Ints:
    """The parts of the triangles of a set."""
    return np.add.outer(triangles * count**2, np.arange(count**2)).ravel()


def _on_sides(mesh: Triangulation, count: int) -> Ints:
    """(e, count + 1) nodes along each edge, its ends among them."""
    new = mesh.node_count + np.arange(len(mesh.edges) * (count - 1)).reshape(len(mesh.edges), count - 1)
    return np.concatenate([mesh.edges[:, :1], new, mesh.edges[:, 1:]], axis=1)


def _inside(count: int) -> list[tuple[int, int]]:
    """Steps from the first corner of a triangle to the second and to the third, of the nodes inside."""
    return [(i, j) for i in range(1, count - 1) for j in range(1, count - i)]


def _lattice(mesh: Triangulation, count: int, on_sides: Ints) -> dict[tuple[int, int], Ints]:
    """(m,) nodes of the triangles, by the steps from their first corner to the second and to the third."""
    steps, inside = np.arange(count + 1), _inside(count)
    nodes: dict[tuple[int, int], Ints] = {}
    for k in range(3):
        one, other = mesh.triangles[:, k], mesh.triangles[:, (k + 1) % 3]
        rows = on_sides[mesh.find_edges(np.stack([one, other], axis=1))[0]]
        along = np.where((one < other)[:, None], rows, rows[:, ::-1])
        for step in steps.tolist():
            place = ((step, 0), (count - step, step), (0, count - step))[k]
            nodes[place] = along[:, step]
    first = mesh.node_count + len(mesh.edges) * (count - 1)
    for number, place in enumerate(inside):
        nodes[place] = first + len(inside) * np.arange(len(mesh.triangles)) + number
    return nodes


def _points(mesh: Triangulation, points: Floats, count: int) -> Floats:
    """All nodes, linear between corners at `points` (n, 3)."""
    start, end = points[mesh.edges[:, :1]], points[mesh.edges[:, 1:]]
    parts = (np.arange(1, count) / count)[:, None]
    a, b, c = (points[mesh.triangles[:, [k]]] for k in range(3))
    i, j = (np.array([place[k] for place in _inside(count)], dtype=float)[:, None] / count for k in (0, 1))
    return np.concatenate(
        [points, (start + parts * (end - start)).reshape(-1, 3), (a + i * (b - a) + j * (c - a)).reshape(-1, 3)]
    )
