"""Small symmetric eigenproblems: threads, signs and the numerical range of a covariance.

Shared by principal components and slow features, so that both cut ranks and choose signs by one rule.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg as sl

from andante.data import FloatArray
from andante.sfa.threads import one_thread

RANK_TOLERANCE = 1e-10
"""Directions with less than this share of the largest variance count as empty, unless a caller says otherwise."""

_SIGN_TIE = 1e-6


def largest(symmetric: FloatArray, k: int) -> tuple[FloatArray, FloatArray]:
    """The k largest eigenvalues, descending, and their eigenvectors in the columns of (d, k)."""
    dim = len(symmetric)
    with one_thread():
        if 2 * k >= dim:
            values, vectors = sl.eigh(symmetric, driver="evd")
        else:
            values, vectors = sl.eigh(symmetric, subset_by_index=(dim - k, dim - 1), driver="evr")
    return values[::-1][:k], vectors[:, ::-1][:, :k]


def slowest(a: FloatArray, b: FloatArray, k: int) -> tuple[FloatArray, FloatArray]:
    """The k smallest solutions of a w = lambda b w, ascending, b positive definite; w^T b w = 1."""
    with one_thread():
        values, vectors = sl.eigh(a, b, subset_by_index=(0, k - 1), driver="gvx")
    return values, vectors


def numerical_range(covariance: FloatArray, tolerance: float) -> FloatArray | None:
    """An orthonormal basis (d, r) of the directions whose variance exceeds ``tolerance`` x the largest.

    ``None`` says that all d directions do. A Cholesky factor and its condition estimate settle the common case of full
    rank in a fraction of the time of an eigendecomposition.
    """
    with one_thread():
        if _well_conditioned(covariance, tolerance):
            return None
        values, vectors = sl.eigh(covariance, driver="evd")
    kept = values > tolerance * max(values[-1], 0.0)
    return None if kept.all() else np.ascontiguousarray(vectors[:, kept])


def _well_conditioned(covariance: FloatArray, tolerance: float) -> bool:
    factor, failed = sl.lapack.dpotrf(covariance, lower=1)
    if failed:
        return False
    norm = np.abs(covariance).sum(axis=0).max()
    reciprocal_condition, _ = sl.lapack.dpocon(factor, norm, uplo="L")
    # In the 1-norm, which bounds the ratio of eigenvalues from the safe side; the estimate may be 3 times too good.
    return bool(reciprocal_condition > 10 * tolerance)


def sign_of_columns(vectors: FloatArray) -> FloatArray:
    """(k,) +1 or -1 for the columns of (d, k), such that their entry of largest magnitude becomes positive.

    Of entries that tie up to rounding the first decides, so that equal data gives equal signs on every machine.
    """
    magnitude = np.abs(vectors)
    decisive = (magnitude >= (1 - _SIGN_TIE) * magnitude.max(axis=0)).argmax(axis=0)
    return np.where(vectors[decisive, np.arange(vectors.shape[1])] < 0, -1.0, 1.0)
