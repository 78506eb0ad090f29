"""From slow features to positions, with what is needed to say how sure that is.

The representation is not the readout: slow features say *which place*, references or a regression fitted on them say
*where*. ``local`` looks up the most similar references; ``polynomial`` is the thesis' global regression (5.2);
``gaussian-process`` interpolates smoothly and knows its variance.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import combinations_with_replacement
from math import comb
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import linalg
from scipy.spatial.distance import cdist

from andante.data import FloatArray, IndexArray
from andante.errors import ArrayError, LearningError
from andante.mapping.compact import products
from andante.mapping.config import ReadoutConfig
from andante.mapping.thinning import thinned_by_place
from andante.sfa.arrays import require_names

_GAUSSIAN_PROCESS_POINTS = 600
_MEDIAN_SAMPLE = 400
_BLOCK_ROWS = 256


@dataclass(frozen=True, eq=False)
class Located:
    """Positions for n images.

    ``xy`` (n, 2) in metres (or places), ``covariance`` (n, 2, 2) uncalibrated, ``likeness`` (n,) from 1 (looks
    just like a mapped place) to 0 (no more like the nearest reference than like any), ``agreement`` (n,) the share of
    the evidence that speaks for this position. ``candidates`` (n, m, 2), best first, with ``weights`` (n, m) are what
    else was considered; those that speak for ``xy`` weigh nothing here, so that weights and agreement sum to one.
    ``spread`` (n,) is how far from the average the features of the mapped images lie that these resemble, infinite
    where that is not known.
    """

    xy: FloatArray
    covariance: FloatArray
    likeness: FloatArray
    agreement: FloatArray
    candidates: FloatArray
    weights: FloatArray
    spread: FloatArray

    @classmethod
    def joined(cls, parts: Sequence[Located]) -> Located:
        """One after the other."""
        if len(parts) == 1:
            return parts[0]
        return cls(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(cls)))

    @property
    def sigma(self) -> FloatArray:
        """(n,) root of the covariance's trace: the expected distance to the truth, before calibration."""
        sigma: FloatArray = np.sqrt(np.trace(self.covariance, axis1=1, axis2=2))
        return sigma


