"""A mesh as a FOLD file: the crease pattern as its key frame, the stowed shape as one that inherits from it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from membrane_rs._arrays import Floats, Ints
from membrane_rs._files import replacing
from membrane_rs.errors import MeshError
from membrane_rs.mesh.face_orders import face_orders
from membrane_rs.mesh.fold_angles import FLAT, measured_fold_angles
from membrane_rs.mesh.fold_creases import RADIANS
from membrane_rs.mesh.fold_reading import BRIDGES, NODE_SETS, REFERENCE, TRIANGLE_SETS
from membrane_rs.mesh.polygons import PolygonError, neighbours
from membrane_rs.mesh.triangulation import Triangulation

VERSION = 1.2
"""Of the format, as it is written."""


class FoldedFilm(Protocol):
    """What of a mesh is written beside its triangulation."""

    positions: Floats
    fold_angles: Floats

    @property
    def node_sets(self) -> Mapping[str, Ints]:
        """Nodes by name."""

    @property
    def triangle_sets(self) -> Mapping[str, Ints]:
        """Triangles by name."""


def write_fold_file(path: Path, mesh: Any, title: str = "") -> None:
    """Write a mesh, whole or not at all. Raises MeshError for one that FOLD cannot hold, OutputError."""
    try:
        is_against = neighbours(mesh.triangles, mesh.node_count)[1]
    except PolygonError as error:
        raise MeshError(f"{path}: triangles[{error.index}] {error}; FOLD files are written of films alone") from None
    if is_against.any():
        raise MeshError(
            f"{path}: triangles are wound in opposite senses at {np.count_nonzero(is_against)} edges, so that valley "
            "and mountain mean nothing; reverse the order of nodes in those that differ"
        )
    table = _table(mesh, mesh, title)
    with replacing(path) as part, part.open("w", encoding="utf-8") as file:
        file.writelines(_lines(table))


def _table(mesh: Triangulation, film: FoldedFilm, title: str) -> dict[str, Any]:
    from importlib.metadata import version  # slow to import

    positions, fold_angles = film.positions, film.fold_angles
    index, _ = mesh.find_edges(mesh.creases)
    is_plain = np.ones(len(mesh.edges), dtype=bool)
    is_plain[index] = False
    plain = np.flatnonzero(is_plain)
    edges = np.concatenate([mesh.creases, mesh.edges[plain]])
    number = np.empty(len(edges), dtype=np.int64)
    number[np.concatenate([index, plain])] = np.arange(len(edges))
    is_border = mesh.triangles_per_edge[plain] == 1

    is_stowed = positions.tobytes() != mesh.reference.tobytes()
    bends = _bends(mesh, positions, mesh.edges[plain]) if is_stowed else np.zeros(len(plain))
    angles = np.clip(np.degrees(fold_angles), -180.0, 180.0)
    of_creases = np.array(["M", "U", "V"])[1 + np.sign(angles).astype(int)].tolist()
    of_others = np.where(is_border, "B", np.where(bends == 0.0, "J", "F")).tolist()

    is_planar = np.ptp(mesh.reference[:, 2]) == 0.0
    flat_class = "creasePattern" if is_planar else REFERENCE if is_stowed else "foldedForm"
    joins = "joins" if "J" in of_others else "noJoins"
    table: dict[str, Any] = {
        "file_spec": VERSION,
        "file_creator": f"membrane_rs {version('membrane_rs')}",
        "file_classes": ["singleModel"],
        **({"file_title": title} if title else {}),
        "frame_title": "without strain",
        "frame_classes": [flat_class],
        "frame_attributes": _attributes(mesh.reference, joins),
        "frame_unit": "m",
        "vertices_coords": _coordinates(mesh.reference),
        "edges_vertices": edges.tolist(),
        "edges_assignment": of_creases + of_others,
        "edges_foldAngle": angles.tolist() + [0] * len(plain),
        "faces_vertices": mesh.triangles.tolist(),
        "faces_edges": number[np.roll(mesh.triangle_edges, 1, axis=1)].tolist(),
    }
    if not np.array_equal(np.radians(angles), fold_angles):
        table[RADIANS] = fold_angles.tolist() + [None] * len(plain)
    for key, sets in ((NODE_SETS, film.node_sets), (TRIANGLE_SETS, film.triangle_sets)):
        if sets:
            table[key] = {name: members.tolist() for name, members in sets.items()}
    if len(mesh.bridges):
        table[BRIDGES] = mesh.bridges.tolist()
    if is_stowed:
        stowed: dict[str, Any] = {
            "frame_title": "stowed",
            "frame_classes": ["foldedForm"],
            "frame_attributes": _attributes(positions, joins),
            "frame_parent": 0,
            "frame_inherit": True,
            "vertices_coords": _coordinates(positions),
            "edges_foldAngle": angles.tolist() + bends.tolist(),
        }
        if bends.any():
            bent = np.where(bends > 0.0, "V", np.where(bends < 0.0, "M", of_others))
            stowed["edges_assignment"] = of_creases + bent.tolist()
        orders = face_orders(mesh, positions, fold_angles)
        if orders:
            stowed["faceOrders"] = orders
        table["file_frames"] = [stowed]
    return table


def _bends(mesh: Triangulation, positions: Floats, edges: Ints) -> Floats:
    """(k,) angle by which the film is bent at edges that are no creases [degrees]; 0 below one degree, at a border."""
    angles = measured_fold_angles(Triangulation(mesh.reference, mesh.triangles, edges, mesh.bridges), positions)
    bends: Floats = np.where(np.abs(angles) >= FLAT, np.degrees(angles), 0.0)
    return bends


def _coordinates(points: Floats) -> list[list[float]]:
    """Rows [x, y] where all z are 0, as programs for crease patterns expect them; else [x, y, z]."""
    is_2d = not points[:, 2].any() and not np.signbit(points[:, 2]).any()
    rows: list[list[float]] = points[:, : 2 if is_2d else 3].tolist()
    return rows


def _attributes(points: Floats, joins: str) -> list[str]:
    return ["3D" if points[:, 2].any() else "2D", "manifold", "orientable", "noCuts", joins, "convexFaces"]


def _lines(table: Mapping[str, Any], indent: str = "") -> Iterator[str]:
    """JSON with a line for each key, and one for each entry of its lists; numbers keep all their bits."""
    yield "{"
    for k, (key, value) in enumerate(table.items()):
        yield f"{',' if k else ''}\n{indent} {json.dumps(key, ensure_ascii=False)}: "
        if key == "file_frames":
            yield "["
            for j, frame in enumerate(value):
                yield ", " if j else ""
                yield from _lines(frame, f"{indent} ")
            yield "]"
        elif isinstance(value, list) and value and isinstance(value[0], list):
            yield "[\n"
            yield ",\n".join(f"{indent}  {json.dumps(row)}" for row in value)
            yield f"\n{indent} ]"
        else:
            yield json.dumps(value, ensure_ascii=False, allow_nan=False)
    yield f"\n{indent}}}{'' if indent else chr(10)}"
