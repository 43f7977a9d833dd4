"""Where the stages of a run begin, in figures against time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.plotting.figure import plain_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def stage_starts(table: Mapping[str, Floats]) -> list[tuple[int, float]]:
    """Index and start [s] of each stage, where the table of a history tells stages; the first row's among them."""
    stages = table.get("stage")
    if stages is None or not len(stages):
        return []
    first = np.concatenate([[0], np.flatnonzero(np.diff(stages) > 0) + 1])
    return [(int(stages[row]), float(table["time"][row])) for row in first]


def mark_stages(panels: Sequence[Axes], starts: Sequence[tuple[int, float]], names: Sequence[str] = ()) -> None:
    """A thin line at the start of each stage but the first, in all panels; names stand in the first panel."""
    for axes in panels:
        for _, time in starts[1:]:
            axes.axvline(time, color="0.6", linewidth=0.6)
    for index, time in starts if names else ():
        text = plain_text(names[index]) if index < len(names) else ""
        panels[0].annotate(
            text, (time, 1.0), (3, -3), xycoords=panels[0].get_xaxis_transform(), textcoords="offset points",
            fontsize=7, color="0.4", rotation=90, va="top",
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.8},
        )  # fmt: skip