class Readout(Protocol):
    """Slow features (n, k) -> positions."""

    def locate(self, slow: FloatArray) -> Located:
        """(n, k) -> n positions with their uncertainty."""
        ...

    def strangers(self, slow: FloatArray, xy: FloatArray, apart: float, spread: FloatArray | None = None) -> FloatArray:
        """Likeness (n,) that images (n, k) of places ``xy`` (n, 2) would have were these places not mapped.

        Everything within ``apart`` of the image's true place is ignored; ``spread`` (n,), where known, tempers the
        likeness as for an estimate (see ``tempered``). Empty for readouts that cannot.
        """
        ...

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Arrays by name, for a file."""
        ...


@dataclass(frozen=True, eq=False)
class LocalReadout:
    """The nearest references vote, and those around the winner are averaged.

    ``references`` (r, k) float32 are slow features times ``metric`` (k,); ``xy`` (r, 2) their positions and ``spread``
    (r,) the distances of their features from the average; ``typical`` is the median squared distance between them.
    """

    references: NDArray[np.float32]
    xy: FloatArray
    spread: FloatArray
    metric: FloatArray
    typical: float
    neighbours: int
    sharpness: float
    consensus_m: float
    floor_m: float

    @classmethod
    def fit(
        cls,
        slow: FloatArray,
        xy: FloatArray,
        metric: FloatArray,
        config: ReadoutConfig,
        consensus_m: float,
        *,
        spread: FloatArray | None = None,
    ) -> LocalReadout:
        """From slow features (n, k), positions (n, 2) and, where known, spread (n,) of the mapped frames."""
        references = np.ascontiguousarray(slow * metric, dtype=np.float32)
        sample = references[np.linspace(0, len(references) - 1, min(len(references), _MEDIAN_SAMPLE)).astype(int)]
        typical = float(np.median(cdist(sample, references, "sqeuclidean")))
        if typical <= 0:
            raise LearningError("all references look the same in slow-feature space; are the images all one picture?")
        neighbours = min(config.neighbours, len(references))
        # Two references of one place are this far apart; no position can be told more finely.
        spacing = np.median(np.linalg.norm(np.diff(xy, axis=0), axis=1)) if len(xy) > 1 else 0.0
        floor_m = max(float(spacing), 0.02 * consensus_m)
        spread = np.full(len(xy), np.inf) if spread is None else spread
        return cls(references, xy, spread, metric, typical, neighbours, config.sharpness, consensus_m, floor_m)

    def locate(self, slow: FloatArray) -> Located:
        """(n, k) -> n positions."""
        return Located.joined([self._locate(slow[rows]) for rows in _blocks(len(slow))])

    def _locate(self, slow: FloatArray) -> Located:
        squared = self._squared_distances(slow)
        nearest = _smallest(squared, self.neighbours)
        d2 = np.take_along_axis(squared, nearest, axis=1).astype(np.float64)
        # How clearly each neighbour loses against the nearest one.
        best = np.maximum(d2[:, :1], 1e-9 * self.typical)
        votes = np.exp(-self.sharpness * (d2 / best - 1))
        votes /= votes.sum(axis=1, keepdims=True)
        positions = self.xy[nearest]
        apart = np.linalg.norm(positions[:, :, None] - positions[:, None], axis=-1)
        together = apart <= self.consensus_m
        winner = np.where(together, votes[:, None], 0).sum(axis=2).argmax(axis=1)
        chosen = together[np.arange(len(slow)), winner]
        share = np.where(chosen, votes, 0)
        agreement = share.sum(axis=1)
        xy = np.einsum("nm,nmi->ni", share / agreement[:, None], positions)
        # All votes count for the spread, so that two places that look alike give a large one.
        offset = positions - xy[:, None]
        covariance = np.einsum("nm,nmi,nmj->nij", votes, offset, offset) + np.eye(2) * self.floor_m**2 / 2
        likeness = self._likeness(squared, d2[:, 0])
        spread = np.median(self.spread[nearest], axis=1)
        return Located(xy, covariance, likeness, agreement, positions, np.where(chosen, 0, votes), spread)

    def strangers(self, slow: FloatArray, xy: FloatArray, apart: float, spread: FloatArray | None = None) -> FloatArray:
        """The likeness of the best reference that lies elsewhere."""
        parts = []
        for rows in _blocks(len(slow)):
            squared = self._squared_distances(slow[rows])
            candidates = np.where(cdist(xy[rows], self.xy) > apart, squared, np.inf)
            elsewhere = candidates.min(axis=1)
            likeness = self._likeness(squared, elsewhere)
            if spread is not None:
                likeness = tempered(likeness, spread[rows], self.spread[candidates.argmin(axis=1)])
            parts.append(likeness[np.isfinite(elsewhere)])
        return np.concatenate(parts)

    @cached_property
    def _reference_norms(self) -> NDArray[np.float32]:
        return np.asarray((self.references**2).sum(axis=1), dtype=np.float32)

    def _squared_distances(self, slow: FloatArray) -> NDArray[np.float32]:
        """(n, r) by one product; the largest rounding error is far below the distance between two images."""
        queries = np.asarray(slow * self.metric, dtype=np.float32)
        squared = self._reference_norms - 2 * products(queries, self.references)
        squared += (queries**2).sum(axis=1)[:, None]
        return np.asarray(np.maximum(squared, 0, out=squared), dtype=np.float32)

    def _likeness(self, squared: NDArray[np.float32], best: NDArray[np.floating[Any]]) -> FloatArray:
        # Light and season move an image away from all references alike, and a foreign image is far from all.
        usual = np.maximum(np.median(squared, axis=1), np.finfo(np.float32).tiny)
        return np.asarray(np.clip(1 - best / usual, 0, 1), dtype=np.float64)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Arrays by name, for a file."""
        numbers = [self.typical, self.neighbours, self.sharpness, self.consensus_m, self.floor_m]
        return {
            "references": self.references,
            "xy": self.xy,
            "spread": self.spread,
            "metric": self.metric,
            "numbers": np.array(numbers),
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> LocalReadout:
        """The inverse of ``to_arrays``."""
        references, xy, spread, metric, numbers = _named(arrays, ("references", "xy", "spread", "metric"), 5)
        typical, neighbours, sharpness, consensus_m, floor_m = numbers.tolist()
        return cls(references, xy, spread, metric, typical, int(neighbours), sharpness, consensus_m, floor_m)


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

    def locate(self, slow: FloatArray) -> Located:
        """(n, k) -> n positions; likeness falls where the features leave the range they were learnt in."""
        terms = _monomials(slow[:, : self.inputs], self.degree)
        xy = terms @ self.coefficients
        # Unit variance is what the mapped frames have on average.
        likeness = 1 / np.maximum(1, (slow[:, : self.inputs] ** 2).mean(axis=1))
        covariance = self.residual[None] / likeness[:, None, None]
        return _without_rivals(xy, covariance, likeness)

    def strangers(self, slow: FloatArray, xy: FloatArray, apart: float, spread: FloatArray | None = None) -> FloatArray:
        """Nothing: a regression has no references to ignore."""
        return np.empty(0)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Arrays by name, for a file."""
        numbers = np.array([self.inputs, self.degree], dtype=np.int64)
        return {"coefficients": self.coefficients, "residual": self.residual, "numbers": numbers}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> PolynomialReadout:
        """The inverse of ``to_arrays``."""
        coefficients, residual, numbers = _named(arrays, ("coefficients", "residual"), 2)
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

    def locate(self, slow: FloatArray) -> Located:
        """(n, k) -> n positions; likeness is the share of the prior variance that the points explain."""
        cross = np.exp(-cdist(slow * self.metric, self.points, "sqeuclidean") / (2 * self.length**2))
        xy = cross @ self.dual + self.mean
        explained = (linalg.solve_triangular(self.factor, cross.T, lower=True) ** 2).sum(axis=0)
        unexplained = np.clip(1 - explained, 0, 1)
        variance = self.prior * (unexplained + self.noise)
        return _without_rivals(xy, variance[:, None, None] * np.eye(2), 1 - unexplained)

    def strangers(self, slow: FloatArray, xy: FloatArray, apart: float, spread: FloatArray | None = None) -> FloatArray:
        """Nothing: a regression has no references to ignore."""
        return np.empty(0)

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
        points, metric, dual, factor, mean, numbers = _named(arrays, ("points", "metric", "dual", "factor", "mean"), 3)
        length, noise, prior = numbers.tolist()
        return cls(points, metric, dual, factor, mean, length, noise, prior)


def _named(arrays: Mapping[str, NDArray[Any]], names: tuple[str, ...], count: int) -> list[NDArray[Any]]:
    """The arrays of these names, and ``numbers`` (count,); raises ``ArrayError`` where one is missing."""
    require_names(arrays, (*names, "numbers"), "this readout")
    if arrays["numbers"].shape != (count,):
        raise ArrayError(f"this readout has {count} numbers, got an array of shape {arrays['numbers'].shape}")
    return [arrays[name] for name in (*names, "numbers")]


def fit_readout(
    slow: FloatArray,
    xy: FloatArray,
    session: IndexArray,
    *,
    metric: FloatArray,
    config: ReadoutConfig,
    consensus_m: float,
    spread: FloatArray | None = None,
) -> Readout:
    """The configured readout of slow features (n, k), positions (n, 2), sessions (n,) and, where known, spread (n,)."""
    if config.kind == "polynomial":
        return PolynomialReadout.fit(slow, xy, config)
    if config.kind == "gaussian-process":
        return GaussianProcessReadout.fit(slow, xy, metric)
    kept = thinned_by_place(xy, session, config.max_references)
    around = None if spread is None else spread[kept]
    return LocalReadout.fit(slow[kept], xy[kept], metric, config, consensus_m, spread=around)


def tempered(likeness: FloatArray, spread: FloatArray, expected: FloatArray) -> FloatArray:
    """Likeness (n,) of images ``spread`` (n,) from the average, where mapped ones of their kind lie ``expected`` (n,).

    Slow features see only what varies along the mapped drives, and what is foreign can fall near some reference in
    their space. Likeness is a share of squared distance there; here it becomes one of the whole.
    """
    share: FloatArray = likeness / np.maximum(1.0, spread / expected) ** 2
    return share


def _without_rivals(xy: FloatArray, covariance: FloatArray, likeness: FloatArray) -> Located:
    """The answer of a regression, which considers no other place."""
    n = len(xy)
    nothing = np.empty((n, 0, 2)), np.empty((n, 0))
    return Located(xy, covariance, likeness, np.ones(n), *nothing, spread=np.full(n, np.inf))


def _blocks(n: int) -> list[slice]:
    """Rows to work on at a time, so that the distances to all references stay small in memory."""
    return [slice(start, start + _BLOCK_ROWS) for start in range(0, max(n, 1), _BLOCK_ROWS)]


def _smallest(values: NDArray[np.float32], count: int) -> NDArray[np.intp]:
    """Columns of the ``count`` smallest values of each row, ascending."""
    if count < values.shape[1]:
        columns = np.argpartition(values, count - 1, axis=1)[:, :count]
    else:
        columns = np.broadcast_to(np.arange(values.shape[1]), values.shape)
    order = np.argsort(np.take_along_axis(values, columns, axis=1), axis=1, kind="stable")
    return np.take_along_axis(columns, order, axis=1)


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
