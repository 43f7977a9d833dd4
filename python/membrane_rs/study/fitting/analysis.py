"""What measured data say of parameters: how far they are known, and which of their combinations are not.

With the Jacobian J of the residuals by the shares of the parameters' ranges (central differences) and its singular
values s_k with directions v_k, the standard deviation along v_k is sigma/s_k, and the covariance of the shares

    C = sigma^2 sum_k v_k v_k^T / s_k^2

sigma is 1 where the standard deviation of each value is given, else the root of the sum of squared residuals over the
degrees of freedom: then residuals are taken for independent errors of one size. The linear form holds near the best
values alone.

J. Nocedal, S. Wright, Numerical Optimization (2006), chapter 10; G. Seber, C. Wild, Nonlinear Regression (1989),
section 2.1.2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.study.fitting.model import Curves, FitModel

UNDETERMINED = 0.5
"""A direction is not determined where one standard deviation along it is more than this share of the range."""
NAMED = 0.2
"""Components of a direction that are named, as a share of its length."""
DROWNED = 2.0
"""A change of the curves by a difference step is lost below this many standard errors of their means."""


@dataclass(frozen=True)
class FittedParameter:
    """One parameter.

    Attributes
    ----------
    key, unit : str
        Of the scene.
    start, value : float
        Before and after.
    low, high : float
        One standard deviation to both sides; beyond the range where the data leave it open.
    error : float
        The standard deviation as a share of the range.
    end : str
        "lower" or "upper" where the value is at that end of the range, else empty.
    """

    key: str
    unit: str
    start: float
    value: float
    low: float
    high: float
    error: float
    end: str

    @property
    def is_determined(self) -> bool:
        """Whether one standard deviation is less than half of the range, and the value not at its end."""
        return self.error <= UNDETERMINED and not self.end


@dataclass(frozen=True)
class Analysis:
    """How far parameters are known.

    Attributes
    ----------
    errors : (p,) float
        Standard deviation of each, as a share of its range; infinite where nothing changes with it.
    correlation : (p, p) float
        Of their errors; NaN beside a parameter with an infinite one.
    undetermined : sequence of str
        Parameters, or combinations of several, that the data do not determine.
    sensitivity : (columns, p) float
        Root mean square change of each column, in its unit, for a tenth of the range of each parameter.
    is_drowned : bool
        Whether the spread of the starts hides the changes that the Jacobian is made of.
    """

    errors: Floats
    correlation: Floats
    undetermined: Sequence[str]
    sensitivity: Floats
    is_drowned: bool


def differences(shares: Floats, step: float) -> list[tuple[Floats, Floats]]:
    """Pairs of points around some shares, one pair for each parameter, within the ranges."""
    pairs = []
    for k in range(len(shares)):
        low, high = shares.copy(), shares.copy()
        low[k], high[k] = max(shares[k] - step, 0.0), min(shares[k] + step, 1.0)
        pairs.append((low, high))
    return pairs


def jacobian(model: FitModel, shares: Floats, step: float) -> Floats:
    """(n, p) derivatives of the residuals by the shares; 0 where a run at one of the two points fails.

    Where one of the two points fails, the derivative is that from the point itself to the other one.
    """
    pairs = differences(shares, step)
    found = model.curves([shares, *(point for pair in pairs for point in pair)])
    here, sides = found[0], list(zip(found[1::2], found[2::2], strict=True))
    columns = []
    for k, ((low, high), (below, above)) in enumerate(zip(pairs, sides, strict=True)):
        known = [
            (share[k], curves) for share, curves in ((low, below), (shares, here), (high, above)) if not curves.failure
        ]
        if len(known) < 2 or known[0][0] == known[-1][0]:
            columns.append(np.zeros(len(here.residuals)))
        else:
            columns.append((known[-1][1].residuals - known[0][1].residuals) / (known[-1][0] - known[0][0]))
    return np.stack(columns, axis=1)


def analysed(model: FitModel, shares: Floats, best: Curves, step: float) -> Analysis:
    """How far the best parameters are known. Raises `BudgetSpent`."""
    slopes = jacobian(model, shares, step)
    count = slopes.shape[1]
    _, singular, axes = np.linalg.svd(slopes, full_matrices=len(slopes) < count)
    sigma = _sigma(model, best, count)
    least = np.finfo(float).eps * max(slopes.shape) * (singular[0] if len(singular) else 0.0)
    along = np.full(count, math.inf)
    seen = np.flatnonzero(singular > least)
    along[seen] = sigma / singular[seen]
    is_blind = np.array([bool((np.abs(axes[np.isinf(along), k]) > 1e-6).any()) for k in range(count)])
    covariance = sum((along[k] ** 2 * np.outer(axes[k], axes[k]) for k in seen), np.zeros((count, count)))
    errors = np.where(is_blind, math.inf, np.sqrt(np.diag(covariance)))
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = covariance / np.sqrt(np.outer(np.diag(covariance), np.diag(covariance)))
    correlation[is_blind, :] = correlation[:, is_blind] = math.nan
    undetermined = [_direction(model, axes[k]) for k in range(count) if along[k] > UNDETERMINED]
    return Analysis(errors, correlation, undetermined, _sensitivity(model, slopes), _is_drowned(slopes, best, step))


def _sigma(model: FitModel, best: Curves, count: int) -> float:
    """Standard deviation of a residual."""
    if all(column.has_deviation for column in model.columns):
        return 1.0
    freedom = len(best.residuals) - count
    return math.sqrt(float(np.sum(best.residuals**2)) / freedom) if freedom > 0 else math.inf


def _direction(model: FitModel, axis: Floats) -> str:
    """A direction in the space of the parameters, as text: what leaves the curves as they are."""
    largest = axis[np.abs(axis).argmax()]
    named = [(one.key, share) for one, share in zip(model.parameters, axis * np.sign(largest), strict=True)]
    parts = [(key, share) for key, share in named if abs(share) > NAMED]
    if len(parts) == 1:
        return parts[0][0]
    up = [key for key, share in parts if share > 0.0]
    down = [key for key, share in parts if share < 0.0]
    if not down:
        return f"{' and '.join(up)}, raised together"
    return f"{' and '.join(up)} raised while {' and '.join(down)} {'is' if len(down) == 1 else 'are'} lowered"


def _sensitivity(model: FitModel, slopes: Floats) -> Floats:
    """(columns, p) changes for a tenth of the range, in the units of the columns."""
    found, first = [], 0
    for column in model.columns:
        rows = slopes[first : first + len(column.time)] * column.scale[:, None]
        found.append(0.1 * np.sqrt(np.mean(rows**2, axis=0)))
        first += len(column.time)
    return np.array(found)


def _is_drowned(slopes: Floats, best: Curves, step: float) -> bool:
    """Whether a difference is less than what the means of other starts would differ by."""
    noise = best.noise[np.isfinite(best.noise)]
    if not len(noise):
        return False
    changes = np.sqrt(np.mean((2.0 * step * slopes) ** 2, axis=0))
    return bool((changes < DROWNED * math.sqrt(2.0) * math.sqrt(float(np.mean(noise**2)))).any())
