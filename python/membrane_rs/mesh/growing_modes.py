"""Modes of a spring network that grow by themselves, because some of its constants are negative."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from membrane_rs._arrays import Floats

_TOLERANCE = 1e-6
_DENSE = 300
_ZERO = 1e-10
"""Eigenvalues nearer to zero than this part of the largest one are rigid motions."""


def growing_modes(points: Floats, edges: NDArray[np.int64], constants: Floats, masses: Floats) -> tuple[float, int]:
    """Growth rate [1/s] of the fastest mode of x'' = -M^-1 K x that grows, and how many grow.

    With lambda < 0 an eigenvalue of M^-1/2 K M^-1/2, the mode grows as exp(sqrt(-lambda) t). K is that of the
    springs at rest, K = sum k n n^T with n along the spring; a flat membrane has none across its plane, so
    only motions in the plane are considered.

    How many eigenvalues lie below a shift is read from the pivots of a factorization. The most negative one
    is found by shift and invert, from a shift below them all: lambda >= -|K-|, with K- the part of the
    negative springs, for which Gershgorin's bound is taken and then brought nearer in steps of four.

    Parameters
    ----------
    points : (n, 3) [m];  edges : (e, 2), whose ends may be one node;  constants : (e,) [N/m];  masses : (n,) [kg]
    """
    from scipy.sparse import coo_matrix, diags_array
    from scipy.sparse.linalg import LinearOperator, eigsh

    # Springs between nodes in one place, such as the ends of a bridge, have no direction and no mode.
    has_direction = np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1) > 0.0
    edges, constants = edges[has_direction], constants[has_direction]
    if not len(edges):
        return 0.0, 0
    used = np.unique(edges)
    edges = np.searchsorted(used, edges)
    points, masses = points[used], masses[used]
    points = points / np.abs(points).max()  # of any scale: directions alone matter
    points = points - points.mean(axis=0)
    spread, axes = np.linalg.eigh(points.T @ points)
    dimensions = axes[:, spread > 1e-12 * spread[-1]]
    size = dimensions.shape[1]
    direction = (points[edges[:, 1]] - points[edges[:, 0]]) @ dimensions
    direction /= np.maximum(np.linalg.norm(direction, axis=1), np.finfo(float).tiny)[:, None]
    # One row for each spring: B = (-n / sqrt(m_i), n / sqrt(m_j)), so that M^-1/2 K M^-1/2 = B^T k B.
    root = np.sqrt(masses)
    values = np.concatenate([-direction / root[edges[:, :1]], direction / root[edges[:, 1:]]], axis=1)
    columns = (size * edges[:, :, None] + np.arange(size)).reshape(len(edges), -1)
    rows = np.repeat(np.arange(len(edges)), columns.shape[1])
    unknowns = size * len(points)
    b = coo_matrix((values.ravel(), (rows, columns.ravel())), shape=(len(edges), unknowns)).tocsr()
    matrix = (b.T @ diags_array(constants) @ b).tocsc()
    inverse = 1.0 / root[edges]
    row_sum = np.abs(constants)[:, None] * inverse * inverse.sum(axis=1)[:, None]

    def bound(chosen: NDArray[np.bool_]) -> float:
        return float(np.bincount(edges[chosen].ravel(), row_sum[chosen].ravel()).max(initial=0.0))

    limit = -_ZERO * bound(np.ones(len(edges), dtype=np.bool_))
    if unknowns <= _DENSE:
        found = np.linalg.eigvalsh(matrix.toarray())
        return float(np.sqrt(max(-found[0], 0.0))), int((found < limit).sum())
    count = int((_factors(matrix, limit).U.diagonal() < 0.0).sum())
    if count == 0:
        return 0.0, 0
    shift = -1.01 * bound(constants < 0.0)
    while shift / 4.0 < limit and _factors(matrix, shift / 4.0).U.diagonal().min() > 0.0:
        shift /= 4.0
    factors = _factors(matrix, shift)
    inverted = LinearOperator(matrix.shape, matvec=factors.solve, dtype=np.float64)
    start = np.random.default_rng(0).standard_normal(unknowns)
    lowest = eigsh(matrix, k=1, sigma=shift, OPinv=inverted, v0=start, tol=_TOLERANCE, return_eigenvectors=False)
    return float(np.sqrt(-lowest[0])), count


def _factors(matrix: Any, shift: float) -> Any:
    """L U = K - shift, without pivoting: as many pivots in U are negative as eigenvalues lie below."""
    from scipy.sparse import eye_array
    from scipy.sparse.linalg import splu

    return splu(
        (matrix - shift * eye_array(matrix.shape[0])).tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
