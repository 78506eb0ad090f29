"""Principal components: fewer dimensions before slow features are sought.

With more dimensions than samples the slowest direction is noise that fits by chance; keeping 80 to 250 principal
components first makes slow features generalise. A ``PCA`` is a frozen stage: it projects samples, and it projects
``Moments`` so that slow features can be learnt in the reduced space without seeing the data again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np

from andante.data import FloatArray
from andante.errors import ArrayError, ConfigError, LearningError
from andante.sfa.arrays import Matrix, as_matrix, require_columns, require_names
from andante.sfa.eigen import RANK_TOLERANCE, largest, sign_of_columns
from andante.sfa.moments import Moments
from andante.sfa.threads import one_thread


@dataclass(frozen=True, slots=True, eq=False)
class PCA:
    """The directions of largest variance: x -> (x - mean) @ components.

    ``mean`` (d,), ``components`` (d, k) orthonormal columns in descending order of ``variances`` (k,), each with
    its entry of largest magnitude positive. ``total_variance`` is that of all d dimensions. ``rank_tolerance`` is
    the share of the largest variance below which components were not kept, even if more had been asked for.
    """

    mean: FloatArray
    components: FloatArray
    variances: FloatArray
    total_variance: float
    rank_tolerance: float

    def __post_init__(self) -> None:
        dim, k = self.components.shape if self.components.ndim == 2 else (-1, -1)
        if self.mean.shape != (dim,) or self.variances.shape != (k,):
            raise ArrayError(
                f"a PCA needs mean (d,), components (d, k) and variances (k,), got shapes {self.mean.shape}, "
                f"{self.components.shape}, {self.variances.shape}"
            )

    @classmethod
    def of(cls, moments: Moments, n_components: int, *, rank_tolerance: float = RANK_TOLERANCE) -> Self:
        """At most ``n_components`` principal components; fewer where the rank is lower.

        Raises ``ConfigError`` for n_components < 1 and ``LearningError`` where nothing varies.
        """
        _require_positive(n_components)
        covariance = moments.covariance
        values, vectors = largest(covariance, min(n_components, moments.dim))
        return cls._cut(moments.mean.copy(), vectors, values, float(np.trace(covariance)), rank_tolerance)

    @classmethod
    def _cut(
        cls, mean: FloatArray, vectors: FloatArray, variances: FloatArray, total: float, rank_tolerance: float
    ) -> Self:
        kept = variances > rank_tolerance * variances.max(initial=0.0)
        if not kept.any():
            raise LearningError("there are no principal components: all samples are the same; hand in data that varies")
        components = vectors[:, kept] * sign_of_columns(vectors[:, kept])
        return cls(mean, np.ascontiguousarray(components), variances[kept].copy(), total, rank_tolerance)

    @property
    def input_dim(self) -> int:
        """Number of signals d that come in."""
        return len(self.components)

    @property
    def output_dim(self) -> int:
        """Number of components k that were kept."""
        return len(self.variances)

    @property
    def explained(self) -> float:
        """Share of the total variance that the components keep, 0..1."""
        return float(self.variances.sum() / self.total_variance)

    def transform(self, x: Matrix) -> FloatArray:
        """(n, d) -> (n, k) float64; raises ``ArrayError`` for another number of columns."""
        x = np.asarray(x, dtype=np.float64)
        require_columns(x, self.input_dim, "PCA")
        reduced: FloatArray = (x - self.mean) @ self.components
        return reduced

    def project(self, moments: Moments) -> Moments:
        """The moments that the transformed samples have."""
        return moments.projected(self.components, origin=self.mean)

    def to_arrays(self) -> dict[str, FloatArray]:
        """Everything as float64 arrays by name, for a file."""
        return {
            "mean": self.mean,
            "components": self.components,
            "variances": self.variances,
            "total_variance": np.array([self.total_variance]),
            "rank_tolerance": np.array([self.rank_tolerance]),
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, FloatArray]) -> Self:
        """The inverse of ``to_arrays``; raises ``ArrayError`` for missing names or shapes that do not fit."""
        require_names(arrays, ("mean", "components", "variances", "total_variance", "rank_tolerance"), "PCA")
        return cls(
            mean=np.asarray(arrays["mean"], dtype=np.float64),
            components=np.asarray(arrays["components"], dtype=np.float64),
            variances=np.asarray(arrays["variances"], dtype=np.float64),
            total_variance=float(arrays["total_variance"].item()),
            rank_tolerance=float(arrays["rank_tolerance"].item()),
        )


def pca_of_samples(x: Matrix, n_components: int, *, rank_tolerance: float = RANK_TOLERANCE) -> PCA:
    """At most ``n_components`` principal components of ``x`` (n, d), the cheaper way round.

    With fewer samples than dimensions the eigenvectors of the (n, n) Gram matrix give the same components,
    signs included, without a (d, d) matrix. Raises as ``PCA.of``.
    """
    x = as_matrix(x)
    n, dim = x.shape
    if n >= dim:
        return PCA.of(Moments.of(x), n_components, rank_tolerance=rank_tolerance)
    _require_positive(n_components)
    start = x[0].astype(np.float64)
    centred = x - start
    offset = centred.mean(axis=0)
    centred -= offset
    gram = centred @ centred.T / n
    values, vectors = largest(gram, min(n_components, n))
    # The last kept component may be 1e-5 of the first: QR takes the share of the large ones out of the small ones.
    kept = values > rank_tolerance * values.max(initial=0.0)
    with one_thread():
        components, _ = np.linalg.qr(centred.T @ vectors[:, kept])
    return PCA._cut(start + offset, components, values[kept], float(np.trace(gram)), rank_tolerance)


def _require_positive(n_components: int) -> None:
    if n_components < 1:
        raise ConfigError(f"n_components={n_components}: ask for at least one principal component")
