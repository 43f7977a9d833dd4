"""FOLD files as the specification 1.2 defines them, read without the package: invariants of frames, and folding.

https://github.com/edemaine/fold/blob/main/doc/spec.md
"""

from __future__ import annotations

import json
import math
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Frame = dict[str, Any]
Points = NDArray[np.float64]
KEYS = {
    "file_spec", "file_creator", "file_author", "file_title", "file_description", "file_classes", "file_frames",
    "frame_author", "frame_title", "frame_description", "frame_classes", "frame_attributes", "frame_unit",
    "frame_parent", "frame_inherit", "vertices_coords", "vertices_vertices", "vertices_edges", "vertices_faces",
    "edges_vertices", "edges_faces", "edges_assignment", "edges_foldAngle", "edges_length", "faces_vertices",
    "faces_edges", "faces_faces", "faceOrders", "edgeOrders",
}  # fmt: skip
SIGNS = {"V": 1.0, "M": -1.0}


def frames_of(path: Path) -> list[Frame]:
    """All frames of a file, each with what it inherits. NaN and infinities are no JSON."""
    table = json.loads(path.read_text(encoding="utf-8"), parse_constant=lambda name: 1 / 0)
    frames = [table]
    for frame in table.get("file_frames", []):
        inherited = frames[frame["frame_parent"]] if frame.get("frame_inherit") else {}
        frames.append({**inherited, **frame})
    return frames


def check_specification(frame: Frame) -> None:
    """What the specification says of a frame with faces."""
    assert all(key in KEYS or ":" in key for key in frame), set(frame) - KEYS
    assert frame["file_spec"] == 1.2
    vertices, edges, faces = frame["vertices_coords"], frame["edges_vertices"], frame["faces_vertices"]
    for key in frame:
        if key.startswith("edges_"):
            assert len(frame[key]) == len(edges), key
    attributes = frame["frame_attributes"]
    assert ("2D" in attributes) == all(len(row) == 2 or row[2] == 0 for row in vertices)
    assert ("2D" in attributes) != ("3D" in attributes)
    assert all(len(row) in (2, 3) and all(math.isfinite(number) for number in row) for row in vertices)
    assert all(0 <= vertex < len(vertices) for row in (*edges, *faces) for vertex in row)
    assert len({frozenset(edge) for edge in edges}) == len(edges)
    for face, own in zip(faces, frame["faces_edges"], strict=True):
        assert [set(edges[k]) for k in own] == [set(side) for side in sides_of(face)]
    beside = faces_beside(frame)
    letters, angles = frame["edges_assignment"], frame["edges_foldAngle"]
    for (u, v), letter, angle in zip(edges, letters, angles, strict=True):
        # "manifold", "orientable": at most one face to the left of each direction.
        assert len(beside[u, v]) + len(beside[v, u]) == (1 if letter == "B" else 2)
        assert len(beside[u, v]) <= 1
        assert -180 <= angle <= 180
        assert np.sign(angle) == SIGNS.get(letter, 0.0), (letter, angle)
    assert ("joins" in attributes) == ("J" in letters)
    assert "C" not in letters
    assert {"manifold", "orientable", "noCuts"} <= set(attributes)
    if "creasePattern" in frame["frame_classes"] and "2D" in attributes:
        x, y = np.array(vertices)[np.array(faces)][:, :, :2].transpose(2, 1, 0)
        assert ((x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]) > 0.0).all()


def sides_of(face: list[int]) -> list[tuple[int, int]]:
    """The sides of a face, in its direction."""
    return list(zip(face, face[1:] + face[:1], strict=True))


def faces_beside(frame: Frame) -> dict[tuple[int, int], list[int]]:
    """The faces to the left of each direction of each edge."""
    found: dict[tuple[int, int], list[int]] = defaultdict(list)
    for k, face in enumerate(frame["faces_vertices"]):
        for side in sides_of(face):
            found[side].append(k)
    return found


def points_of(frame: Frame) -> Points:
    """(n, 3) coordinates of the vertices."""
    return np.array([[*row, 0.0][:3] for row in frame["vertices_coords"]])


def folded(pattern: Frame, angles: list[float]) -> Points:
    """(n, 3) the vertices of a pattern, folded face by face from face 0 on, which stays.

    The face to the left of an edge u -> v sees a valley of angle a turn the face to the right up, to where its normal
    points: a rotation by -a about u -> v.
    """
    flat, beside = points_of(pattern), faces_beside(pattern)
    angle = {frozenset(edge): math.radians(each) for edge, each in zip(pattern["edges_vertices"], angles, strict=True)}
    motion: dict[int, tuple[Points, Points]] = {0: (np.eye(3), np.zeros(3))}
    front, made = [0], np.full(flat.shape, np.nan)
    while front:
        following = []
        for face in front:
            turn, shift = motion[face]
            made[pattern["faces_vertices"][face]] = flat[pattern["faces_vertices"][face]] @ turn.T + shift
            for u, v in sides_of(pattern["faces_vertices"][face]):
                for other in beside[v, u]:
                    if other not in motion:
                        local = rotation(flat[v] - flat[u], -angle[frozenset((u, v))])
                        motion[other] = turn @ local, turn @ (flat[u] - local @ flat[u]) + shift
                        following.append(other)
        front = following
    return made


def rotation(axis: Points, angle: float) -> Points:
    """The matrix of a rotation about an axis, by Rodrigues's formula."""
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn: Points = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    return turn


def apart(one: Points, other: Points, *, mirrored: bool = False) -> float:
    """The largest distance of nodes of two shapes, when one is moved onto the other, or its mirror image is."""
    a, b = one - one.mean(axis=0), other - other.mean(axis=0)
    u, _, v = np.linalg.svd(a.T @ b)
    sign = np.linalg.det(u @ v) * (-1.0 if mirrored else 1.0)
    return float(np.linalg.norm(a @ u @ np.diag([1.0, 1.0, sign]) @ v - b, axis=1).max())
