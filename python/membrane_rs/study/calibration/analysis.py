"""What measured data say of parameters: how far they are known, and which of their combinations are not.

J is the Jacobian of the residuals by the shares of the parameters' ranges, of central differences over widths w. Means
over starts have standard errors e, which differences magnify: J^T J is too large by D, on average,

    D = diag(2 sum e^2 / w^2)        M = J^T J - D = sum_k lambda_k v_k v_k^T        B = sum_c sigma_c^2 M_c
    C = M^-1 B M^-1

C is the covariance of the shares, M_c the part of M of the column c: residuals are taken for independent errors of one
size in each column. Where all sigma_c are one sigma, C = sigma^2 M^-1. A direction v_k with lambda_k below v_k^T D v_k
is hidden by the spread of the starts: nothing is known along it but the range, whose length stands for its standard
deviation. Where the standard deviations of the column are given, sigma_c^2 is 1 + (n + 1) mean e^2: n e^2 is the
variance of one of n starts, and the measured motion is such a one. Else it is the sum of the squared residuals of the
column over its share of the degrees of freedom. The linear form holds near the best values alone.

J. Nocedal, S. Wright, Numerical Optimization (2006), chapter 10; G. Seber, C. Wild, Nonlinear Regression (1989),
section 2.1.2. C is that of least squares whose weights are not those of the errors: H. White, Econometrica 48 (1980),
817. D is the bias of a normal matrix with noise in its factors: W. Fuller, Measurement Error Models (1987),
section 1.2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.study.calibration.model import Curves, FitModel

NORMAL_95 = 1.96
"""Standard deviations to both sides of the mean that hold 95 % of a normal distribution."""
UNDETERMINED = 0.5 / NORMAL_95
"""A direction is not determined where one standard deviation along it is more than this share of the range: its 95 %
interval is then longer than the range.
"""
NAMED = 0.2
"""Components of a direction that are named, as a share of its length."""
FINEST = 1e-9
"""Standard deviations below this share of the range are rounding of the runs."""
SMALLEST = 1e-12
"""An eigenvalue below this share of the largest one is none."""


@dataclass(frozen=True)
class FittedParameter:
    """One parameter of a calibration.

    Attributes
    ----------
    key, unit : str
        Of the scene.
    start, value : float
        Before and after, in its unit.
    low, high : float
        One standard deviation to both sides, in its unit; beyond the range where the data leave it open.
    error : float
        The standard deviation as a share of the range [-].
    end : str
        "lower" or "upper" where the value is at that end of the range, else empty.
    reaches : str
        "lower", "upper" or "lower and upper" where the 95 % interval holds that end, else empty.

    Examples
    --------
    >>> from membrane_rs.study import FittedParameter
    >>> FittedParameter("laws.creases.stiffness", "", 10.0, 20.0, 18.0, 22.0, 0.02, "").is_determined
    True
    """

    key: str
    unit: str
    start: float
    value: float
    low: float
    high: float
    error: float
    end: str
    reaches: str = ""

    @property
    def is_determined(self) -> bool:
        """Whether the 95 % interval, of 1.96 standard deviations to both sides, lies within the range."""
        return self.error <= UNDETERMINED and not self.end and not self.reaches


@dataclass(frozen=True)
class Analysis:
    """How far parameters are known.

    Attributes
    ----------
    errors : (p,) float
        Standard deviation of each, as a share of its range [-].
    correlation : (p, p) float
        Of their errors [-].
    undetermined : sequence of str
        Parameters, or combinations of several, that the data do not determine.
    sensitivity : (columns, p) float
        Root mean square change of each column, in its unit, for a tenth of the range of each parameter.
    is_hidden : bool
        Whether the spread of the starts hides one of the undetermined.

    Examples
    --------
    >>> import numpy as np
    >>> from membrane_rs.study import Analysis
    >>> Analysis(np.array([0.02]), np.eye(1), [], np.ones((1, 1)), is_hidden=False).errors
    array([0.02])
    """

    errors: Floats
    correlation: Floats
    undetermined: Sequence[str]
    sensitivity: Floats
    is_hidden: bool


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
    noise = np.where(np.isfinite(best.noise), best.noise, 0.0)
    widths = np.array([(high - low)[k] for k, (low, high) in enumerate(differences(shares, step))])
    parts = list(zip(_rows(model), _variances(model, best, noise, count), strict=True))
    biases = [np.diag(2.0 * float(np.sum(noise[rows] ** 2)) / widths**2) for rows, _ in parts]
    normal = [slopes[rows].T @ slopes[rows] - bias for (rows, _), bias in zip(parts, biases, strict=True)]
    bias = np.sum(biases, axis=0)
    values, vectors = np.linalg.eigh(np.sum(normal, axis=0))
    axes = vectors.T
    least = np.maximum(SMALLEST * max(values.max(), 0.0), [float(axis @ bias @ axis) for axis in axes])
    seen = np.flatnonzero(values > least)
    covariance = np.eye(count)
    if all(math.isfinite(variance) for _, variance in parts):
        middle = np.sum([variance * one for (_, variance), one in zip(parts, normal, strict=True)], axis=0)
        inverse = axes[seen] / values[seen, None]
        covariance[np.ix_(seen, seen)] = _bounded(inverse @ middle @ inverse.T)
    along = np.sqrt(np.diag(covariance))
    covariance = axes.T @ covariance @ axes
    errors = np.sqrt(np.diag(covariance))
    correlation = np.clip(covariance / np.outer(errors, errors), -1.0, 1.0)
    undetermined = [_direction(model, axes[k]) for k in range(count) if along[k] > UNDETERMINED]
    is_hidden = bool(noise.any()) and len(seen) < count
    return Analysis(errors, correlation, undetermined, _sensitivity(model, slopes), is_hidden)


def _rows(model: FitModel) -> list[slice]:
    """The rows of each column among the residuals."""
    ends = np.cumsum([len(column.time) for column in model.columns])
    return [slice(end - len(column.time), end) for column, end in zip(model.columns, ends, strict=True)]


def _variances(model: FitModel, best: Curves, noise: Floats, count: int) -> list[float]:
    """Variance of a residual of each column; infinite where the data are too few to tell."""
    freedom = 1.0 - count / len(best.residuals)
    found = []
    for column, rows in zip(model.columns, _rows(model), strict=True):
        if column.has_deviation:
            found.append(1.0 + (len(best.runs) + 1) * float(np.mean(noise[rows] ** 2)))
        else:
            found.append(float(np.mean(best.residuals[rows] ** 2)) / freedom if freedom > 0.0 else math.inf)
    return found


def _bounded(covariance: Floats) -> Floats:
    """A covariance whose standard deviations are at least `FINEST`, and at most the range."""
    sizes = np.sqrt(np.maximum(np.diag(covariance), FINEST**2))
    factors = np.minimum(1.0, 1.0 / sizes)
    found: Floats = covariance * np.outer(factors, factors)
    np.fill_diagonal(found, (sizes * factors) ** 2)
    return found


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
