"""Convergence of a mesh study: distances between the curves of successive meshes, orders, extrapolated limits.

With d(h) the distance of the curves on cells of height h from those on cells of h/r, an error proportional to h^p
implies d(h)/d(h/r) = r^p. Three meshes thus give one order p, and p gives the limit of a feature by Richardson's
extrapolation. Where the motion is chaotic the mean over perturbed starts represents a mesh, and a distance is
significant if it exceeds the standard error of those means.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.results.features import curve_features
from membrane_rs.study.mesh import COLUMNS, MeshRun

POINTS = 2001
"""Number of instants at which curves are compared."""
CURVES = COLUMNS[1:]


@dataclass(frozen=True)
class Density:
    """All runs of one form on one mesh.

    Attributes
    ----------
    form : str
        Name of the length scales.
    rows : int
        Rows of cells from the inner to the outer edge.
    cell : float
        Height of a cell [m].
    runs : tuple of MeshRun
        One for each start.

    Examples
    --------
    >>> import numpy as np
    >>> from membrane_rs.study import Density, MeshRun
    >>> tables = [{"time": np.array([0.0, 1.0]), "deployment_rate": np.array([0.0, end])} for end in (0.8, 1.0)]
    >>> runs = tuple(MeshRun("paper", 8, 0.02, k, 99, 1e-5, 0.0, 1.0, None, tables[k]) for k in (0, 1))
    >>> mesh = Density("paper", 8, 0.02, runs)
    >>> mesh.until, mesh.mean("deployment_rate", np.array([0.5])), round(mesh.spread("deployment_rate", 1.0), 4)
    (1.0, array([0.45]), 0.0817)
    """

    form: str
    rows: int
    cell: float
    runs: tuple[MeshRun, ...]

    @property
    def until(self) -> float:
        """Time that all runs reached [s]."""
        return min(float(run.table["time"][-1]) for run in self.runs)

    def mean(self, column: str, times: Floats) -> Floats:
        """Mean over the starts of a curve.

        Parameters
        ----------
        column : str
            Name of the curve.
        times : (n,) float
            Where [s].

        Returns
        -------
        (n,) float
            In the unit of the column.
        """
        return np.asarray(self._curves(column, times).mean(axis=0))

    def spread(self, column: str, until: float) -> float:
        """Standard deviation over the starts, root mean square over the time.

        Parameters
        ----------
        column : str
            Name of the curve.
        until : float
            Time up to which it is taken [s].

        Returns
        -------
        float
            In the unit of the column; NaN from one start.
        """
        if len(self.runs) < 2:
            return math.nan
        curves = self._curves(column, np.linspace(0.0, until, POINTS))
        return float(np.sqrt(np.mean(curves.var(axis=0, ddof=1))))

    def feature(self, key: str) -> tuple[float, float]:
        """Mean over the starts of a feature of a curve, and its standard deviation.

        Parameters
        ----------
        key : str
            Name of the feature, as `Sweep.rows` has it, such as "first_peak_rate".

        Returns
        -------
        (float, float)
            In the unit of the feature; NaN where it is undefined.

        Examples
        --------
        >>> import numpy as np
        >>> from membrane_rs.study import Density, MeshRun
        >>> names = ("time", "deployment_rate", "phase_difference_deg")
        >>> table = dict(zip(names, np.array([[0.0, 1.0, 2.0], [0.0, 1.0, 0.5], [0.0, 5.0, -5.0]])))
        >>> run = MeshRun("paper", 8, 0.02, 0, 99, 1e-5, 0.0, 1.0, None, table)
        >>> Density("paper", 8, 0.02, (run,)).feature("first_peak_rate")
        (1.0, nan)
        """
        found = [run_features(run)[key] for run in self.runs]
        known = [value for value in found if value is not None]
        if len(known) < len(found):
            return math.nan, math.nan
        return float(np.mean(known)), float(np.std(known, ddof=1)) if len(known) > 1 else math.nan

    def _curves(self, column: str, times: Floats) -> Floats:
        return np.array([np.interp(times, run.table["time"], run.table[column]) for run in self.runs])


@dataclass(frozen=True)
class Step:
    """From one mesh to the next finer one, over the time that all meshes of the form cover."""

    coarse: Density
    fine: Density
    until: float
    distance: dict[str, float]
    """Root mean square distance of the mean curves, by column."""
    noise: dict[str, float]
    """Standard error of that distance from the spread of the starts, by column; NaN where no mesh has two starts."""

    @property
    def ratio(self) -> float:
        """Ratio of the cell heights."""
        return self.coarse.cell / self.fine.cell


def run_features(run: MeshRun) -> dict[str, float | None]:
    """Peak, trough and zero crossing of a run's curves, None where the run ended before."""
    return curve_features(run.table)


