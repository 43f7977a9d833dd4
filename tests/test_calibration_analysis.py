"""What a calibration says of its errors, on models whose Jacobian is known."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
import pytest
from membrane_rs import InputError
from membrane_rs._arrays import Floats
from membrane_rs.results import Experiment
from membrane_rs.study.calibration.analysis import FINEST, Analysis, analysed
from membrane_rs.study.calibration.model import Curves, DataColumn, data_columns
from membrane_rs.study.common.one_run import RunPoint, RunResult
from membrane_rs.study.common.vary import Parameter


class Linear:
    """Residuals that are a matrix times the shares: what a fit sees of its runs, with a known Jacobian."""

    def __init__(self, matrix: list[list[float]], noise: float = math.nan, starts: int = 1) -> None:
        self.matrix, self.noise = np.array(matrix), noise
        self.runs = [RunResult(RunPoint({}, k), "finished") for k in range(starts)]
        count = len(matrix)
        deviations = np.ones(count)
        self.columns = [DataColumn("force", "N", np.arange(count, dtype=float), np.zeros(count), deviations, True)]
        self.parameters = [Parameter(name, "", (1.0, 10.0), True) for name in ("a", "b", "c")[: self.matrix.shape[1]]]

    def curves(self, shares: list[Floats]) -> list[Curves]:
        return [Curves(self.matrix @ one, np.full(len(self.matrix), self.noise), self.runs) for one in shares]

    def analysis(self) -> Analysis:
        shares = np.full(len(self.parameters), 0.5)
        model: Any = self
        return analysed(model, shares, self.curves([shares])[0], 0.01)


def test_errors_and_correlation_are_those_of_the_normal_equations() -> None:
    matrix = [[6.0, 2.0], [2.0, 8.0], [4.0, -2.0]]
    found = Linear(matrix).analysis()
    covariance = np.linalg.inv(np.array(matrix).T @ np.array(matrix))
    assert found.errors == pytest.approx(np.sqrt(np.diag(covariance)))
    assert found.correlation[0, 1] == pytest.approx(covariance[0, 1] / math.sqrt(covariance[0, 0] * covariance[1, 1]))
    assert found.sensitivity[0] == pytest.approx(0.1 * np.sqrt(np.mean(np.array(matrix) ** 2, axis=0)))
    assert not found.undetermined


@pytest.mark.parametrize(
    ("matrix", "expected"),
    [
        ([[9.0, 9.0], [8.0, 8.0]], ["a raised while b is lowered"]),
        ([[9.0, -9.0], [8.0, -8.0]], ["a and b, raised together"]),
        ([[9.0, 0.0], [8.0, 0.0]], ["b"]),
        ([[9.0, 0.0], [0.0, 3.9]], ["b"]),
        ([[9.0, 0.0], [0.0, 3.95]], []),
        ([[9.0, 9.0, 0.0], [0.0, 0.0, 9.0]], ["a raised while b is lowered"]),
        ([[9.0, 0.0, 0.0]], ["b", "c"]),
    ],
)
def test_combinations_that_leave_the_curves_as_they_are_are_named(
    matrix: list[list[float]], expected: list[str]
) -> None:
    found = Linear(matrix).analysis()
    named = sorted(
        one.replace("b raised while a is lowered", "a raised while b is lowered") for one in found.undetermined
    )
    assert named == expected


@pytest.mark.parametrize(("noise", "is_hidden"), [(math.nan, False), (1e-3, False), (0.03, True)])
def test_noise_of_the_means_can_hide_a_direction(noise: float, is_hidden: bool) -> None:
    """Differences over 0.02: noise of 0.03 in the means is one of 2 in derivatives, and the second of these is 1.5."""
    found = Linear([[9.0, 0.0], [0.0, 1.5]], noise).analysis()
    assert found.is_hidden is is_hidden
    assert bool(found.errors[1] == pytest.approx(1.0)) is is_hidden
    assert found.errors[0] == pytest.approx(1 / 9, rel=0.15)


def test_noisy_derivatives_do_not_make_errors_smaller() -> None:
    """The errors of a fit with noise in its derivatives are, on average, those without."""
    random, matrix, noise = np.random.default_rng(0), np.tile([[3.0, 1.0], [1.0, 4.0]], (50, 1)), 0.02
    true = Linear(matrix.tolist()).analysis().errors
    ratios: dict[float, list[Floats]] = {noise: [], math.nan: []}
    for _ in range(40):
        rough = (matrix + random.normal(0.0, math.sqrt(2.0) * noise / 0.02, matrix.shape)).tolist()
        for known, found in ratios.items():
            found.append(Linear(rough, known).analysis().errors / true)
    assert np.median(ratios[noise], axis=0) == pytest.approx([1.0, 1.0], rel=0.05)
    assert (np.median(ratios[math.nan], axis=0) < 0.9).all()


class Unknown(Linear):
    """The same, of columns of given lengths whose deviations are not known, with given residuals."""

    def __init__(self, matrix: Floats, residuals: Floats, lengths: tuple[int, ...]) -> None:
        super().__init__(matrix.tolist())
        self.residuals = residuals
        self.columns = [
            DataColumn(f"c{k}", "N", np.arange(n, dtype=float), np.zeros(n), np.ones(n), False)
            for k, n in enumerate(lengths)
        ]

    def curves(self, shares: list[Floats]) -> list[Curves]:
        middle = np.full(len(self.parameters), 0.5)
        return [
            Curves(self.residuals + self.matrix @ (one - middle), np.full(len(self.matrix), math.nan), ())
            for one in shares
        ]


def test_errors_of_columns_with_noise_of_different_size_are_those_of_the_scatter() -> None:
    """Least squares with equal weights, of data whose second half is fifty times as noisy."""
    random = np.random.default_rng(1)
    matrix = random.normal(size=(40, 2)) + np.array([1.0, 0.0])
    sizes = np.repeat([0.01, 0.5], 20)
    gain = np.linalg.pinv(matrix)
    found, said = [], []
    for _ in range(300):
        noise = sizes * random.standard_normal(40)
        change = gain @ noise
        found.append(change)
        said.append(Unknown(matrix, noise - matrix @ change, (20, 20)).analysis().errors)
    assert np.sqrt(np.mean(np.square(said), axis=0)) == pytest.approx(np.std(found, axis=0), rel=0.1)


def test_data_that_the_model_meets_exactly_have_no_errors_below_rounding() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        matrix = np.array([[3.0, 1.0], [1.0, 4.0], [2.0, -1.0]])
        found = Unknown(matrix, np.zeros(3), (3,)).analysis()
    assert found.errors == pytest.approx([FINEST, FINEST])
    assert np.isfinite(found.correlation).all()
    assert not found.undetermined


@pytest.mark.parametrize("count", [1, 2])
def test_as_few_data_as_parameters_say_nothing_of_errors(count: int) -> None:
    found = Unknown(np.array([[3.0, 1.0], [1.0, 4.0]])[:count], np.full(count, 0.1), (count,)).analysis()
    assert found.errors == pytest.approx([1.0, 1.0])
    assert len(found.undetermined) == 2


@pytest.mark.parametrize(("sign", "words"), [(1.0, "raised while"), (-1.0, "raised together")])
def test_two_that_enter_as_one_are_correlated_wholly(sign: float, words: str) -> None:
    found = Linear([[900.0, sign * 900.0], [800.0, sign * 800.0]]).analysis()
    assert found.correlation[0, 1] == pytest.approx(-sign, abs=1e-4)
    assert [words in one for one in found.undetermined] == [True]


def one(values: list[float], **others: list[float]) -> Experiment:
    columns = {"force": np.array(values), **{name: np.array(some) for name, some in others.items()}}
    return Experiment("rig", np.arange(float(len(values))), columns)


def test_values_whose_squares_overflow_are_refused() -> None:
    with pytest.raises(InputError, match=r"rig, column 'force': -1e\+308 at 1 s is beyond 1e\+60"):
        data_columns(one([1.0, -1e308]), None, None, 10.0)
    with pytest.raises(InputError, match=r"'force_std': must be above 0, from 1e-60"):
        data_columns(one([1.0, 2.0], force_std=[1.0, 0.0]), None, None, 10.0)
    (column,) = data_columns(one([1e-320, -1e-320]), None, None, 10.0)
    assert (column.scale == 1.0).all()


def test_columns_without_a_value_are_left_out_unless_they_are_named() -> None:
    data = one([1.0, 2.0], torque=[math.nan, math.nan])
    assert [column.name for column in data_columns(data, None, None, 10.0)] == ["force"]
    with pytest.raises(InputError, match="no value of 'torque' from 0 to 10 s"):
        data_columns(data, ["torque"], None, 10.0)


def test_data_up_to_the_end_of_the_runs_count() -> None:
    (column,) = data_columns(one([1.0, 2.0, 3.0]), None, None, 1.0)
    assert column.time.tolist() == [0.0, 1.0]


def test_noise_of_the_means_and_of_the_measured_motion_adds_to_given_deviations() -> None:
    """Means over 4 starts with noise of 2 standard deviations: one start has a variance of 4 * 2^2, and so has the
    measured motion; the derivatives have noise that hides little.
    """
    matrix, noise = np.full((100, 1), 1e4), 2.0
    bias = 2.0 * 100 * noise**2 / 0.02**2
    expected = math.sqrt((1.0 + noise**2 + 4 * noise**2) / (100 * 1e8 - bias))
    assert Linear(matrix.tolist(), noise, starts=4).analysis().errors == pytest.approx([expected], rel=1e-6)
