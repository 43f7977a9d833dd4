"""What runs in the process that reads a file of another program: meshio, and what it has to be helped with."""

from __future__ import annotations

import io
import os
import pickle
import re
import sys
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from membrane_rs._messages import in_one_line
from membrane_rs.mesh.meshio_process import MEMORY, MEMORY_PER_BYTE, SECONDS, SECONDS_PER_BYTE, Read

MOST_TAIL = 4096
"""Bytes at the end of a file in which its last word is looked for."""


MOST_NAMES = 10**7
"""Bytes at the beginning of a file in which names are looked for."""


def serve() -> None:
    """Read one file, and write what it holds to the standard output, pickled, or why it cannot be read."""
    sink = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what meshio prints is no answer
    path, kind = Path(sys.argv[1]), sys.argv[2]
    try:
        _bound(path.stat().st_size)
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
    """Bound the memory and the time of this process, for a file of so many bytes, as far as the system can.

    Windows bounds neither; macOS takes no bound of memory below what the process has reserved. There the time alone is
    bounded, by the process that waits.
    """
    try:
        import resource
    except ModuleNotFoundError:
        return
    for bound, value in (
        (resource.RLIMIT_AS, MEMORY + MEMORY_PER_BYTE * size),
        (resource.RLIMIT_CPU, int(SECONDS + SECONDS_PER_BYTE * size)),
        (resource.RLIMIT_CORE, 0),
    ):
        most = resource.getrlimit(bound)[1]
        least = value if most == resource.RLIM_INFINITY else min(value, most)
        with suppress(ValueError):
            resource.setrlimit(bound, (least, most))


def _read(path: Path, kind: str) -> Read:
    """What a file holds. Raises errors of any kind."""
    import meshio

    source: Any = path
    groups: list[str] = []
    if kind == "obj":
        source, groups = _plain_obj(path)
    else:
        kind = _checked(path, kind)
    # Not meshio.read: that prints, and ends the process, where a file cannot be read.
    mesh = getattr(meshio, kind).read(source)
    tags = mesh.cell_data.get("gmsh:physical")
    sets = {
        str(name): {
            k: np.asarray(members, np.int64)
            for k, members in zip(range(len(mesh.cells)), blocks, strict=False)
            if members is not None
        }
        for name, blocks in mesh.cell_sets.items()
        if name != "gmsh:bounding_entities"
    }
    for name, k, rows in _faces_of_groups(groups, mesh.cell_data.get("obj:group_ids", ())):
        sets.setdefault(name, {})[k] = rows
    return Read(
        points=np.asarray(mesh.points),
        cells=[(str(block.type), _rows(block)) for block in mesh.cells],
        tags=None if tags is None else [np.asarray(each) for each in tags],
        names=_names(path) if tags else {},
        cell_sets=sets,
        point_sets={str(name): np.asarray(members, np.int64) for name, members in mesh.point_sets.items()},
    )


def _checked(path: Path, kind: str) -> str:
    """The module of meshio for a file. Raises ValueError for one that was cut off, which meshio takes for whole."""
    with path.open("rb") as file:
        first = file.read(84)
        size = path.stat().st_size
        file.seek(max(size - MOST_TAIL, 0))
        tail = file.read(MOST_TAIL)
    if kind == "gmsh" and first.startswith(b"("):
        return "ansys"  # Fluent writes .msh as well
    is_binary = kind == "stl" and len(first) == 84 and size == 84 + 50 * int.from_bytes(first[80:], "little")
    if kind == "stl" and not is_binary and b"endsolid" not in tail:
        raise ValueError("it ends before its endsolid")
    if kind == "gmsh" and first and not tail.rsplit(b"$", 1)[-1].startswith(b"End"):
        raise ValueError("it ends within a section")
    return kind


def _plain_obj(path: Path) -> tuple[io.StringIO, list[str]]:
    """The points and faces of an OBJ file alone, by positive indices, and the names of its groups, in their order.

    meshio takes neither colours of points, nor indices from the end, nor as many textures or normals as a file has.
    """
    lines: list[str] = []
    groups: list[str] = []
    count = 0
    text = path.read_text(encoding="utf-8", errors="replace").replace("\\\n", " ")
    for line in text.splitlines():
        word, *rest = line.split() or [""]
        if word == "v":
            count += 1
            lines.append(" ".join(("v", *rest[:3])))
        elif word == "f":
            corners = [int(corner.partition("/")[0]) for corner in rest]
            lines.append(" ".join(("f", *(str(k if k >= 0 else count + 1 + k) for k in corners))))
        elif word in ("g", "o"):
            groups.append(" ".join(rest))
            lines.append("g")
    return io.StringIO("\n".join(lines)), groups


def _names(path: Path) -> dict[tuple[int, int], str]:
    """Names of physical groups of Gmsh, by dimension and number: meshio keeps one of those that share a name."""
    with path.open("rb") as file:
        section = file.read(MOST_NAMES).partition(b"$PhysicalNames")[2].partition(b"$EndPhysicalNames")[0]
    lines = re.findall(r'^\s*(\d+)\s+(\d+)\s+"(.*)"\s*$', section.decode(errors="replace"), re.MULTILINE)
    return {(int(dimension), int(number)): name for dimension, number, name in lines}


def _faces_of_groups(groups: list[str], ids: Iterable[Any]) -> Iterator[tuple[str, int, NDArray[Any]]]:
    """Name, block and rows of the faces of each named group, by the numbers of groups of each block, -1 for none."""
    number = {name: k for k, name in enumerate(dict.fromkeys(groups))}
    names = list(number)
    of_group = np.array([*(number[name] for name in groups), -1], np.int64)
    for k, each in enumerate(ids):
        numbers = of_group[np.asarray(each, np.int64)]
        for found in np.unique(numbers[numbers >= 0]).tolist():
            if names[found]:
                yield names[found], k, np.flatnonzero(numbers == found)


def _rows(block: Any) -> NDArray[Any]:
    """(k, corners) of a block of cells; (k, 0) of cells that have different numbers of corners."""
    try:
        rows = np.asarray(block.data, np.int64)
    except (ValueError, TypeError):
        return np.empty((len(block.data), 0), np.int64)
    return rows if rows.ndim == 2 else np.empty((len(block.data), 0), np.int64)
