"""Everything that slow feature analysis needs to know of the data: two matrices and a mean.

Slow features are learnt from the covariance of the samples and from the mean outer product of differences along
weighted edges between samples (Escalante-B. and Wiskott, JMLR 14, 2013; in the plain case an edge joins each sample
with the next one). ``Moments`` accumulates both in float64 around the running mean, so that float32 data far
from zero loses no digits, and two of them merge exactly: one pass, any chunking, parts learnt on different
machines or in different years all give the same matrices.

>>> x = np.sin(np.arange(300.0)[:, None] * [0.01, 0.3])
>>> parts = Moments.of(x[:100]).merge(Moments.of(x[100:]))
>>> bool(np.allclose(parts.covariance, Moments.of(x).covariance))
True
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from andante.data import Edges, FloatArray
from andante.errors import ArrayError, LearningError
from andante.sfa.arrays import Matrix, require_columns, require_finite

_BLOCK_VALUES = 1 << 21
"""Values widened to float64 at a time: 16 MB, whatever the length of the recording."""


@dataclass(slots=True, eq=False)
class Moments:
    """Centred second moments of samples and of differences along edges, d = ``dim``.

    ``count`` is the sum of sample weights, ``mean`` (d,) their weighted mean, ``scatter`` (d, d) the weighted sum of
    centred outer products. ``edge_count`` is the sum of edge weights and ``edge_scatter`` (d, d) the weighted
    sum of outer products of differences. ``n_samples`` and ``n_edges`` count rows and pairs.
    """

    count: float
    mean: FloatArray
    scatter: FloatArray
    edge_count: float
    edge_scatter: FloatArray
    n_samples: int
    n_edges: int

    @classmethod
    def empty(cls, dim: int) -> Self:
        """No data yet, of ``dim`` signals."""
        return cls(0.0, np.zeros(dim), np.zeros((dim, dim)), 0.0, np.zeros((dim, dim)), 0, 0)

    @classmethod
    def of(cls, x: Matrix, edges: Edges | None = None, sample_weight: FloatArray | None = None) -> Self:
        """The moments of samples ``x`` (n, d), optionally weighted (n,), and of the edges between them."""
        moments = cls.empty(x.shape[1])
        moments.add_samples(x, sample_weight)
        if edges is not None:
            moments.add_edges(x, edges)
        return moments

    @property
    def dim(self) -> int:
        """Number of signals d."""
        return len(self.mean)

    @property
    def covariance(self) -> FloatArray:
        """(d, d) weighted covariance of the samples, normalised by the sum of weights."""
        if self.count <= 0:
            raise LearningError("there is no covariance of 0 samples: add samples first")
        return self.scatter / self.count

    @property
    def edge_covariance(self) -> FloatArray:
        """(d, d) weighted mean of (x_j - x_i)(x_j - x_i)^T over all edges."""
        if self.edge_count <= 0:
            raise LearningError("there are no edges, so nothing says which samples ought to be alike: add edges first")
        return self.edge_scatter / self.edge_count

    def add_samples(self, x: Matrix, sample_weight: FloatArray | None = None) -> None:
        """Take in samples ``x`` (n, d) with weights (n,), one each where absent; raises ``ArrayError``."""
        require_columns(x, self.dim, "Moments")
        require_finite(x)
        weight = None if sample_weight is None else _checked_weight(sample_weight, len(x))
        for rows in _blocks(len(x), self.dim):
            self._add_block(x[rows], None if weight is None else weight[rows])
        self.n_samples += len(x)

    def add_differences(self, dx: Matrix, weight: FloatArray | None = None) -> None:
        """Take in differences along edges ``dx`` (m, d) with weights (m,), one each where absent."""
        require_columns(dx, self.dim, "Moments")
        require_finite(dx)
        weight = np.ones(len(dx)) if weight is None else _checked_weight(weight, len(dx))
        for rows in _blocks(len(dx), self.dim):
            weighted = dx[rows].astype(np.float64) * np.sqrt(weight[rows])[:, None]
            self.edge_scatter += _gram(weighted)
        self._count_edges(weight)

    def add_edges(self, x: Matrix, edges: Edges) -> None:
        """Take in the differences of ``x`` (n, d) along ``edges``, whose samples have been added or will be.

        Few edges are differenced one by one. Many are summed as X^T L X with the graph Laplacian L of the edges,
        which costs as much as a covariance however many edges there are.
        """
        require_columns(x, self.dim, "Moments")
        if len(edges) == 0:
            return
        weight = _checked_weight(edges.weight, len(edges))
        low, high = min(edges.first.min(), edges.second.min()), max(edges.first.max(), edges.second.max())
        if low < 0 or high >= len(x):
            raise ArrayError(f"edges join samples {low}..{high}, but there are samples 0..{len(x) - 1}")
        require_finite(x)
        if len(edges) <= 2 * len(x):
            for rows in _blocks(len(edges), self.dim):
                dx: FloatArray = x[edges.second[rows]].astype(np.float64) - x[edges.first[rows]]
                self.edge_scatter += _gram(dx * np.sqrt(weight[rows])[:, None])
        else:
            self.edge_scatter += _laplacian_scatter(x, edges, weight)
        self._count_edges(weight)

    def add_series(self, x: Matrix) -> None:
        """Take in one unbroken time series ``x`` (n, d): its samples, and an edge from each to the next."""
        self.add_samples(x)
        self.add_edges(x, Edges.between(np.arange(len(x) - 1), np.arange(1, len(x))))

    def merge(self, other: Moments) -> Moments:
        """The moments of both data sets together; neither operand changes (Chan, Golub and LeVeque 1979)."""
        if self.dim != other.dim:
            raise ArrayError(f"moments of {self.dim} and of {other.dim} signals cannot be merged")
        merged = self.copy()
        merged._merge_samples(other.count, other.mean, other.scatter)
        merged.n_samples += other.n_samples
        merged.edge_scatter += other.edge_scatter
        merged.edge_count += other.edge_count
        merged.n_edges += other.n_edges
        return merged

    def projected(self, basis: FloatArray, origin: FloatArray | None = None) -> Moments:
        """The moments of (x - origin) @ basis without seeing x again; the origin (d,) is the mean where absent.

        ``basis`` is (d, k); the result has k signals and equals, up to rounding, what the projected samples give.
        """
        offset = np.zeros(self.dim) if origin is None else self.mean - origin
        return Moments(
            self.count,
            offset @ basis,
            _symmetric(basis.T @ self.scatter @ basis),
            self.edge_count,
            _symmetric(basis.T @ self.edge_scatter @ basis),
            self.n_samples,
            self.n_edges,
        )

    def copy(self) -> Moments:
        """An independent copy, to go on accumulating without touching the original."""
        return Moments(
            self.count,
            self.mean.copy(),
            self.scatter.copy(),
            self.edge_count,
            self.edge_scatter.copy(),
            self.n_samples,
            self.n_edges,
        )

    def _add_block(self, x: Matrix, weight: FloatArray | None) -> None:
        # Relative to its first row a signal that never changes is exactly zero, at any distance from zero.
        start = x[0].astype(np.float64)
        block = x - start
        if weight is None:
            mean = block.mean(axis=0)
            block -= mean
            self._merge_samples(float(len(block)), start + mean, _gram(block))
        elif (total := float(weight.sum())) > 0:
            mean = weight @ block / total
            block -= mean
            self._merge_samples(total, start + mean, _gram(block * np.sqrt(weight)[:, None]))

    def _merge_samples(self, count: float, mean: FloatArray, scatter: FloatArray) -> None:
        total = self.count + count
        if total == 0:
            return
        gap = mean - self.mean
        self.scatter += scatter
        self.scatter += np.outer(gap, gap) * (self.count * count / total)
        self.mean = self.mean + gap * (count / total)
        self.count = total

    def _count_edges(self, weight: FloatArray) -> None:
        self.edge_count += float(weight.sum())
        self.n_edges += len(weight)


def _laplacian_scatter(x: Matrix, edges: Edges, weight: FloatArray) -> FloatArray:
    """(d, d) sum of w_ij (x_j - x_i)(x_j - x_i)^T as X^T (D - W) X."""
    nodes, ends = np.unique(np.concatenate([edges.first, edges.second]), return_inverse=True)
    first, second = np.split(ends, 2)
    adjacency = sp.coo_array((weight, (first, second)), shape=(len(nodes), len(nodes))).tocsr()
    adjacency = adjacency + adjacency.T
    degree: FloatArray = np.asarray(adjacency.sum(axis=1))
    centred = x[nodes].astype(np.float64)
    # Differences do not feel an offset, but the cancellation inside L X does.
    centred -= centred.mean(axis=0)
    return _symmetric(centred.T @ (degree[:, None] * centred - adjacency @ centred))


def _gram(a: FloatArray) -> FloatArray:
    """a^T a, of which BLAS computes one half (syrk)."""
    gram: FloatArray = a.T @ a
    return gram


def _symmetric(a: FloatArray) -> FloatArray:
    """``a`` without the rounding that makes it unsymmetric."""
    symmetric: FloatArray = (a + a.T) / 2
    return symmetric


def _blocks(rows: int, dim: int) -> Iterator[slice]:
    """Slices over ``rows`` rows that keep temporary arrays small."""
    step = max(1, _BLOCK_VALUES // max(1, dim))
    return (slice(start, start + step) for start in range(0, rows, step))


def _checked_weight(weight: FloatArray, length: int) -> NDArray[np.float64]:
    weight = np.asarray(weight, dtype=np.float64)
    if weight.shape != (length,) or not (np.isfinite(weight).all() and (weight >= 0).all()):
        raise ArrayError(f"weights have to be {length} finite numbers >= 0, got an array of shape {weight.shape}")
    return weight
