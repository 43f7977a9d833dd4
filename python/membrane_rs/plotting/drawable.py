"""Values that a figure can show: what is infinite or beyond all physics is left out, and the figure says so."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from membrane_rs._arrays import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LARGEST = 1e100
"""Magnitude that is drawn, in any unit: squares and spans of such values are finite."""


def drawable(values: Any) -> Floats:
    """Values as float64, NaN where they are infinite or beyond `LARGEST`."""
    found = np.asarray(values, dtype=np.float64)
    beyond = np.abs(found) > LARGEST
    return np.where(beyond, np.nan, found) if beyond.any() else found


def count_beyond(columns: Iterable[Any]) -> int:
    """How many values `drawable` leaves out that are not NaN already."""
    return sum(int((np.abs(np.asarray(values, dtype=np.float64)) > LARGEST).sum()) for values in columns)


def note_beyond(axes: Axes, count: int) -> None:
    """Say in a panel how many values are left out."""
    if count:
        what = "1 value is" if count == 1 else f"{count} values are"
        axes.annotate(
            f"{what} not shown: infinite or beyond {LARGEST:g}", (0.5, 0.97), xycoords="axes fraction", ha="center",
            va="top", fontsize="x-small", color="0.35", zorder=4,
        )  # fmt: skip
