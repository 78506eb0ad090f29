"""One node of a hierarchical network, shared by all receptive fields of its layer.

Signals lie in rows and receptive fields in columns, (d, N): products of two signals are then products of long
contiguous rows, and a layer is two matrix products and a few dozen vector operations however many fields it has.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, Self

import numpy as np
from numpy.typing import DTypeLike, NDArray

from andante.sfa.expansion import expanded_dim
from andante.sfa.layers import Grid, Maps
from andante.sfa.model import AffineModel
from andante.sfa.quadratic import QuadraticModel

Signals = NDArray[np.floating[Any]]
"""(d, N) or (d, n, P): d signals in N = n * P receptive fields."""


@dataclass(frozen=True, slots=True, eq=False)
class AffineRows:
    """y = weights @ x + offset on signals in rows, in one floating type: ``weights`` (k, d), ``offset`` (k, 1)."""

    weights: Signals
    offset: Signals

    @classmethod
    def of(cls, model: AffineModel, dtype: DTypeLike) -> Self:
        """What ``model`` does to rows of samples, for columns of samples."""
        weights = np.ascontiguousarray(model.weights.T, dtype=dtype)
        return cls(weights, (-model.weights.T @ model.mean)[:, None].astype(dtype))

    def __call__(self, x: Signals) -> Signals:
        """(d, N) -> (k, N)."""
        y: Signals = self.weights @ x
        y += self.offset
        return y


@dataclass(frozen=True, slots=True, eq=False)
class SharedNode:
    """``model`` and clipping, ready to run in one floating type: x (d, N) -> (k, N)."""

    reduce: AffineRows
    slow: AffineRows
    clip: float | None

    @classmethod
    def of(cls, model: QuadraticModel, clip: float | None, dtype: DTypeLike) -> Self:
        """The node that does to columns what ``model`` does to rows, and then clips."""
        return cls(AffineRows.of(model.reduce, dtype), AffineRows.of(model.slow, dtype), clip)

    def __call__(self, fields: Signals) -> Signals:
        """Receptive fields (d, N) -> outputs (k, N)."""
        y = self.slow(expanded_rows(self.reduce(fields)))
        if self.clip is not None:
            np.clip(y, -self.clip, self.clip, out=y)
        return y


def expanded_rows(x: Signals) -> Signals:
    """(r, N) -> (r + r(r+1)/2, N), the terms of ``expand_quadratic`` in the same order."""
    dim = len(x)
    terms = np.empty((expanded_dim(dim), x.shape[1]), dtype=x.dtype)
    terms[:dim] = x
    for i, start in enumerate(_starts(dim)):
        np.multiply(x[i:], x[i], out=terms[start : start + dim - i])
    return terms


def normalise_fields(fields: Signals, deviation_floor: float) -> Signals:
    """Bring each field (column) to zero mean and about unit deviation, in place (thesis 5.1.1: patch normalisation).

    variance + floor^2 stands below the root, so that noise in a plain patch is not blown up to the size of an edge.
    """
    fields -= fields.mean(axis=0)
    variance = np.einsum("ij,ij->j", fields, fields) / fields.dtype.type(len(fields))
    variance += fields.dtype.type(deviation_floor**2)
    # Where nothing varies and there is no floor, zeros stay zeros.
    fields /= np.sqrt(np.maximum(variance, np.finfo(fields.dtype).tiny, out=variance), out=variance)
    return fields


def fields_of(grid: Grid, maps: Maps, deviation_floor: float | None, dtype: DTypeLike) -> Signals:
    """What the nodes of a grid see (d, n * P), patch-normalised where there is a floor."""
    fields = grid.fields(maps, dtype)
    return fields if deviation_floor is None else normalise_fields(fields, deviation_floor)


def maps_of(grid: Grid, outputs: Signals) -> Maps:
    """Outputs (k, n * P) of a layer as maps (n, k, rows, columns)."""
    return outputs.reshape(len(outputs), -1, grid.rows, grid.columns).transpose(1, 0, 2, 3)


@cache
def _starts(dim: int) -> tuple[int, ...]:
    """Where the products of each signal with itself and those after it begin."""
    return tuple(dim + i * dim - i * (i - 1) // 2 for i in range(dim))
