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
from membrane_rs.mesh.joined import merged, without_repeats, wound_alike
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
    quads : {"alternate", "shorter"}
        By which diagonals quadrilaterals are split: those that meet at every other node, or each by its shorter one.
    merge : float, optional
        Nodes that are not further apart than this become one [m].
    """

    scale: Annotated[Finite, Ge(1e-12), Le(1e12), Unit("m")]
    quads: QuadRule = "alternate"
    merge: Annotated[Positive, Unit("m")] | None = field(default=None, kw_only=True)


class _Cells(NamedTuple):
    """Some cells of one type."""

    corners: Ints
    """(k, corners) nodes."""
    block: Ints
    """(k,) block of each."""
    row: Ints
    """(k,) row in that block."""


def read_foreign(path: Path, options: ForeignFile) -> dict[str, Any]:
    """What `Mesh` takes, by name, of a file whose suffix is one of `BY_SUFFIX`. Raises MeshError."""
    read = read_by_meshio(path)
    try:
        return _made(path, read, options)
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from None


def _made(path: Path, read: Read, options: ForeignFile) -> dict[str, Any]:
    points, steps = _points(read.points)
    others = _check_types(read.cells)
    groups = dict(_groups(read, len(points)))
    triangles, quads = (_cells_of(read.cells, kind, len(points)) for kind in SURFACES)
    if not len(triangles.row) + len(quads.row):
        held = ", ".join(f"{count} {kind}" for kind, count in others.items()) or "no cells at all"
        raise MeshError(f"holds neither triangles nor quadrilaterals, but {held}; write the surface that is the film")
    points = points * options.scale
    if BY_SUFFIX[path.suffix.lower()] == "stl":
        joined = 3 * len(triangles.row) - len(points)
        steps.append(f"{joined} of {3 * len(triangles.row)} corners merged with others of equal coordinates")
    corners, fours = triangles.corners, quads.corners
    if options.merge is not None:
        place, words = merged(points, options.merge)
        corners, fours, steps = place[corners], place[fours], [*steps, words]
    split, remarks = split_quads(points, fours, options.quads)
    rows = np.concatenate([corners, split])
    cells = _Cells(
        rows,
        np.concatenate([triangles.block, np.repeat(quads.block, 2)]),
        np.concatenate([triangles.row, np.repeat(quads.row, 2)]),
    )
    order = np.lexsort((np.arange(len(rows)), cells.row, cells.block))
    cells = _Cells(*(each[order] for each in cells))
    found, numbers, words_of_repeats = without_repeats(cells.corners, may_collapse=options.merge is not None)
    found, words_of_turned = wound_alike(found)
    node_sets, triangle_sets = _sets(groups, cells, numbers, read.cells)
    if options.merge is not None:
        node_sets = {name: np.unique(place[nodes]) for name, nodes in node_sets.items()}
    used = np.unique(found)
    unused = len(np.unique(place)) - len(used) if options.merge is not None else len(points) - len(used)
    left = [f"{unused} nodes left out, which no triangle has"] if unused else []
    index = np.full(len(points), -1, np.int64)
    index[used] = np.arange(len(used))
    kept_sets = {name: kept for name, nodes in node_sets.items() if len(kept := _kept(index[nodes]))}
    empty = [name for name in node_sets if name not in kept_sets]
    if empty:
        left.append(f"groups left out, whose nodes no triangle has: {', '.join(sorted(empty))}")
    ignored = [f"{count} cells of type {kind!r} ignored, but for named groups" for kind, count in others.items()]
    steps += [*remarks, *words_of_repeats, *words_of_turned, *left, *ignored]
    if kept_sets:
        steps.append(f"node sets of named groups: {', '.join(kept_sets)}")
    if triangle_sets:
        steps.append(f"triangle sets of named groups: {', '.join(triangle_sets)}")
    return {
        "reference": points[used],
        "triangles": index[found],
        "node_sets": kept_sets,
        "triangle_sets": triangle_sets,
        "source": MeshOrigin(str(path), options.scale, tuple(steps)),
    }


def _kept(nodes: Ints) -> Ints:
    found: Ints = np.unique(nodes[nodes >= 0])
    return found


def _points(points: NDArray[Any]) -> tuple[Floats, list[str]]:
    """Points (n, 3), and whether z was added. Raises MeshError."""
    if points.size == 0:
        raise MeshError("holds no points; write the mesh of a surface")
    if points.ndim != 2 or points.shape[1] not in (2, 3) or points.dtype.kind not in "fiu":
        raise MeshError(f"holds points of shape {points.shape} and dtype {points.dtype}; must be rows x, y, z")
    check_nodes(len(points), "its points", "take fewer", MeshError)
    found: Floats = np.zeros((len(points), 3))
    found[:, : points.shape[1]] = points
    bad = np.flatnonzero(~np.isfinite(found).all(axis=1))
    if len(bad):
        raise MeshError(
            f"point {bad[0]}, counted from 0, is {found[bad[0]].tolist()}, not finite ({len(bad)} such); correct it"
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


def _cells_of(cells: list[tuple[str, NDArray[Any]]], kind: str, count: int) -> _Cells:
    """All cells of a type of surface, in the order of the file. Raises MeshError for corners that are no point."""
    width = SURFACES[kind]
    chosen = [(k, rows) for k, (name, rows) in enumerate(cells) if _kind(name, rows) == kind and len(rows)]
    made = _Cells(
        np.concatenate([np.empty((0, width), np.int64), *(rows for _, rows in chosen)]),
        np.concatenate([np.empty(0, np.int64), *(np.full(len(rows), k) for k, rows in chosen)]),
        np.concatenate([np.empty(0, np.int64), *(np.arange(len(rows)) for _, rows in chosen)]),
    )
    bad = np.argwhere((made.corners < 0) | (made.corners >= count))
    if len(bad):
        row, corner = bad[0]
        raise MeshError(
            f"corner {corner} of cell {made.row[row]} of type {kind!r}, both counted from 0, is none of its {count} "
            "points; correct it, or write the mesh anew"
        )
    return made


class _Group(NamedTuple):
    """A named group of a file."""

    points: list[Ints]
    cells: dict[int, Ints]
    """Rows of blocks."""


def _groups(read: Read, count: int) -> Iterator[tuple[str, _Group]]:
    """Named groups: sets of points and cells, physical groups of Gmsh. Raises MeshError for members that are none."""
    found: dict[str, _Group] = {}

    def group(name: str) -> _Group:
        return found.setdefault(name, _Group([], {}))

    for name, points in read.point_sets.items():
        _check_members(points, count, f"the set {name!r} of points")
        group(name).points.append(points)
    for name, blocks in read.cell_sets.items():
        for k, (members, (_, rows)) in enumerate(zip(blocks, read.cells, strict=False)):
            _check_members(members, len(rows), f"the set {name!r} of cells")
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


def _sets(
    groups: Mapping[str, _Group], cells: _Cells, numbers: Ints, blocks: list[tuple[str, NDArray[Any]]]
) -> tuple[dict[str, Ints], dict[str, Ints]]:
    """Node sets and triangle sets of groups; `numbers` says which triangle became of each of the cells, -1 for none."""
    node_sets: dict[str, Ints] = {}
    triangle_sets: dict[str, Ints] = {}
    for name, group in groups.items():
        nodes, triangles = list(group.points), []
        for k, rows in group.cells.items():
            nodes.append(blocks[k][1][rows].ravel())
            is_chosen = (cells.block == k) & np.isin(cells.row, rows)
            triangles.append(numbers[is_chosen])
        node_sets[name] = np.unique(np.concatenate(nodes)) if nodes else np.empty(0, np.int64)
        found = _kept(np.concatenate(triangles)) if triangles else np.empty(0, np.int64)
        if len(found):
            triangle_sets[name] = found
    return node_sets, triangle_sets
