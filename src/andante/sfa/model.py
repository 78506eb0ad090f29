"""What learning leaves behind: frozen models that turn samples into slow features.

An estimator learns and may learn more; a model is a handful of arrays that only transforms, so that it can be shared
between threads and written to a file (``to_arrays`` and ``from_arrays`` with flat names).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray
from andante.errors import ArrayError
from andante.sfa.arrays import Matrix, require_columns, require_names
from andante.sfa.pca import PCA


@runtime_checkable
class SlowModel(Protocol):
    """Samples in, slow features out, slowest first; the same for every call."""

    @property
    def input_dim(self) -> int:
        """Number of signals d that come in."""
        ...

    @property
    def output_dim(self) -> int:
        """Number of slow features k that come out."""
        ...

    @property
    def deltas(self) -> FloatArray:
        """(k,) mean squared difference of each unit-variance output along the edges it was learnt on."""
        ...

    def transform(self, x: Matrix) -> FloatArray:
        """(n, d) -> (n, k) float64; raises ``ArrayError`` for another number of columns."""
        ...

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Everything as arrays by flat name, for a file."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class AffineModel:
    """Linear slow features: x -> (x - mean) @ weights.

    ``mean`` (d,), ``weights`` (d, k), ``deltas`` (k,). ``rank`` is the number of dimensions of the training data that
    varied by more than ``rank_tolerance`` allows (see ``solve_slow``); the others were left out.
    """

    mean: FloatArray
    weights: FloatArray
    deltas: FloatArray
    rank: int
    rank_tolerance: float

    def __post_init__(self) -> None:
        dim, k = self.weights.shape if self.weights.ndim == 2 else (-1, -1)
        if self.mean.shape != (dim,) or self.deltas.shape != (k,):
            raise ArrayError(
                f"an affine model needs mean (d,), weights (d, k) and deltas (k,), got shapes {self.mean.shape}, "
                f"{self.weights.shape}, {self.deltas.shape}"
            )

    @property
    def input_dim(self) -> int:
        """Number of signals d that come in."""
        return len(self.weights)

    @property
    def output_dim(self) -> int:
        """Number of slow features k that come out."""
        return len(self.deltas)

    @property
    def dropped(self) -> int:
        """Number of input dimensions without variance of their own, which no output listens to."""
        return self.input_dim - self.rank

    def transform(self, x: Matrix) -> FloatArray:
        """(n, d) -> (n, k) float64; raises ``ArrayError`` for another number of columns."""
        x = np.asarray(x, dtype=np.float64)
        require_columns(x, self.input_dim, "AffineModel")
        slow: FloatArray = (x - self.mean) @ self.weights
        return slow

    def after(self, pca: PCA) -> AffineModel:
        """One affine model that does what ``pca`` and then this one do; exact, as components are orthonormal.

        Its ``rank`` stays that of the reduced space, so ``dropped`` counts what the PCA left out as well.
        """
        if pca.output_dim != self.input_dim:
            raise ArrayError(f"a model of {self.input_dim} signals cannot follow a PCA to {pca.output_dim} components")
        return AffineModel(
            pca.mean + pca.components @ self.mean,
            pca.components @ self.weights,
            self.deltas,
            self.rank,
            self.rank_tolerance,
        )

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """``mean``, ``weights``, ``deltas``, ``rank`` (1,) and ``rank_tolerance`` (1,)."""
        return {
            "mean": self.mean,
            "weights": self.weights,
            "deltas": self.deltas,
            "rank": np.array([self.rank], dtype=np.int64),
            "rank_tolerance": np.array([self.rank_tolerance]),
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """The inverse of ``to_arrays``; raises ``ArrayError`` for missing names or shapes that do not fit."""
        require_names(arrays, ("mean", "weights", "deltas", "rank", "rank_tolerance"), "AffineModel")
        return cls(
            mean=np.asarray(arrays["mean"], dtype=np.float64),
            weights=np.asarray(arrays["weights"], dtype=np.float64),
            deltas=np.asarray(arrays["deltas"], dtype=np.float64),
            rank=int(arrays["rank"].item()),
            rank_tolerance=float(arrays["rank_tolerance"].item()),
        )
