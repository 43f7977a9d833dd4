"""Frames for ParaView: one VTU file per frame.

A frame's cells are the triangles, then a line for each spring (membrane edges first, then tethers).

Point data: velocity [m/s], displacement [m] from the reference. Cell data, NaN or -1 where a cell has none:

    spring_strain         lines      l / L - 1
    triangle_strain       triangles  (2,) principal Green-Lagrange strains, larger first
    crease_angle          lines      [rad] pi flat, 0 shut, negative where the facets interpenetrate
    buckled               lines      1 below the critical length, else 0; with `Triangles` see
                                     `Motion.buckled`
    petal                 triangles  number of the petal, where the scene names petals
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from membrane_rs._arrays import Floats
from membrane_rs._files import replacing
from membrane_rs.analysis.strain import triangle_strains
from membrane_rs.errors import MissingFileError, OutputError
from membrane_rs.mesh.queries import find_pairs, petal_of_triangles
from membrane_rs.simulation.motion import Motion


@dataclass(frozen=True)
class Frame:
    """What a frame shows of a simulation at `time` [s], copied: the simulation may go on while it is written.

    positions (N, 3) [m], velocities (N, 3) [m/s], spring_strains (S,), buckled (S,), crease_angles (c,) [rad].
    """

    time: float
    positions: Floats
    velocities: Floats
    spring_strains: Floats
    buckled: NDArray[np.bool_]
    crease_angles: Floats

    @classmethod
    def of(cls, sim: Motion) -> Frame:
        """The state of `sim` now."""
        shape = sim.positions.copy(), sim.velocities.copy()
        return cls(sim.time, *shape, sim.spring_strains(), sim.buckled(), sim.crease_angles())


class FrameWriter:
    """Writes frames of one simulation. What is the same in all of them is worked out once.

    It keeps nothing of the simulation that changes, so that it can write in another thread.
    """

    def __init__(self, sim: Motion) -> None:
        self._reference = sim.assembly.reference
        self._triangles = sim.assembly.triangles
        pairs = np.asarray(sim.spring_pairs, dtype=np.int64)
        rows = find_pairs(pairs, sim.assembly.creases.nodes)
        self._creases, self._crease_rows = rows >= 0, rows[rows >= 0]
        self._triangle_count, self._spring_count = len(self._triangles), len(pairs)
        # Half the bytes, where they hold the numbers of the nodes.
        index = np.int32 if len(self._reference) <= np.iinfo(np.int32).max else np.int64
        blocks = (("triangle", self._triangles), ("line", pairs))
        self._filled = [k for k, (_, block) in enumerate(blocks) if len(block)]
        self._cells = [(blocks[k][0], blocks[k][1].astype(index)) for k in self._filled]
        self._petals = petal_of_triangles(self._triangles, sim.assembly.node_sets)

    def write(self, path: Path, frame: Frame) -> None:
        """Write `frame` as a VTU file, whole or not at all. Raises OutputError.

        Not compressed: coordinates hardly shrink, and the tenfold time would slow a run where no core is free.
        """
        import meshio

        on_triangles, on_springs = np.full(self._triangle_count, np.nan), np.full(self._spring_count, np.nan)
        crease_angle = on_springs.copy()
        crease_angle[self._crease_rows] = frame.crease_angles[self._creases]
        strains = triangle_strains(self._reference, frame.positions, self._triangles)
        on_cells: dict[str, tuple[NDArray[Any], NDArray[Any]]] = {
            "spring_strain": (on_triangles, frame.spring_strains),
            "triangle_strain": (strains, np.stack([on_springs, on_springs], axis=1)),
            "crease_angle": (on_triangles, crease_angle),
            "buckled": (np.full(self._triangle_count, -1, np.int8), frame.buckled.astype(np.int8)),
            "petal": (self._petals, np.full(self._spring_count, -1, np.int8)),
        }
        mesh = meshio.Mesh(
            frame.positions,
            self._cells,
            point_data={"velocity": frame.velocities, "displacement": frame.positions - self._reference},
            cell_data={name: [blocks[k] for k in self._filled] for name, blocks in on_cells.items()},
        )
        with replacing(path) as part:
            mesh.write(part, file_format="vtu", compression=None)


def write_frame(path: Path, sim: Motion) -> None:
    """Write the state of `sim` as a VTU file, whole or not at all. Raises OutputError."""
    FrameWriter(sim).write(path, Frame.of(sim))


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
