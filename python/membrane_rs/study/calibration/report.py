"""The tables and the figure of a calibration."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from membrane_rs.plotting import plot_comparison
from membrane_rs.study.calibration.analysis import Analysis, FittedParameter
from membrane_rs.study.calibration.model import DataColumn
from membrane_rs.study.common.one_run import RunResult


def table_of_parameters(parameters: Sequence[FittedParameter]) -> str:
    """Values before and after, and one standard deviation to both sides."""
    rows = []
    for one in parameters:
        unit = f" [{one.unit}]" if one.unit else ""
        span = f"{one.low:.4g} to {one.high:.4g}" if math.isfinite(one.error) else "-"
        verdict = "determined" if one.is_determined else f"at its {one.end} end" if one.end else "**not determined**"
        rows.append((one.key + unit, f"{one.start:.4g}", f"{one.value:.4g}", span, verdict))
    return table(("parameter", "start", "fitted", "one standard deviation", ""), rows, words=(0, 4))


def table_of_columns(
    columns: Sequence[DataColumn],
    residuals: Mapping[str, float],
    spreads: Mapping[str, float],
    parameters: Sequence[FittedParameter],
    analysis: Analysis | None,
) -> str:
    """How far the curves are from the data, starts from each other, and how much a tenth of each range changes them."""
    head = ["column", "data", "residual (RMS)", "one start (RMS)", *(f"a tenth of {one.key}" for one in parameters)]
    rows = []
    for k, column in enumerate(columns):
        unit = f" [{column.unit}]" if column.unit else ""
        changes = ["-"] * len(parameters)
        if analysis is not None:
            changes = [f"{value:.3g}" for value in analysis.sensitivity[k]]
        spread = f"{spreads[column.name]:.3g}" if math.isfinite(spreads[column.name]) else "-"
        size = f"{residuals[column.name]:.3g}"
        rows.append((column.name + unit, str(len(column.time)), size, spread, *changes))
    return table(head, rows)


def table_of_correlation(keys: Sequence[str], correlation: Floats) -> str:
    """Correlations of the errors."""
    rows = [(key, *(f"{value:+.2f}" for value in row)) for key, row in zip(keys, correlation, strict=True)]
    return table(("correlation", *keys), rows)


def plot_calibration(
    columns: Sequence[DataColumn],
    first: Sequence[RunResult],
    best: Sequence[RunResult],
    *,
    path: str | Path | None = None,
    **options: Any,
) -> Any:
    """The data, and the curves before and after; with several starts their means and their spread."""
    measured: dict[str, dict[str, Floats]] = {}
    for column in columns:
        own = measured.setdefault(_label(column, columns), {"time": column.time})
        own[column.name] = column.values
        if column.has_deviation:
            own[f"{column.name}_std"] = column.scale
    sets = {"start": [run.history for run in first], "fitted": [run.history for run in best]}
    curves: dict[str, Any] = {"ensembles": sets}
    if len(best) == 1:
        curves = {"runs": {label: some[0] for label, some in sets.items()}}
    names = list(dict.fromkeys(column.name for column in columns))
    return plot_comparison(columns=names, experiments=measured, path=path, **curves, **options)


def _label(column: DataColumn, columns: Sequence[DataColumn]) -> str:
    """One label for all data, or one for each column where their times differ."""
    same = all(np.array_equal(column.time, other.time) for other in columns)
    return "measured" if same else f"measured, {column.name}"
