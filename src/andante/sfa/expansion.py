"""The quadratic expansion: every signal, then every product of two.

Order of the d + d(d+1)/2 terms of d signals: x0, x1, ... x(d-1), then x0*x0, x0*x1, ... x0*x(d-1), x1*x1, x1*x2, ...
so 20 signals make 230 terms (thesis 5.1.1). A linear function of the terms is any polynomial of degree two without
its constant.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from andante.data import FloatArray, IndexArray
from andante.sfa.arrays import Matrix


def expanded_dim(dim: int) -> int:
    """Number of terms of ``dim`` signals."""
    return dim + dim * (dim + 1) // 2


def expand_quadratic(x: Matrix) -> FloatArray:
    """(n, d) -> (n, d + d(d+1)/2) float64, in the order of ``term_names``."""
    x = np.asarray(x, dtype=np.float64)
    dim = x.shape[1]
    left, right = _pairs(dim)
    terms = np.empty((len(x), expanded_dim(dim)))
    terms[:, :dim] = x
    np.multiply(x[:, left], x[:, right], out=terms[:, dim:])
    return terms


def term_names(dim: int) -> list[str]:
    """The terms in order, such as ``x0``, ``x1``, ``x0*x0``, ``x0*x1``, ``x1*x1``."""
    left, right = _pairs(dim)
    products = [f"x{i}*x{j}" for i, j in zip(left, right, strict=True)]
    return [f"x{i}" for i in range(dim)] + products


@cache
def _pairs(dim: int) -> tuple[IndexArray, IndexArray]:
    left, right = np.triu_indices(dim)
    left.setflags(write=False)
    right.setflags(write=False)
    return left, right
