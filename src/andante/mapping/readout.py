"""From slow features to positions, with what is needed to say how sure that is.

The representation is not the readout: slow features say *which place*, references or a regression fitted on them say
*where*. ``local`` looks up the most similar references; ``polynomial`` is the thesis' global regression (5.2);
``gaussian-process`` interpolates smoothly and knows its variance.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from andante.data import FloatArray, IndexArray
from andante.errors import LearningError
from andante.mapping.codes import Codes
from andante.mapping.compact import products
from andante.mapping.config import ReadoutConfig
from andante.mapping.located import Hidden, Located, Readout, Witness, named_arrays
from andante.mapping.regressions import GaussianProcessReadout, PolynomialReadout
from andante.mapping.thinning import thinned_by_place

PRIOR_CAUTION = 30.0
"""Where nothing is known of other lights and seasons: interpolate only what looks as if mapped just now."""
_MEDIAN_SAMPLE = 200
SAME_SUPPORT = 1e-3
INTERPOLATED = 8
LEAST_PULL, _UNMOVED = 1e-3, 1e9
_BLOCK_ROWS = 256
_UNSEEN = np.float32(1e30)
"""Squared distance of a reference that is hidden: no image is as far from any."""


@dataclass(frozen=True, eq=False)
class LocalReadout:
    """The nearest references vote, and those around the winner are averaged.

    ``codes`` are r references, slow features times ``metric`` (k,); ``xy`` (r, 2) their positions and ``spread`` (r,)
    float32 the distances of their features from the average; ``typical`` is the median squared distance between them.
    """

    codes: Codes
    xy: FloatArray
    spread: NDArray[np.float32]
    metric: FloatArray
    typical: float
    neighbours: int
    sharpness: float
    consensus_m: float
    floor_m: float
    caution: float

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
        codes = Codes.of(np.asarray(slow * metric, dtype=np.float32))
        sample = codes.rows(np.linspace(0, len(codes) - 1, min(len(codes), _MEDIAN_SAMPLE)).astype(np.int64))
        typical = float(np.median(cdist(sample, sample, "sqeuclidean")))
        if typical <= 0:
            raise LearningError("all references look the same in slow-feature space; are the images all one picture?")
        neighbours = min(config.neighbours, len(codes))
        # Two references of one place are this far apart; no position can be told more finely.
        spacing = np.median(np.linalg.norm(np.diff(xy, axis=0), axis=1)) if len(xy) > 1 else 0.0
        floor_m = max(float(spacing), 0.02 * consensus_m)
        spread = np.full(len(xy), np.inf) if spread is None else spread
        around = spread.astype(np.float32)
        caution = PRIOR_CAUTION if config.caution is None else config.caution
        return cls(codes, xy, around, metric, typical, neighbours, config.sharpness, consensus_m, floor_m, caution)

    def locate(self, slow: FloatArray, witness: Witness | None = None, hidden: Hidden | None = None) -> Located:
        """(n, k) -> n positions; not finite for an image whose references are all hidden."""
        return Located.joined([self._locate(slow[rows], rows, witness, hidden) for rows in _blocks(len(slow))])

    def _locate(self, slow: FloatArray, rows: slice, witness: Witness | None, hidden: Hidden | None) -> Located:
        squared = self._squared_distances(slow)
        shown = squared
        if hidden is not None:
            shown = np.where(cdist(hidden.around[rows], self.xy) > hidden.radius, squared, _UNSEEN)
        nearest = _smallest(shown, self.neighbours)
        d2 = np.take_along_axis(shown, nearest, axis=1).astype(np.float64)
        # Where fewer are left than vote, the nearest one stands in for the others, which count for nothing.
        counts = d2 < _UNSEEN
        counts[:, 0] = True
        nearest = np.where(counts, nearest, nearest[:, :1])
        # How clearly each neighbour loses against the nearest one.
        best = np.maximum(d2[:, :1], 1e-9 * self.typical)
        votes = np.exp(-self.sharpness * (d2 / best - 1))
        positions = self.xy[nearest]
        if witness is not None:
            votes *= witness(rows, positions)
        votes /= votes.sum(axis=1, keepdims=True)
        apart = np.linalg.norm(positions[:, :, None] - positions[:, None], axis=-1)
        together = apart <= self.consensus_m
        support = np.where(together, votes[:, None], 0).sum(axis=2)
        # The nearest of those with as much support as any: rounding must not choose between them.
        winner = (support >= support.max(axis=1, keepdims=True) - SAME_SUPPORT).argmax(axis=1)
        chosen = together[np.arange(len(slow)), winner] & counts
        share = np.where(chosen, votes, 0)
        agreement = share.sum(axis=1)
        share = self._interpolated(slow, nearest[:, :INTERPOLATED], chosen, share / agreement[:, None], d2[:, 0])
        xy = np.einsum("nm,nmi->ni", share, positions)
        # All votes count for the spread, so that two places that look alike give a large one.
        offset = positions - xy[:, None]
        covariance = np.einsum("nm,nmi,nmj->nij", votes, offset, offset) + np.eye(2) * self.floor_m**2 / 2
        xy[d2[:, 0] >= _UNSEEN] = np.nan
        likeness = self._likeness(squared, d2[:, 0])
        spread = np.median(self.spread[nearest], axis=1).astype(np.float64)
        return Located(xy, covariance, likeness, agreement, positions, np.where(chosen, 0, votes), spread)

    def _interpolated(
        self, slow: FloatArray, nearest: NDArray[np.intp], chosen: NDArray[np.bool_], votes: FloatArray, d1: FloatArray
    ) -> FloatArray:
        """Weights (n, m) that place an image between its references instead of at the nearest one.

        The affine combination w of references r_i that comes closest to the image q, held near the votes v::

            min |q - sum w_i r_i|^2 + c |w - v|^2,   sum w_i = 1,   c = caution d1^2 / gap

        (locally linear, as Roweis and Saul 2000). What another light does to an image lies in all directions, so the
        larger its squared distance ``d1`` (n,) from the nearest reference is against those of the references from
        each other (gap), the less is interpolated.
        """
        few = nearest.shape[1]
        held, taken = votes[:, :few], chosen[:, :few]
        offset = self.references[nearest] - np.asarray(slow * self.metric, dtype=np.float32)[:, None]
        gram = np.asarray(offset @ offset.transpose(0, 2, 1), dtype=np.float64)
        own = np.einsum("nii->ni", gram)
        both = taken[:, :, None] & taken[:, None]
        pairs = both.sum(axis=(1, 2)) - taken.sum(axis=1)
        apart = np.where(both, own[:, :, None] + own[:, None] - 2 * gram, 0).sum(axis=(1, 2))
        gap = np.maximum(apart / np.maximum(pairs, 1), 1e-9 * self.typical)
        pull = np.maximum(self.caution * d1**2 / gap, LEAST_PULL * gap)
        # What was not chosen is held at its vote of zero.
        diagonal = np.where(taken, pull[:, None], _UNMOVED * (own + pull[:, None]))
        inverse = np.linalg.inv(gram + diagonal[:, :, None] * np.eye(few))
        free, ones = np.einsum("nij,nj->ni", inverse, pull[:, None] * held), inverse.sum(axis=2)
        weights = np.zeros_like(votes)
        weights[:, :few] = free + ones * ((1 - free.sum(axis=1)) / ones.sum(axis=1))[:, None]
        return np.where((pairs > 0)[:, None], weights, votes)

    @cached_property
    def references(self) -> NDArray[np.float32]:
        """(r, k) what an image is compared with."""
        return self.codes.rows()

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
        numbers = [self.typical, self.neighbours, self.sharpness, self.consensus_m, self.floor_m, self.caution]
        return {
            **self.codes.to_arrays(),
            "xy": self.xy,
            "spread": self.spread,
            "metric": self.metric,
            "numbers": np.array(numbers),
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> LocalReadout:
        """The inverse of ``to_arrays``."""
        xy, spread, metric, numbers = named_arrays(arrays, ("xy", "spread", "metric"), 6)
        typical, neighbours, sharpness, consensus_m, floor_m, caution = numbers.tolist()
        codes = Codes.from_arrays(arrays)
        return cls(codes, xy, spread, metric, typical, int(neighbours), sharpness, consensus_m, floor_m, caution)


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
