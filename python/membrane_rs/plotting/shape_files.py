"""shapes/shape-<k>.npz: the shapes that are drawn at the end of a run, kept for one that is resumed."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from membrane_rs._archives import ArchiveError, read_arrays
from membrane_rs._arrays import Floats
from membrane_rs._files import replacing
from membrane_rs.analysis.attitude import Turn
from membrane_rs.errors import OutputError

SHAPES = "shapes/shape-*.npz"
"""Pattern of the files in a run's folder."""
Shape = tuple[float, Turn, Floats]
"""Time [s], how the hub has turned, and positions (N, 3) [m]."""


def write_shape(folder: Path, number: int, shape: Shape) -> None:
    """Write a shape, whole or not at all, onto the disk. Raises OutputError."""
    time, turn, positions = shape
    with replacing(folder / SHAPES.replace("*", f"{number:04d}"), synced=True) as part, part.open("wb") as file:
        np.savez(file, time=time, hub_angle=turn, positions=positions)


def read_shapes(folder: Path, until: float) -> list[Shape]:
    """The shapes up to a time [s], in their order. Raises OutputError for a damaged file."""
    shapes = []
    for path in sorted(folder.glob(SHAPES)):
        try:
            found = read_arrays(path)
            turn = found["hub_angle"]
            shapes.append((float(found["time"]), turn if turn.shape == (4,) else float(turn), found["positions"]))
        except (ArchiveError, LookupError, TypeError, ValueError) as error:
            raise OutputError(f"{path} is damaged ({error}); run the scene again") from None
    return [shape for shape in shapes if shape[0] <= until]
