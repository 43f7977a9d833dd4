"""A mesh of what a file of another program holds: in metres, of triangles, joined, wound alike, with named sets."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import field
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
from annotated_types import Ge, Le
from numpy.typing import NDArray

from membrane_rs._arrays import Floats, Ints
from membrane_rs._bounds import check_nodes
from membrane_rs._validation import Finite, Positive, Unit, validated
from membrane_rs.errors import MeshError
from membrane_rs.mesh.joined import distinct_faces, merged, wound_alike
from membrane_rs.mesh.meshio_process import BY_SUFFIX, Read, read_by_meshio
from membrane_rs.mesh.origin import MeshOrigin
from membrane_rs.mesh.quads import QuadRule, split_quads

SURFACES = {"triangle": 3, "quad": 4}
DIMENSIONS = ("point", "line", "surface")
"""What a physical group of Gmsh without a name is called, before its number, by its dimension."""
VOLUMES = ("tetra", "hexahedron", "wedge", "pyramid", "polyhedron")


@validated
class ForeignFile:
    """How a file of another program is read.

    Parameters
    ----------
    scale : float
        Length of the unit of its coordinates [m], 0.001 for millimetres. A scene file may name the unit: "mm".
    quads : {"shorter", "alternate"}
        By which diagonals quadrilaterals are split: each by its shorter one, or all so that they meet at every other
        node.
    merge : float, optional
        Nodes that are not further apart than this become one [m].
    """

    scale: Annotated[Finite, Ge(1e-12), Le(1e12), Unit("m")]
    quads: QuadRule = "shorter"
    merge: Annotated[Positive, Unit("m")] | None = field(default=None, kw_only=True)


class _Faces(NamedTuple):
    """Triangles and quadrilaterals in the order of a file."""

    corners: Ints
    """(k, 4) points; -1 as the last corner of a triangle."""
    first: dict[int, int]
    """The first of each block that has some."""


def read_foreign(path: Path, options: ForeignFile) -> dict[str, Any]:
    """What `Mesh` takes, by name, of a file whose suffix is one of `BY_SUFFIX`. Raises MeshError."""
    read = read_by_meshio(path)
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is refused
            return _made(path, read, options)
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from None


def _made(path: Path, read: Read, options: ForeignFile) -> dict[str, Any]:
    points, steps = _points(read.points, options.scale)
    others = _check_types(read.cells)
    faces = _faces(read.cells, len(points), others)
    groups = dict(_groups(read, len(points)))
    place = np.arange(len(points))
    if BY_SUFFIX[path.suffix.lower()] == "stl":
        steps.append(
            f"{3 * len(faces.corners) - len(points)} of {3 * len(faces.corners)} corners merged, by equal coordinates"
        )
    if options.merge is not None:
        place, words = merged(points, options.merge)
        steps.append(words)
    corners = np.where(faces.corners >= 0, place[faces.corners], -1)
    distinct, numbers, remarks = distinct_faces(corners, may_collapse=options.merge is not None)
    steps += remarks
    is_quad = distinct[:, 3] >= 0
    owner = np.repeat(np.arange(len(distinct)), 1 + is_quad)
    last = np.cumsum(1 + is_quad) - 1  # triangle of each face; of a quadrilateral the second one
    triangles = distinct[owner, :3]
    triangles[is_quad[owner]], remarks = split_quads(points, distinct[is_quad], options.quads)
    steps += remarks
    triangles, remarks = wound_alike(triangles)
    steps += remarks
    used, lowest = np.unique(triangles), np.unique(place)
    if len(used) < len(lowest):
        steps.append(f"{len(lowest) - len(used)} nodes left out, which no triangle has")
    index = np.full(len(points), -1, np.int64)
    index[used] = np.arange(len(used))
    node_sets = {name: _kept(index[place[each.nodes(name, read.cells, len(points))]]) for name, each in groups.items()}
    chosen = {name: _kept(numbers[each.faces(faces)]) for name, each in groups.items()}
    triangle_sets = {name: np.union1d(last[rows], last[rows[is_quad[rows]]] - 1) for name, rows in chosen.items()}
    steps += _words_of_cells(others) + _words_of_sets(node_sets, triangle_sets)
    return {
        "reference": points[used],
        "triangles": index[triangles],
        "node_sets": {name: nodes for name, nodes in node_sets.items() if len(nodes)},
        "triangle_sets": {name: rows for name, rows in triangle_sets.items() if len(rows)},
        "source": MeshOrigin(str(path), options.scale, tuple(steps)),
    }


def _words_of_cells(others: Mapping[str, int]) -> list[str]:
    """What became of points and lines."""
    return [f"{count} cells of type {kind!r} left out" for kind, count in others.items()]


def _words_of_sets(node_sets: Mapping[str, Ints], triangle_sets: Mapping[str, Ints]) -> list[str]:
    """Which sets there are, and which would be empty."""
    empty = ", ".join(name for name, nodes in node_sets.items() if not len(nodes))
    found = ", ".join(f"{name} ({len(nodes)} nodes)" for name, nodes in node_sets.items() if len(nodes))
    of_triangles = ", ".join(f"{name} ({len(rows)} triangles)" for name, rows in triangle_sets.items() if len(rows))
    words = {"named groups left out, whose nodes no triangle has": empty, "node sets": found}
    return [f"{key}: {value}" for key, value in (words | {"triangle sets": of_triangles}).items() if value]


def _kept(nodes: Ints) -> Ints:
    found: Ints = np.unique(nodes[nodes >= 0])
    return found


def _points(points: NDArray[Any], scale: float) -> tuple[Floats, list[str]]:
    """Points (n, 3) [m], and whether z was added. Raises MeshError."""
    if points.size == 0:
        raise MeshError("holds no points; write the mesh of a surface")
    if points.ndim != 2 or points.shape[1] not in (2, 3) or points.dtype.kind not in "fiu":
        raise MeshError(f"holds points of shape {points.shape} and dtype {points.dtype}; must be rows x, y, z")
    check_nodes(len(points), "its points", "take fewer", MeshError)
    found: Floats = np.zeros((len(points), 3))
    found[:, : points.shape[1]] = points
    found *= scale
    bad = np.flatnonzero(~np.isfinite(found).all(axis=1))
    if len(bad):
        raise MeshError(
            f"point {bad[0]}, counted from 0, is {points[bad[0]].tolist()}, not finite in metres ({len(bad)} such); "
            "correct it"
        )
    return found, ["z = 0 added to points of x and y"] if points.shape[1] == 2 else []


def _kind(kind: str, cells: NDArray[Any]) -> str:
    """The type of a block of cells: polygons of three and four corners are triangles and quadrilaterals."""
    if kind.startswith("polygon"):
        return {3: "triangle", 4: "quad"}.get(cells.shape[1], "polygon")
    return kind


def _check_types(cells: list[tuple[str, NDArray[Any]]]) -> Counter[str]:
    """Numbers of points and lines by their types. Raises MeshError for any other cells than these and surfaces."""
    counts: Counter[str] = Counter()
    for kind, rows in cells:
        counts[_kind(kind, rows)] += len(rows)
    for kind, count in counts.items():
        if kind in SURFACES or kind == "vertex" or kind.startswith("line") or not count:
            continue
        many = f"holds {count} cells of type {kind!r}"
        if kind.startswith(VOLUMES):
            raise MeshError(f"{many}, which fill a volume; write the surface alone that is the film (gmsh -2)")
        if kind.startswith(("triangle", "quad")):
            raise MeshError(
                f"{many}, with nodes between their corners; write cells of first order (gmsh: Mesh.ElementOrder = 1)"
            )
        raise MeshError(f"{many}; write triangles and quadrilaterals")
    return Counter({kind: count for kind, count in counts.items() if kind not in SURFACES and count})


def _faces(cells: list[tuple[str, NDArray[Any]]], count: int, others: Mapping[str, int]) -> _Faces:
    """All triangles and quadrilaterals. Raises MeshError where there are none, and for corners that are no point."""
    blocks: list[Ints] = []
    first: dict[int, int] = {}
    many = 0
    for k, (name, rows) in enumerate(cells):
        kind = _kind(name, rows)
        if kind not in SURFACES:
            continue
        bad = np.argwhere((rows < 0) | (rows >= count))
        if len(bad):
            raise MeshError(
                f"corner {bad[0, 1]} of the cell {bad[0, 0]} of type {kind!r}, both counted from 0, is none of its "
                f"{count} points; correct it, or write the mesh anew"
            )
        corners = np.full((len(rows), 4), -1, np.int64)
        corners[:, : SURFACES[kind]] = rows
        blocks.append(corners)
        first[k] = many
        many += len(rows)
    if not many:
        held = ", ".join(f"{count} cells of type {kind!r}" for kind, count in others.items()) or "no cells at all"
        raise MeshError(f"holds neither triangles nor quadrilaterals, but {held}; write the surface that is the film")
    return _Faces(np.concatenate(blocks), first)


class _Group(NamedTuple):
    """A named group of a file."""

    points: list[Ints]
    cells: dict[int, Ints]
    """Rows of blocks."""

    def nodes(self, name: str, blocks: list[tuple[str, NDArray[Any]]], count: int) -> Ints:
        """Its points, and those of its cells. Raises MeshError for what is none of so many points."""
        corners = (blocks[k][1][rows].ravel() for k, rows in self.cells.items())
        found = np.concatenate([np.empty(0, np.int64), *self.points, *corners])
        _check_members(found, count, f"the group {name!r} of points")
        return found

    def faces(self, faces: _Faces) -> Ints:
        """(k,) numbers of the faces that are its cells."""
        rows = (faces.first[k] + rows for k, rows in self.cells.items() if k in faces.first)
        found: Ints = np.concatenate([np.empty(0, np.int64), *rows])
        return found


def _groups(read: Read, count: int) -> Iterator[tuple[str, _Group]]:
    """Named groups: sets of points and cells, physical groups of Gmsh. Raises MeshError for members that are none."""
    found: dict[str, _Group] = {}

    def group(name: str) -> _Group:
        return found.setdefault(name, _Group([], {}))

    for name, points in read.point_sets.items():
        _check_members(points, count, f"the set {name!r} of points")
        group(name).points.append(points)
    for name, blocks in read.cell_sets.items():
        for k, members in blocks.items():
            _check_members(members, len(read.cells[k][1]), f"the set {name!r} of cells")
            if len(members):
                _add(group(name).cells, k, members)
    for k, (tags, (kind, rows)) in enumerate(zip(read.tags or [], read.cells, strict=False)):
        dimension = 0 if kind == "vertex" else 1 if kind.startswith("line") else 2
        for tag in np.unique(tags[tags != 0]) if len(tags) == len(rows) else ():
            name = read.names.get((dimension, int(tag)), f"{DIMENSIONS[dimension]}-{tag}")
            _add(group(name).cells, k, np.flatnonzero(tags == tag))
    return iter(found.items())


def _add(cells: dict[int, Ints], block: int, rows: Ints) -> None:
    cells[block] = np.union1d(cells[block], rows) if block in cells else np.unique(rows)


def _check_members(members: Ints, count: int, words: str) -> None:
    bad = members[(members < 0) | (members >= count)]
    if len(bad):
        raise MeshError(
            f"{words} holds number {bad[0]}, counted from 0, of {count}; correct it, or write the mesh anew"
        )
