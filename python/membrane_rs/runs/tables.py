"""A run as tables of other libraries."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from membrane_rs._extras import extra
from membrane_rs.errors import InputError
from membrane_rs.results.run_history import RunHistory
from membrane_rs.runs.frames import RunFrames
from membrane_rs.scene import Scene

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

MOST_BYTES = 2**32
"""Bytes of the positions of all frames beyond which they are not taken into memory."""


class Shown(Protocol):
    """What is needed of a run."""

    scene: Scene
    history: RunHistory
    frames: RunFrames

    @property
    def outcome(self) -> str:
        """What ended it."""


def to_pandas(run: Shown) -> DataFrame:
    """The history of a run as a table of pandas."""
    pandas: Any = extra("pandas", "Run.to_pandas")
    history = run.history
    columns = {name: column.copy() for name, column in history.items() if name != "time"}
    table: DataFrame = pandas.DataFrame(columns, index=pandas.Index(history["time"].copy(), name="time"))
    table.attrs = {"scene": run.scene.name, "outcome": run.outcome, "units": dict(history.units)}
    return table


def to_xarray(run: Shown, *, frames: bool = True) -> Dataset:
    """The history of a run, and the positions of its frames, as a data set of xarray."""
    xarray: Any = extra("xarray", "Run.to_xarray")
    history = run.history
    variables: dict[str, Any] = {
        name: ("time", column.copy(), {"units": history.units[name]}) for name, column in history.items()
    }
    coordinates = {"time": variables.pop("time")}
    if frames and len(run.frames):
        of_frames, places = _frames(run)
        twice = next((name for name in (*of_frames, *places) if name in history), None)
        if twice is not None:
            raise InputError(f"frames: {twice!r} is the name of a recorded measure too; give frames=False")
        variables |= of_frames
        coordinates |= places
    made: Dataset = xarray.Dataset(variables, coordinates, {"scene": run.scene.name, "outcome": run.outcome})
    return made


def _frames(run: Shown) -> tuple[dict[str, Any], dict[str, Any]]:
    """Variables and coordinates of the frames. Raises InputError where they are too many."""
    node_count, frames = run.scene.assemble().node_count, run.frames
    size = len(frames) * node_count * 24
    if size > MOST_BYTES:
        raise InputError(
            f"frames: positions of {len(frames)} of {node_count} nodes are {size / 1e9:.3g} GB, more than "
            f"{MOST_BYTES / 1e9:.3g} GB; give frames=False, and take them one by one from run.frames"
        )
    positions = np.empty((len(frames), node_count, 3))
    angles, stages = np.empty(len(frames)), np.empty(len(frames), dtype=np.int64)
    for k, frame in enumerate(frames):
        positions[k], angles[k], stages[k] = frame.positions, frame.hub_angle, frame.stage
    note = "in the frame that turns with the hub"
    variables = {
        "positions": (("frame_time", "node", "axis"), positions, {"units": "m", "long_name": note}),
        "frame_hub_angle": ("frame_time", angles, {"units": "rad"}),
        "frame_stage": ("frame_time", stages, {"units": ""}),
    }
    coordinates = {
        "frame_time": ("frame_time", frames.times.copy(), {"units": "s"}),
        "node": ("node", np.arange(node_count), {"units": ""}),
        "axis": ("axis", ["x", "y", "z"], {"units": ""}),
    }
    return variables, coordinates
