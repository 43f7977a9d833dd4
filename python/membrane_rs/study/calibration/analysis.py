"""What measured data say of parameters: how far they are known, and which of their combinations are not.

J is the Jacobian of the residuals by the shares of the parameters' ranges, of central differences over widths w. Means
over starts have standard errors e, which differences magnify: J^T J is too large by D, on average,

    D = diag(2 sum e^2 / w^2)        M = J^T J - D = sum_k lambda_k v_k v_k^T        C = sigma^2 M^-1

C is the covariance of the shares. A direction v_k with lambda_k below v_k^T D v_k is hidden by the spread of the
starts: nothing is known along it but the range, whose length stands for its standard deviation. sigma^2 is 1 + mean e^2
where the standard deviation of each value is given, else the sum of squared residuals over the degrees of freedom: then
residuals are taken for independent errors of one size. The linear form holds near the best values alone.

J. Nocedal, S. Wright, Numerical Optimization (2006), chapter 10; G. Seber, C. Wild, Nonlinear Regression (1989),
section 2.1.2. D is the bias of a normal matrix with noise in its factors: W. Fuller, Measurement Error Models (1987),
section 1.2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from membrane_rs._arrays import Floats
from membrane_rs.study.calibration.model import Curves, FitModel

UNDETERMINED = 0.5
"""A direction is not determined where one standard deviation along it is more than this share of the range."""
NAMED = 0.2
"""Components of a direction that are named, as a share of its length."""
SMALLEST = 1e-12
"""An eigenvalue below this share of the largest one is none."""


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
        Standard deviation of each, as a share of its range.
    correlation : (p, p) float
        Of their errors.
    undetermined : sequence of str
        Parameters, or combinations of several, that the data do not determine.
    sensitivity : (columns, p) float
        Root mean square change of each column, in its unit, for a tenth of the range of each parameter.
    is_hidden : bool
        Whether the spread of the starts hides one of the undetermined.
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
    noise = best.noise[np.isfinite(best.noise)]
    widths = np.array([(high - low)[k] for k, (low, high) in enumerate(differences(shares, step))])
    bias = np.diag(2.0 * float(np.sum(noise**2)) / widths**2)
    values, vectors = np.linalg.eigh(slopes.T @ slopes - bias)
    axes = vectors.T
    least = np.maximum(SMALLEST * max(values.max(), 0.0), [float(axis @ bias @ axis) for axis in axes])
    along = np.full(count, 1.0)
    seen = np.flatnonzero(values > least)
    along[seen] = np.minimum(_sigma(model, best, count) / np.sqrt(values[seen]), 1.0)
    covariance = axes.T @ np.diag(along**2) @ axes
    errors = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(errors, errors)
    undetermined = [_direction(model, axes[k]) for k in range(count) if along[k] > UNDETERMINED]
    is_hidden = bool(len(noise)) and len(seen) < count
    return Analysis(errors, correlation, undetermined, _sensitivity(model, slopes), is_hidden)


def _sigma(model: FitModel, best: Curves, count: int) -> float:
    """Standard deviation of a residual."""
    if all(column.has_deviation for column in model.columns):
        noise = best.noise[np.isfinite(best.noise)]
        return math.sqrt(1.0 + (float(np.mean(noise**2)) if len(noise) else 0.0))
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