def densities(runs: Sequence[MeshRun]) -> dict[str, list[Density]]:
    """The meshes by form, from coarse to fine."""
    groups: dict[tuple[str, int], list[MeshRun]] = {}
    for run in runs:
        groups.setdefault((run.form, run.rows), []).append(run)
    found: dict[str, list[Density]] = {}
    for form, rows in sorted(groups, key=lambda key: key[1]):
        members = groups[form, rows]
        found.setdefault(form, []).append(Density(form, rows, members[0].cell, tuple(members)))
    return {form: found[form] for form in dict.fromkeys(run.form for run in runs)}


def steps(meshes: Sequence[Density], until: float | None = None) -> list[Step]:
    """Mesh to mesh, coarse to fine, over the time that all of them cover, or up to `until` [s]."""
    end = min([mesh.until for mesh in meshes] + ([until] if until is not None else []))
    times = np.linspace(0.0, end, POINTS)
    spreads = {c: [mesh.spread(c, end) for mesh in meshes] for c in CURVES}
    found = []
    for k, (a, b) in enumerate(pairwise(meshes)):
        distance, noise = {}, {}
        for c in CURVES:
            distance[c] = float(np.sqrt(np.mean((a.mean(c, times) - b.mean(c, times)) ** 2)))
            noise[c] = math.hypot(*(_known(spreads[c], k + j) / math.sqrt(len(m.runs)) for j, m in enumerate((a, b))))
        found.append(Step(a, b, end, distance, noise))
    return found


def _known(spreads: Sequence[float], k: int) -> float:
    """The spread of a mesh, or of the next coarser mesh with several starts."""
    return next((spread for spread in reversed(spreads[: k + 1]) if math.isfinite(spread)), math.nan)


def orders(found: Sequence[Step], column: str) -> list[float]:
    """p from each three successive meshes; NaN where the ratio of the cells is not constant."""
    return [
        math.log(a.distance[column] / b.distance[column]) / math.log(a.ratio)
        if math.isclose(a.ratio, b.ratio, rel_tol=1e-6) and min(a.distance[column], b.distance[column]) > 0.0
        else math.nan
        for a, b in pairwise(found)
    ]


def overall_order(found: Sequence[Step], column: str) -> float:
    """p from all meshes: slope of log distance against log cell by least squares; NaN from less than three."""
    values = [(step.coarse.cell, step.distance[column]) for step in found if step.distance[column] > 0.0]
    if len(values) < 2:
        return math.nan
    x, y = np.log(np.array(values)).T
    return float(np.polyfit(x, y, 1)[0])


def limit(meshes: Sequence[Density], key: str, order: float) -> float:
    """Extrapolated limit of a feature from the two finest meshes and the order; NaN unless that is above a half."""
    if len(meshes) < 2 or not order > 0.5:
        return math.nan
    coarse, fine = (mesh.feature(key)[0] for mesh in meshes[-2:])
    return float(fine + (fine - coarse) / ((meshes[-2].cell / meshes[-1].cell) ** order - 1.0))
