"""One position from several landmarks that each know one: by inverse error, and by covariance with correlated errors.

Landmarks are seen in one image, in one light, at one place; what misleads one often misleads the next. Let errors
:math:`e_i` have covariances :math:`C_i` and let any two, each in units of its own deviation, have correlation rho. Then

.. math::  P = (1 + (m - 1) rho) (sum_i C_i^-1)^-1,   x = (sum_i C_i^-1)^-1 sum_i C_i^-1 x_i

is never more certain than the truth, because sum over pairs of a_i a_j is at most (m - 1) sum of a_i², and exact where
all are equally good. Rho 0 is the product of independent Gaussians, rho 1 covariance intersection with equal weights
(Julier and Uhlmann 1997), which is right whatever the correlation.
"""

from __future__ import annotations

import numpy as np

from andante.data import FloatArray
from andante.errors import ArrayError

_MOST_WHITE = 3.0
"""Errors in deviations beyond this are mistakes, which say nothing of how honest ones go together."""


def by_inverse_error(xy: FloatArray, error_m: FloatArray) -> FloatArray:
    """Weighted mean (2,) of positions (m, 2), weights being the inverse of each landmark's usual error (thesis 7.3.3).

    Raises ``ArrayError`` for no position, or an error that is not above zero.
    """
    xy, error_m = _positions(xy), np.asarray(error_m, np.float64)
    if error_m.shape != xy.shape[:1] or not (error_m > 0).all():
        raise ArrayError(f"{len(xy)} positions need as many errors in metres above zero, got {error_m.tolist()}")
    return np.asarray(np.average(xy, axis=0, weights=1.0 / error_m), np.float64)


def by_covariance(xy: FloatArray, covariance: FloatArray, correlation: float = 0.0) -> tuple[FloatArray, FloatArray]:
    """Mean (2,) and covariance (2, 2) of positions (m, 2) with covariances (m, 2, 2) whose errors are correlated.

    Raises ``ArrayError`` for no position, other shapes, or a correlation outside of [0, 1].
    """
    xy, covariance = _positions(xy), np.asarray(covariance, np.float64)
    if covariance.shape != (len(xy), 2, 2):
        raise ArrayError(f"{len(xy)} positions need covariances ({len(xy)}, 2, 2), got shape {covariance.shape}")
    if not 0.0 <= correlation <= 1.0:
        raise ArrayError(f"a correlation of errors is from 0 to 1, got {correlation}")
    information = np.linalg.inv(covariance)
    total = np.linalg.inv(information.sum(axis=0))
    mean: FloatArray = total @ np.einsum("mij,mj->i", information, xy)
    return mean, total * inflation(len(xy), correlation)


def inflation(count: int, correlation: float) -> float:
    """How much larger the covariance of ``count`` fused landmarks is than if their errors were independent."""
    return 1.0 + (count - 1) * correlation


def correlation_of(white: FloatArray) -> float:
    """Correlation in [0, 1] of errors (n, m, 2) in units of their deviations, NaN where a landmark was not seen.

    The mean product of any two landmarks in one image, both axes together; 0 where no two were ever seen at once.
    """
    white = np.clip(white, -_MOST_WHITE, _MOST_WHITE)
    seen = np.asarray(np.isfinite(white).all(axis=2))
    filled = np.where(seen[:, :, None], white, 0.0)
    together = (filled.sum(axis=1) ** 2).sum() - (filled**2).sum()
    pairs = 2.0 * float((seen.sum(axis=1) ** 2 - seen.sum(axis=1)).sum())
    variance = float((filled**2).sum()) / max(2.0 * float(seen.sum()), 1.0)
    if pairs == 0 or variance == 0:
        return 0.0
    return float(np.clip(together / pairs / variance, 0.0, 1.0))


def _positions(xy: FloatArray) -> FloatArray:
    xy = np.asarray(xy, np.float64)
    if xy.ndim != 2 or xy.shape[1:] != (2,) or not len(xy):
        raise ArrayError(f"positions to fuse have shape (m, 2) with at least one row, got {xy.shape}")
    return xy
