"""Frames for ParaView: one VTU file per frame.

A frame's cells are the triangles, then a line for each spring (membrane edges first, then tethers).

Point data: velocity [m/s], displacement [m] from the reference. Cell data, NaN or -1 where a cell has none; those of
the stress only with a law of the film, and the tension only with cords, both in single precision:

    spring_strain         lines      l / L - 1
    triangle_strain       triangles  (2,) principal Green-Lagrange strains, larger first
    crease_angle          lines      [rad] pi flat, 0 shut, negative where the facets interpenetrate
    buckled               lines      1 below the critical length, else 0; with `Triangles` see
                                     `Motion.buckled`
    petal                 triangles  number of the petal, where the scene names petals
    stress_1, stress_2    triangles  [Pa] principal stresses, larger first, see `Motion.film_stress`
    stress_direction      triangles  (3,) direction of stress_1 in the present shape
    von_mises             triangles  [Pa] von Mises's equivalent stress
    film_state            triangles  0 taut, 1 wrinkled, 2 slack, with `Triangles`, see `Motion.film_states`
    tension               lines      [N] elastic tension of the segments of cords
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from membrane_rs._arrays import Floats
from membrane_rs._files import check_regular, path_of, reading_errors, replacing
from membrane_rs.analysis.strain import triangle_strains
from membrane_rs.errors import MissingFileError, OutputError
from membrane_rs.mesh.queries import find_pairs, petal_of_triangles
from membrane_rs.results.measures import check_simulation
from membrane_rs.simulation.motion import Motion
from membrane_rs.simulation.readings import FilmStress


@dataclass(frozen=True)
class Frame:
    """What a frame shows of a simulation at `time` [s], copied: the simulation may go on while it is written.

    positions (N, 3) [m], velocities (N, 3) [m/s], spring_strains (S,), buckled (S,), crease_angles (c,) [rad],
    film_stress of m triangles [Pa], film_states (m,), cord_tensions (s,) [N].
    """

    time: float
    positions: Floats
    velocities: Floats
    spring_strains: Floats
    buckled: NDArray[np.bool_]
    crease_angles: Floats
    film_stress: FilmStress
    film_states: NDArray[np.int8]
    cord_tensions: Floats

    @classmethod
    def of(cls, sim: Motion) -> Frame:
        """The state of `sim` now."""
        return cls(
            time=sim.time,
            positions=sim.positions.copy(),
            velocities=sim.velocities.copy(),
            spring_strains=sim.spring_strains(),
            buckled=sim.buckled(),
            crease_angles=sim.crease_angles(),
            film_stress=sim.film_stress(),
            film_states=sim.film_states(),
            cord_tensions=sim.cord_tensions(),
        )


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
        self._has_stress = any(law.is_film for law in sim.scene.laws) and self._triangle_count > 0

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
            **self._stress(frame.film_stress),
            **self._states(frame.film_states),
            **self._tension(frame.cord_tensions),
        }
        mesh = meshio.Mesh(
            frame.positions,
            self._cells,
            point_data={"velocity": frame.velocities, "displacement": frame.positions - self._reference},
            cell_data={name: [blocks[k] for k in self._filled] for name, blocks in on_cells.items()},
        )
        with replacing(path) as part:
            mesh.write(part, file_format="vtu", compression=None)

    def _stress(self, stress: FilmStress) -> dict[str, tuple[NDArray[Any], NDArray[Any]]]:
        """Fields of the stress on triangles, and NaN on lines; none without a law of the film."""
        if not self._has_stress:
            return {}
        on_triangles = {
            "stress_1": stress.principal[:, 0],
            "stress_2": stress.principal[:, 1],
            "stress_direction": stress.directions[:, 0],
            "von_mises": stress.von_mises,
        }
        on_lines = {name: (self._spring_count, *values.shape[1:]) for name, values in on_triangles.items()}
        return {
            name: (values.astype(np.float32), np.full(on_lines[name], np.nan, np.float32))
            for name, values in on_triangles.items()
        }

    def _states(self, states: NDArray[np.int8]) -> dict[str, tuple[NDArray[Any], NDArray[Any]]]:
        """The field of the state of the film, and -1 on lines; none where the law at work has no states."""
        if not (states >= 0).any():
            return {}
        return {"film_state": (states, np.full(self._spring_count, -1, np.int8))}

    def _tension(self, tensions: Floats) -> dict[str, tuple[NDArray[Any], NDArray[Any]]]:
        """The field of the tension on cords, the last of the lines, and NaN elsewhere; none without cords."""
        if not len(tensions):
            return {}
        on_lines = np.full(self._spring_count, np.nan, np.float32)
        on_lines[-len(tensions) :] = tensions
        return {"tension": (np.full(self._triangle_count, np.nan, np.float32), on_lines)}


def write_frame(path: str | Path, sim: Motion) -> None:
    """Write the state of `sim` as a VTU file, whole or not at all. Raises OutputError."""
    check_simulation(sim)
    FrameWriter(sim).write(path_of(path), Frame.of(sim))


def read_frame(path: str | Path) -> Floats:
    """Positions (N, 3) [m] of a frame. Raises MissingFileError, and OutputError for what is no VTU file."""
    import meshio

    path = path_of(path)
    with reading_errors(path, "VTU file of a run"):
        if not path.is_file():
            raise MissingFileError(f"no frame at {path}; name a .vtu file of a run's folder")
        check_regular(path)
        # Not meshio.read: that prints, and ends the process, where a file cannot be read.
        points = np.asarray(meshio.vtu.read(path).points, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 3:
            raise OutputError(f"{path} holds points of shape {points.shape}, not (N, 3); run the scene again")
        return points
