"""A hub that turns freely: its rate, and the angular momentum of hub and sail, against time."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from membrane_rs._validation import check_kind
from membrane_rs.plotting.drawing import Drawing
from membrane_rs.plotting.figure import finished, save_figure
from membrane_rs.plotting.panels import Content, Panel, draw_panels
from membrane_rs.plotting.sources import Measured, Source, sources_of
from membrane_rs.plotting.style import SCREEN, Style, style_of
from membrane_rs.results.history_table import OF_FREE_HUB
from membrane_rs.simulation.stepper import Stepper

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from membrane_rs.plotting.styled_figure import StyledFigure

RATE, HUB, SAIL = OF_FREE_HUB
TOTAL, NUTATION = "total_momentum", "nutation_deg"
_RPM = 30.0 / math.pi
"""Of one radian per second."""
PANELS = (Panel((RATE,)), Panel((HUB, SAIL, TOTAL), "Angular momentum", levels=(0.0,)))
OF_BODY = Panel((NUTATION,))
"""Of a hub in six degrees of freedom."""


class MomentumPicture(Drawing):
    """Draws momentum.png where the hub turns freely in any stage, from two samples or more."""

    own_files = ("momentum.png",)

    def draw(self, sim: Stepper) -> None:
        """Draw it."""
        table = self.record.table
        if is_of_free_hub(table) and len(table["time"]) > 1:
            source = Source("", table, [record.name for record in sim.stages])
            save_figure(_figure([source], SCREEN, sim.scene.name), self.record.path / "momentum.png")


def is_of_free_hub(table: Mapping[str, Any]) -> bool:
    """Whether a history is that of a run whose hub turns freely."""
    return all(name in table for name in OF_FREE_HUB)


def plot_momentum(
    table: Any,
    path: Path | str | None = None,
    title: str = "",
    dpi: float | None = None,
    *,
    labels: Sequence[str] | None = None,
    style: Style | str | Path | Mapping[str, Any] | None = None,
) -> Figure:
    """The rate of a hub that turns freely, and the angular momentum of hub, sail and both, against time; of one in six
    degrees of freedom the nutation angle too.

    Parameters
    ----------
    table : history, run, sequence or mapping of them
        A history is a mapping of names of columns to (samples,) arrays, with "time" [s], "hub_rate" [rad/s],
        "hub_momentum" and "sail_momentum" [kg m2/s]; what has a `history` is a run. A mapping gives each its label.
    path, title, dpi, labels, style
        As for `plot_deployment`.

    Returns
    -------
    matplotlib.figure.Figure
        Without pyplot: nothing has to be closed.

    Raises
    ------
    InputTypeError
        What is no history with these columns.
    InputError
        Another ending of `path`; a style or resolution that does not exist.
    MissingFileError
        No style sheet of that name.
    OutputError
        `path` cannot be written.

    Examples
    --------
    >>> import numpy as np
    >>> from membrane_rs.plotting import plot_momentum
    >>> time = np.linspace(0.0, 1.0, 50)
    >>> table = {"time": time, "hub_rate": 9.0 - time, "hub_momentum": 9.0 - time, "sail_momentum": time}
    >>> figure = plot_momentum(table, style="paper")
    >>> [axes.get_ylabel() for axes in figure.axes]
    ['Rate of the hub [rpm]', 'Angular momentum [kg m2/s]']
    """
    look = style_of(style)
    check_kind(title, str, "title", "a text")
    return finished(_figure(sources_of(table, labels, OF_FREE_HUB), look, title), path, dpi)


def _figure(sources: Sequence[Source], style: Style, title: str) -> StyledFigure:
    """The figure of histories with the columns of a free hub."""
    panels = (*PANELS, OF_BODY) if any(NUTATION in source.table for source in sources) else PANELS
    with style.context():
        figure, _ = draw_panels(Content([_shown(source) for source in sources]), panels, style, title)
    return figure


def _shown(source: Source) -> Source:
    """What is shown of a history: the rate in turns per minute, and the sum of the momenta."""
    columns = {name: np.asarray(values, dtype=np.float64) for name, values in source.table.items()}
    units = {**getattr(source.table, "units", {}), RATE: "rpm", TOTAL: "kg m2/s"}
    columns |= {RATE: _RPM * columns[RATE], TOTAL: columns[HUB] + columns[SAIL]}
    return replace(source, table=Measured(columns, units))
