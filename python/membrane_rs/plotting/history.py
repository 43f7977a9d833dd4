"""Any columns of a history against time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from membrane_rs._validation import check_kind, nearest, show
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.plotting.columns import label_of, unit_of
from membrane_rs.plotting.figure import finished
from membrane_rs.plotting.panels import Content, Panel, draw_panels
from membrane_rs.plotting.sources import sources_of
from membrane_rs.plotting.style import Style, style_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_PANELS = 26


def plot_history(
    table: Any,
    columns: Sequence[str | Sequence[str]],
    path: Path | str | None = None,
    title: str = "",
    dpi: float | None = None,
    *,
    labels: Sequence[str] | None = None,
    style: Style | str | Path | Mapping[str, Any] | None = None,
) -> Figure:
    """Columns of one history or several against time, a panel for each.

    Parameters
    ----------
    table : history, run, sequence or mapping of them
        A history is a mapping of names of columns to (samples,) arrays, with "time" [s]; what has a `history` is a run.
        A mapping gives each its label.
    columns : sequence of str
        A panel for each, with its unit; several names in a list share one: `["hub_torque", ["energy_springs",
        "energy_creases"]]`.
    path, title, dpi, labels, style
        As for `plot_comparison`.

    Returns
    -------
    matplotlib.figure.Figure
        Without pyplot: nothing has to be closed.

    Raises
    ------
    InputTypeError
        What is no history.
    InputError
        A column that no history has.
    MissingFileError
        No style sheet of that name.
    OutputError
        `path` cannot be written.

    Examples
    --------
    >>> import numpy as np
    >>> from membrane_rs.plotting import plot_history
    >>> time = np.linspace(0.0, 1.0, 50)
    >>> figure = plot_history({"time": time, "hub_torque": 2e-3 * time}, ["hub_torque"])
    >>> figure.axes[0].get_ylabel()
    'Torque on the hub [mN m]'
    """
    look = style_of(style)
    check_kind(title, str, "title", "a text")
    content = Content(sources_of(table, labels, ()))
    panels = panels_of(columns, content)
    with look.context():
        figure, _ = draw_panels(content, panels, look, title)
    return finished(figure, path, dpi)


def panels_of(columns: object, content: Content) -> list[Panel]:
    """A panel for each name or list of names. Raises InputTypeError and InputError."""
    wanted = f"columns = {show(columns)}: must be a list of names of columns, or of lists of them"
    if isinstance(columns, str) or not isinstance(columns, Sequence):
        raise InputTypeError(wanted)
    if not 0 < len(columns) <= MOST_PANELS:
        raise InputError(f"columns: {len(columns)} panels; must be from 1 to {MOST_PANELS}")
    panels = []
    for item in columns:
        names = (item,) if isinstance(item, str) else item
        if not isinstance(names, Sequence) or not names or not all(isinstance(name, str) for name in names):
            raise InputTypeError(wanted)
        for name in names:
            check_column(name, content)
        label = None if len(names) == 1 else _shared(names, content)
        panels.append(Panel(tuple(names), label))
    return panels


def check_column(name: str, content: Content) -> None:
    """Refuse a column that no table has, or that has another length than its time. Raises InputError."""
    known = {str(column) for table in content.tables for column in table}
    if name not in known:
        raise InputError(f"columns: no history has {name!r}; {nearest(name, known - {'time'})}")
    for source in (*content.runs, *content.experiments):
        if name in source.table:
            sources_of(source.table, None, (name,))
    for ensemble in content.ensembles:
        for source in ensemble.members:
            sources_of(source.table, None, (name,), f"a member of {ensemble.label!r}")


def _shared(names: Sequence[str], content: Content) -> str:
    """What the axis of several columns says: the quantity that their unit is one of."""
    units = {unit_of(name, content.tables) for name in names}
    if units == {"J"}:
        return "Energy"
    return label_of(names[0]) if len({label_of(name) for name in names}) == 1 else ""
