"""Slow features as a map keeps them: half precision on disk, single precision at work."""

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

    ``mean`` (d,) is float32. ``weights`` (r, d) float16 times ``scale`` (r,) float32 are the rows of the linear part,
    each with a largest weight of one, so that no unit of the features takes digits away. ``quadratic``, where present,
    follows on the expansion of the r linear outputs. ``deltas`` (k,) are those of learning.
    """

    mean: NDArray[np.float32]
    weights: NDArray[np.float16]
    scale: NDArray[np.float32]
    deltas: FloatArray
    quadratic: AffineModel | None = None

    @classmethod
    def of(cls, model: AffineModel | QuadraticModel) -> CompactModel:
        """The same model, rounded to what a file holds."""
        first = model if isinstance(model, AffineModel) else model.reduce
        quadratic = None if isinstance(model, AffineModel) else model.slow
        largest = np.abs(first.weights).max(axis=0)
        scale = np.where(largest > 0, largest, 1.0)
        rows = np.ascontiguousarray((first.weights / scale).T, dtype=np.float16)
        return cls(first.mean.astype(np.float32), rows, scale.astype(np.float32), model.deltas, quadratic)

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
        return self.weights.astype(np.float32) * self.scale[:, None]

    def spread(self, features: NDArray[np.float32]) -> FloatArray:
        """(n, d) float32 -> (n,) distances from the average of the mapped images."""
        return np.asarray(np.linalg.norm(features - self.mean, axis=1), dtype=np.float64)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Arrays by name, for a file."""
        arrays: dict[str, NDArray[Any]] = {
            "mean": self.mean,
            "weights": self.weights,
            "scale": self.scale,
            "deltas": self.deltas,
        }
        if self.quadratic is not None:
            arrays |= {f"quadratic.{name}": array for name, array in self.quadratic.to_arrays().items()}
        return arrays

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> CompactModel:
        """The inverse of ``to_arrays``."""
        require_names(arrays, ("mean", "weights", "scale", "deltas"), "CompactModel")
        prefix = "quadratic."
        second = {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}
        quadratic = AffineModel.from_arrays(second) if second else None
        return cls(arrays["mean"], arrays["weights"], arrays["scale"], arrays["deltas"], quadratic)
