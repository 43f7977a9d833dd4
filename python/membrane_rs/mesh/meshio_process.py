"""Files of other programs, read by meshio in a process of its own, within bounds of memory and time.

meshio prints, may end the process, and takes memory for whatever a file declares. Here only that process ends, and its
words become those of an error.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from membrane_rs._files import check_regular
from membrane_rs._messages import in_one_line
from membrane_rs.errors import MeshError

BY_SUFFIX = {
    ".msh": "gmsh", ".obj": "obj", ".stl": "stl", ".vtu": "vtu", ".vtk": "vtk", ".ply": "ply", ".off": "off",
    ".inp": "abaqus", ".nas": "nastran", ".bdf": "nastran", ".mesh": "medit",
}  # fmt: skip
"""Modules of meshio that read a kind of file."""
WORDS = {
    "gmsh": "Gmsh", "obj": "OBJ", "stl": "STL", "vtu": "VTU", "vtk": "VTK", "ply": "PLY", "off": "OFF",
    "abaqus": "Abaqus", "nastran": "Nastran", "medit": "Medit",
}  # fmt: skip
"""What messages call the kinds of files."""

MOST_BYTES = 2**30
"""A larger file is not read."""
MEMORY, MEMORY_PER_BYTE = 2**31, 40
"""Bytes that the process may take, and so many more for each byte of the file."""
SECONDS, SECONDS_PER_BYTE = 60, 2e-5
"""Time that the process may take, and so much more for each byte of the file."""
_COMMAND = "from membrane_rs.mesh.meshio_process import serve; serve()"


class Read(NamedTuple):
    """What a file holds."""

    points: NDArray[Any]
    """(n, 2) or (n, 3) coordinates, in the unit of the file."""
    cells: list[tuple[str, NDArray[Any]]]
    """Blocks of cells: their type in the words of meshio, and (k, corners) indices of points."""
    tags: list[NDArray[Any]] | None
    """For each block (k,) numbers of physical groups of Gmsh, 0 for none; None in other files."""
    names: dict[tuple[int, int], str]
    """Names of those groups, by dimension and number."""
    cell_sets: dict[str, list[NDArray[Any]]]
    """For each name, cells of each block."""
    point_sets: dict[str, NDArray[Any]]
    """Points by name."""


def read_by_meshio(path: Path) -> Read:
    """What a file holds whose suffix is one of `BY_SUFFIX`. Raises MeshError, which says why it cannot be read."""
    kind = BY_SUFFIX[path.suffix.lower()]
    is_read: bool
    found: Any
    try:
        check_regular(path, MOST_BYTES)
        size = path.stat().st_size
        seconds = SECONDS + SECONDS_PER_BYTE * size
        done = subprocess.run(
            [sys.executable, "-c", _COMMAND, str(path), kind],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            check=False,
            timeout=seconds,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(each for each in sys.path if each)} | _ONE_THREAD,
            start_new_session=True,
        )
        is_read, found = pickle.loads(done.stdout) if done.stdout else (False, f"its reader ended, {done.returncode}")
    except subprocess.TimeoutExpired:
        is_read, found = False, f"it was not read within {seconds:.0f} s"
    except OSError as error:
        raise MeshError(f"{path}: cannot be read ({error.strerror or error}); give the path of a mesh file") from None
    if not is_read:
        raise MeshError(
            f"{path}: cannot be read as a {WORDS[kind]} file ({found}); {_REMEDIES.get(kind, 'write it anew')}, or in "
            "another format, such as VTU"
        )
    read: Read = found
    return read


_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""Threads of libraries of linear algebra would take address space from the bound."""
_REMEDIES = {
    "gmsh": "write it as version 2.2 (Mesh.MshFileVersion = 2.2), with Mesh.SaveAll = 0 and Mesh.SaveParametric = 0"
}
"""What to do about a file that is not read."""


def serve() -> None:
    """Read one file, in the process of its own, and write what it holds to the standard output, pickled."""
    sink = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what meshio prints is no answer
    path, kind = sys.argv[1:]
    try:
        _bound(os.path.getsize(path))  # noqa: PTH202 - as little as possible is imported before the bound
        reply: tuple[bool, Any] = (True, _read(path, kind))
    except MemoryError:
        reply = (False, "it asks for more memory than a file of its size may")
    except BaseException as error:  # noqa: BLE001 - whatever meshio meets in a file, and SystemExit
        reply = (False, in_one_line(error))
    try:
        pickle.dump(reply, sink)
        sink.flush()
    finally:
        os._exit(0)


def _bound(size: int) -> None:
    """Bound the memory and the time of this process, for a file of so many bytes."""
    import resource

    for bound, value in (
        (resource.RLIMIT_AS, MEMORY + MEMORY_PER_BYTE * size),
        (resource.RLIMIT_CPU, int(SECONDS + SECONDS_PER_BYTE * size)),
        (resource.RLIMIT_CORE, 0),
    ):
        most = resource.getrlimit(bound)[1]
        least = value if most == resource.RLIM_INFINITY else min(value, most)
        resource.setrlimit(bound, (least, most))


def _read(path: str, kind: str) -> Read:
    """What meshio reads of a file. Raises errors of any kind."""
    import meshio

    # Not meshio.read: that prints, and ends the process, where a file cannot be read.
    mesh = getattr(meshio, kind).read(path)
    cells = [(str(block.type), _rows(block)) for block in mesh.cells]
    tags = mesh.cell_data.get("gmsh:physical") if kind == "gmsh" else None
    names = (
        {(int(pair[1]), int(pair[0])): str(name) for name, pair in mesh.field_data.items()} if kind == "gmsh" else {}
    )
    return Read(
        points=np.asarray(mesh.points),
        cells=cells,
        tags=None if tags is None else [np.asarray(each) for each in tags],
        names=names,
        cell_sets={
            str(name): [np.asarray([] if members is None else members, np.int64) for members in blocks]
            for name, blocks in mesh.cell_sets.items()
            if name != "gmsh:bounding_entities"
        },
        point_sets={str(name): np.asarray(members, np.int64) for name, members in mesh.point_sets.items()},
    )


def _rows(block: Any) -> NDArray[Any]:
    """(k, corners) of a block of cells; (k, 0) of cells that have different numbers of corners."""
    try:
        rows = np.asarray(block.data, np.int64)
    except (ValueError, TypeError):
        return np.empty((len(block.data), 0), np.int64)
    return rows if rows.ndim == 2 else np.empty((len(block.data), 0), np.int64)
