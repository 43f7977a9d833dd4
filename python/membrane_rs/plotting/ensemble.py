"""Ensembles of runs: the mean of a column against time, and the spread around it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs._validation import nearest, show
from membrane_rs.errors import InputError
from membrane_rs.plotting.sources import Source

SPREADS = ("std", "range")
"""One standard deviation of the members around their mean; or from the lowest of them to the highest."""


@dataclass(frozen=True)
class Band:
    """Mean and spread of a column over the members of an ensemble; NaN where no member, or one alone, came so far.

    Attributes
    ----------
    time : (samples,) float
        Times [s].
    mean : (samples,) float
        In the unit of the column.
    low, high : (samples,) float
        The ends of the spread, in the unit of the column.

    Examples
    --------
    >>> from membrane_rs import scenes
    >>> from membrane_rs.study import ensemble
    >>> band = ensemble(scenes.load("spinning-tether"), 2, until=1e-3, samples=3).band("kinetic_energy")
    >>> band.time.shape, bool((band.low <= band.high).all())
    ((3,), True)
    """

    time: Floats
    mean: Floats
    low: Floats
    high: Floats


@dataclass(frozen=True)
class Ensemble:
    """Runs that differ in their start, or in a parameter, shown as one."""

    label: str
    members: Sequence[Source]
    spread: str = "std"
    shows_members: bool = False
    """Whether each of them is drawn, as a thin line."""

    def __post_init__(self) -> None:
        """Refuse times that do not ascend, between which nothing can be interpolated. Raises InputError."""
        for k, member in enumerate(self.members):
            if not (np.diff(member.time) > 0.0).all():
                place = f"ensembles[{self.label!r}][{k}]"
                raise InputError(f"{place}: times must ascend; order the samples by time, each time once")

    def band(self, column: str) -> Band:
        """Mean and spread of a column at the times of the member that came farthest; others are interpolated, and
        count as far as they came.
        """
        time = max(
            (source.time for source in self.members), key=lambda times: float(times[-1]) if len(times) else -np.inf
        )
        rows = np.stack([_at(time, source, column) for source in self.members])
        known = np.isfinite(rows)
        count = known.sum(axis=0)
        filled = np.where(known, rows, 0.0)
        mean = np.where(count > 0, filled.sum(axis=0) / np.maximum(count, 1), np.nan)
        if self.spread == "std":
            square = np.where(known, (rows - mean) ** 2, 0.0).sum(axis=0)
            half = np.where(count > 1, np.sqrt(square / np.maximum(count - 1, 1)), np.nan)
            return Band(time, mean, mean - half, mean + half)
        low, high = np.where(known, rows, np.inf).min(axis=0), np.where(known, rows, -np.inf).max(axis=0)
        return Band(time, mean, np.where(count > 1, low, np.nan), np.where(count > 1, high, np.nan))


def check_spread(spread: object) -> str:
    """The name of a spread. Raises InputError."""
    if spread not in SPREADS or not isinstance(spread, str):
        raise InputError(f"spread = {show(spread)}: {nearest(str(spread), SPREADS)}")
    return spread


def _at(time: Floats, source: Source, column: str) -> Floats:
    """A column at times [s], NaN outside of the run."""
    if not len(source.time):
        return np.full(len(time), np.nan)
    found: Floats = np.interp(time, source.time, source.column(column), left=np.nan, right=np.nan)
    return found
