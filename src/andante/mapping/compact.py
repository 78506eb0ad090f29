"""Slow features as a map keeps them: single precision, ready to run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray
from andante.sfa import AffineModel, QuadraticModel, expand_quadratic
from andante.sfa.arrays import require_columns, require_names


def products(queries: NDArray[np.float32], rows: NDArray[np.float32]) -> NDArray[np.float32]:
    """Every query (n, d) times every row (r, d): (n, r).

    A single query takes one dot product a row, which BLAS works out in the thread that asks. A matrix product it would
    share among threads, and on a busy machine their waiting for each other costs 100 times the work.
    """
    if len(queries) == 1:
        return np.asarray(np.vecdot(rows, queries[0])[None], dtype=np.float32)
    return np.asarray(queries @ rows.T, dtype=np.float32)


@dataclass(frozen=True, eq=False)
class CompactModel:
    """Features (n, d) float32 -> slow features (n, k) float64.

    ``mean`` (d,) and ``weights`` (d, r) are float32: at a few thousand inputs the product is bound by memory, and
    halving it halves the time and the file. ``quadratic``, where present, follows on the expansion of the r
    linear outputs. ``deltas`` (k,) are those of learning.
    """

    mean: NDArray[np.float32]
    weights: NDArray[np.float32]
    deltas: FloatArray
    quadratic: AffineModel | None = None

    @classmethod
    def of(cls, model: AffineModel | QuadraticModel) -> CompactModel:
        """The same model in single precision."""
        first = model if isinstance(model, AffineModel) else model.reduce
        quadratic = None if isinstance(model, AffineModel) else model.slow
        return cls(
            np.ascontiguousarray(first.mean, dtype=np.float32),
            np.ascontiguousarray(first.weights, dtype=np.float32),
            model.deltas,
            quadratic,
        )

    @property
    def input_dim(self) -> int:
        """Length d of a feature vector."""
        return len(self.mean)

    @property
    def output_dim(self) -> int:
        """Number k of slow features."""
        return len(self.deltas)

    def transform(self, features: NDArray[np.float32]) -> FloatArray:
        """(n, d) float32 -> (n, k) float64; raises ``ArrayError`` for another number of columns."""
        require_columns(features, self.input_dim, "this map")
        linear = np.asarray(products(features - self.mean, self._rows), dtype=np.float64)
        return linear if self.quadratic is None else self.quadratic.transform(expand_quadratic(linear))

    @cached_property
    def _rows(self) -> NDArray[np.float32]:
        return np.ascontiguousarray(self.weights.T)

    def spread(self, features: NDArray[np.float32]) -> FloatArray:
        """(n, d) float32 -> (n,) distances from the average of the mapped images."""
        return np.asarray(np.linalg.norm(features - self.mean, axis=1), dtype=np.float64)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Arrays by name, for a file."""
        arrays: dict[str, NDArray[Any]] = {"mean": self.mean, "weights": self.weights, "deltas": self.deltas}
        if self.quadratic is not None:
            arrays |= {f"quadratic.{name}": array for name, array in self.quadratic.to_arrays().items()}
        return arrays

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> CompactModel:
        """The inverse of ``to_arrays``."""
        require_names(arrays, ("mean", "weights", "deltas"), "CompactModel")
        prefix = "quadratic."
        second = {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}
        return cls(
            arrays["mean"], arrays["weights"], arrays["deltas"], AffineModel.from_arrays(second) if second else None
        )
