"""Curves of one scene on several meshes: deployment rate above, phase difference below, a column for each form."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from membrane_rs._arrays import Floats
from membrane_rs.plotting.deployment import PANELS
from membrane_rs.plotting.figure import save_figure


def plot_meshes(
    forms: Mapping[str, Sequence[tuple[str, Sequence[Mapping[str, Floats]]]]],
    path: Path,
    legend: str = "height of a cell",
) -> None:
    """Draw, for each form of the parameters, its meshes as (label, tables), coarse to fine, as a figure whose format
    is that of the ending of `path`.

    Each table holds the columns of a history from one start; the first is drawn the strongest. Raises OutputError
    where `path` cannot be written.
    """
    from matplotlib import colormaps
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.0 * len(forms) + 0.6, 6.4), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(2, len(forms), sharex=True, sharey="row", squeeze=False)
    for row, (column, label, level) in enumerate(PANELS):
        panels[row, 0].set_ylabel(label)
        for axes, (form, runs) in zip(panels[row], forms.items(), strict=True):
            for k, (name, tables) in enumerate(runs):
                color = colormaps["viridis_r"](0.15 + 0.85 * k / max(1, len(runs) - 1))
                for j, table in enumerate(tables):
                    look = {"linewidth": 0.5, "alpha": 0.6} if j else {"linewidth": 1.4, "label": name}
                    axes.plot(table["time"], table[column], color=color, **look)
            axes.axhline(level, color="0.5", linewidth=0.8)
            axes.grid(color="0.9")
            axes.margins(x=0.0)
            axes.spines[["top", "right"]].set_visible(False)
            if row == 0:
                axes.set_title(form)
                axes.legend(frameon=False, title=legend)
            else:
                axes.set_xlabel("Time [s]")
    save_figure(figure, path)
