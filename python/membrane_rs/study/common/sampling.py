"""Designs: which combinations of values a sweep runs."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np

from membrane_rs._validation import show
from membrane_rs.errors import InputError, InputTypeError
from membrane_rs.study.common.many_runs import MOST_RUNS
from membrane_rs.study.common.vary import Parameter

GRID, LATIN, SOBOL = "grid", "lhs", "sobol"
MOST_SEED = 2**63 - 1


def is_sampled(sample: str) -> bool:
    """Whether a design takes samples from ranges. Raises InputError for no design."""
    return _design(sample)[0] != GRID


def sample_count(sample: str) -> int:
    """Number of samples of a design; 0 for all combinations. Raises InputError for no design."""
    return _design(sample)[1]


def points_of(parameters: Sequence[Parameter], sample: str = GRID, seed: int = 0) -> list[dict[str, Any]]:
    """The combinations of a design, each once.

    Parameters
    ----------
    parameters : sequence of Parameter
        With ranges for samples, with values for the grid.
    sample : str
        "grid": all combinations, the last parameter's values first. "lhs:20": a Latin hypercube of so many samples, in
        which each parameter takes its range evenly. "sobol:32": a scrambled Sobol sequence, whose number is a power of
        two. Beside ranges a list is sampled as a range of as many equal parts.
    seed : int
        Of the samples.

    Raises
    ------
    InputError, InputTypeError
        No design, no range to sample from, more combinations than `MOST_RUNS`.
    """
    kind, count = _design(sample)
    if isinstance(seed, bool) or not isinstance(seed, int):
        raise InputTypeError(f"seed = {show(seed)}: must be a whole number")
    if not 0 <= seed <= MOST_SEED:
        raise InputError(f"seed = {show(seed)}: must be from 0 to 2^63 - 1")
    if kind == GRID:
        count = math.prod(len(parameter.values) for parameter in parameters)
    elif not any(parameter.is_range for parameter in parameters):
        raise InputError(
            f"sample = {show(sample)}: samples are taken from ranges, and there is none; vary a range such as 10:1000 "
            f"or 10:1000:log, or run all combinations ({GRID})"
        )
    if count > MOST_RUNS:
        raise InputError(f"{count:,} combinations of values: must be at most {MOST_RUNS:,}; give fewer values")
    keys = [parameter.key for parameter in parameters]
    if kind == GRID:
        made = [dict(zip(keys, values, strict=True)) for values in product(*(one.values for one in parameters))]
    else:
        made = [
            {one.key: one.at(float(share)) for one, share in zip(parameters, row, strict=True)}
            for row in _shares(kind, len(parameters), count, seed)
        ]
    return list({tuple(point.items()): point for point in made}.values())


def _shares(kind: str, dimensions: int, count: int, seed: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    """(count, dimensions) from 0 to below 1."""
    from scipy.stats import qmc  # slow to import

    random = np.random.default_rng(seed)
    if kind == LATIN:
        return qmc.LatinHypercube(dimensions, seed=random).random(count)
    return qmc.Sobol(dimensions, seed=random).random(count)


def _design(sample: str) -> tuple[str, int]:
    """The kind of a design, and its number of samples. Raises InputError."""
    found = re.fullmatch(r"(grid)|(lhs|sobol):(\d{1,9})", sample) if isinstance(sample, str) else None
    if found is None:
        raise InputError(f"sample = {show(sample)}: must be grid, lhs:20 or sobol:32, with any number of samples")
    if found[1]:
        return GRID, 0
    kind, count = found[2], int(found[3])
    if not 1 <= count <= MOST_RUNS:
        raise InputError(f"sample = {show(sample)}: must be 1 to {MOST_RUNS:,} samples")
    if kind == SOBOL and count & (count - 1):
        lower = 1 << (count.bit_length() - 1)
        raise InputError(
            f"sample = {show(sample)}: a Sobol sequence is even for powers of two alone; take {lower} or {2 * lower}"
        )
    return kind, count
