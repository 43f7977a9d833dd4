"""Nodes, triangles, pairs and named sets of a mesh as users give them: checked, copied, read-only."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from membrane_rs._arrays import Floats, Ints
from membrane_rs._given_arrays import numeric
from membrane_rs._validation import check_text, show
from membrane_rs.errors import InputTypeError, MeshError
from membrane_rs.mesh.queries import distinct
from membrane_rs.mesh.triangulation import frozen

LONGEST_NAME = 1000
"""Characters of the name of a set: archives cut longer ones than some ten thousand."""


def or_empty(pairs: ArrayLike | None) -> ArrayLike:
    """Pairs, or none."""
    return np.empty((0, 2), dtype=np.int64) if pairs is None else pairs


def points_of(values: ArrayLike, name: str) -> Floats:
    """Points (n, 3) [m] as a read-only array of finite numbers."""
    array = numeric(values, name, "fiu", "numbers, in metres", MeshError)
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshError(f"{name} has shape {array.shape}; it must be (n, 3), one row x, y, z for each node")
    with np.errstate(over="ignore"):
        points = np.array(array, dtype=np.float64, order="C")
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise MeshError(
            f"{name}[{bad[0]}] = {points[bad[0]].tolist()} is not finite ({len(bad)} such nodes); "
            "replace NaN and infinite values by numbers"
        )
    return frozen(points)


def fitting(positions: ArrayLike, node_count: int) -> Floats:
    """A copy of positions, (n, 3) [m], that fit a mesh of so many nodes."""
    points = points_of(positions, "positions")
    if len(points) != node_count:
        raise MeshError(f"positions has {len(points)} nodes and reference {node_count}; give one row for each node")
    return points


def indices_of(values: ArrayLike, name: str, width: int, node_count: int) -> Ints:
    """Rows of node indices as a read-only array, none twice in a row."""
    array = numeric(values, name, "iu", "whole numbers, node indices", MeshError)
    if array.size == 0:
        array = np.empty((0, width), dtype=np.int64)
    if width == 3 and array.shape[1:] == (4,):
        raise MeshError(
            f"{name} has shape {array.shape}: these are quadrilaterals; split each a, b, c, d into the triangles "
            "a, b, c and a, c, d: numpy.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])"
        )
    if array.ndim != 2 or array.shape[1] != width:
        raise MeshError(f"{name} has shape {array.shape}; it must be (k, {width}), node indices in each row")
    _check_range(array, name, node_count)
    rows: Ints = np.array(array, dtype=np.int64, order="C")
    ordered = np.sort(rows, axis=1)
    bad = np.flatnonzero((ordered[:, 1:] == ordered[:, :-1]).any(axis=1))
    if len(bad):
        raise MeshError(
            f"{name}[{bad[0]}] = {rows[bad[0]].tolist()} names a node twice ({len(bad)} such rows); "
            "remove the row or correct it"
        )
    return frozen(rows)


def sets_of(sets: Mapping[str, ArrayLike] | None, kind: str, what: str, count: int) -> dict[str, Ints]:
    """Sets of a `kind` ("node_sets") by name, checked: of so many nodes or triangles, which are called `what`."""
    sets = {} if sets is None else sets
    if not isinstance(sets, Mapping) or not all(isinstance(name, str) for name in sets):
        raise InputTypeError(f"{kind} must be a dict from names (str) to lists of {what} indices")
    for name in sets:
        check_text(name, f"{kind}: the name")
        if not 1 <= len(name) <= LONGEST_NAME or "\0" in name:
            raise MeshError(
                f"{kind}: the name {show(name)}: must be 1 to {LONGEST_NAME} characters without a NUL, for files"
            )
    return {name: _set(members, f"{kind}['{name}']", what, count) for name, members in sets.items()}


def _set(values: ArrayLike, name: str, what: str, count: int) -> Ints:
    array = numeric(values, name, "iu", f"whole numbers, {what} indices", MeshError)
    if array.ndim != 1:
        raise MeshError(f"{name} has shape {array.shape}; it must be (k,), a list of {what} indices")
    _check_range(array, name, count, what)
    members: Ints = frozen(np.array(array, dtype=np.int64))
    if len(distinct(members)) < len(members):
        raise MeshError(f"{name} names a {what} twice; name it once")
    return members


def _check_range(array: NDArray[Any], name: str, count: int, what: str = "node") -> None:
    if array.size and (array.min() < 0 or array.max() >= count):
        bad = np.argwhere((array < 0) | (array >= count))[0]
        raise MeshError(
            f"{name}[{', '.join(map(str, bad))}] = {array[tuple(bad)]} is no {what}; indices run from 0 to {count - 1}"
        )
