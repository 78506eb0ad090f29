"""From moments to slow features: one generalised eigenproblem.

With the covariance C and the mean outer product E of differences along edges, slow features solve

    E w = delta C w,    w^T C w = 1

for the smallest deltas (thesis 3.2 and 3.3; Escalante-B. and Wiskott, JMLR 14, 2013 for weighted edges). The outputs
(x - mean) @ w then have zero mean and unit variance, are decorrelated, and vary along edges by delta in the mean
square: 0 for a constant, 2 for white noise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from andante.data import FloatArray, IndexArray
from andante.errors import ConfigError, LearningError
from andante.sfa.eigen import RANK_TOLERANCE, numerical_range, sign_of_columns, slowest
from andante.sfa.model import AffineModel
from andante.sfa.moments import Moments


def solve_slow(
    moments: Moments,
    n_components: int | None = None,
    *,
    ridge: float = 0.0,
    edge_ridge: float = 0.0,
    rank_tolerance: float = RANK_TOLERANCE,
    trembling: float = 0.0,
) -> AffineModel:
    """The ``n_components`` slowest linear features of data with these moments, all that exist where ``None``.

    Rank: signals are brought to unit variance, then directions with less than ``rank_tolerance`` of the largest
    variance are left out, as rounding alone decides what happens there. The units of a signal do not matter, unless
    ``trembling`` says that they do: signals that deviate by less than this share of the largest deviation are constants
    that tremble, as those that were computed in single precision from the same numbers.

    Ridge: learning behaves as if every sample carried white noise of ``ridge`` times the mean eigenvalue of C, that
    is C + r I and E + 2 r I. Directions of little variance then look fast, as noise does, instead of fitting the
    edges by chance. The outputs are rescaled to unit variance on the training statistics, and the deltas are those
    of the outputs as they are, without the noise. With a ridge the outputs are only nearly decorrelated, and
    their order is that of the noisy problem.

    Edge ridge: learning expects white noise of ``edge_ridge`` times the mean eigenvalue of E between the two ends of
    every edge, beyond what the edges show: E + q I, with C as it is. It stands for the conditions that no recording has
    seen; as it grows, the features become principal components. Deltas are again reported without it.

    Raises ``ConfigError`` for a count or ridge out of range, ``LearningError`` where there are no samples, no edges or
    fewer dimensions than features.
    """
    if n_components is not None and n_components < 1:
        raise ConfigError(f"n_components={n_components}: ask for at least one slow feature, or None for all")
    for name, value in (("ridge", ridge), ("edge_ridge", edge_ridge)):
        if not 0 <= value < np.inf:
            raise ConfigError(f"{name}={value}: has to be a finite number >= 0, in units of the mean variance")
    if not 0 <= rank_tolerance < 1:
        raise ConfigError(f"rank_tolerance={rank_tolerance}: has to be in [0, 1), a share of the largest variance")
    if moments.n_samples < 2:
        raise LearningError(f"n_samples={moments.n_samples}: slow features need at least 2 samples that differ")
    covariance, edge_covariance = moments.covariance, moments.edge_covariance
    space = _Space.of(moments, rank_tolerance, trembling)
    k = space.rank if n_components is None else n_components
    if k > space.rank or space.rank == 0:
        raise LearningError(_too_few_dimensions(moments, max(k, 1), space.rank, rank_tolerance))
    noise = ridge * float(np.trace(covariance)) / moments.dim
    edge_noise = edge_ridge * float(np.trace(edge_covariance)) / moments.dim
    a, b = space.inside(edge_covariance), space.inside(covariance)
    if noise > 0 or edge_noise > 0:
        white = space.inside(np.eye(moments.dim))
        a, b = a + (2 * noise + edge_noise) * white, b + noise * white
    _, vectors = slowest(a, b, k)
    weights = space.outside(vectors)
    variance = np.einsum("ij,ij->j", weights, covariance @ weights)
    weights *= sign_of_columns(weights) / np.sqrt(variance)
    deltas = np.einsum("ij,ij->j", weights, edge_covariance @ weights)
    return AffineModel(moments.mean.copy(), weights, deltas, space.rank, rank_tolerance)


@dataclass(frozen=True, slots=True, eq=False)
class _Space:
    """The directions in which there is variance.

    ``live`` (l,) indexes the signals that vary. At full rank ``basis`` is ``None`` and ``scale`` (l,) brings them to
    unit variance; else ``basis`` (l, r) spans the directions that the samples fill, and ``scale`` is one.
    """

    dim: int
    live: IndexArray
    scale: FloatArray
    basis: FloatArray | None

    @classmethod
    def of(cls, moments: Moments, tolerance: float, trembling: float) -> _Space:
        covariance = moments.covariance
        variance = covariance.diagonal()
        # A signal computed in floating point may tremble in its last digits: that is not variance.
        rounding = (8 * np.finfo(np.float64).eps * moments.mean) ** 2
        live = np.flatnonzero(variance > np.maximum(rounding, trembling**2 * variance.max(initial=0.0)))
        scale = np.sqrt(variance[live])
        if len(live) == 0:
            return cls(moments.dim, live, scale, None)
        correlation = covariance[np.ix_(live, live)] / np.outer(scale, scale)
        basis = numerical_range(correlation, tolerance)
        if basis is None:
            return cls(moments.dim, live, scale, None)
        # Samples span only part of the space, and any weights off that part fit them equally well. The smallest
        # weights on the signals as they are do best on new samples; scaled ones would listen to the weakest signals.
        span, _ = np.linalg.qr(scale[:, None] * basis)
        return cls(moments.dim, live, np.ones(len(live)), span)

    @property
    def rank(self) -> int:
        """Number of directions r."""
        return len(self.live) if self.basis is None else self.basis.shape[1]

    def inside(self, matrix: FloatArray) -> FloatArray:
        """A symmetric (d, d) form in the coordinates of this space, (r, r)."""
        scaled: FloatArray = matrix[np.ix_(self.live, self.live)] / np.outer(self.scale, self.scale)
        return scaled if self.basis is None else self.basis.T @ scaled @ self.basis

    def outside(self, vectors: FloatArray) -> FloatArray:
        """Weights (d, k) on the signals for weights (r, k) in this space."""
        inner = vectors if self.basis is None else self.basis @ vectors
        weights = np.zeros((self.dim, vectors.shape[1]))
        weights[self.live] = inner / self.scale[:, None]
        return weights


def _too_few_dimensions(moments: Moments, asked: int, rank: int, tolerance: float) -> str:
    if rank == 0:
        return (
            f"cannot learn slow features: none of the {moments.dim} signals varies over the "
            f"{moments.n_samples} samples; hand in data that changes"
        )
    return (
        f"cannot learn {asked} slow features: {moments.n_samples} samples of {moments.dim} signals vary in only {rank} "
        f"directions by more than {tolerance:g} of the largest; there may be too few samples, or signals that are "
        f"copies or combinations of others; remedies: (1) ask for at most {rank} features, (2) add samples, "
        "(3) remove redundant signals, (4) lower rank_tolerance if the missing directions are real"
    )
