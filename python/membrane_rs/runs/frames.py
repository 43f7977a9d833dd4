"""The frames of a run, in memory or read from its folder one at a time."""

from __future__ import annotations

import operator
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, overload

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._known_attributes import KnownAttributes
from membrane_rs._validation import number_of, show
from membrane_rs.analysis.attitude import Turn, attitude_at
from membrane_rs.errors import InputError, InputTypeError, OutputError
from membrane_rs.mesh.triangulation import frozen
from membrane_rs.results.frame_fields import Frame, FrameData, FrameFields
from membrane_rs.results.run_history import RunHistory
from membrane_rs.results.vtk import read_frame_data

LEAST_FRAME, BYTES_OF_NODE = 2**20, 2**13
"""Bytes of a file of a frame, and for each node of the scene, beyond which it is not read; a run writes a tenth."""


@dataclass(frozen=True, eq=False)
class RunFrame(FrameData):
    """A shape of a run, with all that a frame shows.

    Attributes
    ----------
    time : float
        [s].
    hub_angle : float
        Turned by the hub since time 0 [rad]; positions and velocities are relative to the frame that turns with it.
    attitude : (4,) float or None
        Unit quaternion (w, x, y, z) of a hub in six degrees of freedom [-]; None: the hub turns about z.
    stage : int
        Index of the stage; at a boundary of the one that begins, 0 for a scene without stages.
    positions : (N, 3) float
        Of the nodes, in the frame that turns with the hub [m].
    velocities : (N, 3) float
        Relative to that frame [m/s].
    triangles : (m, 3) int
        Corners of the triangles.
    lines : (s, 2) int
        Ends of the springs: the edges of the membrane, then the segments of the cords.
    on_nodes, on_triangles, on_lines : mapping of str to array
        Fields by their names, one row for each node, triangle or line, such as "stress_1" [Pa], "crease_angle" [rad],
        "tension" [N]: docs/results.md has all.

    Examples
    --------
    >>> import membrane_rs
    >>> frame = membrane_rs.run("hanging-strip", until=0.01, frames=2).frames[-1]
    >>> frame.time, frame.positions.shape, sorted(frame.on_lines)
    (0.01, (66, 3), ['buckled', 'crease_angle', 'spring_strain'])
    >>> frame.to_pyvista().n_cells == len(frame.triangles) + len(frame.lines)
    True
    """

    time: float
    hub_angle: float
    attitude: Floats | None
    stage: int

    @property
    def turn(self) -> Turn:
        """How the frame of the hub is turned in space: the angle about z [rad], or the quaternion."""
        return self.hub_angle if self.attitude is None else self.attitude

    def to_pyvista(self) -> Any:
        """The frame as a `pyvista.PolyData` of triangles and lines, with all fields.

        Those on cells are NaN, or -1 for whole numbers, where a cell has none. The hub has turned by `hub_angle`, but
        the points are those of the turning frame, as `positions` are.

        Returns
        -------
        pyvista.PolyData
            Points [m], triangles first and lines after them.

        Raises
        ------
        MissingExtraError
            pyvista is not installed.
        """
        from membrane_rs.plotting.polydata import polydata

        return polydata(self)

    def __repr__(self) -> str:
        """Time, size and the names of the fields."""
        fields = ", ".join((*self.on_nodes, *self.on_triangles, *self.on_lines))
        return (
            f"RunFrame(t = {self.time:.6g} s, {len(self.positions)} nodes, {len(self.triangles)} triangles, "
            f"{len(self.lines)} lines: {fields})"
        )


