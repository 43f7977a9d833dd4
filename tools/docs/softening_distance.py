"""Distances between ensembles of curves, what of them is chance, and the front of error against cost."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from membrane_rs._arrays import Floats

ALLOCATIONS = 2000
"""Random allocations of all starts to two ensembles."""


@dataclass(frozen=True)
class Distance:
    """Distance of the mean curves of two ensembles, in the unit of the curves.

    Attributes
    ----------
    value : float
        Root of the mean square over the samples.
    error : float
        Standard error of the difference of both means, root of the mean square over the samples: the distance that two
        ensembles of the same model have.
    chance : float
        Share of the random allocations of all starts to two ensembles whose distance is as large.
    """

    value: float
    error: float
    chance: float

    @property
    def net(self) -> float:
        """The distance without what chance adds on average; 0 where that is more."""
        return math.sqrt(max(0.0, self.value**2 - self.error**2))


def rms(values: Floats) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def mean_distance(one: Floats, other: Floats) -> float:
    """Distance of the mean curves; each ensemble is (starts, samples)."""
    return rms(one.mean(axis=0) - other.mean(axis=0))


def standard_error(one: Floats, other: Floats) -> float:
    """Standard error of the difference of both means, root of the mean square over the samples; NaN of one start."""
    if min(len(one), len(other)) < 2:
        return math.nan
    variance = sum((np.var(each, axis=0, ddof=1) / len(each) for each in (one, other)), start=np.zeros(one.shape[1]))
    return float(np.sqrt(variance.mean()))


def chance(one: Floats, other: Floats, allocations: int = ALLOCATIONS) -> float:
    """Share of random allocations of all starts to ensembles of these sizes whose means are as far apart.

    The given allocation counts as one of them.
    """
    every, count = np.concatenate([one, other]), len(one)
    random, measured = np.random.default_rng(0), mean_distance(one, other)
    as_far = 1
    for _ in range(allocations - 1):
        order = random.permutation(len(every))
        as_far += mean_distance(every[order[:count]], every[order[count:]]) >= measured * (1.0 - 1e-12)
    return as_far / allocations


def distance(one: Floats, other: Floats) -> Distance:
    """Distance of two ensembles, (starts, samples) each."""
    return Distance(mean_distance(one, other), standard_error(one, other), chance(one, other))


def spread(curves: Floats) -> float:
    """Standard deviation of single starts, root of the mean square over the samples; NaN of one start."""
    return rms(np.std(curves, axis=0, ddof=1)) if len(curves) > 1 else math.nan


def shares_inside(curves: Floats, band: Floats) -> Floats:
    """(starts,) share of the samples of each start that lie between the lowest and the highest curve of `band`."""
    low, high = band.min(axis=0), band.max(axis=0)
    found: Floats = np.mean((low <= curves) & (curves <= high), axis=1)
    return found


def expected_inside(count: int) -> float:
    """Share inside the band of `count` curves of one more curve of the same model.

    Of `count` + 1 equally probable orders of values the last one is the lowest or the highest in two.
    """
    return (count - 1) / (count + 1)


def front(costs: Sequence[float], errors: Sequence[float]) -> list[int]:
    """Indices of the points that none beats, by ascending cost.

    A point is beaten by another that is no worse in both and better in one; of equal points the first remains.
    """
    found: list[int] = []
    least = math.inf
    for k in sorted(range(len(costs)), key=lambda k: (costs[k], errors[k], k)):
        if errors[k] < least:
            found.append(k)
            least = errors[k]
    return found
