"""Frames for ParaView: one VTU file per frame.

A frame's cells are the triangles, then a line for each spring (membrane edges first, then tethers). The fields are
those of `membrane_rs.results.frame_fields`, those on cells with NaN or -1 where a cell has none.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from membrane_rs._arrays import Floats
from membrane_rs._files import MOST_BYTES, check_regular, path_of, reading_errors, replacing
from membrane_rs.errors import MissingFileError, OutputError
from membrane_rs.results.frame_fields import ON_LINES, ON_NODES, ON_TRIANGLES, FieldTable, Frame, FrameData, FrameFields
from membrane_rs.simulation.motion import Motion, check_simulation

ORDER = (
    "spring_strain", "triangle_strain", "crease_angle", "buckled", "petal", "stress_1", "stress_2", "stress_direction",
    "von_mises", "film_state", "tension",
)  # fmt: skip
"""The fields on cells, as they stand in a file."""


class FrameWriter:
    """Writes frames of one simulation. It keeps nothing of the simulation that changes, so that it can write in another
    thread.
    """

    def __init__(self, sim: Motion) -> None:
        self._fields = FrameFields(sim)
        counts = len(self._fields.triangles), len(self._fields.lines)
        # Half the bytes, where they hold the numbers of the nodes.
        index = np.int32 if len(self._fields.reference) <= np.iinfo(np.int32).max else np.int64
        blocks = (("triangle", self._fields.triangles), ("line", self._fields.lines))
        self._counts, self._filled = counts, [k for k in (0, 1) if counts[k]]
        self._cells = [(blocks[k][0], blocks[k][1].astype(index)) for k in self._filled]

    def write(self, path: Path, frame: Frame) -> None:
        """Write `frame` as a VTU file, whole or not at all. Raises OutputError.

        Not compressed: coordinates hardly shrink, and the tenfold time would slow a run where no core is free.
        """
        import meshio

        shown = self._fields.of(frame)
        mesh = meshio.Mesh(
            shown.positions,
            self._cells,
            point_data=dict(shown.on_nodes),
            cell_data={name: self._blocks(shown, name) for name in ORDER if _is_in(shown, name)},
        )
        with replacing(path) as part:
            mesh.write(part, file_format="vtu", compression=None)

    def _blocks(self, shown: FrameData, name: str) -> list[NDArray[Any]]:
        """A field on all cells: on those of the other kind NaN, or -1 in place of a whole number."""
        is_line = name in shown.on_lines
        values = (shown.on_lines if is_line else shown.on_triangles)[name]
        shape = (self._counts[not is_line], *values.shape[1:])
        others = np.full(shape, np.nan if values.dtype.kind == "f" else -1, values.dtype)
        blocks = (others, values) if is_line else (values, others)
        return [blocks[k] for k in self._filled]


def _is_in(shown: FrameData, name: str) -> bool:
    return name in shown.on_lines or name in shown.on_triangles


def write_frame(path: str | Path, sim: Motion) -> None:
    """Write the state of `sim` as a VTU file, whole or not at all.

    Parameters
    ----------
    path : path
        Of a .vtu file.
    sim : Simulation
        Or another motion.

    Raises
    ------
    OutputError
        It cannot be written.
    InputError, InputTypeError
        No path, no motion.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from membrane_rs import Simulation, scenes
    >>> from membrane_rs.results import read_frame, write_frame
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_frame(Path(folder) / "start.vtu", Simulation(scenes.load("spinning-tether")))
    ...     read_frame(Path(folder) / "start.vtu").shape[1]
    3
    """
    check_simulation(sim)
    FrameWriter(sim).write(path_of(path), Frame.of(sim))


def read_frame(path: str | Path) -> Floats:
    """Positions (N, 3) [m] of a frame.

    Parameters
    ----------
    path : path
        Of a .vtu file.

    Returns
    -------
    (N, 3) float64
        [m]

    Raises
    ------
    MissingFileError
        No such file.
    OutputError
        What is no VTU file.
    InputError, InputTypeError
        No path.

    Examples
    --------
    See `write_frame`.

    >>> from membrane_rs.results import read_frame
    >>> read_frame("nowhere.vtu")
    Traceback (most recent call last):
    membrane_rs.errors.MissingFileError: ...
    """
    path = path_of(path)
    with reading_errors(path, "VTU file of a run"):
        return _points(path, _read(path))


def read_frame_data(path: Path, most: int = MOST_BYTES) -> FrameData:
    """A frame with its fields, as `FrameFields` made them. Raises MissingFileError, and OutputError for what is no VTU
    file of a run, or has more than `most` bytes.
    """
    with reading_errors(path, "VTU file of a run"):
        mesh = _read(path, most)
        points = _points(path, mesh)
        cells: dict[str, NDArray[Any]] = {"triangle": np.zeros((0, 3), np.int64), "line": np.zeros((0, 2), np.int64)}
        on_cells: dict[str, dict[str, NDArray[Any]]] = {"triangle": {}, "line": {}}
        for k, block in enumerate(mesh.cells):
            if block.type not in cells or len(cells[block.type]):
                raise OutputError(f"{path}: its cells are not triangles, then lines; run the scene again")
            cells[block.type] = np.asarray(block.data, np.int64)
            if len(block.data) and not 0 <= cells[block.type].min() <= cells[block.type].max() < len(points):
                raise OutputError(f"{path}: a cell has a node that is not there; run the scene again")
            names = ON_TRIANGLES if block.type == "triangle" else ON_LINES
            on_cells[block.type] = {name: mesh.cell_data[name][k] for name in names if name in mesh.cell_data}
        for name in ON_NODES:
            if name not in mesh.point_data or mesh.point_data[name].shape != points.shape:
                raise OutputError(f"{path}: lacks the field {name!r} of its nodes; run the scene again")
        return FrameData(
            positions=points,
            velocities=np.asarray(mesh.point_data["velocity"], np.float64),
            triangles=cells["triangle"],
            lines=cells["line"],
            on_nodes=FieldTable("on_nodes", {name: mesh.point_data[name] for name in ON_NODES}),
            on_triangles=FieldTable("on_triangles", on_cells["triangle"]),
            on_lines=FieldTable("on_lines", on_cells["line"]),
        )


def _read(path: Path, most: int = MOST_BYTES) -> Any:
    """A VTU file by meshio. Raises MissingFileError, and errors of any kind for what is none."""
    import meshio

    if not path.is_file():
        remedy = "name a .vtu file that is there; where a run has lost it, put it back, or run the scene again"
        raise MissingFileError(f"no frame at {path}; {remedy}")
    check_regular(path, most)
    # Not meshio.read: that prints, and ends the process, where a file cannot be read.
    return meshio.vtu.read(path)


def _points(path: Path, mesh: Any) -> Floats:
    points = np.asarray(mesh.points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise OutputError(f"{path} holds points of shape {points.shape}, not (N, 3); run the scene again")
    return points
