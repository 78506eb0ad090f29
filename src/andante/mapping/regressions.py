"""Readouts that fit one function to the whole map: a polynomial, a Gaussian process."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations_with_replacement
from math import comb
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg
from scipy.spatial.distance import cdist

from andante.data import FloatArray
from andante.errors import LearningError
from andante.mapping.config import ReadoutConfig
from andante.mapping.located import Hidden, Located, Witness, named_arrays

_GAUSSIAN_PROCESS_POINTS = 600


@dataclass(frozen=True, eq=False)
class PolynomialReadout:
    """One polynomial of the slowest features for the whole garden: the thesis' regression (5.2)."""

    coefficients: FloatArray
    residual: FloatArray
    inputs: int
    degree: int

    @property
    def terms(self) -> int:
        """Number of monomials of up to ``degree`` in ``inputs`` variables."""
        return comb(self.inputs + self.degree, self.degree)

    @classmethod
    def fit(cls, slow: FloatArray, xy: FloatArray, config: ReadoutConfig) -> PolynomialReadout:
        """Least squares on slow features (n, k) and positions (n, 2)."""
        inputs = min(config.inputs, slow.shape[1])
        count = comb(inputs + config.degree, config.degree)
        # Before they are made: there may be millions of them.
        if len(slow) <= count:
            raise LearningError(
                f"a polynomial of degree {config.degree} in {inputs} slow features has {count} terms, "
                f"but there are {len(slow)} frames; lower readout.inputs or readout.degree"
            )
        terms = _monomials(slow[:, :inputs], config.degree)
        coefficients = linalg.lstsq(terms, xy)[0]
        offset = xy - terms @ coefficients
        residual = offset.T @ offset / (len(terms) - terms.shape[1])
        return cls(np.ascontiguousarray(coefficients), residual, inputs, config.degree)

    def locate(self, slow: FloatArray, witness: Witness | None = None, hidden: Hidden | None = None) -> Located:
        """(n, k) -> n positions; likeness falls where the features leave the range they were learnt in."""
        terms = _monomials(slow[:, : self.inputs], self.degree)
        xy = terms @ self.coefficients
        # Unit variance is what the mapped frames have on average.
        likeness = 1 / np.maximum(1, (slow[:, : self.inputs] ** 2).mean(axis=1))
        covariance = self.residual[None] / likeness[:, None, None]
        return _without_rivals(xy, covariance, likeness)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Arrays by name, for a file."""
        numbers = np.array([self.inputs, self.degree], dtype=np.int64)
        return {"coefficients": self.coefficients, "residual": self.residual, "numbers": numbers}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> PolynomialReadout:
        """The inverse of ``to_arrays``."""
        coefficients, residual, numbers = named_arrays(arrays, ("coefficients", "residual"), 2)
        inputs, degree = numbers.tolist()
        return cls(coefficients, residual, int(inputs), int(degree))


@dataclass(frozen=True, eq=False)
class GaussianProcessReadout:
    """A Gaussian process from slow features to positions, with its own variance (Rasmussen and Williams 2006, 2.2).

    ``points`` (m, k) are slow features times ``metric`` (k,), ``dual`` (m, 2) the weights of the mean, ``factor``
    (m, m) the Cholesky factor of the kernel matrix, ``prior`` the variance of positions far from all points.
    """

    points: FloatArray
    metric: FloatArray
    dual: FloatArray
    factor: FloatArray
    mean: FloatArray
    length: float
    noise: float
    prior: float

    @classmethod
    def fit(cls, slow: FloatArray, xy: FloatArray, metric: FloatArray) -> GaussianProcessReadout:
        """Length and noise by marginal likelihood on at most 600 frames spread evenly."""
        chosen = np.linspace(0, len(slow) - 1, min(len(slow), _GAUSSIAN_PROCESS_POINTS)).astype(int)
        points, mean = slow[chosen] * metric, xy.mean(axis=0)
        centred = xy[chosen] - mean
        squared = cdist(points, points, "sqeuclidean")
        typical = float(np.median(squared))
        prior = float(centred.var(axis=0).mean())
        if typical <= 0 or prior <= 0:
            raise LearningError("a Gaussian process needs frames at different places that look different")
        grid = [(np.sqrt(typical * s), n) for s in (0.1, 0.3, 1.0, 3.0) for n in (1e-4, 1e-3, 1e-2, 1e-1)]
        length, noise = max(grid, key=lambda one: _evidence(squared, centred / np.sqrt(prior), *one))
        # Row by row, as a file holds them: another order in memory rounds differently.
        factor = np.ascontiguousarray(linalg.cholesky(_kernel(squared, length, noise), lower=True))
        dual = np.ascontiguousarray(linalg.cho_solve((factor, True), centred))
        return cls(points, metric, dual, factor, mean, float(length), float(noise), prior)

    def locate(self, slow: FloatArray, witness: Witness | None = None, hidden: Hidden | None = None) -> Located:
        """(n, k) -> n positions; likeness is the share of the prior variance that the points explain."""
        cross = self._cross(slow)
        xy = cross @ self.dual + self.mean
        explained = (linalg.solve_triangular(self.factor, cross.T, lower=True) ** 2).sum(axis=0)
        unexplained = np.clip(1 - explained, 0, 1)
        variance = self.prior * (unexplained + self.noise)
        return _without_rivals(xy, variance[:, None, None] * np.eye(2), 1 - unexplained)

    def position(self, slow: FloatArray) -> FloatArray:
        """(n, k) -> positions (n, 2) alone, at a fraction of the time."""
        xy: FloatArray = self._cross(slow) @ self.dual + self.mean
        return xy

    def _cross(self, slow: FloatArray) -> FloatArray:
        """Kernel (n, m) between slow features and points."""
        cross: FloatArray = np.exp(-cdist(slow * self.metric, self.points, "sqeuclidean") / (2 * self.length**2))
        return cross

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Arrays by name, for a file."""
        return {
            "points": self.points,
            "metric": self.metric,
            "dual": self.dual,
            "factor": self.factor,
            "mean": self.mean,
            "numbers": np.array([self.length, self.noise, self.prior]),
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> GaussianProcessReadout:
        """The inverse of ``to_arrays``."""
        points, metric, dual, factor, mean, numbers = named_arrays(
            arrays, ("points", "metric", "dual", "factor", "mean"), 3
        )
        length, noise, prior = numbers.tolist()
        return cls(points, metric, dual, factor, mean, length, noise, prior)


def _without_rivals(xy: FloatArray, covariance: FloatArray, likeness: FloatArray) -> Located:
    """The answer of a regression, which considers no other place."""
    n = len(xy)
    nothing = np.empty((n, 0, 2)), np.empty((n, 0))
    return Located(xy, covariance, likeness, np.ones(n), *nothing, spread=np.full(n, np.inf))


def _monomials(x: FloatArray, degree: int) -> FloatArray:
    """All products of up to ``degree`` columns, the constant first: (n, k) -> (n, terms)."""
    columns = [np.ones(len(x))]
    for power in range(1, degree + 1):
        columns += [np.prod(x[:, list(c)], axis=1) for c in combinations_with_replacement(range(x.shape[1]), power)]
    return np.stack(columns, axis=1)


def _kernel(squared: FloatArray, length: float, noise: float) -> FloatArray:
    kernel: FloatArray = np.exp(-squared / (2 * length**2)) + (noise + 1e-9) * np.eye(len(squared))
    return kernel


def _evidence(squared: FloatArray, targets: FloatArray, length: float, noise: float) -> float:
    """Log marginal likelihood up to a constant, summed over x and y."""
    factor = linalg.cholesky(_kernel(squared, length, noise), lower=True)
    white = linalg.solve_triangular(factor, targets, lower=True)
    return float(-0.5 * (white**2).sum() - targets.shape[1] * np.log(np.diag(factor)).sum())
