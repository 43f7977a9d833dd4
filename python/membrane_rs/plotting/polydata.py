"""A frame as a mesh of pyvista."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from membrane_rs._extras import extra
from membrane_rs.results.frame_fields import FrameData


def polydata(frame: FrameData) -> Any:
    """A frame as a `pyvista.PolyData`: its lines and triangles, with the fields on nodes and cells.

    VTK counts the lines before the triangles. A field of one kind is NaN, or -1 for whole numbers, on the other.
    """
    pyvista = extra("pyvista", "RunFrame.to_pyvista")
    cells: dict[str, Any] = {}
    if len(frame.triangles):
        cells["faces"] = _with_counts(frame.triangles)
    if len(frame.lines):
        cells["lines"] = _with_counts(frame.lines)
    made: Any = pyvista.PolyData(frame.positions.copy(), **cells)
    for name, values in frame.on_nodes.items():
        made.point_data[name] = values
    for name, values in frame.on_lines.items():
        made.cell_data[name] = np.concatenate([values, _none(values, len(frame.triangles))])
    for name, values in frame.on_triangles.items():
        made.cell_data[name] = np.concatenate([_none(values, len(frame.lines)), values])
    return made


def _with_counts(cells: NDArray[Any]) -> NDArray[Any]:
    return np.column_stack([np.full(len(cells), cells.shape[1]), cells]).ravel()


def _none(values: NDArray[Any], count: int) -> NDArray[Any]:
    """A field's values where it has none."""
    return np.full((count, *values.shape[1:]), np.nan if values.dtype.kind == "f" else -1, values.dtype)
