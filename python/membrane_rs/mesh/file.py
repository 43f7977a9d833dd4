"""A mesh in a file of this package: a numpy archive (.npz), which `numpy.savez` writes and `numpy.load` reads.

    reference          (n, 3) float     nodes of the shape without strain [m]
    triangles          (m, 3) int       corners of each triangle
    positions          (n, 3) float     nodes at the start [m]; optional: as the reference
    creases            (c, 2) int       node pairs; optional
    fold_angles        (c,) float       fold angle of each crease at the start [rad]; optional
    bridges            (b, 2) int       node pairs joined by links of no length; optional
    node_set:NAME      (k,) int         node indices under a name; optional, as many as there are
    triangle_set:NAME  (k,) int         triangle indices under a name; optional, as many as there are

Any other array is refused.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from membrane_rs._archives import ArchiveError, read_arrays
from membrane_rs._bounds import check_nodes
from membrane_rs._files import replacing
from membrane_rs._validation import nearest
from membrane_rs.errors import MeshError, MissingFileError

NEEDED = ("reference", "triangles")
ARRAYS = (*NEEDED, "positions", "creases", "fold_angles", "bridges")
SETS = {"node_sets": "node_set:", "triangle_sets": "triangle_set:"}
"""Attributes that hold arrays by name, and what stands before the name in a file."""


def arrays_of(mesh: Any) -> Iterator[tuple[str, Any]]:
    """All arrays of a mesh, by their names in a file."""
    for name in ARRAYS:
        yield name, getattr(mesh, name)
    for kind, prefix in SETS.items():
        for name, members in sorted(getattr(mesh, kind).items()):
            yield prefix + name, members


def write_mesh(path: Path, mesh: Any) -> None:
    """Write the arrays of a mesh, whole or not at all. Raises OutputError."""
    with replacing(path) as part, part.open("wb") as file:
        np.savez(file, **dict(arrays_of(mesh)))


def read_mesh(path: Path, _: object = None) -> dict[str, Any]:
    """What a mesh is built of: its arrays and sets by the names of its parameters.

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
    found: dict[str, Any] = {kind: {} for kind in SETS}
    for name, array in arrays.items():
        kind = next((kind for kind, prefix in SETS.items() if name.startswith(prefix)), None)
        if kind is not None:
            found[kind][name.removeprefix(SETS[kind])] = array
        elif name in ARRAYS:
            found[name] = array
        else:
            known = (*ARRAYS, *(f"{prefix}NAME" for prefix in SETS.values()))
            raise MeshError(f"{path}: {name!r} is no array of a mesh; {nearest(name, known)}")
    missing = [name for name in NEEDED if name not in arrays]
    if missing:
        raise MeshError(
            f"{path}: holds no array {missing[0]!r}, so it is no mesh; its arrays are {', '.join(NEEDED)} and, where "
            f"there are such, {', '.join((*ARRAYS[2:], *(f'{prefix}NAME' for prefix in SETS.values())))}"
        )
    check_nodes(arrays["reference"].shape[0] if arrays["reference"].ndim else 0, f"{path}", "take fewer", MeshError)
    return found
