"""Runs, experiments and ensembles in one figure: lines, marks, and means with a band of their spread."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from membrane_rs._validation import check_kind, flag_of
from membrane_rs.errors import InputError
from membrane_rs.plotting.columns import unit_of
from membrane_rs.plotting.deployment import deployment_panels, draw_deployment
from membrane_rs.plotting.ensemble import Ensemble, check_spread
from membrane_rs.plotting.figure import finished
from membrane_rs.plotting.history import panels_of
from membrane_rs.plotting.panels import Content, draw_panels
from membrane_rs.plotting.sources import Measured, Source, sources_of
from membrane_rs.plotting.style import Style, style_of
from membrane_rs.results.given_experiment import ExperimentLike, experiment_of
from membrane_rs.results.history_table import FIRST_COLUMNS

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_comparison(
    runs: Any = (),
    columns: Sequence[str | Sequence[str]] | None = None,
    *,
    experiments: Mapping[str, ExperimentLike] | None = None,
    ensembles: Mapping[str, Sequence[Any]] | None = None,
    spread: str = "std",
    members: bool = False,
    labels: Sequence[str] | None = None,
    path: Path | str | None = None,
    title: str = "",
    dpi: float | None = None,
    style: Style | str | Path | Mapping[str, Any] | None = None,
) -> Figure:
    """Runs as lines, experiments as marks, ensembles as a mean with a band, against time.

    Parameters
    ----------
    runs : history, run, sequence or mapping of them
        A history is a mapping of names of columns to (samples,) arrays, with "time" [s]; what has a `history` is a run.
        A mapping gives each its label.
    columns : sequence of str, optional
        A panel for each; several names in a list share one. Default: the deployment rate and, where a hub turns, the
        phase difference.
    experiments : mapping of str to path, Experiment, mapping or pandas.DataFrame, optional
        Measured curves by label: a CSV file (`results.read_experiment`), an `Experiment`, or arrays by name, which may
        be followed by a unit, "hub_torque [mN m]"; with "time" [s] and some of the columns. Values are converted to the
        units of the runs. A column "<name>_std" holds standard deviations of another one, drawn as bars.
    ensembles : mapping of str to sequences of histories or runs, optional
        By label. A member counts as far as it came.
    spread : {"std", "range"}
        The band: one standard deviation of the members to both sides of the mean, or from their lowest to their
        highest.
    members : bool
        Whether each member of an ensemble is drawn, as a thin line.
    labels : sequence of str, optional
        Of the runs.
    path : path, optional
        A PNG, PDF or SVG file, by its ending. Default: none is written.
    title : str
        Where the style has one.
    dpi : float, optional
        Resolution of a PNG file [1/inch]. Default: the style's.
    style : Style, str, path or mapping, optional
        "screen" (the default), "paper", a `Style`, a style sheet of matplotlib, or its parameters.

    Returns
    -------
    matplotlib.figure.Figure
        Without pyplot: nothing has to be closed.

    Raises
    ------
    InputTypeError
        What is no history, or lacks a column.
    InputError
        Nothing to draw; a spread, style or resolution that does not exist.
    MissingFileError
        No style sheet of that name.
    OutputError
        `path` cannot be written.

    Examples
    --------
    >>> import numpy as np
    >>> from membrane_rs.plotting import plot_comparison
    >>> time = np.linspace(0.0, 1.0, 50)
    >>> runs = {"soft": {"time": time, "hub_torque": np.sin(time)}, "stiff": {"time": time, "hub_torque": time}}
    >>> measured = {"time": [0.2, 0.6], "hub_torque": [0.21, 0.55], "hub_torque_std": [0.03, 0.04]}
    >>> figure = plot_comparison(runs, ["hub_torque"], experiments={"measured": measured}, style="paper")
    >>> [text.get_text() for text in figure.legends[0].get_texts()]
    ['soft', 'stiff', 'measured']
    """
    look = style_of(style)
    check_kind(title, str, "title", "a text")
    check_spread(spread)
    members = flag_of("members", members)
    given = [] if isinstance(runs, Sequence) and not runs else sources_of(runs, labels, (), "runs")
    others = _by_label(experiments, "experiments")
    together = _by_label(ensembles, "ensembles")
    bands = [
        Ensemble(label, sources_of(some, None, (), f"ensembles[{label!r}]"), spread, shows_members=members)
        for label, some in together.items()
    ]
    content = Content(given, _measured(others, Content(given, (), bands)), bands)
    if not content.tables:
        raise InputError("plot_comparison: nothing to draw; give runs, experiments or ensembles")
    with look.context():
        if columns is None:
            figure = draw_deployment(content, deployment_panels(content), look, title)
        else:
            figure, _ = draw_panels(content, panels_of(columns, content), look, title)
    return finished(figure, path, dpi)


def _measured(given: Mapping[str, Any], others: Content) -> list[Source]:
    """Experiments in the units of the other curves. Raises InputError and InputTypeError."""
    known = {name: unit_of(name, (table,)) for table in others.tables for name in table}
    units = {name: unit for name, unit in known.items() if unit or name in FIRST_COLUMNS}
    found = []
    for label, one in given.items():
        experiment = experiment_of(one, units, f"experiments[{label!r}]", str(label))
        units |= {name: unit for name, unit in experiment.units.items() if unit and name not in units}
        table = Measured({"time": experiment.time, **experiment.columns}, experiment.units)
        found.append(Source(str(label), table))
    return found


def _by_label(given: Mapping[str, Any] | None, name: str) -> Mapping[str, Any]:
    """What is given by label. Raises InputTypeError for anything else, and for one table without a label."""
    check_kind(given, (Mapping, type(None)), name, "a mapping of labels to tables")
    found = given or {}
    if "time" in found:
        raise InputError(f"{name}: is one table; give each a label, as in {name}={{'measured': table}}")
    return found
