"""What a FOLD file holds as the arrays of a mesh: the flat film, its stowed shape, its creases."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
from annotated_types import Ge, Le

from membrane_rs._arrays import Floats, Ints
from membrane_rs._validation import Finite, Unit, Whole, show, validated
from membrane_rs.errors import MeshError
from membrane_rs.mesh.fold_creases import SIGNS, Creases, creases_of, fold_angles_of
from membrane_rs.mesh.fold_frames import Frame, chosen_frame, read_frames
from membrane_rs.mesh.origin import MeshOrigin
from membrane_rs.mesh.planar_faces import NoFacesError, faces_between
from membrane_rs.mesh.polygons import PolygonError, slit, triangulated, wound_one_way
from membrane_rs.mesh.triangulation import Triangulation

FOLD = ".fold"
"""How the name of such a file ends."""
BRIDGES, NODE_SETS, TRIANGLE_SETS = "membrane_rs:bridges", "membrane_rs:node_sets", "membrane_rs:triangle_sets"
FACES = "faces_vertices"
REFERENCE = "membrane_rs:reference"
"""Class of a frame that is the film without strain, and no crease pattern since it does not lie in a plane."""
OF_LENGTHS = 0.01
"""By how much `edges_length` may differ from the distance of its vertices, relatively."""


@validated
class FoldFile:
    """How a FOLD file is read.

    Parameters
    ----------
    scale : float, optional
        Length of the unit of its coordinates [m], 0.001 for millimetres, where the file names no unit of length.
    frame : int, optional
        Frame whose coordinates are the positions. Default: the folded form, where there is one.
    """

    scale: Annotated[Finite, Ge(1e-12), Le(1e12), Unit("m")] | None = None
    frame: Whole | None = None


def read_fold_file(path: Path, options: FoldFile) -> dict[str, Any]:
    """What `Mesh` takes, by name; see `read_fold`. Raises MissingFileError, and MeshError with file, frame and key."""
    flat, stowed = _shapes(read_frames(path), options.frame)
    points = flat.coordinates()
    edges = flat.edges(len(points))
    letters = flat.assignments(len(edges)) or []
    polygons, key = _polygons(flat, points, edges, letters)
    whole, of_triangle = _triangles(flat, points, polygons, key)
    beside = _faces_beside(flat, polygons, edges, letters)
    _check_lengths(flat, points, edges)
    cuts = edges[[k for k, letter in enumerate(letters) if letter == "C"]]
    triangles, origin = slit(whole, cuts, len(points))
    reference = positions = _in_metres(flat, points, options.scale)[origin]
    found = {"reference": reference, "triangles": triangles}
    if stowed is not flat:
        found["positions"] = positions = _in_metres(stowed, stowed.coordinates(), options.scale)[origin]
    creases = creases_of(flat, stowed, edges, letters, beside)
    found["creases"] = pairs = _pairs_of(triangles, origin, edges[creases.edges], len(points))
    found["fold_angles"] = fold_angles_of(
        stowed, creases, Triangulation(reference, triangles, pairs, edges[:0]), positions
    )
    bridges, node_sets = flat.get(BRIDGES), _sets(flat, NODE_SETS)
    if bridges is not None:
        _check_whole(flat, BRIDGES, bridges)
    up, down = stowed.metres(options.scale)
    steps = _steps(flat, stowed, polygons, found, creases)
    return {
        **found,
        "bridges": bridges,
        "node_sets": node_sets,
        "triangle_sets": _of_faces(_sets(flat, TRIANGLE_SETS), of_triangle),
        "source": MeshOrigin(str(path), up / down, tuple(steps)),
    }


def _shapes(frames: list[Frame], index: int | None) -> tuple[Frame, Frame]:
    """The frame without strain and the stowed one, which may be the same."""
    classes = [frame.words("frame_classes") for frame in frames]
    of_class = {kind: frame for frame, own in zip(frames[::-1], classes[::-1], strict=True) for kind in own}
    flat = of_class.get("creasePattern", of_class.get(REFERENCE))
    if index is not None:
        stowed = chosen_frame(frames, index)
        return (flat if flat is not None and _is_same_film(stowed, flat) else stowed), stowed
    if flat is None:
        flat = next((frame for frame in frames if frame.get("vertices_coords") is not None), frames[0])
    folded = (frame for frame, own in zip(frames, classes, strict=True) if "foldedForm" in own)
    return flat, next((frame for frame in folded if _is_same_film(frame, flat)), flat)


def _is_same_film(frame: Frame, flat: Frame) -> bool:
    """Whether a frame has the vertices, edges and faces of another one, or just other coordinates of its vertices."""
    own, other = frame.get("vertices_coords"), flat.get("vertices_coords")
    if not isinstance(own, list) or not isinstance(other, list) or len(own) != len(other):
        return False
    return all(frame.get(key) in (None, flat.get(key)) for key in ("edges_vertices", "faces_vertices"))


def _in_metres(frame: Frame, points: Floats, scale: float | None) -> Floats:
    up, down = frame.metres(scale)
    scaled: Floats = points * up / down
    return scaled


def _polygons(flat: Frame, points: Floats, edges: Ints, letters: list[str]) -> tuple[list[list[int]], str]:
    """The faces of a frame, or those between its edges, and what messages call them."""
    polygons = flat.polygons(len(points))
    if polygons is None:
        return _without_holes(_between_edges(flat, points, edges), edges, letters), "face between edges, "
    return polygons, FACES


def _triangles(flat: Frame, points: Floats, polygons: list[list[int]], key: str) -> tuple[Ints, Ints]:
    """Triangles of polygons, all wound one way, and the polygon of each."""
    size = np.abs(points).max(initial=0.0)
    scaled = points / size if size > 0.0 else points
    of_triangle = np.arange(len(polygons))
    try:
        triangles, of_triangle = triangulated(scaled, polygons)
        return wound_one_way(scaled, triangles), of_triangle
    except PolygonError as error:
        face = of_triangle[error.index]
        flat.fail(f"{key}[{face}]", f" = {show(polygons[face])}: {error}")
    except MeshError as error:
        flat.fail(key, f": {error}")


def _between_edges(flat: Frame, points: Floats, edges: Ints) -> list[list[int]]:
    if len(edges) == 0:
        flat.fail("faces_vertices", ": is missing, and there are no edges_vertices of which faces could be made")
    if np.ptp(points[:, 2]) != 0.0:
        flat.fail(
            "faces_vertices", ": is missing, and the vertices do not lie in a plane, where edges alone make faces"
        )
    try:
        polygons = faces_between(points[:, :2], edges)
    except NoFacesError as error:
        named = " and ".join(f"edges_vertices[{k}] = {edges[k].tolist()}" for k in error.edges) or "edges_vertices"
        flat.fail("faces_vertices", f": is missing, and {named} {error}; give the faces, or split or correct the edges")
    if not polygons:
        flat.fail("faces_vertices", ": is missing, and the edges enclose no face")
    return polygons


def _without_holes(polygons: list[list[int]], edges: Ints, letters: list[str]) -> list[list[int]]:
    """Faces without those that only borders surround, each of which has the film on its other side."""
    borders = {frozenset(pair) for pair, letter in zip(edges.tolist(), letters, strict=False) if letter == "B"}
    sides = [[frozenset(side) for side in zip(face, face[1:] + face[:1], strict=True)] for face in polygons]
    is_hole = [borders.issuperset(own) for own in sides]
    of_film = {side for own, hole in zip(sides, is_hole, strict=True) if not hole for side in own}
    return [
        face for face, own, hole in zip(polygons, sides, is_hole, strict=True) if not (hole and of_film.issuperset(own))
    ]


def _keys(pairs: Ints, count: int) -> Ints:
    keys: Ints = pairs.min(axis=1) * count + pairs.max(axis=1)
    return keys


def _faces_beside(frame: Frame, polygons: list[list[int]], edges: Ints, letters: list[str]) -> Ints:
    """(e,) faces beside each edge, compared with its letter: none is refused, two at a border, and one at a crease."""
    start = np.array([vertex for polygon in polygons for vertex in polygon], dtype=np.int64)
    end = np.array([vertex for polygon in polygons for vertex in (*polygon[1:], polygon[0])], dtype=np.int64)
    count = int(max(start.max(), edges.max(initial=0))) + 1
    keys, wanted = np.sort(_keys(np.stack([start, end], axis=1), count)), _keys(edges, count)
    sides: Ints = np.searchsorted(keys, wanted, side="right") - np.searchsorted(keys, wanted)
    for k in np.flatnonzero(sides == 0)[:1]:
        frame.fail(f"edges_vertices[{k}]", f" = {edges[k].tolist()}: is no side of a face; leave it out")
    for k, letter in enumerate(letters):
        if (letter == "B" and sides[k] > 1) or (letter in SIGNS and sides[k] < 2):
            remedy = "a border has one, and C is a cut between two" if letter == "B" else "a crease has two; write B"
            faces = "one face" if sides[k] == 1 else f"{sides[k]} faces"
            words = f" = {letter!r}: the edge {edges[k].tolist()} has {faces} beside it; {remedy}"
            frame.fail(f"edges_assignment[{k}]", words)
    return sides


def _check_lengths(frame: Frame, points: Floats, edges: Ints) -> None:
    given = frame.lengths(len(edges))
    if given is None:
        return
    found = np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1)
    for k in np.flatnonzero(~(np.abs(found - np.array(given)) <= OF_LENGTHS * found))[:1]:
        words = f" = {given[k]:g}: the vertices {edges[k].tolist()} are {found[k]:g} apart; correct it, or leave it out"
        frame.fail(f"edges_length[{k}]", words)


def _pairs_of(triangles: Ints, origin: Ints, pairs: Ints, count: int) -> Ints:
    """Pairs of vertices as nodes of the sides of triangles that have them, in their order."""
    if len(origin) == count:
        return pairs
    sides = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    keys = _keys(origin[sides], count)
    order = np.argsort(keys, kind="stable")
    found = sides[order[np.searchsorted(keys[order], _keys(pairs, count))]]
    same = origin[found[:, 0]] == pairs[:, 0]
    made: Ints = np.where(same[:, None], found, found[:, ::-1])
    return made


def _sets(flat: Frame, key: str) -> dict[str, Any]:
    """Lists of whole numbers by name."""
    sets = flat.get(key)
    if sets is None:
        return {}
    if not isinstance(sets, dict):
        flat.fail(key, f" = {show(sets)}: must be an object of names and lists of indices")
    for name, members in sets.items():
        _check_whole(flat, f"{key}[{show(name)}]", members)
    return dict(sets)


def _of_faces(sets: dict[str, Any], of_triangle: Ints) -> dict[str, Any]:
    """Sets of triangles for sets of faces, which may have been cut into several."""
    if len(of_triangle) == of_triangle.max() + 1:
        return sets
    return {name: np.flatnonzero(np.isin(of_triangle, faces)) for name, faces in sets.items()}


def _check_whole(frame: Frame, place: str, found: Any) -> None:
    """Refuse a key of our own that holds anything but lists of whole numbers."""
    rows: list[Any] = found if isinstance(found, list) else [None]
    numbers = [number for row in rows for number in (row if isinstance(row, list) else [row])]
    if not all(type(number) is int and abs(number) < 2**62 for number in numbers):
        frame.fail(place, f" = {show(found)}: must hold whole numbers, indices")


def _steps(flat: Frame, stowed: Frame, polygons: list[list[int]], made: dict[str, Any], creases: Creases) -> list[str]:
    """What was done to make a mesh of a file, a few words each."""
    shape = "" if stowed is flat else f", frame {stowed.index} the shape at the start"
    steps = [f"frame {flat.index} is the film without strain{shape}"]
    if flat.get(FACES) is None:
        steps.append(f"{len(polygons)} faces made between the edges")
    if len(made["triangles"]) > len(polygons):
        steps.append(f"{len(polygons)} faces cut into {len(made['triangles'])} triangles")
    doubled = len(made["reference"]) - len(flat.get("vertices_coords"))
    if doubled:
        steps.append(f"{doubled} nodes doubled along cuts")
    assumed = int(creases.has_side_alone.sum())
    if assumed and stowed is flat and "foldedForm" not in flat.words("frame_classes"):
        steps.append(f"{assumed} creases without fold angle taken as shut, 180 degrees to the side of M or V")
    orders = len(stowed.rows("faceOrders") or [])
    if orders:
        steps.append(f"{orders} orders of faces skipped: those that the shape tells are written again")
    return steps
