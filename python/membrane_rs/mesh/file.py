"""A mesh in a file: a numpy archive (.npz), which `numpy.savez` writes and `numpy.load` reads.

    reference      (n, 3) float     nodes of the shape without strain [m]
    triangles      (m, 3) int       corners of each triangle
    positions      (n, 3) float     nodes at the start [m]; optional: as the reference
    creases        (c, 2) int       node pairs; optional
    fold_angles    (c,) float       fold angle of each crease at the start [rad]; optional
    bridges        (b, 2) int       node pairs joined by links of no length; optional
    node_set:NAME  (k,) int         node indices under a name; optional, as many as there are

Any other array is refused.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from membrane_rs._archives import ArchiveError, Arrays, read_arrays
from membrane_rs._bounds import check_nodes
from membrane_rs._files import replacing
from membrane_rs._validation import nearest
from membrane_rs.errors import MeshError, MissingFileError

NODE_SET = "node_set:"
NEEDED = ("reference", "triangles")
ARRAYS = (*NEEDED, "positions", "creases", "fold_angles", "bridges")


def write_mesh(path: Path, arrays: Mapping[str, Any], node_sets: Mapping[str, Any]) -> None:
    """Write the arrays of a mesh, whole or not at all. Raises OutputError."""
    sets = {NODE_SET + name: nodes for name, nodes in node_sets.items()}
    with replacing(path) as part, part.open("wb") as file:
        np.savez(file, **dict(arrays), **sets)


def read_mesh(path: Path) -> tuple[Arrays, Arrays]:
    """The arrays of a mesh, and its node sets, both by name.

    Raises
    ------
    MissingFileError
        No such file.
    MeshError
        A file that holds no mesh, or an array that a mesh does not have.
    """
    try:
        arrays = read_arrays(path)
    except FileNotFoundError:
        raise MissingFileError(f"{path}: there is no such mesh file; give one that Mesh.save wrote") from None
    except ArchiveError as error:
        raise MeshError(f"{path}: is no numpy archive of a mesh ({error}); give one that Mesh.save wrote") from None
    for name in arrays:
        if name not in ARRAYS and not name.startswith(NODE_SET):
            raise MeshError(f"{path}: {name!r} is no array of a mesh; {nearest(name, (*ARRAYS, NODE_SET + 'NAME'))}")
    missing = [name for name in NEEDED if name not in arrays]
    if missing:
        raise MeshError(
            f"{path}: holds no array {missing[0]!r}, so it is no mesh; its arrays are {', '.join(NEEDED)} and, where "
            f"there are such, {', '.join(ARRAYS[2:])} and {NODE_SET}NAME"
        )
    check_nodes(arrays["reference"].shape[0] if arrays["reference"].ndim else 0, f"{path}", "take fewer", MeshError)
    sets = {name.removeprefix(NODE_SET): nodes for name, nodes in arrays.items() if name.startswith(NODE_SET)}
    return {name: arrays[name] for name in ARRAYS if name in arrays}, sets