class RunFrames(KnownAttributes, Sequence[RunFrame]):
    """The frames of a run: a sequence, each made when it is asked for.

    Parameters
    ----------
    times : sequence of float
        Of the frames [s].
    history : RunHistory
        Of the same run.

    Attributes
    ----------
    times : (frames,) float
        [s], read only.

    Examples
    --------
    >>> import membrane_rs
    >>> frames = membrane_rs.run("spinning-tether", until=1e-3, frames=3).frames
    >>> len(frames), frames.times.tolist(), frames[-1].time
    (3, [0.0, 0.0005, 0.001], 0.001)
    >>> frames.near(6e-4).time
    0.0005
    """

    ONCE = ("times",)
    INSTEAD = "run the scene again"

    def __init__(self, times: Sequence[float], history: RunHistory) -> None:
        self.times: Floats = frozen(np.array(times, dtype=np.float64))
        self._history = history

    @overload
    def __getitem__(self, index: int) -> RunFrame: ...

    @overload
    def __getitem__(self, index: slice) -> list[RunFrame]: ...

    def __getitem__(self, index: int | slice) -> RunFrame | list[RunFrame]:
        """A frame by its index, or several by a slice.

        Raises InputError, which is an IndexError too, for one that is not there; OutputError for a damaged file.
        """
        if isinstance(index, slice):
            return [self[k] for k in range(*index.indices(len(self)))]
        try:
            k = operator.index(index)
        except TypeError:
            raise InputTypeError(f"frames[{show(index)}]: must be a whole number or a slice") from None
        if not -len(self) <= k < len(self):
            raise NoSuchFrameError(f"frames[{k}]: there are {len(self)}; count from 0, or from -1 backwards")
        k %= len(self)
        time, data = float(self.times[k]), self._data(k)
        stage = self._stage(time)
        angle, attitude = self._history.at(time, "hub_angle"), attitude_at(self._history, time)
        return RunFrame(**vars(data), time=time, hub_angle=angle, attitude=attitude, stage=stage)

    def __len__(self) -> int:
        """The number of frames."""
        return len(self.times)

    def near(self, time: float) -> RunFrame:
        """The frame nearest to a time.

        Parameters
        ----------
        time : float
            [s]

        Returns
        -------
        RunFrame
            The earlier one of two that are as near.

        Raises
        ------
        InputError, InputTypeError
            There is no frame at all; no time.
        """
        time = number_of("time", time)
        if not len(self):
            raise InputError("frames: there are none; a run writes the first one at its start")
        return self[int(np.abs(self.times - time).argmin())]

    def __repr__(self) -> str:
        """How many, from when to when."""
        span = f", {self.times[0]:.6g} to {self.times[-1]:.6g} s" if len(self) else ""
        return f"RunFrames({len(self)}{span})"

    def _stage(self, time: float) -> int:
        """The stage at a time [s], by the last sample not after it."""
        if "stage" not in self._history:
            return 0
        row = int(np.searchsorted(self._history["time"], time, side="right")) - 1
        return int(self._history["stage"][max(row, 0)]) if self._history.sample_count else 0

    @abstractmethod
    def _data(self, index: int) -> FrameData:
        """The arrays of a frame."""


class NoSuchFrameError(InputError, IndexError):
    """An index beyond the frames of a run."""


class KeptFrames(RunFrames):
    """Frames in memory, compact; their fields are made when one is asked for."""

    def __init__(self, frames: Sequence[Frame], fields: FrameFields, history: RunHistory) -> None:
        super().__init__([frame.time for frame in frames], history)
        self._frames, self._fields = tuple(frames), fields

    def _data(self, index: int) -> FrameData:
        return self._fields.of(self._frames[index])


class FilesOfFrames(RunFrames):
    """Frames in files, each read when it is asked for, and not kept.

    Parameters
    ----------
    files : sequence of (float, path)
        Time [s] and file of each.
    history : RunHistory
        Of the same run.
    node_count : int
        Of its scene: a file of another one is refused.
    """

    def __init__(self, files: Sequence[tuple[float, Path]], history: RunHistory, node_count: int) -> None:
        super().__init__([time for time, _ in files], history)
        self._files, self._node_count = [path for _, path in files], node_count
        self._most = LEAST_FRAME + BYTES_OF_NODE * node_count

    def _data(self, index: int) -> FrameData:
        path = self._files[index]
        data = read_frame_data(path, self._most)
        if len(data.positions) != self._node_count:
            raise OutputError(
                f"{path}: has {len(data.positions)} nodes, but the scene of the run {self._node_count}; it belongs to "
                "another run: run the scene again"
            )
        return data
