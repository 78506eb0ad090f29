"""Linear regression from all features to the position: what a global map without places achieves."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from andante.baselines.baseline import Baseline
from andante.data import FloatArray
from andante.mapping import FrontEnd
from andante.mapping.slow_map import Unit
from andante.sfa import one_thread

_RIDGES = np.logspace(-6, 2, 17)
_RANK_TOLERANCE = 1e-10


@dataclass(frozen=True)
class RidgeRegression(Baseline):
    """xy = (features - mean) @ weights + offset with the ridge that leave-one-out errors are smallest for.

    ``mean`` (d,), ``weights`` (d, 2), ``offset`` (2,); ``ridge`` is absolute, in squared feature units.
    """

    mean: FloatArray = field(repr=False)
    weights: FloatArray = field(repr=False)
    offset: FloatArray = field(repr=False)
    ridge: float

    @classmethod
    def fit(cls, front_end: FrontEnd, unit: Unit, features: NDArray[np.float32], xy: FloatArray) -> Self:
        """From features (n, d) and positions (n, 2) by the closed form of PRESS (Golub, Heath, Wahba 1979)."""
        mean, offset = features.mean(axis=0, dtype=np.float64), xy.mean(axis=0)
        centred, targets = features - mean, xy - offset
        left, squared = _left_singular(centred)
        projected = left.T @ targets
        ridges = _RIDGES * squared.sum() / len(xy)
        ridge = min(ridges, key=lambda one: _leave_one_out(left, squared / (squared + one), projected, targets))
        weights = centred.T @ (left @ (projected / (squared + ridge)[:, None]))
        return cls(front_end, unit, mean, weights, offset, float(ridge))

    @property
    def name(self) -> str:
        """The name in tables."""
        return "ridge regression"

    @property
    def bytes(self) -> int:
        """What has to be kept for localizing."""
        return self.mean.nbytes + self.weights.nbytes + self.offset.nbytes

    def position(self, features: NDArray[np.float32]) -> FloatArray:
        """(d,) -> (2,)."""
        xy: FloatArray = (features - self.mean) @ self.weights + self.offset
        return xy


def _left_singular(centred: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Left singular vectors (n, r) and squared singular values (r,), from the smaller of the two Gram matrices."""
    n, dim = centred.shape
    with one_thread():
        squared, vectors = linalg.eigh(centred @ centred.T if n <= dim else centred.T @ centred)
    kept = squared > _RANK_TOLERANCE * squared.max()
    squared, vectors = squared[kept], vectors[:, kept]
    return (vectors if n <= dim else centred @ vectors / np.sqrt(squared)), squared


def _leave_one_out(left: FloatArray, shrink: FloatArray, projected: FloatArray, targets: FloatArray) -> float:
    """Mean squared error of every frame under the regression learnt without it."""
    residual = targets - left @ (shrink[:, None] * projected)
    # The mean is learnt too and has a leverage of 1 / n.
    leverage = (left**2) @ shrink + 1 / len(targets)
    return float(((residual / np.maximum(1 - leverage, 1e-9)[:, None]) ** 2).mean())
