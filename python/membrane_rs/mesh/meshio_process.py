"""Files of other programs, read by meshio in a process of its own, within bounds of memory and time.

meshio prints, may end the process, and takes memory for whatever a file declares. Here only that process ends, and its
words become those of an error.
"""

from __future__ import annotations

import errno
import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

from numpy.typing import NDArray

from membrane_rs._files import check_regular
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
SECONDS, SECONDS_PER_BYTE = 30, 2e-5
"""Time that the process may take, and so much more for each byte of the file."""
_COMMAND = "import sys; sys.path[:] = filter(None, sys.path); from membrane_rs.mesh.meshio_reader import serve; serve()"
"""Without the present folder, in which a file may lie beside modules of others."""


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
    cell_sets: dict[str, dict[int, NDArray[Any]]]
    """For each name, cells of some blocks, by the numbers of these."""
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
        if not size:
            raise OSError(errno.ENODATA, "it is empty")
        seconds = SECONDS + SECONDS_PER_BYTE * size
        done = subprocess.run(
            [sys.executable, "-c", _COMMAND, str(path), kind],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            check=False,
            timeout=seconds,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(map(os.path.abspath, _module_folders()))} | _ONE_THREAD,
            start_new_session=True,
        )
        is_read, found = pickle.loads(done.stdout)
    except (EOFError, pickle.UnpicklingError):
        is_read, found = False, "the process that reads it has ended"
    except subprocess.TimeoutExpired:
        is_read, found = False, f"it was not read within {seconds:.0f} s"
    except OSError as error:
        raise MeshError(f"{path}: cannot be read ({error.strerror or error}); give the path of a mesh file") from None
    if not is_read:
        raise MeshError(
            f"{path}: is no {WORDS[kind]} file that can be read ({found}); {_REMEDIES.get(kind, 'write it anew')}, or "
            "in another format, such as VTU"
        )
    read: Read = found
    return read


def _module_folders() -> list[str]:
    """Where that process finds modules: as this one, but not in the present folder, "" where no script runs."""
    return [*filter(None, sys.path), str(Path(__file__).parents[2])]


_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""Threads of libraries of linear algebra would take address space from the bound."""
_REMEDIES = {
    "gmsh": "write it as version 2.2 (Mesh.MshFileVersion = 2.2), with Mesh.SaveAll = 0 and Mesh.SaveParametric = 0"
}
"""What to do about a file that is not read."""
