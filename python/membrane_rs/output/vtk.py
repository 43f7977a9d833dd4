"""Frames for ParaView: one VTU file per frame, and a PVD file that lists them with their times.

A frame's cells are the triangles, then a line for each spring (membrane edges first, then tethers).

Point data: velocity [m/s], displacement [m] from the reference. Cell data, NaN or -1 where a cell has none:

    spring_strain         lines      l / L - 1
    triangle_strain       triangles  (2,) principal Green-Lagrange strains, larger first
    crease_angle          lines      [rad] pi flat, 0 shut, negative where the wings have passed each other
    buckled               lines      1 at or below the critical length, 0 above
    petal                 triangles  number of the petal, where the scene names petals
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from membrane_rs._files import replacing
from membrane_rs.errors import MissingFileError, OutputError
from membrane_rs.observe import Floats, Ints, triangle_strains

if TYPE_CHECKING:
    from membrane_rs.assembly import Assembly
    from membrane_rs.simulation import Simulation


def find_pairs(pairs: Ints, wanted: Ints) -> Ints:
    """Row in `pairs` (s, 2) of each of the `wanted` (c, 2) node pairs, in either direction; -1 for none."""
    if not len(wanted) or not len(pairs):
        return np.full(len(wanted), -1, dtype=np.int64)
    stride = int(max(pairs.max(), wanted.max())) + 1
    keys = np.sort(pairs, axis=1) @ [stride, 1]
    order = np.argsort(keys, kind="stable")
    sought = np.sort(wanted, axis=1) @ [stride, 1]
    rows = order[np.minimum(np.searchsorted(keys, sought, sorter=order), len(keys) - 1)]
    return np.where(keys[rows] == sought, rows, -1)


def petal_of_triangles(assembly: Assembly) -> NDArray[np.int8]:
    """Number of the petal (node set "petal-<k>") that holds all three nodes, (m,); -1 for none."""
    petal = np.full(len(assembly.triangles), -1, dtype=np.int8)
    for name, nodes in assembly.node_sets.items():
        head, _, number = name.rpartition("-")
        if head == "petal" and number.isdigit():
            petal[np.isin(assembly.triangles, nodes).all(axis=1)] = int(number)
    return petal


def write_frame(path: Path, sim: Simulation) -> None:
    """Write the state of `sim` as a VTU file, whole or not at all. Raises OutputError."""
    import meshio

    assembly, pairs = sim.assembly, np.asarray(sim.spring_pairs, dtype=np.int64)
    positions, triangles = sim.positions, assembly.triangles
    crease_angle = np.full(len(pairs), np.nan)
    crease_rows = find_pairs(pairs, assembly.creases)
    crease_angle[crease_rows[crease_rows >= 0]] = sim.crease_angles()[crease_rows >= 0]
    no_springs, no_triangles = np.full(len(triangles), np.nan), np.full(len(pairs), np.nan)

    cells: dict[str, Ints] = {"triangle": triangles, "line": pairs}
    on_cells: dict[str, list[NDArray[Any]]] = {
        "spring_strain": [no_springs, sim.spring_strains()],
        "triangle_strain": [
            triangle_strains(assembly.reference, positions, triangles),
            np.stack([no_triangles, no_triangles], axis=1),
        ],
        "crease_angle": [no_springs, crease_angle],
        "buckled": [np.full(len(triangles), -1, np.int8), sim.buckled().astype(np.int8)],
        "petal": [petal_of_triangles(assembly), np.full(len(pairs), -1, np.int8)],
    }
    filled = [k for k, block in enumerate(cells.values()) if len(block)]
    mesh = meshio.Mesh(
        positions,
        [block for k, block in enumerate(cells.items()) if k in filled],
        point_data={"velocity": sim.velocities, "displacement": positions - assembly.reference},
        cell_data={name: [blocks[k] for k in filled] for name, blocks in on_cells.items()},
    )
    with replacing(path) as part:
        mesh.write(part, file_format="vtu")


def read_frame(path: Path) -> Floats:
    """Positions (N, 3) [m] of a frame. Raises MissingFileError, and OutputError for what is no VTU file."""
    import meshio

    if not path.is_file():
        raise MissingFileError(f"no frame at {path}; name a .vtu file of a run's folder")
    try:
        # Not meshio.read: that prints, and ends the process, where a file cannot be read.
        return np.asarray(meshio.vtu.read(path).points, dtype=np.float64)
    except (meshio.ReadError, SyntaxError, LookupError, TypeError, ValueError, zlib.error) as error:
        raise OutputError(f"{path} is no VTU file of a run: {error}; run the scene again") from error


def write_pvd(path: Path, frames: Sequence[tuple[float, str]]) -> None:
    """List frames as (time [s], file relative to `path`), whole or not at all. Raises OutputError."""
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1", byte_order="LittleEndian")
    collection = ElementTree.SubElement(root, "Collection")
    for time, file in frames:
        ElementTree.SubElement(collection, "DataSet", timestep=repr(float(time)), group="", part="0", file=file)
    ElementTree.indent(root)
    with replacing(path) as part:
        ElementTree.ElementTree(root).write(part, encoding="utf-8", xml_declaration=True)


def read_pvd(path: Path) -> list[tuple[float, Path]]:
    """Times [s] and paths of the frames that a PVD file lists. Raises MissingFileError and OutputError."""
    if not path.is_file():
        raise MissingFileError(f"no frames.pvd at {path}; name a run's folder that holds frames")
    try:
        entries = ElementTree.parse(path).getroot().iter("DataSet")
        return [(float(entry.attrib["timestep"]), path.parent / entry.attrib["file"]) for entry in entries]
    except (ElementTree.ParseError, KeyError, ValueError) as error:
        raise OutputError(f"{path} is no PVD file: {error}; run the scene again to write it anew") from error
